"""Programs of the library that are traced once for all starts of a command: what JAX compiled is kept whole.

JAX's own cache saves the compiling. Tracing a program in Python and lowering it take longer than that saves, in a short
fit more than half of a second start. Kept here is the executable itself, under a digest of all that its tracing reads:
the source of the library, the releases it stands on, JAX's settings, and the arguments, of arrays their kind alone.
"""

import contextlib
import dataclasses
import functools
import hashlib
import inspect
import os
import pickle
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, ParamSpec, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.experimental.compilation_cache import compilation_cache
from jax.experimental.serialize_executable import deserialize_and_load, serialize

from lgmd2jax._compute.cluster import running_versions
from lgmd2jax._compute.fingerprint import fingerprint
from lgmd2jax._compute.kept_programs import place_of_programs, processor
from lgmd2jax._files.atomic import replaced
from lgmd2jax._types import is_concrete

P = ParamSpec("P")
Out = TypeVar("Out")

_compiling = threading.Lock()
_DIGEST_BYTES = hashlib.sha256().digest_size


@dataclasses.dataclass(frozen=True)
class _Hole:
    """In the place of an array."""

    shape: tuple[int, ...]
    dtype: str
    is_weak: bool


class _Program(NamedTuple):
    """What was compiled, from arrays to arrays, and the result that these fill."""

    compiled: Callable[[list], list]
    out: Any

    def __call__(self, arrays: list) -> Any:
        leaves, tree = jax.tree.flatten(self.out)
        values = iter(self.compiled(arrays))
        return jax.tree.unflatten(tree, [next(values) if _is_hole(leaf) else leaf for leaf in leaves])


def traced_once(function: Callable[P, Out]) -> Callable[P, Out]:
    """`equinox.filter_jit` of a function of this library, whose programs commands keep on disk; see the module.

    The function depends on its arguments alone, not on variables around it. Within another traced function, outside of
    commands, and where something refuses to be kept, it is what `equinox.filter_jit` makes of it.
    """
    jitted, signature = eqx.filter_jit(function), inspect.signature(function)
    programs: dict[Any, _Program | None] = {}

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> Out:
        folder = place_of_programs()
        if folder is None or jax.config.jax_disable_jit:  # pyright: ignore[reportAttributeAccessIssue]
            return jitted(*args, **kwargs)
        bound = signature.bind(*args, **kwargs)
        bound.apply_defaults()
        leaves, tree = jax.tree.flatten((bound.args, bound.kwargs))
        arrays = [leaf for leaf in leaves if eqx.is_array(leaf)]
        if not is_concrete(*arrays) or jax.device_count() > 1:
            return jitted(*args, **kwargs)
        holes = [_hole(leaf) if eqx.is_array(leaf) else leaf for leaf in leaves]
        key = _settings(), tree, *((type(leaf), leaf) for leaf in holes)
        if key not in programs:
            programs[key] = _program(function, folder, jax.tree.unflatten(tree, holes), arrays)
        program = programs[key]
        return jitted(*args, **kwargs) if program is None else program(arrays)

    return call


def _hole(array: Any) -> _Hole:
    aval = jax.typeof(array)
    return _Hole(aval.shape, str(aval.dtype), aval.weak_type)


def _is_hole(value: Any) -> bool:
    return isinstance(value, _Hole)


def _settings() -> tuple:
    """What changes from call to call of what JAX reads beside the arguments."""
    return str(jnp.result_type(float)), jax.default_backend()


@functools.cache
def _surroundings() -> tuple:
    """What else a program depends on: releases, the processor, and what the environment tells JAX and XLA."""
    told = {
        name: value for name, value in os.environ.items() if name.startswith(("JAX_", "XLA_")) and "CACHE" not in name
    }
    return running_versions(), processor(), told


def _program(function: Callable, folder: Path, arguments: Any, arrays: list) -> _Program | None:
    """The program from the folder, or compiled and put there; None where it cannot be kept."""
    name = f"{function.__module__}.{function.__qualname__}"
    try:
        digest = fingerprint((name, _surroundings(), _settings(), arguments))
    except ValueError:
        return None
    path = folder / f"{name}-{digest[:32]}-cache"
    return _read(path, len(arrays)) or _compiled(function, path, arguments, arrays)


def _compiled(function: Callable, path: Path, arguments: Any, arrays: list) -> _Program | None:
    """The program, compiled and written where that is allowed."""
    holes, tree = jax.tree.flatten(arguments)
    outs = []

    def of_arrays(arrays):
        values = iter(arrays)
        args, kwargs = jax.tree.unflatten(tree, [next(values) if _is_hole(hole) else hole for hole in holes])
        leaves, out = jax.tree.flatten(function(*args, **kwargs))
        outs.append(jax.tree.unflatten(out, [_hole(leaf) if eqx.is_array(leaf) else leaf for leaf in leaves]))
        return [leaf for leaf in leaves if eqx.is_array(leaf)]

    of_arrays.__name__ = function.__name__
    lowered = jax.jit(of_arrays).lower(arrays)
    with _without_cache():
        compiled = lowered.compile()
    out = outs[-1]
    try:
        content = pickle.dumps((serialize(compiled)[0], out))
    except Exception:  # calls back to Python, of which pickle and XLA say all kinds of errors
        return None
    with contextlib.suppress(OSError, ValueError):  # a full disk, a folder in its place
        path.parent.mkdir(parents=True, exist_ok=True)
        with replaced(path, is_result=False) as temporary:
            temporary.write_bytes(hashlib.sha256(content).digest() + content)
    return _Program(compiled, out)


@contextlib.contextmanager
def _without_cache() -> Iterator[None]:
    """Within the block JAX's own cache is off: a program that came from there breaks when it is written once more."""
    with _compiling:
        jax.config.update("jax_enable_compilation_cache", False)
        compilation_cache.reset_cache()  # JAX looks at the setting once
        try:
            yield
        finally:
            jax.config.update("jax_enable_compilation_cache", True)
            compilation_cache.reset_cache()


def _read(path: Path, count: int) -> _Program | None:
    """The program that a file holds; None for no file, one that is spoilt, and one that XLA refuses."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, content = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
    if hashlib.sha256(content).digest() != digest:
        return None
    try:
        executable, out = pickle.loads(content)
        if b"lapack" in executable:
            _load_lapack()
        into = jax.tree.structure((([0] * count,), {}))
        found = jax.tree.structure([0] * sum(map(_is_hole, jax.tree.leaves(out))))
        return _Program(deserialize_and_load(executable, into, found), out)
    except Exception:
        return None


@functools.cache
def _load_lapack() -> None:
    """Let JAX look up LAPACK, which it does when it lowers a program that needs it; one that is read would crash."""
    jax.jit(jax.lax.linalg.cholesky).lower(jax.ShapeDtypeStruct((1, 1), jnp.float32))
