"""The scene that passes an eye that turns."""

import dataclasses

import jax.numpy as jnp

from lgmd2jax._eye import Eye
from lgmd2jax.stimuli._arguments import one_of, positive
from lgmd2jax.stimuli._background import Panorama
from lgmd2jax.stimuli._family import family
from lgmd2jax.stimuli._scene import film
from lgmd2jax.stimuli._stimulus import Sketch, frame_times
from lgmd2jax.stimuli._units import DegreesPerSecond, Milliseconds


@family
def turning(
    eye: Eye,
    *,
    background: Panorama | None = None,
    speed: DegreesPerSecond = 60.0,
    direction: str = "right",
    duration_ms: Milliseconds = 1000.0,
    start_ms: float | int | None = None,
    end_ms: float | int | None = None,
) -> Sketch:
    """The eye turns in a scene, about the vertical. 0 ms is the onset of motion; the scene stands before and after.

    **Arguments:**

    - `background`: the scene, `Panorama()` by default; its own `speed` does not count.
    - `speed`: at which the eye turns, in deg/s.
    - `direction`: `"right"` or `"left"`; the scene passes to the other side.
    - `duration_ms`: of the turn.
    - `start_ms`, `end_ms`: plain numbers; by default from 500 ms before the motion to 500 ms after it.

    **Raises:** `ValueError` for a speed or a duration that is not positive, and for a background that is no panorama.
    """
    one_of("direction", direction, ("right", "left"))
    scene = Panorama() if background is None else background
    if not isinstance(scene, Panorama):
        raise ValueError(f"background is {scene!r}; an eye turns in a Panorama")
    speed = positive("speed", speed, DegreesPerSecond)
    duration = positive("duration_ms", duration_ms, Milliseconds)
    time = frame_times(eye, start_ms, end_ms, 0.0, duration)
    scene = dataclasses.replace(scene, speed=-speed if direction == "right" else speed)
    since = jnp.clip(time, 0, duration)
    return Sketch(time, lambda: (film(eye, since, scene), {"turn_deg": speed * since / 1000}))
