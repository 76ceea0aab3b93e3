"""The parameters of the LGMD2 network, by the paper's symbols, and all that is known of each."""

import functools
from collections.abc import Mapping

import equinox as eqx
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._network.parameter_set import ParameterSet, Symbol, declared, declares, scalar
from lgmd2jax._words import nearest

_OURS = "; formula and bounds are this project's"
_SIZE = "inhibition codes size: Wang, Dewell, Zhu & Gabbiani 2018; Gabbiani, Cohen & Laurent 2005" + _OURS
_SHUNT = "multiplication by division: Keil 2011; exponentiation: Gabbiani et al. 2002" + _OURS
_LAG = "delays of photoreceptors, lamina and synapses" + _OURS
_MEMBRANE = "leaky membrane" + _OURS
_LAMINA = "transient answers of the large monopolar cells: Laughlin 1981; Srinivasan, Laughlin & Dubs 1982" + _OURS
_HABITUATION = "habituation of the synapses onto the LGMD: O'Shea & Rowell 1976" + _OURS
_declares = functools.partial(declares, source="Fu, Hu & Yue, Table I")


@checked
class Parameters(ParameterSet):
    """The network's parameters by the paper's symbols: one floating scalar each, so the whole is a pytree of leaves.

    The defaults are Table I of the paper (point values where it gives a range). The last ones belong to mechanisms that
    the paper's circuit does not have (`LGMD2(mechanisms=...)`); without them they act on nothing. `symbols()` says what
    each means, in which unit, where it may lie and where a fit searches. For a batch, build them under `jax.vmap`.

    **Raises:** `ValueError` for a value outside its domain, when the value is concrete (not traced).
    """

    theta1: Float[Array, ""] = eqx.field(
        default=0.0,
        converter=scalar,
        metadata=_declares("weight of the ON pathway (eq. 8)", "1", "[0, inf)", (0.0, 0.1), stage="pixels"),
    )
    theta2: Float[Array, ""] = eqx.field(
        default=1.0,
        converter=scalar,
        metadata=_declares("weight of the OFF pathway (eq. 8)", "1", "[0, inf)", (1.0, 6.0), stage="pixels"),
    )
    theta3: Float[Array, ""] = eqx.field(
        default=0.0,
        converter=scalar,
        metadata=_declares(
            "weight of the product of ON and OFF (eq. 8)", "1/grey level", "[0, inf)", (0.0, 0.1), stage="pixels"
        ),
    )
    tau1: Float[Array, ""] = eqx.field(
        default=30.0,
        converter=scalar,
        metadata=_declares(
            "delay of the lateral flow (eq. 4)", "ms", "(0, inf)", (5.0, 50.0), scale="log", stage="pixels"
        ),
    )
    tau2: Float[Array, ""] = eqx.field(
        default=30.0,
        converter=scalar,
        metadata=_declares(
            "delay of the feed-forward inhibition (eq. 14)", "ms", "(0, inf)", (5.0, 100.0), scale="log"
        ),
    )
    tau3: Float[Array, ""] = eqx.field(
        default=500.0,
        converter=scalar,
        metadata=_declares(
            "time constant of spike-frequency adaptation (eq. 15)", "ms", "(0, inf)", (400.0, 1000.0), scale="log"
        ),
    )
    w_bias: Float[Array, ""] = eqx.field(
        default=0.3,
        converter=scalar,
        metadata=_declares(
            "weight of the inhibition in a local sum (eq. 7)", "1", "[0, inf)", (0.05, 1.0), stage="pixels"
        ),
    )
    sigma1: Float[Array, ""] = eqx.field(
        default=0.1,
        converter=scalar,
        metadata=_declares(
            "share of ON and OFF kept from the frame before (eq. 3)",
            "1",
            "[0, 1)",
            (0.0, 0.5),
            stage="pixels",
            per_frame="share",
        ),
    )
    T_s: Float[Array, ""] = eqx.field(
        default=10.0,
        converter=scalar,
        metadata=_declares(
            "threshold of the S layer (eq. 9)",
            "grey level",
            "[0, inf)",
            (1.0, 50.0),
            scale="log",
            stage="pixels",
            per_frame="change",
        ),
    )
    T_ffi: Float[Array, ""] = eqx.field(
        default=10.0,
        converter=scalar,
        metadata=_declares(
            "feed-forward inhibition above which the cell is silenced",
            "grey level",
            "(0, inf)",
            (1.0, 60.0),
            scale="log",
            per_frame="change",
            of_field=True,
        ),
    )
    T_sfa: Float[Array, ""] = eqx.field(
        default=1e-3,
        converter=scalar,
        metadata=_declares(
            "rise of the SMP in a frame up to which adaptation acts (eq. 15)",
            "1",
            "[-1, 1]",
            (1e-5, 1e-2),
            scale="log",
            per_frame="change",
        ),
    )
    T_sp: Float[Array, ""] = eqx.field(
        default=0.78, converter=scalar, metadata=_declares("spiking threshold (eq. 16)", "1", "(0.5, 1)", (0.6, 0.85))
    )
    sigma_sp: Float[Array, ""] = eqx.field(
        default=0.1,
        converter=scalar,
        metadata=_declares("step above T_sp from which there are two spikes (eq. 16)", "1", "[0, inf)", (0.02, 0.3)),
    )
    k: Float[Array, ""] = eqx.field(
        default=1.0,
        converter=scalar,
        metadata=_declares(
            "mean potential of a pixel that maps to sigma(1) (eq. 12)",
            "grey level",
            "(0, inf)",
            (0.1, 2.0),
            scale="log",
            per_frame="change",
            of_field=True,
        ),
    )
    u: Float[Array, ""] = eqx.field(
        default=1.0,
        converter=scalar,
        metadata=_declares(
            "decay of the photoreceptors' persistence, where n_p > 0 (eq. 1)",
            "1",
            "(-inf, inf)",
            (-1.5, 3.0),  # what u = 0 leaves after a frame at 30 fps, -1.5 leaves after as long a time at 100 fps
            source="free in the paper",
            stage="pixels",
            per_frame="persistence",
        ),
    )
    N_sp: Float[Array, ""] = eqx.field(
        default=6.0,
        converter=scalar,
        metadata=_declares(
            "spikes in N_ts + 1 frames that make an alarm (eq. 17)",
            "spikes",
            "(0, inf)",
            (1.0, 10.0),
            per_frame="count",
        ),
    )
    T_p: Float[Array, ""] = eqx.field(
        default=19.0,
        converter=scalar,
        metadata=declares(
            "step of luminance (behind a lamina: of D) from which a pixel counts as changed",
            "grey level",
            "(0, inf)",
            (5.0, 60.0),
            _SIZE,
            scale="log",
            stage="pixels",
            mechanism="size",
        ),
    )
    tau_hold: Float[Array, ""] = eqx.field(
        default=250.0,
        converter=scalar,
        metadata=declares(
            "how long a changed pixel counts",
            "ms",
            "(0, inf)",
            (30.0, 2000.0),
            _SIZE,
            scale="log",
            stage="pixels",
            mechanism="size",
        ),
    )
    A_ffi: Float[Array, ""] = eqx.field(
        default=0.09,
        converter=scalar,
        metadata=declares(
            "share of the field that changed recently, from which the cell is inhibited",
            "1",
            "(0, inf)",
            (0.005, 0.5),
            _SIZE,
            scale="log",
            of_field=True,
            mechanism="size",
        ),
    )
    m: Float[Array, ""] = eqx.field(
        default=4.5,
        converter=scalar,
        metadata=declares(
            "steepness of the shunt", "1", "(0, inf)", (1.0, 20.0), _SHUNT, scale="log", mechanism="shunt"
        ),
    )
    gamma: Float[Array, ""] = eqx.field(
        default=0.65,
        converter=scalar,
        metadata=declares("exponent of the excitation", "1", "(0, inf)", (0.3, 1.5), _SHUNT, mechanism="shunt"),
    )
    lag: Float[Array, ""] = eqx.field(
        default=30.0,
        converter=scalar,
        metadata=declares(
            "time from the photoreceptors to the cell", "ms", "[0, 80]", (0.0, 80.0), _LAG, mechanism="lag"
        ),
    )
    tau_cell: Float[Array, ""] = eqx.field(
        default=26.0,
        converter=scalar,
        metadata=declares(
            "time constant of the membrane", "ms", "[0, inf)", (0.0, 80.0), _MEMBRANE, mechanism="membrane"
        ),
    )
    tau_lamina: Float[Array, ""] = eqx.field(
        default=100.0,
        converter=scalar,
        metadata=declares(
            "time constant with which the lamina returns to rest after a change of luminance",
            "ms",
            "(0, inf)",
            (10.0, 500.0),
            _LAMINA,
            scale="log",
            stage="pixels",
            mechanism="lamina",
        ),
    )
    tau_hab: Float[Array, ""] = eqx.field(
        default=400.0,
        converter=scalar,
        metadata=declares(
            "time constant of habituation, and of recovery from it",
            "ms",
            "(0, inf)",
            (50.0, 2000.0),
            _HABITUATION,
            scale="log",
            stage="pixels",
            mechanism="habituation",
        ),
    )
    S_hab: Float[Array, ""] = eqx.field(
        default=10.0,
        converter=scalar,
        metadata=declares(
            "excitation by a pixel of late that halves what it adds",
            "grey level",
            "(0, inf)",
            (0.5, 100.0),
            _HABITUATION,
            scale="log",
            stage="pixels",
            per_frame="change",
            mechanism="habituation",
        ),
    )


@checked
def symbols(kind: type[ParameterSet] = Parameters) -> dict[str, Symbol]:
    """What is known of each parameter, by name, in the order of the fields: of the LGMD2, or of another network's."""
    return declared(kind)


PRESETS: Mapping[str, Mapping[str, float]] = {
    "lgmd2": {},
    "balanced": {"theta1": 1.0},
    "light_selective": {"theta1": 1.0, "theta2": 0.0},
}
"""The sets of `preset`, by what each has otherwise than Table I."""


@checked
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
