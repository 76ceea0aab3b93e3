"""Where the time goes: the hard response, the gradient, of which the Jacobian is most, and a sweep, part by part.

XLA makes a loop over the map of every result where the loop in numba makes one of all. How many bytes these loops read
and write says how near a program is to the bandwidth of its cache.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

import lgmd2jax as lgmd
from benchmarks import _library, _traffic
from benchmarks._task import FPS, Size, film
from lgmd2jax._network import medulla, retina
from lgmd2jax._network.low_pass import coefficient, low_pass
from lgmd2jax._network.maps import folded, inside, pool
from lgmd2jax._network.tiles import DERIVED, FORWARD, change, over_tiles, tile_height

FRAMES, SIDE = 60, 10
PARTS = ("P with its border", "ON and OFF", "their delays", "F", "spread, S, gate and MP")
# The Jacobian by parameters beside those before them. The first act on a frame alone, the last two are remembered.
FREE = {
    "by T_s": ("T_s",),
    "by theta1 to 3": ("theta1", "theta2", "theta3"),
    "by w_bias": ("w_bias",),
    "by tau1": ("tau1",),
    "by sigma1": ("sigma1",),
}


class Program(NamedTuple):
    """A compiled program, how many frames a call is, and the bytes of maps that it reads and writes in a frame."""

    call: Callable[[], Any]
    frames: int
    bytes: int


def programs(size: Size) -> dict[str, dict[str, Program]]:
    """By what is profiled, the programs that end with each of its parts and have all before it."""
    frames = jnp.asarray(film(size, FRAMES))

    def made(function, maps: int = DERIVED) -> Program:
        call, text = _compiled(function, frames)
        height = tile_height(size.rows, 4 * size.cols, maps)
        return Program(call, FRAMES, _of_pixels(text, height, size.cols) * size.rows // height)

    gradient, names = {"MP and F": made(_sums, FORWARD)}, ()
    for part, more in FREE.items():
        names += more
        gradient[part] = made(_with_jacobian(names))
    gradient["the cell, forth and back"] = made(jax.grad(_library.loss(_library.exact)))
    return {"hard response": {part: made(_up_to(part), FORWARD) for part in PARTS}, "gradient": gradient}


def sweep_programs(side: int = SIDE) -> dict[str, Program]:
    """The same of a sweep over side x side conditions: with a film that is there, and drawn."""
    eye, axes = _library.sweep_eye(), _library.sweep_axes(side, side)
    drawn = lgmd.stimuli.looming(eye, **_library.WINDOW).frames
    there = jnp.clip(drawn + 2 * jax.random.normal(jax.random.key(0), drawn.shape, drawn.dtype), 0, 255)

    def given(v, film):
        def peak(condition):
            contrast, speed = condition  # by which the film is a hair dimmer, so that XLA computes each response anew
            return lgmd.LGMD2(v)(film * (1 + contrast / 1e4 + speed / 1e6), eye.fps).smp_adapted.max()

        return jax.lax.map(peak, axes)

    frames, (rows, cols) = side**2 * len(drawn), drawn.shape[1:]
    response, text = _compiled(given, there)
    of_response = _of_pixels(text, rows, cols)
    whole, text = _compiled(lambda v, _: _library.surface(side, side)(v), there)
    loop = _traffic.body_of_loop(text, f"f32[{len(drawn)},{rows},{cols}]", without=_bordered(rows, cols))
    # A film of zeros is written first, and drawn over.
    of_drawing = _traffic.bytes_of_step(text, loop) + 4 * rows * cols
    return {
        "response to a film that is there": Program(response, frames, of_response),
        "drawing it": Program(whole, frames, of_response + of_drawing),
    }


def _compiled(function, frames) -> tuple[Callable[[], Any], str]:
    """A call of a function of the task's parameters and of frames, and the text of its program."""
    given = _library.parameters()
    compiled = jax.jit(function).lower(given, frames).compile()
    text = compiled.as_text()
    assert text is not None
    return lambda: jax.block_until_ready(compiled(given, frames)), text


def _of_pixels(text: str, height: int, cols: int) -> int:
    return _traffic.bytes_of_step(text, _traffic.body_of_loop(text, _bordered(height, cols)))


def _bordered(height: int, cols: int) -> str:
    return f"f32[{height + 2},{cols + 2}]"


def _sums(v: lgmd.Parameters, frames):
    return _library.exact(lgmd.LGMD2(v, lgmd.Soft()), frames, jnp.float32(1000 / FPS))


def _with_jacobian(names: tuple[str, ...]) -> Callable:
    """The Jacobian of MP and F by these parameters, and MP and F."""

    def slopes_and_sums(v, frames):
        def of_values(values):
            return (_sums(dataclasses.replace(v, **values), frames),) * 2

        return jax.jacfwd(of_values, has_aux=True)({name: getattr(v, name) for name in names})

    return slopes_and_sums


def _up_to(last: str) -> Callable:
    """The loop of the hard response over a film, which ends with this part."""
    kept = PARTS[: PARTS.index(last) + 1]

    def loop(v: lgmd.Parameters, frames):
        v = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), v)
        a = coefficient(v.tau1, jnp.float32(1000 / FPS), "backward_euler")

        def of_tile(first, height):
            def step(maps, t):
                p, on, off, d_on, d_off = maps
                p, f, mp = change(frames, t, first, onto=p), None, None
                if "ON and OFF" in kept:
                    flows = zip(retina.half_wave(p), (on, off), strict=True)
                    on, off = (retina.residual(flow, trace, v.sigma1) for flow, trace in flows)
                if "their delays" in kept:
                    d_on, d_off = low_pass(d_on, on, a), low_pass(d_off, off, a)
                if "F" in kept:
                    f = retina.mean_change(inside(p))
                if PARTS[-1] in kept:
                    spreads = medulla.lateral(d_on), medulla.lateral(d_off)
                    s = medulla.s_layer(*medulla.local_sums(inside(on), inside(off), *spreads, v.w_bias), v)
                    mp = pool(folded(medulla.gate(s, v.T_s, lgmd.Hard())))
                return (p, on, off, d_on, d_off), (f, mp)

            zero = jnp.zeros((height + 2, frames.shape[2] + 2), jnp.float32)
            return jax.lax.scan(step, (zero,) * 5, jnp.arange(len(frames)))

        return over_tiles(of_tile, frames)

    return loop
