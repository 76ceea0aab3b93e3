"""What a parameter declares of itself, and sets of such parameters."""

import dataclasses
from collections.abc import Callable
from typing import Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from lgmd2jax._arguments.checked import checked
from lgmd2jax._types import is_concrete
from lgmd2jax._words import warn

Stage = Literal["pixels", "cell", "observation"]
Rule = Literal["as it is", "change", "share", "persistence", "count"]

# How a value that belongs to one frame interval becomes that of another one, `ratio` times as long.
_RULES: dict[Rule, Callable] = {
    "as it is": lambda value, ratio: value,
    "change": lambda value, ratio: ratio * value,
    "share": lambda value, ratio: value**ratio,
    # a = 1/(1 + exp(u)) is the share.
    "persistence": lambda value, ratio: jnp.log(jnp.expm1(ratio * jnp.log1p(jnp.exp(value)))),
    "count": lambda value, ratio: value / ratio,
}


@dataclasses.dataclass(frozen=True)
class Symbol:
    """What is known of one parameter.

    - `meaning`: what it does, with the equation that it stands in.
    - `unit`: `"1"` for a plain number.
    - `domain`: the values that make sense at all, as an interval such as `"(0, inf)"`; square brackets include the end.
    - `bounds`: the range that a fit searches by default.
    - `source`: where default and bounds come from.
    - `scale`: how a fit measures within the bounds; `"log"` for what is a matter of factors.
    - `stage`: `"pixels"` where MP and F depend on it, `"cell"` where it acts on them.
    - `per_frame`: what becomes of it at another frame rate. `"change"`: it is compared with a change in a frame and
      goes with the time that a frame lasts, unless the network sees changes per time (`at_frame_rate` tells which);
      `"share"`: that much is left after a frame; `"persistence"`: 1/(1 + exp(u)) is left, where it acts over one frame;
      `"count"`: it counts in frames.
    - `of_field`: whether it is compared with a mean over the field of view, of which an object of one size is a smaller
      share where the field is larger.
    - `mechanism`: the optional mechanism that it belongs to; None for what the network always has.
    """

    meaning: str
    unit: str
    domain: str
    bounds: tuple[float, float]
    source: str
    scale: Literal["linear", "log"] = "linear"
    stage: Stage = "cell"
    per_frame: Rule = "as it is"
    of_field: bool = False
    mechanism: str | None = None

    @property
    def limits(self) -> tuple[float, float]:
        """The two ends of `domain`."""
        low, high = self.domain[1:-1].split(",")
        return float(low), float(high)

    def contains(self, value):
        """Whether `value`, a number or an array, lies in `domain`; it is finite then, since infinity is an open end."""
        low, high = self.limits
        above = value >= low if self.domain[0] == "[" else value > low
        below = value <= high if self.domain[-1] == "]" else value < high
        return above & below

    def at_interval(self, value, ratio: float):
        """The value for frames that last `ratio` times as long, within the domain."""
        return jnp.clip(_RULES[self.per_frame](value, ratio), *self.limits)

    def in_field(self, value, ratio: float):
        """The value for a field of view of `ratio` times the area, within the domain."""
        return jnp.clip(value / ratio, *self.limits) if self.of_field else value


def scalar(value) -> Array:
    """A strongly typed floating scalar, so that a value never changes what is compiled."""
    value = value if eqx.is_array(value) else np.asarray(value)
    if value.dtype.kind not in "fiub":
        raise ValueError(f"a parameter is {value!s}; give a number")
    if not jnp.issubdtype(value.dtype, jnp.floating):
        value = value.astype(float)
    return jnp.asarray(value, dtype=jax.dtypes.canonicalize_dtype(value.dtype))


@checked
def declares(
    meaning: str,
    unit: str,
    domain: str,
    bounds: tuple[float, float],
    source: str,
    scale: Literal["linear", "log"] = "linear",
    *,
    stage: Stage = "cell",
    per_frame: Rule = "as it is",
    of_field: bool = False,
    mechanism: str | None = None,
):
    """The metadata of a field that is a parameter, for `equinox.field`.

    ```python
    class Mine(lgmd.ParameterSet):
        tau: Float[Array, ""] = eqx.field(
            default=60.0,
            converter=lgmd.scalar,
            metadata=lgmd.declares("time constant of the cell", "ms", "(0, inf)", (10.0, 300.0), "a guess", "log"),
        )
    ```

    **Arguments:** the fields of a `Symbol`, which says what each means.
    """
    return {"symbol": Symbol(meaning, unit, domain, bounds, source, scale, stage, per_frame, of_field, mechanism)}


class ParameterSet(eqx.Module):
    """Parameters of a network that declare themselves: one floating scalar each, so the whole is a pytree of leaves.

    A network of your own has a subclass: each field is a parameter that declares itself by `equinox.field(default=...,
    converter=scalar, metadata=declares(...))`; `declares` has an example.

    **Raises:** `ValueError` for a value outside its domain, when the value is concrete (not traced).
    """

    @property
    def dtype(self):
        """The type in which the parameters compute together."""
        return jnp.result_type(*(getattr(self, name).dtype for name in declared(type(self))))

    def __check_init__(self):
        for name in declared(type(self)):
            shape = jnp.shape(getattr(self, name))
            if shape != ():
                kind = type(self).__name__
                raise ValueError(
                    f"{name} has shape {shape}; a parameter is a scalar: build a batch with "
                    f"jax.vmap(lambda value: {kind}({name}=value))(values)"
                )
        check_domains(self)
        for name, symbol in declared(type(self)).items():
            value = getattr(self, name)
            # Still less is meant to be no delay at all.
            if symbol.unit == "ms" and is_concrete(value) and 1e-3 <= (ms := float(value)) < 1:
                warn(f"{name} is {ms:.4g} ms; was {1000 * ms:.4g} ms meant, given in seconds?")

    def __repr__(self):
        rows, width = [], max(map(len, declared(type(self))))
        for name, symbol in declared(type(self)).items():
            leaf = getattr(self, name)
            value = f"{leaf:.6g}" if is_concrete(leaf) and np.ndim(leaf) == 0 else eqx.tree_pformat(leaf)
            unit = "" if symbol.unit == "1" else symbol.unit
            rows.append(f"  {name:{width}} = {value:<10} {unit:12} {symbol.meaning}")
        return f"{type(self).__name__}(\n" + "\n".join(rows) + "\n)"


def declared(kind: type[eqx.Module]) -> dict[str, Symbol]:
    """What the fields of a class declare of themselves, by name."""
    return {field.name: field.metadata["symbol"] for field in dataclasses.fields(kind)}


def check_domains(owner: eqx.Module) -> None:
    """Raise `ValueError` for the first concrete value of a field that lies outside the domain declared with it."""
    for name, symbol in declared(type(owner)).items():
        leaf = getattr(owner, name)
        if not is_concrete(leaf):
            continue
        outside = np.ravel(leaf)[~symbol.contains(np.ravel(leaf))]
        if outside.size:
            unit = "" if symbol.unit == "1" else f" {symbol.unit}"
            raise ValueError(f"{name} is {outside[0]:g}{unit}; it must lie in {symbol.domain}{unit}")
