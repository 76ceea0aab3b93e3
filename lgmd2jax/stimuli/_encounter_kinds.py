"""The kinds of encounter, each drawn by chance from a family of stimuli.

Sizes and speeds are what robots and cars meet. Windows have one length, and little more than numbers is drawn, so that
hundreds of clips share a dozen compiled renderers.
"""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np

from lgmd2jax._eye import Eye
from lgmd2jax.stimuli._approach import looming, receding
from lgmd2jax.stimuli._background import Panorama, Photograph
from lgmd2jax.stimuli._scene import SHAPES, behind, film
from lgmd2jax.stimuli._stimulus import Stimulus, frame_times
from lgmd2jax.stimuli._surroundings import piece, surroundings
from lgmd2jax.stimuli._translation import translating
from lgmd2jax.stimuli._turning import turning

_CONTACT_S = 0.1, 0.5  # how long before contact a collision ends: when there is still something to be done
_FASTEST_MS, _SLOWEST_MS = 60.0, 400.0  # half-size by speed: from a post before a car to a wall before a robot
_SEEN_LARGE = 25.0  # degrees that an object spans at least before contact, or when it begins to draw away
_MISS = 3.0, 8.0  # half-sizes between the eye and the path of what passes by: its own size aside, or more
_OFF_CENTRE = 0.25  # of the field's width or height, at most
_FAR = 12.0  # half-sizes; nearer nothing begins, so that it fits into the field and its path begins ahead
_DARK = -0.95, -0.5  # Weber: at most half as bright as what is around
_LIGHT = 0.5, 2.0
_LIGHT_SHARE = 0.2  # of what passes by or crosses
_LEVELS = 70.0, 200.0  # mean grey level of surroundings
_DIM = 30.0, 75.0  # of those behind a light object
_NEARLY_WHITE = 250.0


@dataclasses.dataclass(frozen=True)
class Take:
    """What a clip is drawn for, and from: the eye, a source of chance, and its number of frames."""

    eye: Eye
    chance: np.random.Generator
    frames: int

    @property
    def length_ms(self) -> float:
        return self.frames * 1000 / self.eye.fps

    def log(self, low: float, high: float) -> float:
        """A number between two, its logarithm uniform."""
        return math.exp(self.chance.uniform(math.log(low), math.log(high)))

    def window(self, last: float | int) -> dict[str, Any]:
        """That of the frames up to the one that is the `last`-th after the event."""
        last = round(last)
        return {"start_ms": (last - self.frames + 1) * 1000 / self.eye.fps, "end_ms": last * 1000 / self.eye.fps}

    def half_size(self, fastest: float, slowest: float) -> float:
        """In ms, by speed; an edge is in the field half a second before contact, when the alarm is due."""
        edge = math.tan(math.radians(min(max(self.eye.field_of_view) / 2, 80.0)))
        return self.log(fastest, max(fastest, min(slowest, 1000 * _CONTACT_S[1] * edge)))

    def heading(self) -> float:
        """A direction in the field, in degrees."""
        return self.chance.uniform(0, 360)

    def place(self, heading: float) -> dict[str, Any]:
        """A place off the middle to some side."""
        height, width = self.eye.field_of_view
        share, heading = self.chance.uniform(0, _OFF_CENTRE), math.radians(heading)
        return {"azimuth": share * width * math.cos(heading), "elevation": share * height * math.sin(heading)}

    def object(self, light: bool) -> dict[str, Any]:
        """A look, and surroundings in which it is possible."""
        ground = surroundings(self.chance, _DIM if light else _LEVELS)
        dark, bright = self.chance.uniform(*_DARK), self.log(*_LIGHT)
        contrast = min(bright, _NEARLY_WHITE / float(behind(ground).mean_level) - 1) if light else dark
        return {"contrast": contrast, "background": ground, "shape": str(self.chance.choice(SHAPES))}

    def passing_object(self) -> dict[str, Any]:
        return self.object(light=self.chance.random() < _LIGHT_SHARE)


def _approach(take: Take, light: bool) -> Stimulus:
    """Along the line of sight, up to a frame shortly before contact."""
    fps = take.eye.fps
    left = int(take.chance.integers(math.ceil(_CONTACT_S[0] * fps), math.ceil(_CONTACT_S[1] * fps)))
    half_size = take.half_size(
        max(_FASTEST_MS, 1000 * left / fps * math.tan(math.radians(_SEEN_LARGE / 2))), _SLOWEST_MS
    )
    return looming(
        take.eye,
        l_over_v=half_size,
        start_angle=_angle_before(take.length_ms + 1000 * left / fps, half_size),
        stop_angle=178.0,
        **take.place(take.heading()),
        **take.object(light),
        **take.window(-left),
    )


def _near_miss(take: Take) -> Stimulus:
    """From one side of the field to the other, growing, up to a frame about when it passes the eye."""
    half_size = take.half_size(_FASTEST_MS, _SLOWEST_MS / 2)
    end = take.chance.uniform(-600, 300)  # ms after it is beside the eye
    start_angle = _angle_before(take.length_ms - end, half_size)
    heading = take.heading()
    return looming(
        take.eye,
        l_over_v=half_size,
        start_angle=start_angle,
        stop_angle=178.0,
        deviation=math.degrees(math.asin(take.log(*_MISS) * math.tan(math.radians(start_angle / 2)))),
        deviation_direction=heading,
        **take.place(heading + 180),
        **take.passing_object(),
        **take.window(end * take.eye.fps / 1000),
    )


def _recession(take: Take) -> Stimulus:
    half_size = take.half_size(_FASTEST_MS, _SLOWEST_MS)
    start_angle = take.chance.uniform(_SEEN_LARGE, 90.0)
    stands = take.chance.uniform(0, 0.3)  # of the clip, before it draws away
    return receding(
        take.eye,
        l_over_v=half_size,
        start_angle=start_angle,
        stop_angle=_angle_before(take.length_ms + half_size / math.tan(math.radians(start_angle / 2)), half_size),
        **take.place(take.heading()),
        **take.object(light=False),
        **take.window((1 - stands) * take.frames - 1),
    )


def _angle_before(time_ms: float, half_size_ms: float) -> float:
    """The full angle so long before contact, or far away, where that is earlier: what is larger, is in motion."""
    return math.degrees(2 * math.atan(half_size_ms / max(time_ms, _FAR * half_size_ms)))


def _translation(take: Take) -> Stimulus:
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
        direction=take.heading(),
        **take.place(take.heading()),
        **take.passing_object(),
        **take.window(reach / speed * take.eye.fps + (1 - centred) * take.frames),
    )


def _turning(take: Take) -> Stimulus:
    stands = take.chance.uniform(0, 0.5)  # of the clip, before it turns
    return turning(
        take.eye,
        background=Panorama(piece(take.chance, _LEVELS)),
        speed=take.log(15.0, 150.0),
        direction=str(take.chance.choice(["left", "right"])),
        duration_ms=take.chance.uniform(0.2, 1.0) * take.length_ms,
        **take.window((1 - stands) * take.frames - 1),
    )


def _clutter(take: Take) -> Stimulus:
    eye = take.eye
    scene = Photograph(piece(take.chance, _LEVELS), speed=take.log(3.0, 60.0), direction=take.heading())
    window = take.window(take.frames - 1)
    time = frame_times(eye, window["start_ms"], window["end_ms"], 0.0, take.length_ms)
    rhythm, phase = 2 * np.pi * take.chance.uniform(0.3, 2.0) / 1000, take.chance.uniform(0, 2 * np.pi)
    # The speed swings about its mean: what a scene does before an eye that runs.
    moved = time + take.chance.uniform(0, 1) / rhythm * jnp.sin(rhythm * time + phase)
    return Stimulus(film(eye, moved, scene), eye.fps, time, name="clutter")


KINDS: dict[str, Callable[[Take], Stimulus]] = {
    "collision": lambda take: _approach(take, light=False),
    "near miss": _near_miss,
    "recession": _recession,
    "translation": _translation,
    "turning": _turning,
    "clutter": _clutter,
    "light approach": lambda take: _approach(take, light=True),
}
