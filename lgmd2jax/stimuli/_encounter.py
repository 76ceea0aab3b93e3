"""Clips of what happens before a moving eye: collisions of dark objects, and what must not be taken for one."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray, UInt32

from lgmd2jax._eye import Eye
from lgmd2jax.stimuli._approach import looming, receding
from lgmd2jax.stimuli._arguments import one_of, positive
from lgmd2jax.stimuli._background import Panorama, Photograph
from lgmd2jax.stimuli._camera import camera
from lgmd2jax.stimuli._scene import SHAPES, behind, film
from lgmd2jax.stimuli._stimulus import Stimulus, frame_times
from lgmd2jax.stimuli._surroundings import piece, surroundings
from lgmd2jax.stimuli._translation import translating
from lgmd2jax.stimuli._turning import turning

Key = PRNGKeyArray | UInt32[Array, "2"]

_CONTACT_S = 0.1, 0.5  # how long before contact a collision ends: when there is still something to be done
_HALF_SIZE_BY_SPEED_MS = 60.0, 400.0  # from a post beside a fast robot to a car ahead of a slow one
_SEEN_LARGE = 25.0  # degrees that an object spans at least before contact, or when it begins to draw away
_MISS = 2.0, 6.0  # half-sizes between the eye and the path of what passes by
_FAR = 12.0  # half-sizes; nearer nothing begins, so that it fits into the field and its path begins ahead
_DARK = -0.9, -0.4  # Weber
_LIGHT = 0.5, 2.0
_LIGHT_SHARE = 0.2  # of what passes by or crosses
_LEVELS = 70.0, 200.0  # mean grey level of surroundings
_DIM = 30.0, 75.0  # of those behind a light object
_NEARLY_WHITE = 250.0


@dataclasses.dataclass(frozen=True)
class Encounter:
    """A clip as a camera delivers it, and what it shows.

    - `kind`: one of `ENCOUNTERS`.
    - `stimulus`: in 8 bits, with its time from 0 ms on.
    - `time_to_contact_ms`: until a dark object would touch the eye, infinite where none is on its way to it.
    """

    kind: str
    stimulus: Stimulus
    time_to_contact_ms: Float[np.ndarray, " time"]


def encounter(eye: Eye, key: Key, *, kind: str | None = None, duration_ms: float | int = 3000.0) -> Encounter:
    """A clip drawn by chance: the same key gives the same one.

    - `"collision"`: a dark disc or square approaches at constant velocity; the clip ends .1 to .5 s before contact.
    - `"near miss"`: an object that passes the eye by, at 2 to 6 times its half-size.
    - `"recession"`: a dark object that draws away.
    - `"translation"`: an object that crosses the field.
    - `"turning"`: the eye turns in a scene.
    - `"clutter"`: a scene alone that drifts at a changing speed.
    - `"light approach"`: a light object on its way to the eye, to which the LGMD2 is blind.

    Sizes, speeds, directions, contrasts and surroundings (plain, or pieces of scikit-image's photographs, still or in
    motion) are drawn too, and so are the camera's noise, flicker and blur.

    **Arguments:**

    - `eye`: known in degrees, of more than 2 frames per second.
    - `key`: of everything that is drawn.
    - `kind`: drawn by default, one half collisions and the others equally often.
    - `duration_ms`: of the clip; it holds the whole frames that fit.

    **Raises:** `ValueError` for an unknown kind, and for an eye or a duration without two frames.
    """
    take = _Take(eye, _chance(key), _frames(eye, duration_ms))
    drawn = "collision" if take.chance.random() < 0.5 else str(take.chance.choice(_SILENT))
    if kind is not None:
        one_of("kind", kind, ENCOUNTERS)
    kind = drawn if kind is None else kind
    seen = _KINDS[kind](take)
    until = -np.asarray(seen.time) if kind == "collision" else np.full(seen.time.shape, np.inf)
    seen = dataclasses.replace(seen, time=jnp.arange(take.frames) * 1000 / eye.fps)
    filmed = camera(
        seen,
        key,
        noise=take.chance.uniform(0.5, 3.0),
        flicker=take.chance.uniform(0, 0.02),
        flicker_hz=take.chance.choice([100.0, 120.0]),
        blur=take.chance.uniform(0, 0.6),
    )
    return Encounter(kind, filmed, until)


def encounters(eye: Eye, key: Key, count: int, *, duration_ms: float | int = 3000.0) -> Iterator[Encounter]:
    """So many clips, `count // 2` of them collisions, in a shuffled order; the other kinds come equally often.

    Of each two clips in a row one is a collision. Clip i is the same whatever the count, but for the last of an odd
    count, which is never a collision. It is `encounter(eye, jax.random.fold_in(key, i), kind=...)`.

    **Arguments:** as for `encounter`, and

    - `count`: how many, 1 or more; they are rendered one by one as they are asked for.

    **Raises:** `ValueError` as `encounter`, and for a count below 1.
    """
    if not isinstance(count, int) or count < 1:
        raise ValueError(f"count is {count!r}; give a whole number of clips, 1 or more")
    _frames(eye, duration_ms)
    order = _order(_chance(key))
    kinds = list(itertools.islice(order, count))
    if count % 2 and kinds[-1] == "collision":
        kinds[-1] = next(order)
    return (
        encounter(eye, jax.random.fold_in(key, i), kind=kind, duration_ms=duration_ms) for i, kind in enumerate(kinds)
    )


def _order(chance: np.random.Generator) -> Iterator[str]:
    """Kinds without end: pairs of a collision and another, in which each other kind has had its turn every 6 pairs."""
    while True:
        for silent in chance.permutation(_SILENT):
            yield from map(str, chance.permutation(["collision", silent]))


def _chance(key: Key) -> np.random.Generator:
    return np.random.default_rng(np.asarray(jax.random.key_data(key)))


def _frames(eye: Eye, duration_ms: float | int) -> int:
    frames = math.floor(float(positive("duration_ms", duration_ms, "ms")) * eye.fps / 1000 + 1e-6)
    if frames < 2:
        raise ValueError(f"duration_ms is {duration_ms} at {eye.fps:g} fps; give time for 2 frames or more")
    if eye.fps <= 2:
        raise ValueError(f"fps is {eye.fps:g}; give an eye of more than 2 fps, to see what comes before a contact")
    return frames


@dataclasses.dataclass(frozen=True)
class _Take:
    """What the kinds are drawn from, and for."""

    eye: Eye
    chance: np.random.Generator
    frames: int

    @property
    def length_ms(self) -> float:
        return self.frames * 1000 / self.eye.fps

    def log(self, low: float, high: float) -> float:
        """A number between two, its logarithm uniform."""
        return math.exp(self.chance.uniform(math.log(low), math.log(high)))

    def window(self, last: float) -> dict[str, float]:
        """That of the frames up to the one that is the `last`-th after the event."""
        last = round(last)
        return {"start_ms": (last - self.frames + 1) * 1000 / self.eye.fps, "end_ms": last * 1000 / self.eye.fps}

    def centre(self, share: float) -> dict[str, float]:
        """A place off the middle, by at most so large a share of the field."""
        height, width = self.eye.field_of_view
        across, up = self.chance.uniform(-share, share, 2)
        return {"azimuth": across * width, "elevation": up * height}

    def object(self, light: bool) -> dict:
        """A look, and surroundings in which it is possible."""
        ground = surroundings(self.chance, _DIM if light else _LEVELS)
        dark, bright = self.chance.uniform(*_DARK), self.log(*_LIGHT)
        contrast = min(bright, _NEARLY_WHITE / float(behind(ground).mean_level) - 1) if light else dark
        return {"contrast": contrast, "background": ground, "shape": str(self.chance.choice(SHAPES))}

    def passing_object(self) -> dict:
        return self.object(light=self.chance.random() < _LIGHT_SHARE)


def _approach(take: _Take, light: bool) -> Stimulus:
    """Along the line of sight, up to a frame shortly before contact."""
    fps = take.eye.fps
    left = take.chance.integers(math.ceil(_CONTACT_S[0] * fps), math.ceil(_CONTACT_S[1] * fps))
    slowest, fastest = _HALF_SIZE_BY_SPEED_MS
    slowest = max(slowest, 1000 * left / fps * math.tan(math.radians(_SEEN_LARGE / 2)))
    half_size = take.log(slowest, fastest)
    return looming(
        take.eye,
        l_over_v=half_size,
        start_angle=_angle_before(take.length_ms + 1000 * left / fps, half_size),
        stop_angle=178.0,
        **take.centre(0.15),
        **take.object(light),
        **take.window(-left),
    )


def _near_miss(take: _Take) -> Stimulus:
    slowest, fastest = _HALF_SIZE_BY_SPEED_MS
    half_size = take.log(slowest, fastest / 1.6)
    end = take.chance.uniform(-200, 800)
    start_angle = _angle_before(take.length_ms - end, half_size)
    return looming(
        take.eye,
        l_over_v=half_size,
        start_angle=start_angle,
        stop_angle=178.0,
        deviation=math.degrees(math.asin(take.log(*_MISS) * math.tan(math.radians(start_angle / 2)))),
        deviation_direction=take.chance.uniform(0, 360),
        **take.centre(0.25),
        **take.passing_object(),
        **take.window(end * take.eye.fps / 1000),
    )


def _recession(take: _Take) -> Stimulus:
    half_size = take.log(*_HALF_SIZE_BY_SPEED_MS)
    start_angle = take.chance.uniform(_SEEN_LARGE, 90.0)
    stands = take.chance.uniform(0, 0.3)  # of the clip, before it draws away
    return receding(
        take.eye,
        l_over_v=half_size,
        start_angle=start_angle,
        stop_angle=_angle_before(take.length_ms + half_size / math.tan(math.radians(start_angle / 2)), half_size),
        **take.centre(0.15),
        **take.object(light=False),
        **take.window((1 - stands) * take.frames - 1),
    )


def _angle_before(time_ms: float, half_size_ms: float) -> float:
    """The full angle so long before contact, or far away, where that is earlier: what is larger, is in motion."""
    return math.degrees(2 * math.atan(half_size_ms / max(time_ms, _FAR * half_size_ms)))


def _translation(take: _Take) -> Stimulus:
    field = take.eye.field_of_view
    size = take.log(4.0, min(30.0, *field))
    reach = min(math.hypot(*field) / 2 + size, 89.0)
    speed = take.log(15.0, 150.0)
    centred = take.chance.uniform(0.2, 0.8)  # of the clip, when the object is in the middle of its way
    return translating(
        take.eye,
        size=size,
        speed=speed,
        start=-reach,
        stop=reach,
        direction=take.chance.uniform(0, 360),
        **take.centre(0.25),
        **take.passing_object(),
        **take.window(1000 * reach / speed * take.eye.fps / 1000 + (1 - centred) * take.frames),
    )


def _turning(take: _Take) -> Stimulus:
    stands = take.chance.uniform(0, 0.5)  # of the clip, before it turns
    return turning(
        take.eye,
        background=Panorama(piece(take.chance, _LEVELS)),
        speed=take.log(15.0, 150.0),
        direction=str(take.chance.choice(["left", "right"])),
        duration_ms=take.chance.uniform(0.2, 1.0) * take.length_ms,
        **take.window((1 - stands) * take.frames - 1),
    )


def _clutter(take: _Take) -> Stimulus:
    eye = take.eye
    scene = Photograph(piece(take.chance, _LEVELS), speed=take.log(3.0, 60.0), direction=take.chance.uniform(0, 360))
    window = take.window(take.frames - 1)
    time = frame_times(eye, window["start_ms"], window["end_ms"], 0.0, take.length_ms)
    rhythm, phase = 2 * np.pi * take.chance.uniform(0.3, 2.0) / 1000, take.chance.uniform(0, 2 * np.pi)
    # The speed swings about its mean: what a scene does before an eye that runs.
    moved = time + take.chance.uniform(0, 1) / rhythm * jnp.sin(rhythm * time + phase)
    return Stimulus(film(eye, moved, scene), eye.fps, time, name="clutter")


_KINDS: dict[str, Callable[[_Take], Stimulus]] = {
    "collision": lambda take: _approach(take, light=False),
    "near miss": _near_miss,
    "recession": _recession,
    "translation": _translation,
    "turning": _turning,
    "clutter": _clutter,
    "light approach": lambda take: _approach(take, light=True),
}
ENCOUNTERS = tuple(_KINDS)
_SILENT = tuple(kind for kind in ENCOUNTERS if kind != "collision")
