"""The parameters of the network, by the paper's symbols, and all that is known of each."""

import abc
import dataclasses
from collections.abc import Mapping
from typing import Literal, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._types import is_concrete
from lgmd2jax._words import nearest

_TABLE_I = "Fu, Hu & Yue, Table I"


@dataclasses.dataclass(frozen=True)
class Symbol:
    """What is known of one parameter.

    - `meaning`: what it does, with the equation that it stands in.
    - `unit`: `"1"` for a plain number.
    - `domain`: the values that make sense at all, as an interval such as `"(0, inf)"`; square brackets include the end.
    - `bounds`: the range that a fit searches by default.
    - `source`: where default and bounds come from.
    - `scale`: how a fit measures within the bounds; `"log"` for what is a matter of factors.
    """

    meaning: str
    unit: str
    domain: str
    bounds: tuple[float, float]
    source: str
    scale: Literal["linear", "log"] = "linear"

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


def _scalar(value) -> Array:
    """A strongly typed floating scalar, so that a value never changes what is compiled."""
    value = value if eqx.is_array(value) else np.asarray(value)
    if value.dtype.kind not in "fiub":
        raise ValueError(f"a parameter is {value!s}; give a number")
    if not jnp.issubdtype(value.dtype, jnp.floating):
        value = value.astype(float)
    return jnp.asarray(value, dtype=jax.dtypes.canonicalize_dtype(value.dtype))


def _symbol(
    meaning: str,
    unit: str,
    domain: str,
    bounds: tuple[float, float],
    source: str = _TABLE_I,
    scale: Literal["linear", "log"] = "linear",
):
    return {"symbol": Symbol(meaning, unit, domain, bounds, source, scale)}


class Levels(NamedTuple):
    """Where a curve crosses what: the SMP from which there are one, two.. spikes, the FFI that forbids them."""

    spikes: tuple[float, ...]
    ffi: float

    @property
    def by_count(self) -> dict[str, float]:
        """The SMP from which there is `1 spike`, from which there are `2 spikes`, and so on."""
        return {f"{count} spike{'s' * (count > 1)}": level for count, level in enumerate(self.spikes, start=1)}


class ParameterSet(eqx.Module):
    """Parameters of a network that declare themselves: one floating scalar each, so the whole is a pytree of leaves.

    By the same symbols each has u, T_ffi, k and T_sp, and in `levels` what figures draw.

    **Raises:** `ValueError` for a value outside its domain, when the value is concrete (not traced).
    """

    @property
    @abc.abstractmethod
    def levels(self) -> Levels:
        """The thresholds of the cell, as figures draw them."""

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

    def __repr__(self):
        rows, width = [], max(map(len, declared(type(self))))
        for name, symbol in declared(type(self)).items():
            leaf = getattr(self, name)
            value = f"{leaf:.6g}" if is_concrete(leaf) and np.ndim(leaf) == 0 else eqx.tree_pformat(leaf)
            unit = "" if symbol.unit == "1" else symbol.unit
            rows.append(f"  {name:{width}} = {value:<10} {unit:12} {symbol.meaning}")
        return f"{type(self).__name__}(\n" + "\n".join(rows) + "\n)"


class Parameters(ParameterSet):
    """The network's parameters by the paper's symbols: one floating scalar each, so the whole is a pytree of leaves.

    The defaults are Table I of the paper (point values where it gives a range). `symbols()` says what each means, in
    which unit, where it may lie and where a fit searches. For a batch of sets, build them under `jax.vmap`.

    **Raises:** `ValueError` for a value outside its domain, when the value is concrete (not traced).
    """

    theta1: Float[Array, ""] = eqx.field(
        default=0.0,
        converter=_scalar,
        metadata=_symbol("weight of the ON pathway (eq. 8)", "1", "[0, inf)", (0.0, 0.1)),
    )
    theta2: Float[Array, ""] = eqx.field(
        default=1.0,
        converter=_scalar,
        metadata=_symbol("weight of the OFF pathway (eq. 8)", "1", "[0, inf)", (1.0, 6.0)),
    )
    theta3: Float[Array, ""] = eqx.field(
        default=0.0,
        converter=_scalar,
        metadata=_symbol("weight of the product of ON and OFF (eq. 8)", "1/grey level", "[0, inf)", (0.0, 0.1)),
    )
    tau1: Float[Array, ""] = eqx.field(
        default=30.0,
        converter=_scalar,
        metadata=_symbol("delay of the lateral flow (eq. 4)", "ms", "(0, inf)", (5.0, 50.0), scale="log"),
    )
    tau2: Float[Array, ""] = eqx.field(
        default=30.0,
        converter=_scalar,
        metadata=_symbol("delay of the feed-forward inhibition (eq. 14)", "ms", "(0, inf)", (5.0, 100.0), scale="log"),
    )
    tau3: Float[Array, ""] = eqx.field(
        default=500.0,
        converter=_scalar,
        metadata=_symbol(
            "time constant of spike-frequency adaptation (eq. 15)", "ms", "(0, inf)", (400.0, 1000.0), scale="log"
        ),
    )
    w_bias: Float[Array, ""] = eqx.field(
        default=0.3,
        converter=_scalar,
        metadata=_symbol("weight of the inhibition in a local sum (eq. 7)", "1", "[0, inf)", (0.05, 1.0)),
    )
    sigma1: Float[Array, ""] = eqx.field(
        default=0.1,
        converter=_scalar,
        metadata=_symbol("share of ON and OFF kept from the frame before (eq. 3)", "1", "[0, 1)", (0.0, 0.5)),
    )
    T_s: Float[Array, ""] = eqx.field(
        default=10.0,
        converter=_scalar,
        metadata=_symbol("threshold of the S layer (eq. 9)", "grey level", "[0, inf)", (1.0, 50.0), scale="log"),
    )
    T_ffi: Float[Array, ""] = eqx.field(
        default=10.0,
        converter=_scalar,
        metadata=_symbol(
            "feed-forward inhibition above which the cell is silenced",
            "grey level",
            "(0, inf)",
            (1.0, 60.0),
            scale="log",
        ),
    )
    T_sfa: Float[Array, ""] = eqx.field(
        default=1e-3,
        converter=_scalar,
        metadata=_symbol(
            "rise of the SMP in a frame up to which adaptation acts (eq. 15)", "1", "[-1, 1]", (1e-5, 1e-2), scale="log"
        ),
    )
    T_sp: Float[Array, ""] = eqx.field(
        default=0.78, converter=_scalar, metadata=_symbol("spiking threshold (eq. 16)", "1", "(0.5, 1)", (0.6, 0.85))
    )
    sigma_sp: Float[Array, ""] = eqx.field(
        default=0.1,
        converter=_scalar,
        metadata=_symbol("step above T_sp from which there are two spikes (eq. 16)", "1", "[0, inf)", (0.02, 0.3)),
    )
    k: Float[Array, ""] = eqx.field(
        default=1.0,
        converter=_scalar,
        metadata=_symbol(
            "mean potential of a pixel that maps to sigma(1) (eq. 12)",
            "grey level",
            "(0, inf)",
            (0.1, 2.0),
            scale="log",
        ),
    )
    u: Float[Array, ""] = eqx.field(
        default=1.0,
        converter=_scalar,
        metadata=_symbol(
            "decay of the photoreceptors' persistence, where n_p > 0 (eq. 1)",
            "1",
            "(-inf, inf)",
            (0.0, 3.0),
            source="free in the paper",
        ),
    )
    N_sp: Float[Array, ""] = eqx.field(
        default=6.0,
        converter=_scalar,
        metadata=_symbol("spikes in N_ts + 1 frames that make an alarm (eq. 17)", "spikes", "(0, inf)", (1.0, 10.0)),
    )

    @property
    def levels(self) -> Levels:
        """The thresholds of the cell, as figures draw them."""
        return Levels((float(self.T_sp), float(self.T_sp + self.sigma_sp)), float(self.T_ffi))


def symbols(kind: type[ParameterSet] = Parameters) -> dict[str, Symbol]:
    """What is known of each parameter, by name, in the order of the fields: of the LGMD2, or of another network's."""
    return declared(kind)


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


PRESETS: Mapping[str, Mapping[str, float]] = {
    "lgmd2": {},
    "balanced": {"theta1": 1.0},
    "light_selective": {"theta1": 1.0, "theta2": 0.0},
}


def preset(name: str, **changes: float | int) -> Parameters:
    """One of the parameter sets that the paper names, with single parameters changed.

    - `"lgmd2"`: Table I; the ON pathway is blocked, so the cell answers dark approach.
    - `"balanced"`: ON and OFF alike, the paper's LGMD1 by this circuit.
    - `"light_selective"`: the OFF pathway is blocked, so the cell answers light objects.

    **Raises:** `ValueError` for another name, and for values outside of their domain.
    """
    if name not in PRESETS:
        raise ValueError(f"preset is {name!r}; choose {nearest(name, PRESETS)}")
    return Parameters(**{**PRESETS[name], **changes})
