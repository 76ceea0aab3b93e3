"""Clips of what happens before a moving eye: collisions of dark objects, and what must not be taken for one."""

import dataclasses
import itertools
import math
from collections.abc import Iterator

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int
from typing_extensions import deprecated

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._types import Key, check_key
from lgmd2jax.stimuli._arguments import one_of, positive
from lgmd2jax.stimuli._camera import FILM_BY_FILE, FLICKER, FLICKER_HZ, NOISE, camera
from lgmd2jax.stimuli._encounter_kinds import KINDS, Scenario
from lgmd2jax.stimuli._stimulus import Stimulus
from lgmd2jax.stimuli._units import Milliseconds

ENCOUNTERS = tuple(KINDS)
"""The kinds of `random_encounter`, of which the first is a collision."""
_SILENT = tuple(kind for kind in ENCOUNTERS if kind != "collision")
_CONVERTED = 0.5  # of the clips


@dataclasses.dataclass(frozen=True)
class Encounter:
    """A clip as a camera delivers it, and what it shows.

    - `kind`: one of `ENCOUNTERS`.
    - `stimulus`: in 8 bits, with its time from 0 ms on.
    - `time_to_contact_ms`: from each frame until a dark object touches the eye, by geometry; infinite where none
      approaches it.
    """

    kind: str
    stimulus: Stimulus
    time_to_contact_ms: Float[np.ndarray, " time"]


@checked
def random_encounter(eye: Eye, key: Key, *, kind: str | None = None, duration_ms: float | int = 3000.0) -> Encounter:
    """A random clip: the same key gives the same one.

    - `"collision"`: a disc or square, at most half as bright as what is around, approaches at constant velocity; the
      clip ends .1 to .5 s before contact.
    - `"near miss"`: an object that passes the eye by, at 3 to 8 times its half-size.
    - `"recession"`: a dark object that draws away.
    - `"translation"`: an object that crosses the field.
    - `"turning"`: the eye turns in a scene.
    - `"clutter"`: a scene alone that drifts at a changing speed.
    - `"light approach"`: a light object that approaches the eye, to which the LGMD2 is blind.

    Sizes, speeds, directions, contrasts and surroundings (plain, or pieces of scikit-image's photographs, still or in
    motion) are random too, and so are the camera's noise, flicker and blur. Half of the clips, by chance, were shot at
    2/3, 4/5 or 5/6 of the eye's frame rate and converted to it, as dash-cam films often are: they repeat frames.

    **Arguments:**

    - `eye`: known in degrees, of more than 3 frames per second.
    - `key`: of everything that is random.
    - `kind`: random by default, one half collisions and the others equally often.
    - `duration_ms`: of the clip; it holds the whole frames that fit.

    **Raises:** `ValueError` for an unknown kind, and for an eye or a duration without two frames.
    """
    if kind is not None:
        one_of("kind", kind, ENCOUNTERS)
    chance, frames = chance_of(key), _frames(eye, duration_ms)
    rate = float(chance.choice(FILM_BY_FILE)) if chance.random() < _CONVERTED else 1.0
    scenario = Scenario(dataclasses.replace(eye, fps=rate * eye.fps), chance, math.ceil(rate * frames - 1e-6))
    # Also where the kind is given, so that the clip is the same as where the kind is random.
    random_kind = "collision" if chance.random() < 0.5 else str(chance.choice(_SILENT))
    kind = kind or random_kind
    stimulus = KINDS[kind](scenario)
    contact = -np.asarray(stimulus.time, dtype=float) if kind == "collision" else np.full(scenario.frames, np.inf)
    film = camera(
        dataclasses.replace(stimulus, time=jnp.arange(scenario.frames) * 1000 / scenario.eye.fps),
        key,
        noise=chance.uniform(*NOISE),
        flicker=chance.uniform(*FLICKER),
        flicker_hz=chance.choice(FLICKER_HZ),
        blur=chance.uniform(0, 0.6),
    )
    sources = np.arange(frames) * scenario.frames // frames
    return Encounter(kind, _convert(film, sources, eye.fps), contact[sources])


@deprecated("encounter is called random_encounter now, since it differed from Encounter by a capital alone")
def encounter(eye: Eye, key: Key, *, kind: str | None = None, duration_ms: float | int = 3000.0) -> Encounter:
    """The old name of `random_encounter`."""
    return random_encounter(eye, key, kind=kind, duration_ms=duration_ms)


def _convert(film: Stimulus, sources: Int[np.ndarray, " time"], fps: float | int) -> Stimulus:
    """A film as a file of another frame rate, each of whose frames is the film's of a number in `sources`."""
    frames, courses = jax.tree.map(lambda values: values[sources], (film.frames, film.courses))
    time = jnp.arange(len(sources)) * 1000 / fps
    return dataclasses.replace(film, frames=frames, fps=fps, time=time, courses=courses)


@checked
def encounters(eye: Eye, key: Key, count: int, *, duration_ms: float | int = 3000.0) -> Iterator[Encounter]:
    """So many clips, `count // 2` of them collisions, in a shuffled order; the other kinds come equally often.

    Of each two clips in a row one is a collision. Clip i is the same whatever the count, but for the last of an odd
    count, which is never a collision. It is `random_encounter(eye, jax.random.fold_in(key, i), kind=...)`.

    **Arguments:** as for `random_encounter`, and

    - `count`: how many, 1 or more; they are rendered one by one as they are asked for.

    **Raises:** `ValueError` as `random_encounter`, and for a count below 1.
    """
    if not isinstance(count, int) or count < 1:
        raise ValueError(f"count is {count!r}; give a whole number of clips, 1 or more")
    _frames(eye, duration_ms)
    order = _order(chance_of(key))
    kinds = list(itertools.islice(order, count))
    if count % 2 and kinds[-1] == "collision":
        kinds[-1] = next(order)
    return (
        random_encounter(eye, jax.random.fold_in(key, i), kind=kind, duration_ms=duration_ms)
        for i, kind in enumerate(kinds)
    )


def _order(chance: np.random.Generator) -> Iterator[str]:
    """Kinds without end: pairs of a collision and another, in which each other kind has had its turn every 6 pairs."""
    while True:
        for silent in chance.permutation(_SILENT):
            yield from map(str, chance.permutation(["collision", silent]))


def chance_of(key: Key) -> np.random.Generator:
    check_key(key)
    return np.random.default_rng(np.asarray(jax.random.key_data(key)))


def _frames(eye: Eye, duration_ms: float | int) -> int:
    frames = math.floor(float(positive("duration_ms", duration_ms, Milliseconds)) * eye.fps / 1000 + 1e-6)
    if frames < 2:
        raise ValueError(f"duration_ms is {duration_ms} at {eye.fps:g} fps; give time for 2 frames or more")
    slowest = 2 / min(FILM_BY_FILE)  # two frames of the film
    if eye.fps <= slowest:
        raise ValueError(
            f"fps is {eye.fps:g}; give an eye of more than {slowest:g} fps, to see what comes before a contact"
        )
    return frames
