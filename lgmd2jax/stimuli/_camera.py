"""A camera that films the screen: blur, flicker, sensor noise, quantisation."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._types import Key, check_key
from lgmd2jax.stimuli._arguments import number
from lgmd2jax.stimuli._stimulus import Stimulus
from lgmd2jax.stimuli._units import GreyLevelDeviation, Hertz, Pixels, ShareOfLight

# Of cameras by chance: noise in grey levels, flicker as a share of the light and its frequency in Hz.
NOISE, FLICKER, FLICKER_HZ = (0.5, 3.0), (0.0, 0.02), (100.0, 120.0)
# Frame rates of films by those of the files that they were converted to: in one of 30 frames a second 20, 24 and 25.
FILM_BY_FILE = 2 / 3, 4 / 5, 5 / 6

_SHARP = 1e-3  # pixels; a blur below it is none


@checked
def camera(
    stimulus: Stimulus,
    key: Key,
    *,
    noise: GreyLevelDeviation = 2.0,
    flicker: ShareOfLight = 0.0,
    flicker_hz: Hertz = 100.0,
    blur: Pixels = 0.0,
    bits: int | None = 8,
) -> Stimulus:
    """The stimulus as a camera delivers it, with blur, flicker of the light, noise and whole grey levels.

    **Arguments:**

    - `key`: of the noise, and of the phase of the flicker.
    - `noise`: standard deviation of the sensor's noise, in grey levels; independent for pixels and frames.
    - `flicker`: amplitude of the light's flicker, as a share of its mean strength.
    - `flicker_hz`: frequency of the flicker; a frame samples it at one moment, so that it beats with the frame rate.
    - `blur`: standard deviation of the lens's Gaussian, in pixels.
    - `bits`: of the digital output, 0..255 in 2^bits steps; None for an analogue one. Rounding passes slopes unchanged.

    **Raises:** `ValueError` for negative strengths, and for bits outside of 1..16.
    """
    check_key(key)
    if bits is not None and not (isinstance(bits, int) and 1 <= bits <= 16):
        raise ValueError(f"bits is {bits!r}; give a whole number in 1..16, or None")
    noise = number("noise", noise, GreyLevelDeviation, 0)
    flicker = number("flicker", flicker, ShareOfLight, 0, 1)
    flicker_hz = number("flicker_hz", flicker_hz, Hertz, 0)
    blur = number("blur", blur, Pixels, 0)
    frames = _film(stimulus.frames, stimulus.time, key, noise, flicker, flicker_hz, blur, bits)
    return dataclasses.replace(stimulus, frames=frames, parameters={**stimulus.parameters, "noise": noise})


@functools.partial(jax.jit, static_argnames="bits")
def _film(frames, time, key, noise, flicker, flicker_hz, blur, bits: int | None) -> Float[Array, "time row col"]:
    noise_key, phase_key = jax.random.split(key)
    dtype, (_, rows, cols) = frames.dtype, frames.shape
    frames = _gaussian(rows, blur) @ frames @ _gaussian(cols, blur).T
    phase = 2 * np.pi * (flicker_hz * time / 1000 + jax.random.uniform(phase_key))
    frames = frames * (1 + flicker * jnp.sin(phase))[:, None, None]
    frames = jnp.clip(frames + noise * jax.random.normal(noise_key, frames.shape), 0, 255)
    if bits is not None:
        step = 255 / (2**bits - 1)
        frames = frames + jax.lax.stop_gradient(step * jnp.round(frames / step) - frames)
    return frames.astype(dtype)


def _gaussian(size: int, blur: Float[Array, ""]) -> Float[Array, "size size"]:
    """A matrix that blurs along one side; near the border it weighs what there is."""
    apart = jnp.arange(size)[:, None] - jnp.arange(size)[None, :]
    weights = jnp.exp(-((apart / jnp.maximum(blur, _SHARP)) ** 2) / 2)
    return weights / jnp.sum(weights, axis=1, keepdims=True)
