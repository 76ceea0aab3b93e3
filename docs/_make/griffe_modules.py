"""What Griffe does not see in the source: which fields construct an `equinox.Module`, and what docstrings refer to."""

import importlib
import inspect
import re

import griffe

from docs._make.public_names import links_of, object_at, with_references

_CLASS = re.compile(r"(?<![\[`])`((?:[a-z]\w*\.)*[A-Z]\w*)`(?![`\]])")
_logger = griffe.get_logger("lgmd2jax.docs")  # mkdocs takes its warnings for its own, so that --strict fails


class Modules(griffe.Extension):
    """Gives each class without an `__init__` of its own the signature that it has when it runs."""

    def on_package(self, *, pkg, **_):
        if pkg.name == "lgmd2jax":
            self._visit(pkg, links_of())

    def _visit(self, scope, links):
        for member in scope.members.values():
            if member.is_alias:
                continue
            if member.is_class:
                _give_init(member)
            if member.docstring is not None:
                member.docstring.value = linked(member.docstring.value, member, links)
            if member.is_module or member.is_class:
                self._visit(member, links)


def _give_init(cls: griffe.Class) -> None:
    if "__init__" in cls.members:
        return
    try:
        signature = inspect.signature(
            object_at(importlib.import_module(cls.module.path), cls.path[len(cls.module.path) + 1 :])
        )
    except (ImportError, AttributeError, ValueError, TypeError):
        return
    fields = {name: each for base in (*reversed(_bases(cls)), cls) for name, each in base.members.items()}
    parameters = [griffe.Parameter("self", kind=griffe.ParameterKind.positional_or_keyword)]
    for name, parameter in signature.parameters.items():
        field = fields.get(name)
        parameters.append(
            griffe.Parameter(
                name,
                annotation=field.annotation if field is not None and field.is_attribute else None,
                kind=getattr(griffe.ParameterKind, parameter.kind.name.lower()),
                default=None if parameter.default is inspect.Parameter.empty else _default(parameter.default),
            )
        )
    init = griffe.Function("__init__", parameters=griffe.Parameters(*parameters))
    cls.set_member("__init__", init)


def _bases(cls: griffe.Class) -> list[griffe.Class]:
    try:
        return [base for base in cls.mro() if base.is_class]
    except (griffe.GriffeError, ValueError, KeyError):
        return []


def _default(value) -> str:
    text = repr(value)
    return "..." if "<" in text or len(text) > 40 else text


def linked(text: str, place: griffe.Object, links: dict[str, str]) -> str:
    """The docstring, with links where it names a public class, and where it refers to another's docstring."""
    room = ".".join(place.path.split(".")[:2])

    def public(name: str) -> str | None:
        return links.get(f"{room}.{name}") or links.get(name)

    def entry(name: str) -> str | None:
        owner = place if place.is_class else place.parent
        if owner is not None and owner.is_class and name in owner.members:
            return f"{owner.path}.{name}"
        return public(name)

    def mention(match):
        found = public(match[1])
        return f"[`{match[1]}`][{found}]" if found else match[0]

    blocks = re.split(r"(```.*?```)", text, flags=re.S)
    for i, block in enumerate(blocks[::2]):
        blocks[2 * i] = _CLASS.sub(mention, with_references(block, entry))
    return "".join(blocks)
