"""Curves over conditions, as figures and JSON show them."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import Curves, mean, peak, top
from lgmd2jax._characterise.measures_field import SETTLED_MS, changes_of_light
from lgmd2jax._characterise.measures_looming import LOOMS, angles_at_peak
from lgmd2jax._characterise.trials import (
    CHANGES,
    CONTRASTS,
    DEVIATIONS,
    DIRECTIONS,
    GRATING_MS,
    GRATINGS,
    L_OVER_V,
    LIGHT_LOOM,
    LIGHT_RECESSION,
    RECESSION,
    REFERENCE,
    SPEEDS,
)

_OBJECTS = {
    "dark\nloom": REFERENCE,
    "light\nloom": LIGHT_LOOM,
    "dark\nrecession": RECESSION,
    "light\nrecession": LIGHT_RECESSION,
    "dark bar\ngrows": trials.bar("dark", True),
    "dark bar\nshrinks": trials.bar("dark", False),
    "trans-\nlation": trials.translation(),
}

# What each panel's values stand over: its name with the unit, and numbers or names.
OVER: dict[str, tuple[str, tuple[float, ...] | tuple[str, ...]]] = {
    "peak time before collision (ms)": ("l/|v| (ms)", L_OVER_V),
    "angle at t_peak - D (deg)": ("l/|v| (ms)", L_OVER_V),
    "peak R, approach": ("l/|v| (ms)", L_OVER_V),
    "peak R, contrast": ("Weber contrast", CONTRASTS),
    "peak R, speed": ("speed (deg/s)", SPEEDS),
    "peak R, direction": ("direction (deg)", DIRECTIONS),
    "peak R, deviation": ("deviation (deg)", DEVIATIONS),
    "mean R, grating": ("cyc/deg, Hz", tuple(f"{cycles:g}\n{hertz:g}" for cycles, hertz in GRATINGS)),
    "largest R, change of light": ("", tuple(trials.change(*each) for each in CHANGES)),
    "peak R, objects": ("", tuple(_OBJECTS)),
}


def panels(curves: Curves) -> dict[str, Float[Array, " _place"]]:
    """The values of each panel; NaN for a grating that the eye does not sample."""
    gratings = []
    for name in (trials.grating(*each) for each in GRATINGS):
        stack = curves(name) if name in curves.exam.places else None
        gratings.append(jnp.nan if stack is None else mean(stack, stack.between(SETTLED_MS, GRATING_MS))[0])
    values = (
        -peak(curves(*LOOMS))[1],
        angles_at_peak(curves, *LOOMS, l_over_v=np.array(L_OVER_V)),
        top(curves, *LOOMS),
        top(curves, *map(trials.contrast, CONTRASTS)),
        top(curves, *map(trials.translation, SPEEDS)),
        top(curves, *(trials.translation(direction=direction) for direction in DIRECTIONS)),
        top(curves, *map(trials.deviating, DEVIATIONS)),
        jnp.stack(gratings),
        jnp.stack(changes_of_light(curves)),
        top(curves, *_OBJECTS.values()),
    )
    return dict(zip(OVER, values, strict=True))
