"""The subjects of this library, and plain differentiation of the same scan: each a jitted function of a film."""

from collections.abc import Callable

import jax
import jax.numpy as jnp

import lgmd2jax as lgmd
from benchmarks._task import FPS, PARAMETERS, SMALL

# All that may stand together but habituation, by which S has a memory, so that every parameter of S needs a map.
MECHANISMS = tuple(name for name in lgmd.MECHANISMS if name not in ("lamina", "habituation"))


def parameters() -> lgmd.Parameters:
    """Those of the task."""
    return lgmd.Parameters(**PARAMETERS)


def _of_parameters(function) -> Callable:
    """Jitted, with the parameters as an argument rather than constants, and the result awaited."""
    jitted, given = jax.jit(function), parameters()
    return lambda *inputs: jax.block_until_ready(jitted(given, *inputs))


def forward(thresholds: lgmd.Thresholds, mechanisms: tuple[str, ...] = ()) -> Callable:
    """The response."""

    def respond(parameters, frames):
        return lgmd.LGMD2(parameters, thresholds, mechanisms=mechanisms)(frames, FPS)

    return _of_parameters(respond)


def exact(model: lgmd.LGMD2, frames, interval):
    """The sums over a film by the library's rule."""
    return model.sums(frames, interval)[0]


def plain(model: lgmd.LGMD2, frames, interval):
    """The same, as JAX derives the loop over frames."""
    return model.pixels.plain(frames, interval)[0]


def loss(pixel_stage) -> Callable:
    """The sum of U' over a film with soft thresholds, as a function of parameters and film."""

    def total(parameters, frames):
        model, interval = lgmd.LGMD2(parameters, lgmd.Soft()), jnp.float32(1000 / FPS)
        return model.respond(pixel_stage(model, frames, interval), interval, frames[0].size).smp_adapted.sum()

    return total


def gradient(pixel_stage=exact) -> Callable:
    """The gradient of `loss` by all parameters; `plain` as `pixel_stage` differentiates the loop."""
    return _of_parameters(jax.grad(loss(pixel_stage)))


def jacobian(pixel_stage=exact, mechanisms: tuple[str, ...] = ()) -> Callable:
    """The derivatives of MP(t) and F(t) with soft thresholds by all parameters."""

    def sums(parameters, frames):
        model = lgmd.LGMD2(parameters, lgmd.Soft(), mechanisms=mechanisms)
        return pixel_stage(model, frames, jnp.float32(1000 / FPS))

    return _of_parameters(jax.jacfwd(sums))


def naive_gradient() -> Callable:
    """`gradient` without the library's rule."""
    return gradient(plain)


def naive_jacobian() -> Callable:
    """`jacobian` without the library's rule."""
    return jacobian(plain)


def vmapped() -> Callable:
    """The hard responses to a batch, all of it at once."""
    return _of_parameters(jax.vmap(_respond, in_axes=(None, 0)))


def mapped() -> Callable:
    """The hard responses to a batch, one after the other."""
    return _of_parameters(_respond_each)


def sharded() -> Callable:
    """The hard responses to a batch, one after the other on each of the host's devices."""
    split = jax.P("devices")
    each = jax.shard_map(_respond_each, mesh=_devices(), in_specs=(jax.P(), split), out_specs=split, check_vma=False)
    return _of_parameters(each)


def spread(films) -> jax.Array:
    """A batch laid over the host's devices, as `sharded` takes it."""
    return jax.device_put(films, jax.NamedSharding(_devices(), jax.P("devices")))


WINDOW = {"start_ms": -900.0, "end_ms": 90.0}  # 100 frames


def sweep(contrasts: int, speeds: int) -> Callable:
    """The peak of U' over 100 frames of looming, for each contrast and speed, rendering included."""
    return _of_parameters(surface(contrasts, speeds))


def surface(contrasts: int, speeds: int) -> Callable:
    """The same as a function of the parameters."""
    eye, axes = sweep_eye(), sweep_axes(contrasts, speeds)

    def peak(parameters, contrast, l_over_v):
        shown = lgmd.stimuli.looming(eye, contrast=contrast, l_over_v=l_over_v, **WINDOW)
        return lgmd.LGMD2(parameters)(shown.frames, eye.fps).smp_adapted.max()

    return lambda parameters: jax.lax.map(lambda pair: peak(parameters, *pair), axes)


def sweep_eye() -> lgmd.Eye:
    """What a sweep samples."""
    return lgmd.Eye(*SMALL, degrees_per_pixel=2.0, fps=100.0)


def sweep_axes(contrasts: int, speeds: int) -> tuple[jax.Array, jax.Array]:
    """Contrast and speed of each condition."""
    grid = jnp.meshgrid(jnp.linspace(-0.05, -1.0, contrasts), jnp.linspace(5.0, 100.0, speeds), indexing="ij")
    return grid[0].ravel(), grid[1].ravel()


def _devices():
    return jax.make_mesh((jax.device_count(),), ("devices",))


def _respond(parameters, frames):
    return lgmd.LGMD2(parameters)(frames, FPS)


def _respond_each(parameters, films):
    return jax.lax.map(lambda frames: _respond(parameters, frames), films)
