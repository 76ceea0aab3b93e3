"""What users give a network: frames and clocks, checked and made arrays of JAX's."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from lgmd2jax._arguments.units import has_unit
from lgmd2jax._types import is_concrete
from lgmd2jax._words import warn
from lgmd2jax.hard import BRIGHTEST


def as_pixels(frames, name: str, shape: str, rank: int) -> Array:
    """Frames as an array of JAX's, their shape and dtype checked."""
    if isinstance(frames, np.ma.MaskedArray):
        raise ValueError(f"{name} is masked; fill what is masked with a grey level first: {name}.filled(128)")
    if isinstance(frames, np.ndarray):
        frames = frames.astype(frames.dtype.newbyteorder("="), copy=False)  # as the files of some instruments are not
    try:
        frames = jnp.asarray(frames)
    except (TypeError, ValueError):
        what = f"has dtype {frames.dtype}" if isinstance(frames, np.ndarray) else f"is {frames!r:.40}"
        raise ValueError(f"{name} {what}; give an array of grey levels as {shape}") from None
    if frames.ndim != rank:
        raise ValueError(f"{name} has shape {frames.shape}; give grey levels as {shape}")
    if min(frames.shape[-2:]) < 3:
        raise ValueError(f"{name} has shape {frames.shape}; the lateral spread needs at least 3 rows and 3 columns")
    if not jnp.issubdtype(frames.dtype, jnp.integer) and frames.dtype not in (jnp.float32, jnp.float64):
        raise ValueError(f"{name} has dtype {frames.dtype}; give integers, float32 or float64")
    return frames


def check_record(record: object) -> None:
    if not (record is None or callable(record)):
        raise ValueError(f"record is {record!r:.60}; give a function of the layers, such as lambda layers: layers.s")


def warn_of_levels(frames: np.ndarray) -> None:
    """Warn of frames that are hardly meant in grey levels 0..255."""
    lowest, highest = frames.min(), frames.max()
    if -1 <= lowest < highest <= 1:
        span = "0..1" if lowest >= 0 else "-1..1"
        warn(f"frames lie in {span}; were grey levels in 0..255 meant? Give black as 0 and white as 255")
    elif BRIGHTEST < highest < np.inf:
        warn(f"frames reach {highest:g}; grey levels lie in 0..255: multiply by 255 over what is white")


def positive(value, name: str, unit: str, shape: tuple[int, ...]) -> Array:
    """A strong array, so that another value does not compile again; checked where it is concrete."""
    of = f"{shape[0]} positive numbers" if shape else "a positive number"
    other = has_unit(value) or np.shape(value) != shape
    if other or (not isinstance(value, jax.Array) and np.asarray(value).dtype.kind not in "iuf"):
        raise ValueError(f"{name} is {value!r:.60}; give {of} of {unit}")
    if is_concrete(value) and not np.all((np.asarray(value) > 0) & np.isfinite(value)):
        raise ValueError(f"{name} is {value!r:.60}; give {of} of {unit}")
    return jnp.asarray(value, dtype=float)
