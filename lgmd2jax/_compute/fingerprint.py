"""A digest of what a function will do: its code, and the values that it captured on its way here."""

import copyreg
import dataclasses
import enum
import functools
import hashlib
import inspect
import sys
import types
import weakref
from collections.abc import Iterable, Iterator, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

_PLAIN = (bool, int, float, complex, str, bytes, range, slice, types.NoneType, types.EllipsisType, np.dtype)
_INSTALLED = {"site-packages", "dist-packages"}


def fingerprint(value: Any) -> str:
    """A digest of a value, the same in another process, another one where anything in it differs.

    Of functions count the code, defaults, the variables of enclosing functions, and, of code that no package holds, the
    globals that it names; of partial functions and bound methods the arguments and the object; of objects their state.
    What a package holds is known by its name and version.

    **Raises:** `ValueError` for a value whose content cannot be told, such as an open file.
    """
    return _Walk().digest(value).hex()


class _Walk:
    """One walk through a value. `_known`: what has been met, with the digest; None on the way to it, in a circle."""

    def __init__(self):
        self._known: dict[int, tuple[Any, bytes | None]] = {}

    def digest(self, value: Any) -> bytes:
        if isinstance(value, _PLAIN):
            return _hash(type(value).__qualname__, repr(value))
        if id(value) not in self._known:
            self._known[id(value)] = value, None
            self._known[id(value)] = value, self._content(value)
        return self._known[id(value)][1] or _hash("circle")

    def _content(self, value: Any) -> bytes:
        kind = type(value).__qualname__
        if isinstance(value, (np.ndarray, np.generic, jax.Array)):
            return self._array(value)
        if isinstance(value, (list, tuple)):
            return _hash(kind, *map(self.digest, value))
        if isinstance(value, (set, frozenset)):
            return _hash(kind, *sorted(map(self.digest, value)))
        if isinstance(value, Mapping):
            return _hash(kind, *sorted(self._all(item) for item in value.items()))
        if isinstance(value, types.CodeType):
            return self._all((value.co_code, value.co_consts, value.co_names, value.co_varnames, value.co_freevars))
        if isinstance(value, types.FunctionType):
            return self._function(value)
        if isinstance(value, types.MethodType):
            return self._all((value.__func__, value.__self__))
        if isinstance(value, functools.partial):
            return self._all((value.func, value.args, value.keywords))
        if isinstance(value, (types.ModuleType, type)):
            return _hash(_name(value), _package(value), _source(value))
        if hasattr(value, "__wrapped__"):  # of jax.jit and functools.wraps
            return self._all((kind, value.__wrapped__))
        if isinstance(value, weakref.ref):
            return self.digest(value())
        if isinstance(value, enum.Enum):
            return self._all((type(value), value.name))
        if dataclasses.is_dataclass(value):
            return self._all((type(value), *(getattr(value, field.name, None) for field in dataclasses.fields(value))))
        return self._object(value)

    def _all(self, values: Iterable[Any]) -> bytes:
        return _hash(*map(self.digest, values))

    def _array(self, value: Any) -> bytes:
        if isinstance(value, jax.Array) and jnp.issubdtype(value.dtype, jax.dtypes.prng_key):
            value = jax.random.key_data(value)
        array = np.asarray(value)
        content = self.digest(array.tolist()) if array.dtype == object else array.tobytes()
        return _hash("array", str(array.dtype), str(array.shape), content)

    def _function(self, value: types.FunctionType) -> bytes:
        if _package(value) and _is_global(value):
            return self._all((_name(value), _package(value), inspect.unwrap(value).__code__))
        enclosed = []
        for cell in value.__closure__ or ():
            try:
                enclosed.append(cell.cell_contents)
            except ValueError:  # a variable that is not set yet
                enclosed.append("unset")
        named = {}
        if not _package(value):
            named = {name: value.__globals__[name] for name in _names(value.__code__) if name in value.__globals__}
        return self._all(
            (_name(value), _package(value), value.__code__, value.__defaults__, value.__kwdefaults__, enclosed, named)
        )

    def _object(self, value: Any) -> bytes:
        """What pickle would keep, or the name of what it keeps by name."""
        try:
            reduce = copyreg.dispatch_table.get(type(value))
            state = value.__reduce_ex__(2) if reduce is None else reduce(value)
        except Exception as error:
            kind = type(value).__qualname__
            raise ValueError(
                f"an object of type {kind} has no content that can be compared, so that finished work could not be "
                "recognised; hold plain values and arrays instead, or leave out store and memory"
            ) from error
        if isinstance(state, str):
            return _hash(_name(value), _package(value))
        make, arguments, *rest = state
        parts = [list(part) if isinstance(part, Iterator) else part for part in rest]
        return self._all((_name(make), arguments, *parts))


def _hash(*parts: str | bytes) -> bytes:
    whole = hashlib.sha256()
    for part in parts:
        content = part.encode() if isinstance(part, str) else part
        whole.update(len(content).to_bytes(8, "little") + content)
    return whole.digest()


def _names(code: types.CodeType) -> set[str]:
    """The globals and attributes that code names, functions within it included."""
    inner = (part for part in code.co_consts if isinstance(part, types.CodeType))
    return set(code.co_names).union(*map(_names, inner))


def _name(value: Any) -> str:
    module = getattr(value, "__module__", None) or ""
    return f"{module}.{getattr(value, '__qualname__', getattr(value, '__name__', type(value).__qualname__))}"


def _is_global(value: types.FunctionType) -> bool:
    """Whether a module holds the function under its name, so that it captured nothing."""
    return getattr(sys.modules.get(value.__module__), value.__qualname__, None) is value


def _package(value: Any) -> str:
    """The installed package that holds a function, class or module, with its version; empty for code of one's own."""
    module = value.__name__ if isinstance(value, types.ModuleType) else getattr(value, "__module__", None) or ""
    top = module.partition(".")[0]
    if top == "__main__":
        return ""
    if top in sys.stdlib_module_names:
        return f"python {sys.version_info.major}.{sys.version_info.minor}"
    file = getattr(sys.modules.get(module), "__file__", None)
    if top != "lgmd2jax" and not (file and _INSTALLED & set(Path(file).parts)):
        return ""
    try:
        return f"{top} {_release(top)}"
    except PackageNotFoundError:
        return top


_release = functools.cache(version)  # which reads a file at each call


def _source(value: Any) -> str:
    """The text of a class or module of one's own; empty where it cannot be had."""
    if _package(value):
        return ""
    try:
        return inspect.getsource(value)
    except (OSError, TypeError):
        return ""
