"""Changes of light: steps and ramps of the whole field or of its middle."""

import jax
import jax.numpy as jnp

from lgmd2jax._eye import Eye
from lgmd2jax._types import Scalar, Times
from lgmd2jax.stimuli._arguments import number, positive
from lgmd2jax.stimuli._background import Uniform
from lgmd2jax.stimuli._family import family
from lgmd2jax.stimuli._scene import Look, Trajectory, grey_level, sketch_object
from lgmd2jax.stimuli._stimulus import Sketch, frame_times
from lgmd2jax.stimuli._units import GreyLevel, Milliseconds, ShareOfField, WeberContrast


class _Middle(Trajectory):
    """A part of the field around its centre, of its own form, `side` times as high and wide."""

    side: Scalar

    def __call__(self, eye, time):
        across, up = self.side * eye.cols / 2, self.side * eye.rows / 2
        return jnp.tile(jnp.stack([-across, across, -up, up]), (time.size, 1)), {}


@family
def luminance(
    eye: Eye,
    *,
    contrast: WeberContrast = -0.5,
    level: GreyLevel | None = None,
    background: GreyLevel = 200.0,
    fraction: ShareOfField = 1.0,
    ramp_ms: Milliseconds = 0.0,
    hold_ms: Milliseconds | None = None,
    start_ms: float | int | None = None,
    end_ms: float | int | None = None,
) -> Sketch:
    """The field, or its middle, changes from the background's grey level to another. 0 ms is the onset.

    **Arguments:**

    - `contrast`: Weber contrast of the new level; or `level`, grey level 0..255.
    - `background`: grey level before, and around the part that changes.
    - `fraction`: of the field's area that changes, in the middle and of the field's own form.
    - `ramp_ms`: how long the change takes; 0 for a step.
    - `hold_ms`: how long the new level stays before it goes back in the same way; by default it stays.
    - `start_ms`, `end_ms`: plain numbers; by default from 500 ms before the change to 500 ms after it.

    **Raises:** `ValueError` for levels outside of 0..255, a fraction outside of 0..1 and negative times.
    """
    ground = Uniform(background)
    target = grey_level(ground, "contrast", contrast, "level", level)
    side = jnp.sqrt(positive("fraction", fraction, ShareOfField, 1))
    ramp = number("ramp_ms", ramp_ms, Milliseconds, 0)
    hold = None if hold_ms is None else number("hold_ms", hold_ms, Milliseconds, 0)
    time = frame_times(eye, start_ms, end_ms, 0.0, ramp if hold is None else 2 * ramp + hold)
    levels = _levels(time, ground.level, target, ramp, hold)
    sketch = sketch_object(eye, time, ground, Look(levels, levels), _Middle(side))
    return Sketch(time, lambda: (sketch.draw()[0], {"level": levels}))


@jax.jit
def _levels(time: Times, ground: Scalar, target: Scalar, ramp: Scalar, hold: Scalar | None) -> Times:
    """The grey level over time."""

    def change(since):
        """0 before, 1 after; a ramp of no length is a step, which frame 0 shows already."""
        return jnp.where(ramp > 0, jnp.clip(since / jnp.where(ramp > 0, ramp, 1), 0, 1), since >= 0)

    back = 0 if hold is None else change(time - ramp - hold)
    return ground + (target - ground) * (change(time) - back)
