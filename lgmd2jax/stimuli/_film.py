"""Films by chance with the statistics of real ones: what a camera in traffic, on a robot or in a hand delivers."""

import itertools
import math
from collections.abc import Iterator

import jax
import jax.numpy as jnp
import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._types import Key
from lgmd2jax.stimuli._arguments import one_of, positive
from lgmd2jax.stimuli._encounter import Encounter, chance_of
from lgmd2jax.stimuli._film_camera import recorded
from lgmd2jax.stimuli._film_kinds import COLLISIONS, OTHERS
from lgmd2jax.stimuli._film_scene import draw
from lgmd2jax.stimuli._flash import flashed
from lgmd2jax.stimuli._flutter import fluttered
from lgmd2jax.stimuli._shot import Shot
from lgmd2jax.stimuli._stimulus import Stimulus
from lgmd2jax.stimuli._units import Hertz, Milliseconds

FILMS = (*COLLISIONS, *OTHERS)
"""The kinds of `random_film`, collisions first."""
FILM_MS = 5600.0  # the median of real clips
# Frames per second, and how often: those of real films once repeated frames are dropped, and of robots.
_RATES = {8: 0.02, 10: 0.04, 12: 0.04, 15: 0.06, 20: 0.08, 24: 0.2, 25: 0.22, 30: 0.27, 50: 0.04, 60: 0.03}


@checked
def random_film(
    eye: Eye, key: Key, *, kind: str | None = None, fps: float | int | None = None, duration_ms: float | int = FILM_MS
) -> Encounter:
    """A random film: the same key gives the same one, and at another frame rate the same scene.

    Collisions, whose films end 70 ms after contact, by which the camera is thrown about:

    - `"runs into"`: a vehicle drives at another one that stands or is slower.
    - `"robot"`: a small robot or a drone runs into a post, a wall or whatever is in its way.
    - `"struck"`: a camera that stands is hit by a vehicle. `"side"`: one that crosses is hit, or hits.
    - `"thrown"`: a ball, a balloon or debris flies at the camera.

    What is no collision:

    - `"drive"`: driving behind somebody, past others, through bends and the shadows of bridges.
    - `"passing by"`: traffic and people cross before a fixed camera. `"walk up"`: somebody comes up to it, slowly.
    - `"miss"`: a vehicle comes as fast as in a collision and passes a lane aside.
    - `"turning"`: a camera in a hand, on a robot or under a drone turns and sways.

    Ground, walls, distance and objects carry pieces of scikit-image's photographs, of which each ray sees as much as it
    resolves; in some films leaves, water or a crowd stir in a part of the field, or the light changes suddenly, as by
    lamps that pass or between trees; a tenth are shot at night, with lamps. Exposure, contrast, noise, flicker and
    frame rate (8 to 60 frames a second) are random too; half of the films pass through H.264, a tenth keep the repeated
    frames of a conversion.

    **Arguments:**

    - `eye`: known in degrees, with at least 8 rows and columns, both even. Its own frame rate plays no part.
    - `key`: of everything that is random.
    - `kind`: random by default, one half collisions.
    - `fps`: frames per second, random by default.
    - `duration_ms`: of the film; it holds the whole frames that fit.

    **Raises:** `ValueError` for an unknown kind, an odd or small eye, without two frames, and without PyAV.
    """
    if kind is not None:
        one_of("kind", kind, FILMS)
    if min(eye.rows, eye.cols) < 8 or eye.rows % 2 or eye.cols % 2:
        raise ValueError(f"eye has {eye.rows} x {eye.cols} pixels; films need even numbers from 8 on")
    chance = chance_of(key)
    random_rate = float(chance.choice(list(_RATES), p=list(_RATES.values())))
    rate = random_rate if fps is None else float(positive("fps", fps, Hertz))
    random_kind = str(chance.choice(list(COLLISIONS if chance.random() < 0.5 else OTHERS)))
    kind = kind or random_kind
    lasts = float(positive("duration_ms", duration_ms, Milliseconds)) / 1000
    count = math.floor(lasts * rate + 1e-6)
    if count < 2:
        raise ValueError(f"duration_ms is {duration_ms} at {rate:g} fps; give time for 2 frames or more")
    shot = Shot(chance, lasts - np.arange(count)[::-1] / rate)
    scene, motion, left = (COLLISIONS | OTHERS)[kind](shot)
    frames = recorded(flashed(fluttered(draw(eye, scene, motion), shot), shot), shot)
    time = jnp.arange(count) * 1000 / rate
    return Encounter(kind, Stimulus(jnp.asarray(frames, dtype=float), rate, time, "film"), 1000 * left)


@checked
def films(
    eye: Eye, key: Key, count: int, *, fps: float | int | None = None, duration_ms: float | int = FILM_MS
) -> Iterator[Encounter]:
    """So many films, by turns a collision and something else; the kinds come equally often.

    Film i is `random_film(eye, jax.random.fold_in(key, i), kind=...)`, the same whatever the count.

    **Arguments:** as for `random_film`, and

    - `count`: how many, 1 or more; they are rendered one by one as they are asked for.

    **Raises:** `ValueError` as `random_film`, and for a count below 1.
    """
    if not isinstance(count, int) or count < 1:
        raise ValueError(f"count is {count!r}; give a whole number of films, 1 or more")
    pairs = zip(itertools.cycle(OTHERS), itertools.cycle(COLLISIONS), strict=False)
    return (
        random_film(eye, jax.random.fold_in(key, i), kind=kind, fps=fps, duration_ms=duration_ms)
        for i, kind in enumerate(itertools.islice(itertools.chain.from_iterable(pairs), count))
    )
