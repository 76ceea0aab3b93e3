"""What is swept: axes over stimuli, over parameters, over models; and what stays fixed."""

import dataclasses
import inspect
import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array
from typing_extensions import TypeAliasType

from lgmd2jax._arguments.units import has_unit
from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.parameters import symbols
from lgmd2jax._types import is_concrete
from lgmd2jax._words import nearest
from lgmd2jax.stimuli import FAMILIES, Stimulus
from lgmd2jax.stimuli._family import outline

Models = TypeAliasType("Models", AbstractNetwork | Sequence[AbstractNetwork] | Mapping[str, AbstractNetwork])


Kind = Literal["model", "parameter", "stimulus"]


@dataclasses.dataclass(frozen=True, eq=False)
class Axis:
    """One dimension of the grid, with the values along it; of models, their names or numbers."""

    name: str
    kind: Kind
    values: np.ndarray
    unit: str = ""
    meaning: str = ""


class Setup(eqx.Module):
    """What answers, one model or a stack, and what it is shown, but for what a point of the grid fills in.

    It knows no values of axes, only what each is, by name: so sweeps over other values compile nothing anew.
    """

    model: AbstractNetwork
    renderer: Callable = eqx.field(static=True)
    eye: Eye = eqx.field(static=True)
    kinds: tuple[tuple[str, Kind], ...] = eqx.field(static=True)
    fixed: dict[str, Any]

    def render(self, point: Mapping[str, Array]) -> Stimulus:
        """The stimulus at a point; what does not depend on the point, such as times, is computed at once."""
        with jax.ensure_compile_time_eval():
            return self.renderer(self.eye, **self.fixed, **self._part(point, "stimulus"))

    def model_at(self, point: Mapping[str, Array]) -> AbstractNetwork:
        """The model at a point, with the parameters of that point."""
        model = self.model
        if stacked := self._part(point, "model"):
            model = jax.tree.map(lambda leaf: jnp.asarray(leaf)[stacked["model"]], model)
        parameters = dataclasses.replace(model.parameters, **self._part(point, "parameter"))
        return dataclasses.replace(model, parameters=parameters)

    def _part(self, point: Mapping[str, Array], kind: Kind) -> dict[str, Array]:
        return {name: point[name] for name, own in self.kinds if own == kind}


@dataclasses.dataclass(frozen=True)
class Grid:
    """The axes of a sweep, and what they are filled into."""

    setup: Setup
    axes: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    def at(self, places: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
        """The values at places along the axes; for models their numbers, which are what JAX can look up."""
        return {
            axis.name: place if axis.kind == "model" else axis.values[place]
            for axis, place in zip(self.axes, places, strict=True)
        }


def read_grid(
    models: Models, renderer: Callable, eye: Eye, parameters: Mapping[str, Any] | None, arguments: Mapping[str, Any]
) -> Grid:
    """The grid that the arguments of a sweep ask for: models first, then parameters, then the stimulus.

    **Raises:** `ValueError` for names that nothing takes, for axes that are empty or not finite, and for what the
    renderer or the network refuses at the corners of the grid.
    """
    model, axes = _stack(models)
    declared = symbols(type(model.parameters))
    for name, value in (parameters or {}).items():
        if name not in declared:
            raise ValueError(f"parameters has {name!r}, which is not a parameter; choose {nearest(name, declared)}")
        symbol = declared[name]
        values = _values(name, value)
        if np.any(outside := ~symbol.contains(values)):
            raise ValueError(f"{name} is {values[outside][0]:g}; it must lie in {symbol.domain} {symbol.unit}")
        axes.append(Axis(name, "parameter", values, symbol.unit, symbol.meaning))
    if not callable(renderer):
        cure = f"; choose {nearest(renderer, FAMILIES)} of them" if isinstance(renderer, str) else ""
        raise ValueError(f"renderer is {renderer!r:.40}; give a function, such as lgmd2jax.stimuli.looming{cure}")
    known = inspect.signature(renderer).parameters
    open_ended = any(parameter.kind is parameter.VAR_KEYWORD for parameter in known.values())
    fixed = {}
    for name, value in arguments.items():
        if name not in list(known)[1:] and not open_ended:
            cure = f"; write parameters={{{name!r}: ...}}" if name in declared else ""
            choices = nearest(name, list(known)[1:])
            raise ValueError(f"{_named(renderer)} takes no {name!r}{cure or f', choose {choices}'}")
        if _is_axis(value):
            axes.append(Axis(name, "stimulus", _values(name, value)))
        else:
            fixed[name] = value.item() if hasattr(value, "item") and is_concrete(value) else value
    if not axes:
        raise ValueError("nothing is swept; give at least one argument, parameter or model as a list")
    twice = {axis.name for axis in axes if sum(other.name == axis.name for other in axes) > 1}
    if twice:
        raise ValueError(f"{sorted(twice)[0]} is an axis twice; name each once")
    units, window = _corners(renderer, eye, fixed, [axis for axis in axes if axis.kind == "stimulus"])
    if {"start_ms", "end_ms"} <= set(known):
        fixed |= {"start_ms": window[0], "end_ms": window[1]}
    axes = [dataclasses.replace(axis, unit=axis.unit or units.get(axis.name, "")) for axis in axes]
    kinds: list[tuple[str, Kind]] = [(axis.name, axis.kind) for axis in axes]
    return Grid(Setup(model, renderer, eye, tuple(kinds), fixed), tuple(axes))


def _stack(models: Models) -> tuple[AbstractNetwork, list[Axis]]:
    """One model whose leaves have the models as first axis, and that axis; none for a single model."""
    if isinstance(models, AbstractNetwork):
        sizes = {leaf.shape[0] for leaf in jax.tree.leaves(models) if leaf.ndim}
        if not sizes:
            return models, []
        if len(sizes) > 1 or any(leaf.ndim != 1 for leaf in jax.tree.leaves(models)):
            raise ValueError("model has leaves of several shapes; build a stack under jax.vmap, or give a list")
        return models, [Axis("model", "model", np.arange(sizes.pop()))]
    names = np.array(list(models), dtype=object) if isinstance(models, Mapping) else np.arange(len(models))
    stack = list(models.values() if isinstance(models, Mapping) else models)
    if not stack:
        raise ValueError("model is an empty collection; give at least one network")
    for name, model in zip(names, stack, strict=True):
        if jax.tree.structure(model) != jax.tree.structure(stack[0]):
            raise ValueError(
                f"model {name} has another structure (thresholds, n_p, low_pass, N_ts or eye) than the first; "
                "sweep each and join them with xarray.concat"
            )
    return jax.tree.map(lambda *leaves: jnp.stack(leaves), *stack), [Axis("model", "model", names)]


def _is_axis(value: Any) -> bool:
    """Whether this holds several values: a sequence, an array, or an iterator; no text, no table."""
    if isinstance(value, (str, bytes, Mapping)) or callable(value):
        return False
    return np.ndim(value) > 0 if hasattr(value, "ndim") else isinstance(value, Iterable)


def _values(name: str, value: Any) -> np.ndarray:
    """An axis as an array of numbers; one number is an axis of one."""
    if isinstance(value, (set, frozenset)):
        raise ValueError(f"{name} is a set, which has no order; give a list")
    if _is_axis(value) and not hasattr(value, "ndim"):
        value = list(value)
    if has_unit(value):
        raise ValueError(
            f"{name} is {' '.join(repr(value).split()):.30}, which has a unit or a date; give plain numbers"
        )
    try:
        values = np.atleast_1d(np.asarray(value, dtype=float))
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r:.60}; an axis is a list of numbers, sweep other things apart") from None
    if values.ndim != 1 or not values.size:
        raise ValueError(f"{name} has shape {values.shape}; give the values of an axis as a list with at least one")
    if not np.all(np.isfinite(values)):
        raise ValueError(f"{name} holds {values[~np.isfinite(values)][0]}; give finite values")
    return values


def _corners(
    renderer: Callable, eye: Eye, fixed: Mapping[str, Any], axes: Sequence[Axis]
) -> tuple[dict[str, str], tuple[float, float]]:
    """What the renderer says of the corners of the grid, which it checks: units, and a window that covers them all."""
    units, frames = {}, []
    for corner in itertools.product(*((axis.values.min(), axis.values.max()) for axis in axes)):
        point = {axis.name: float(value) for axis, value in zip(axes, corner, strict=True)}
        time, units = outline(renderer, eye, **fixed, **point)
        frames += np.rint(np.asarray(time)[[0, -1]] * (eye.fps / 1000)).tolist()
    return units, (min(frames) * 1000 / eye.fps, max(frames) * 1000 / eye.fps)


def _named(renderer: Callable) -> str:
    return getattr(renderer, "__name__", repr(renderer))
