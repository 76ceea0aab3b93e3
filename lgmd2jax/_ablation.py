"""Taking one mechanism out of a model, as a pharmacologist would."""

from collections.abc import Mapping

import equinox as eqx
import jax.numpy as jnp

from lgmd2jax._model import LGMD2
from lgmd2jax._parameters import nearest

ABLATIONS: Mapping[str, Mapping[str, float]] = {
    "ffi": {"T_ffi": 1e9},
    "sfa": {"T_sfa": -1.0, "tau3": 1e9},
    "lateral": {"w_bias": 0.0},
    "on": {"theta1": 0.0, "theta3": 0.0},
    "off": {"theta2": 0.0, "theta3": 0.0},
}


def ablate(model: LGMD2, *mechanisms: str) -> LGMD2:
    """The model without the named mechanisms.

    - `"ffi"`: feed-forward inhibition never silences the cell.
    - `"sfa"`: no spike-frequency adaptation; `smp_adapted` is `smp`.
    - `"lateral"`: no inhibition in the local sums (eq. 7).
    - `"on"`, `"off"`: the pathway, and its product with the other, carries no weight (eq. 8).

    **Raises:** `ValueError` for another name.
    """
    for mechanism in mechanisms:
        if mechanism not in ABLATIONS:
            raise ValueError(f"mechanism is {mechanism!r}; choose {nearest(mechanism, ABLATIONS)}")
        values = {
            name: jnp.full_like(getattr(model.parameters, name), value) for name, value in ABLATIONS[mechanism].items()
        }
        model = eqx.tree_at(
            lambda model, names=tuple(values): [getattr(model.parameters, name) for name in names],
            model,
            list(values.values()),
        )
    return model
