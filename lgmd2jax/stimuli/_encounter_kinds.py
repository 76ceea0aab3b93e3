"""The kinds of encounter, each a family of stimuli with random arguments.

Sizes and speeds are what robots and cars meet. Windows have one length, and little more than numbers is random, so that
hundreds of clips share a dozen compiled renderers.
"""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np

from lgmd2jax._eye import Eye
from lgmd2jax.stimuli._background import Panorama, Photograph
from lgmd2jax.stimuli._looming import looming, receding
from lgmd2jax.stimuli._scene import SHAPES, behind, film
from lgmd2jax.stimuli._stimulus import Stimulus, frame_times
from lgmd2jax.stimuli._surroundings import piece, surroundings
from lgmd2jax.stimuli._translation import translating
from lgmd2jax.stimuli._turning import turning

_CONTACT_S = 0.1, 0.5  # how long before contact a collision ends: when there is still something to be done
_FASTEST_MS, _SLOWEST_MS = 60.0, 400.0  # half-size by speed: from a post before a car to a wall before a robot
_LARGE = 25.0  # degrees that an object spans at least before contact, or when it begins to draw away
_MISS = 3.0, 8.0  # half-sizes between the eye and the line of what passes by: its own size aside, or more
_OFF_CENTRE = 0.25  # of the field's width or height, at most
_FAR = 12.0  # half-sizes; nothing begins nearer, so that it fits into the field and begins ahead
_DARK = -0.95, -0.5  # Weber: at most half as bright as what is around
_LIGHT = 0.5, 2.0
_LIGHT_SHARE = 0.2  # of what passes by or crosses
_LEVELS = 70.0, 200.0  # mean grey level of surroundings
_DIM = 30.0, 75.0  # of those behind a light object
_NEARLY_WHITE = 250.0


@dataclasses.dataclass(frozen=True)
class Scenario:
    """What a random clip is made from: the eye, a source of chance, and the number of frames."""

    eye: Eye
    chance: np.random.Generator
    frames: int

    @property
    def length_ms(self) -> float:
        """How long the clip is."""
        return self.frames * 1000 / self.eye.fps

    def log(self, low: float, high: float) -> float:
        """A random number between two, its logarithm uniform."""
        return math.exp(self.chance.uniform(math.log(low), math.log(high)))

    def window(self, last: float | int) -> dict[str, Any]:
        """The window that ends `last` frames after the event."""
        last = round(last)
        return {"start_ms": (last - self.frames + 1) * 1000 / self.eye.fps, "end_ms": last * 1000 / self.eye.fps}

    def l_over_v(self, fastest: float, slowest: float) -> float:
        """A random half-size by speed, in ms.

        It is bounded so that the object's edges are in the field half a second before contact: then the alarm is due.
        """
        edge = math.tan(math.radians(min(max(self.eye.field_of_view) / 2, 80.0)))
        return self.log(fastest, max(fastest, min(slowest, 1000 * _CONTACT_S[1] * edge)))

    def heading(self) -> float:
        """A random direction in the field, in degrees."""
        return self.chance.uniform(0, 360)

    def place(self, heading: float) -> dict[str, Any]:
        """A random place off the middle, in a direction in degrees."""
        height, width = self.eye.field_of_view
        share, heading = self.chance.uniform(0, _OFF_CENTRE), math.radians(heading)
        return {"azimuth": share * width * math.cos(heading), "elevation": share * height * math.sin(heading)}

    def object(self, light: bool) -> dict[str, Any]:
        """A random look, and surroundings in which it is possible."""
        ground = surroundings(self.chance, _DIM if light else _LEVELS)
        dark, bright = self.chance.uniform(*_DARK), self.log(*_LIGHT)
        contrast = min(bright, _NEARLY_WHITE / float(behind(ground).mean_level) - 1) if light else dark
        return {"contrast": contrast, "background": ground, "shape": str(self.chance.choice(SHAPES))}

    def passing_object(self) -> dict[str, Any]:
        """The same of an object that is light in a fifth of the clips."""
        return self.object(light=self.chance.random() < _LIGHT_SHARE)


def _approach(scenario: Scenario, light: bool) -> Stimulus:
    """Along the line of sight, up to a frame shortly before contact."""
    fps = scenario.eye.fps
    left = int(scenario.chance.integers(math.ceil(_CONTACT_S[0] * fps), math.ceil(_CONTACT_S[1] * fps)))
    l_over_v = scenario.l_over_v(max(_FASTEST_MS, 1000 * left / fps * math.tan(math.radians(_LARGE / 2))), _SLOWEST_MS)
    return looming(
        scenario.eye,
        l_over_v=l_over_v,
        start_angle=_angle_before(scenario.length_ms + 1000 * left / fps, l_over_v),
        stop_angle=178.0,
        **scenario.place(scenario.heading()),
        **scenario.object(light),
        **scenario.window(-left),
    )


def _near_miss(scenario: Scenario) -> Stimulus:
    """From one side of the field to the other, growing, up to a frame about when it passes the eye."""
    l_over_v = scenario.l_over_v(_FASTEST_MS, _SLOWEST_MS / 2)
    end = scenario.chance.uniform(-600, 300)  # ms after it is beside the eye
    start_angle = _angle_before(scenario.length_ms - end, l_over_v)
    heading = scenario.heading()
    return looming(
        scenario.eye,
        l_over_v=l_over_v,
        start_angle=start_angle,
        stop_angle=178.0,
        deviation=math.degrees(math.asin(scenario.log(*_MISS) * math.tan(math.radians(start_angle / 2)))),
        deviation_direction=heading,
        **scenario.place(heading + 180),
        **scenario.passing_object(),
        **scenario.window(end * scenario.eye.fps / 1000),
    )


def _recession(scenario: Scenario) -> Stimulus:
    l_over_v = scenario.l_over_v(_FASTEST_MS, _SLOWEST_MS)
    start_angle = scenario.chance.uniform(_LARGE, 90.0)
    stands = scenario.chance.uniform(0, 0.3)  # of the clip, before it draws away
    return receding(
        scenario.eye,
        l_over_v=l_over_v,
        start_angle=start_angle,
        stop_angle=_angle_before(scenario.length_ms + l_over_v / math.tan(math.radians(start_angle / 2)), l_over_v),
        **scenario.place(scenario.heading()),
        **scenario.object(light=False),
        **scenario.window((1 - stands) * scenario.frames - 1),
    )


def _angle_before(time_ms: float, l_over_v: float) -> float:
    """The full angle at a time before contact, but at most that of an object far away."""
    return math.degrees(2 * math.atan(l_over_v / max(time_ms, _FAR * l_over_v)))


def _translation(scenario: Scenario) -> Stimulus:
    field = scenario.eye.field_of_view
    size = scenario.log(4.0, min(30.0, *field))
    reach = min(math.hypot(*field) / 2 + size, 89.0)
    speed = scenario.log(15.0, 150.0)
    centred = scenario.chance.uniform(0.2, 0.8)  # of the clip, when the object is in the middle of its line
    return translating(
        scenario.eye,
        size=size,
        speed=speed,
        start=-reach,
        stop=reach,
        direction=scenario.heading(),
        **scenario.place(scenario.heading()),
        **scenario.passing_object(),
        **scenario.window(reach / speed * scenario.eye.fps + (1 - centred) * scenario.frames),
    )


def _turning(scenario: Scenario) -> Stimulus:
    stands = scenario.chance.uniform(0, 0.5)  # of the clip, before it turns
    return turning(
        scenario.eye,
        background=Panorama(piece(scenario.chance, _LEVELS)),
        speed=scenario.log(15.0, 150.0),
        direction=str(scenario.chance.choice(["left", "right"])),
        duration_ms=scenario.chance.uniform(0.2, 1.0) * scenario.length_ms,
        **scenario.window((1 - stands) * scenario.frames - 1),
    )


def _clutter(scenario: Scenario) -> Stimulus:
    eye = scenario.eye
    scene = Photograph(piece(scenario.chance, _LEVELS), speed=scenario.log(3.0, 60.0), direction=scenario.heading())
    window = scenario.window(scenario.frames - 1)
    time = frame_times(eye, window["start_ms"], window["end_ms"], 0.0, scenario.length_ms)
    rhythm, phase = 2 * np.pi * scenario.chance.uniform(0.3, 2.0) / 1000, scenario.chance.uniform(0, 2 * np.pi)
    # The speed swings about its mean: what a scene does before an eye that runs.
    swinging_time = time + scenario.chance.uniform(0, 1) / rhythm * jnp.sin(rhythm * time + phase)
    return Stimulus(film(eye, swinging_time, scene), eye.fps, time, name="clutter")


KINDS: dict[str, Callable[[Scenario], Stimulus]] = {
    "collision": lambda scenario: _approach(scenario, light=False),
    "near miss": _near_miss,
    "recession": _recession,
    "translation": _translation,
    "turning": _turning,
    "clutter": _clutter,
    "light approach": lambda scenario: _approach(scenario, light=True),
}
