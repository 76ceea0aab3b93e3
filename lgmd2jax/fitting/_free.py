"""Which parameters a fit may change, within which bounds, and how it measures there."""

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.parameters import Parameters, ParameterSet, Symbol, symbols
from lgmd2jax._targets.observation import Observation, observation_symbols
from lgmd2jax._words import nearest, warn_renamed
from lgmd2jax.fitting._bounds import Linear, Log, Range, Scale, between, check_bounds

P = TypeVar("P", bound=ParameterSet)


@checked
@dataclasses.dataclass(frozen=True)
class Tie:
    """A parameter that follows another one, free or fixed.

    `Free(theta2=(1, 6), theta1=Tie("theta2", 0.5))` fits theta2 and keeps theta1 = 0.5 theta2.

    **Arguments:** `to`: the name of the other. `factor`: by which its value is multiplied.
    """

    to: str
    factor: Any = 1.0


class Structure(NamedTuple):
    """What a compiled program knows of a free parameter: all but its numbers."""

    name: str
    symbol: Symbol
    scale: Scale
    has_prior: bool


@dataclasses.dataclass(frozen=True)
class FreeParameter:
    """One free parameter, resolved: where it may lie, and how that maps to [0, 1].

    The numbers are floats, and traced arrays within a compiled program.
    """

    name: str
    symbol: Symbol
    low: Any
    high: Any
    scale: Scale
    prior: tuple[Any, Any] | None

    def value(self, z):
        """The value at z in [0, 1]."""
        return between(self.low, self.high, self.scale, z)

    def place(self, value):
        """The z of a value."""
        if self.scale == "log":
            return jnp.log(value / self.low) / jnp.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def slope(self, z: float) -> float:
        """The derivative of the value by z."""
        return self.value(z) * math.log(self.high / self.low) if self.scale == "log" else self.high - self.low


Choice = Annotated[
    tuple[float | int, float | int] | Linear | Log | Tie | None, "(low, high), a Linear, a Log, a Tie or None"
]


@checked
@jax.tree_util.register_pytree_node_class
class Free:
    """The free parameters of a fit, by the paper's symbols and the fields of `Observation`.

    ```python
    Free(theta2=(1, 6), tau1=Log(5, 50), T_sp=None, theta1=Tie("theta2"), k=Log(prior=(1.0, 0.3)))
    ```

    A pair gives bounds on a linear scale. None takes bounds and scale as they are declared with the parameter
    (`symbols()`). `Linear` and `Log` state the scale, and may carry a prior. `Tie` makes a parameter follow another.
    What is not named stays fixed. Names that several networks have are taken to be the LGMD2's, until a fit of another
    network asks for its own (`of`).

    **Raises:** `ValueError` for unknown parameters, for none that is free, for bounds that are empty or leave the
    domain, for priors without width, and for ties to what is tied itself.
    """

    def __init__(self, **choices: Choice):
        known = (kind for kind in _kinds() if choices.keys() <= _symbols(kind).keys())
        self._resolve(choices, next(known, Parameters))

    def _resolve(self, choices, kind: type[ParameterSet]) -> None:
        self._choices, self._kind = choices, kind
        for name in choices:
            _check_name(name, "free parameter", kind)
        ties = {name: choice for name, choice in choices.items() if isinstance(choice, Tie)}
        for name, tie in ties.items():
            _check_name(tie.to, f"{name} is tied to a parameter that", kind)
            if tie.to in ties or tie.to == name:
                raise ValueError(f"{name} is tied to {tie.to}, which is tied itself; tie both to one that is not")
        parameters = [
            _free_parameter(name, choice, _symbols(kind)[name])
            for name, choice in choices.items()
            if not isinstance(choice, Tie)
        ]
        if not parameters:
            raise ValueError("free is empty; name at least one parameter")
        self.structure = tuple(
            Structure(each.name, each.symbol, each.scale, each.prior is not None) for each in parameters
        )
        self._tied = tuple((name, tie.to) for name, tie in ties.items())
        self._bounds = np.array([(parameter.low, parameter.high) for parameter in parameters])
        self._priors = np.array([parameter.prior or (math.nan, math.nan) for parameter in parameters])
        self._factors = np.array([float(tie.factor) for tie in ties.values()])

    def tree_flatten(self):
        """For JAX: numbers are data, so that other bounds, priors and factors compile nothing anew."""
        return (self._bounds, self._priors, self._factors), (self.structure, self._tied)

    @classmethod
    def tree_unflatten(cls, structure, numbers) -> "Free":
        """For JAX: the same with other numbers, or what stands for these while a program is traced."""
        free = cls.__new__(cls)
        free.structure, free._tied = structure
        free._bounds, free._priors, free._factors = numbers
        return free

    @property
    def parameters(self) -> tuple[FreeParameter, ...]:
        """The free parameters, in the order in which they were named."""
        return tuple(
            FreeParameter(name, symbol, *_pair(bounds), scale, _pair(prior) if has_prior else None)
            for (name, symbol, scale, has_prior), bounds, prior in zip(
                self.structure, self._bounds, self._priors, strict=True
            )
        )

    @property
    def freedoms(self) -> tuple[FreeParameter, ...]:
        """The old name of `parameters`."""
        warn_renamed("Free.freedoms", "Free.parameters")
        return self.parameters

    @property
    def ties(self) -> Mapping[str, Tie]:
        """What follows another parameter, by its name."""
        factors = (_number(factor) for factor in self._factors)
        return {name: Tie(to, factor) for (name, to), factor in zip(self._tied, factors, strict=True)}

    def of(self, kind: type[ParameterSet]) -> "Free":
        """The same choices for the parameters of a network, with the bounds that these declare.

        **Raises:** `ValueError` for a name that they do not have, and as the class itself.
        """
        if kind is self._kind:
            return self
        free = Free.__new__(Free)
        free._resolve(self._choices, kind)
        return free

    def check_used_by(self, network: AbstractNetwork) -> None:
        """Raise `ValueError` for a free or tied parameter that acts on nothing in this network."""
        for name in (*self.names, *self.ties):
            if name in network.unused:
                raise ValueError(f"{name} is free, but acts on nothing in this {type(network).__name__}; {_cure(name)}")

    @checked
    def also(self, **choices: Choice) -> "Free":
        """These choices and further ones.

        **Raises:** `ValueError` as the class itself.
        """
        return Free(**{**self._choices, **choices})

    def __len__(self):
        return len(self.structure)

    def __eq__(self, other):
        return isinstance(other, Free) and (self.parameters, self.ties) == (other.parameters, other.ties)

    def __hash__(self):
        return hash((self.parameters, tuple(self.ties.items())))

    def __repr__(self):
        rows = [
            f"  {parameter.name:10} {parameter.low:g} .. {parameter.high:g} {parameter.symbol.unit} ({parameter.scale})"
            for parameter in self.parameters
        ]
        rows += [f"  {name:10} = {tie.factor:g} {tie.to}" for name, tie in self.ties.items()]
        return "Free(\n" + "\n".join(rows) + "\n)"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the free parameters, in the order in which they were named."""
        return tuple(structure.name for structure in self.structure)

    def indices(self, *names: str) -> tuple[int, ...]:
        """Where those of `names` that are free stand."""
        return tuple(i for i, name in enumerate(self.names) if name in names)

    def values(self, z: Float[Array | np.ndarray, " free"]) -> dict[str, Array]:
        """The free parameters and the tied ones at a point of the unit box."""
        values = {parameter.name: jnp.asarray(parameter.value(z[i])) for i, parameter in enumerate(self.parameters)}
        return values | {name: tie.factor * values[tie.to] for name, tie in self.ties.items() if tie.to in values}

    def unpacked(self, z: Float[np.ndarray, " free"]) -> Float[np.ndarray, " free"]:
        """The values of the free parameters, as an array."""
        return np.array([float(parameter.value(place)) for parameter, place in zip(self.parameters, z, strict=True)])

    def slopes(self, z: Float[np.ndarray, " free"]) -> Float[np.ndarray, " free"]:
        """The derivative by z of each free parameter."""
        return np.array([parameter.slope(float(z[i])) for i, parameter in enumerate(self.parameters)])

    def insert(
        self, parameters: P, observation: Observation, z: Float[Array | np.ndarray, " free"]
    ) -> tuple[P, Observation]:
        """The parameters and the observation at z, a point of the unit box, tied ones following the free ones."""
        values = self.values(z)
        for name, tie in self.ties.items():
            if name not in values:
                owner = observation if tie.to in observation_symbols() else parameters
                values[name] = tie.factor * jnp.asarray(getattr(owner, tie.to))
        parameters = _replaced(parameters, values, symbols(type(parameters)))
        return parameters, _replaced(observation, values, observation_symbols())

    def place(self, parameters: ParameterSet, observation: Observation) -> Float[np.ndarray, " free"]:
        """The point of the unit box at which the free parameters have the values that they have here.

        **Raises:** `ValueError` for a value outside of its bounds.
        """
        point = []
        for each in self.parameters:
            value = float(getattr(observation if each.name in observation_symbols() else parameters, each.name))
            if not each.low <= value <= each.high:
                raise ValueError(
                    f"{each.name} starts at {value:g}, outside of its bounds {each.low:g} to {each.high:g}; "
                    "widen them, or start within"
                )
            point.append(float(each.place(value)))
        return np.array(point)

    def penalties(self, z: Float[Array | np.ndarray, " free"]) -> Float[Array, " priors"]:
        """The residual of each prior: (value - mean) / standard deviation."""
        rows = [
            (parameter.value(z[i]) - parameter.prior[0]) / parameter.prior[1]
            for i, parameter in enumerate(self.parameters)
            if parameter.prior
        ]
        return jnp.stack(rows) if rows else jnp.zeros(0)


def _number(value):
    """A float, or what stands for one while a program is traced."""
    return float(value) if isinstance(value, np.floating) else value


def _pair(values) -> tuple[Any, Any]:
    return _number(values[0]), _number(values[1])


def _replaced(owner: Any, values: Mapping[str, Array], known) -> Any:
    names = [name for name in values if name in known]
    if not names:
        return owner
    # In the dtype that the leaf has: another one would compile anew.
    leaves = [values[name].astype(jnp.asarray(getattr(owner, name)).dtype) for name in names]
    return eqx.tree_at(lambda tree: [getattr(tree, name) for name in names], owner, leaves)


def _cure(name: str) -> str:
    mechanism = symbols()[name].mechanism if name in symbols() else None
    if mechanism is not None:
        return f"add {mechanism!r} to its mechanisms, or fix the parameter"
    return "fix the parameter"


def _kinds() -> Iterator[type[ParameterSet]]:
    """The parameters of every network that is defined, the LGMD2's first."""
    kinds = [Parameters, *ParameterSet.__subclasses__()]
    for kind in kinds:
        yield kind
        kinds.extend(kind.__subclasses__())


def _symbols(kind: type[ParameterSet]) -> dict[str, Symbol]:
    return symbols(kind) | observation_symbols()


def _check_name(name: str, role: str, kind: type[ParameterSet]) -> None:
    known = _symbols(kind)
    if name not in known:
        raise ValueError(f"{role} is {name!r}; choose {nearest(name, known)}")


def _free_parameter(name: str, choice, symbol: Symbol) -> FreeParameter:
    if choice is None:
        choice = Range()
    elif not isinstance(choice, Range):
        try:
            low, high = (float(bound) for bound in choice)
        except (TypeError, ValueError):
            raise ValueError(f"{name} is free in {choice!r}; give (low, high), None, Linear, Log or Tie") from None
        choice = Linear(low, high)
    scale: Scale = "linear" if isinstance(choice, Linear) else "log" if isinstance(choice, Log) else symbol.scale
    try:
        low, high = (
            float(bound if given is None else given)
            for given, bound in zip((choice.low, choice.high), symbol.bounds, strict=True)
        )
    except (TypeError, ValueError):
        raise ValueError(f"{name} has the bounds {choice.low!r} and {choice.high!r}; give numbers") from None
    for bound in (low, high):
        if not (math.isfinite(bound) and symbol.contains(bound)):
            raise ValueError(f"{name} has the bound {bound:g}; it must lie in {symbol.domain}")
    check_bounds(name, low, high, scale)
    return FreeParameter(name, symbol, low, high, scale, _prior(name, choice.prior))


def _prior(name: str, prior) -> tuple[float, float] | None:
    if prior is None:
        return None
    try:
        mean, deviation = (float(number) for number in prior)
    except (TypeError, ValueError):
        raise ValueError(f"{name} has the prior {prior!r}; give a pair (mean, standard deviation)") from None
    if not (math.isfinite(mean) and math.isfinite(deviation) and deviation > 0):
        raise ValueError(f"{name} has the prior ({mean:g}, {deviation:g}); its standard deviation must be positive")
    return mean, deviation
