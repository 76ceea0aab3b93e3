"""Gratings that move: sinusoidal and square."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar, is_concrete
from lgmd2jax.stimuli._arguments import number, one_of, positive
from lgmd2jax.stimuli._family import family
from lgmd2jax.stimuli._pieces import in_pieces
from lgmd2jax.stimuli._stimulus import Sketch, frame_times
from lgmd2jax.stimuli._units import (
    CyclesPerDegree,
    CyclesPerImage,
    Degrees,
    GreyLevel,
    Hertz,
    MichelsonContrast,
    Milliseconds,
)

_NODES = 8  # of Gauss' rule


@family
def grating(
    eye: Eye,
    *,
    spatial_frequency: CyclesPerDegree = 0.1,
    cycles: CyclesPerImage | None = None,
    temporal_frequency: Hertz = 4.0,
    direction: Degrees = 0.0,
    contrast: MichelsonContrast = 1.0,
    background: GreyLevel = 110.0,
    waveform: str = "sine",
    duration_ms: Milliseconds = 2000.0,
    start_ms: float | int | None = None,
    end_ms: float | int | None = None,
) -> Sketch:
    """Stripes that move. Before 0 ms there is plain ground; after `duration_ms` the stripes stand.

    **Arguments:**

    - `spatial_frequency`: in cycles per degree (in the middle of the field); or `cycles` across the width of the image.
    - `temporal_frequency`: in Hz.
    - `direction`: of motion, across the stripes, in degrees: 0 to the right, 90 upwards.
    - `contrast`: Michelson, (bright - dark)/(bright + dark), in 0..1.
    - `background`: mean grey level, also of the plain ground.
    - `waveform`: `"sine"`, each pixel the value in its middle, or `"square"`, each pixel the mean over its area.
    - `duration_ms`: of the motion.
    - `start_ms`, `end_ms`: plain numbers; by default from 500 ms before the motion to 500 ms after it.

    **Raises:** `ValueError` for a frequency that aliases: half a cycle a pixel or half the frame rate, or more.
    """
    one_of("waveform", waveform, _WAVEFORMS)
    mean = number("background", background, GreyLevel, 0, 255)
    contrast = number("contrast", contrast, MichelsonContrast, 0, 1)
    bright = mean * (1 + contrast)
    if is_concrete(bright) and bright > 255 + 1e-9:
        raise ValueError(f"contrast is {contrast:g} on a mean of {mean:g}: stripes of {bright:.4g}; keep to 0..255")
    heading = jnp.radians(number("direction", direction, Degrees))
    wave = _wave_per_px(eye, spatial_frequency, cycles) * jnp.stack([jnp.cos(heading), jnp.sin(heading)])
    rate = positive("temporal_frequency", temporal_frequency, Hertz)
    name, finest = "spatial_frequency" if cycles is None else "cycles", jnp.max(jnp.abs(wave))
    if is_concrete(finest) and finest >= 0.5:
        raise ValueError(
            f"{name} aliases: {finest:.3g} cycles a pixel along rows or columns, where less than 0.5 is shown; lower it"
        )
    if is_concrete(rate) and rate >= eye.fps / 2:
        raise ValueError(
            f"temporal_frequency aliases: {rate:g} Hz, where {eye.fps:g} frames per second need less than "
            f"{eye.fps / 2:g} Hz; lower it"
        )
    duration = positive("duration_ms", duration_ms, Milliseconds)
    time = frame_times(eye, start_ms, end_ms, 0.0, duration)
    drift = rate * jnp.clip(time, 0, duration) / 1000
    return Sketch(
        time, lambda: (in_pieces(_stripes, eye, (time, drift), wave, mean, contrast, waveform), {"drift_cycles": drift})
    )


def _wave_per_px(eye: Eye, spatial_frequency: CyclesPerDegree, cycles: CyclesPerImage | None) -> Scalar:
    if cycles is not None:
        return positive("cycles", cycles, CyclesPerImage) / eye.cols
    return positive("spatial_frequency", spatial_frequency, CyclesPerDegree) / eye.pixels_per_degree


def _sine(place, wave):
    """At a drift, by the sine of a difference: sine and cosine of the places are taken once for all frames."""
    sine, cosine = jnp.sin(2 * np.pi * place), jnp.cos(2 * np.pi * place)
    return lambda drift: sine * jnp.cos(2 * np.pi * drift) - cosine * jnp.sin(2 * np.pi * drift)


def _square(place, wave):
    """Mean over a pixel's area: exact across the longer component of the wave, by Gauss' rule across the shorter."""
    steep, flat = jnp.max(jnp.abs(wave)), jnp.min(jnp.abs(wave))

    def primitive(at):
        """Of a square wave of +1 and -1: a triangle wave."""
        return 0.5 - jnp.abs(jnp.mod(at, 1) - 0.5)

    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    across = place[:, :, None] + (flat * nodes / 2)[None, None, :]

    def at(drift):
        phase = across - drift
        return (primitive(phase + steep / 2) - primitive(phase - steep / 2)) @ (weights / 2) / steep

    return at


_WAVEFORMS = {"sine": _sine, "square": _square}


@traced_once
def _stripes(eye: Eye, moments, wave, mean, contrast, waveform: str) -> Float[Array, "time row col"]:
    right, up = eye.pixel_centres()
    stripes = _WAVEFORMS[waveform](wave[0] * right + wave[1] * up, wave)

    def frame(now):
        time, drift = now
        return mean * (1 + contrast * jnp.where(time < 0, 0, stripes(drift)))

    return jax.lax.map(frame, moments)
