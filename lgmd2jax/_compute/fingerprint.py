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

    Of functions count the code, defaults, attributes, the variables of enclosing functions, and, of code that no
    package holds, the globals that it names, also those of other modules; of partial functions and bound methods the
    arguments and the object; of objects their state and their class. What a package holds is known by its name and
    version.

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
        if type(value) is np.ndarray or isinstance(value, (np.generic, jax.Array)):
            return self._array(value)
        if isinstance(value, (list, tuple, Mapping)) and not _package(type(value)):
            return self._object(value)
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
        if isinstance(value, type) and not _package(value):
            return self._class(value)
        if isinstance(value, (types.ModuleType, type)):
            return _hash(_name(value), _package(value), _source(value))
        if hasattr(value, "__wrapped__") and _package(type(value)):  # of jax.jit and functools.cache
            return self._all((kind, value.__wrapped__))
        if isinstance(value, weakref.ref):
            return self.digest(value())
        if isinstance(value, enum.Enum):
            return self._all((type(value), value.name, value.value))
        if dataclasses.is_dataclass(value) and _package(type(value)):
            return self._all((type(value), *(getattr(value, field.name, None) for field in dataclasses.fields(value))))
        return self._object(value)

    def _all(self, values: Iterable[Any]) -> bytes:
        return _hash(*map(self.digest, values))

    def _array(self, value: Any) -> bytes:
        if isinstance(value, jax.Array) and jnp.issubdtype(value.dtype, jax.dtypes.prng_key):
            value = jax.random.key_data(value)
        array = np.asarray(value)
        content = self.digest(array.tolist()) if array.dtype.hasobject else array.tobytes()
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
        named = {} if _package(value) else _named(value, enclosed)
        own = value.__defaults__, value.__kwdefaults__, value.__dict__
        return self._all((_name(value), _package(value), value.__code__, *own, enclosed, named))

    def _class(self, value: type) -> bytes:
        """A class of one's own: its bases, its methods, and what else it holds for all its objects."""
        members = {}
        for name, member in vars(value).items():
            method = _method(member)
            if isinstance(method, types.FunctionType) or not name.startswith(("__", "_abc_")):
                try:
                    members[name] = self.digest(method)
                except ValueError:  # a lock, for example, which no value depends on
                    members[name] = _name(type(method))
        return self._all((_name(value), value.__bases__, members))

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
        rest = [_uncached(part, type(value)) if isinstance(part, dict) else part for part in rest]
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


def _named(value: types.FunctionType, enclosed: Iterable[Any]) -> dict[str, Any]:
    """What a function of one's own finds under the names in its code: globals, also in modules of one's own."""
    names = sorted(_names(value.__code__))
    found = {name: value.__globals__[name] for name in names if name in value.__globals__}
    modules = [each for each in (*found.values(), *enclosed) if isinstance(each, types.ModuleType)]
    for module in modules:
        if not _package(module):
            held = {f"{module.__name__}.{name}": vars(module)[name] for name in names if name in vars(module)}
            modules += [each for each in held.values() if isinstance(each, types.ModuleType) and each not in modules]
            found |= held
    return found


def _method(member: Any) -> Any:
    """The function of a method, also of one of a class or behind a property; else what is given."""
    if isinstance(member, (classmethod, staticmethod)):
        return member.__func__
    if isinstance(member, functools.cached_property):
        return member.func
    return member.fget if isinstance(member, property) else member


def _uncached(state: dict, kind: type) -> dict:
    """The state of an object without what its cached properties keep, which follows from the rest."""
    return {
        name: value
        for name, value in state.items()
        if not isinstance(getattr(kind, str(name), None), functools.cached_property)
    }


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
    """The text of a module of one's own; empty where it cannot be had."""
    if _package(value):
        return ""
    try:
        return inspect.getsource(value)
    except (OSError, TypeError):
        return ""
