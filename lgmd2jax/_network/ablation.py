"""Taking one mechanism out of a model, as a pharmacologist would."""

from collections.abc import Mapping

import equinox as eqx
import jax.numpy as jnp

from lgmd2jax._network.abstract import AnyNetwork, Network
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.yue_rind import YueRindLGMD1
from lgmd2jax._words import nearest

ABLATIONS: Mapping[str, Mapping[str, float]] = {
    "ffi": {"T_ffi": 1e9},
    "sfa": {"T_sfa": -1.0, "tau3": 1e9},
    "lateral": {"w_bias": 0.0},
    "on": {"theta1": 0.0, "theta3": 0.0},
    "off": {"theta2": 0.0, "theta3": 0.0},
}
_OF = {LGMD2: ABLATIONS, YueRindLGMD1: {"ffi": {"T_ffi": 1e9}, "lateral": {"W_I": 0.0}}}


def mechanisms_of(model: Network) -> Mapping[str, Mapping[str, float]]:
    """The mechanisms that the model has, with the values that take them out."""
    return _OF[type(model)]


def ablate(model: AnyNetwork, *mechanisms: str) -> AnyNetwork:
    """The model without the named mechanisms.

    - `"ffi"`: feed-forward inhibition never silences the cell.
    - `"sfa"`: no spike-frequency adaptation; `smp_adapted` is `smp`.
    - `"lateral"`: no inhibition in the local sums (eq. 7).
    - `"on"`, `"off"`: the pathway, and its product with the other, carries no weight (eq. 8).

    **Raises:** `ValueError` for another name, and for what the model does not have: a `YueRindLGMD1` has
    FFI and lateral inhibition alone.
    """
    known = mechanisms_of(model)
    for mechanism in mechanisms:
        if mechanism not in known:
            raise ValueError(f"mechanism is {mechanism!r}; choose {nearest(mechanism, known)}")
        values = {
            name: jnp.full_like(getattr(model.parameters, name), value) for name, value in known[mechanism].items()
        }
        model = eqx.tree_at(
            lambda model, names=tuple(values): [getattr(model.parameters, name) for name in names],
            model,
            list(values.values()),
        )
    return model
