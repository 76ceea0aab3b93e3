"""The stimuli of the exam: dark objects of 20 on 200, light ones of 200 on 20, gratings, changes of light."""

import dataclasses
import functools
import math
from collections.abc import Callable, Iterator
from typing import Any

import jax
import numpy as np
from jaxtyping import Float

from lgmd2jax import stimuli
from lgmd2jax._eye import Eye
from lgmd2jax.stimuli import Photograph, Stimulus

L_OVER_V = (10.0, 20.0, 30.0, 40.0, 50.0, 80.0)  # ms
CONTRASTS = (-0.1, -0.2, -0.3, -0.5, -0.7, -0.9, -1.0)  # Weber
SPEEDS = (20.0, 40.0, 60.0, 100.0, 200.0)  # deg/s
DIRECTIONS = (0.0, 90.0, 180.0, 270.0)  # degrees
DEVIATIONS = (0.0, 10.0, 20.0, 40.0)  # degrees
GRATINGS = tuple((cycles, hertz) for cycles in (0.05, 0.1, 0.2) for hertz in (1.0, 4.0, 10.0))  # cyc/deg, Hz
STEPS = (20.0, 80.0, 140.0)  # grey levels
PARTS = {"field": 1.0, "quarter": 0.25}  # of the field that changes
CHANGES = tuple(  # part, grey levels up or down, ms that it takes
    (part, sign * size, ramp)
    for part in PARTS
    for sign in (1, -1)
    for size, ramp in (*((step, 0.0) for step in STEPS), (STEPS[-1], 1000.0))
)
FINE_RATES = (40.0, 50.0, 80.0)  # ms, the l/|v| that are shown at the finer frame rate too

SMALL, LARGE = 2.0, 80.0  # degrees, full angles between which an object approaches
LEAD = 500.0  # ms of rest before the motion and after it
GRATING_MS = 2000.0
_FROM_TO = {"l_over_v": 40.0, "start_angle": SMALL, "stop_angle": LARGE}
DARK, LIGHT = {"level": 20.0, "background": 200.0}, {"level": 200.0, "background": 20.0}
NOISE = 2.0  # grey levels, s.d. in every pixel and frame of a textured scene

# A trial lasts as long as one of these, so that few programs are compiled; the object stands meanwhile.
_LENGTHS = (2350.0, 3250.0, 5500.0)  # ms


@dataclasses.dataclass(frozen=True)
class Trial:
    """One stimulus of the exam: motion from `begin` to `end`, in ms, within a window of whole frames.

    `render` takes an eye and the window. `textured` scenes are compared with the approach in the same scene; `seed` is
    that of their noise.
    """

    name: str
    render: Callable[..., Stimulus]
    begin: float
    end: float
    fps: float
    textured: bool = False
    seed: int = 0

    @property
    def count(self) -> int:
        """Frames."""
        needed = self.end - self.begin + 2 * LEAD
        length = next((length for length in _LENGTHS if length >= needed), needed)
        return round(length * self.fps / 1000) + 1

    @property
    def time(self) -> Float[np.ndarray, " time"]:
        """Of each frame, in ms; 0 is the collision, or the onset."""
        first = math.ceil((self.begin - LEAD) * self.fps / 1000 - 1e-6)
        return (first + np.arange(self.count)) * 1000 / self.fps

    def frames(self, eye: Eye) -> Float[np.ndarray, "time row col"]:
        """What the eye sees, in single precision: half the memory, and twice the speed."""
        time, eye = self.time, dataclasses.replace(eye, fps=self.fps)
        stimulus = self.render(eye, start_ms=float(time[0]), end_ms=float(time[-1]))
        if self.textured:
            stimulus = stimuli.camera(stimulus, jax.random.key(self.seed), noise=NOISE, bits=None)
        return np.asarray(stimulus.frames, dtype=np.float32)


def loom(l_over_v: float, fine: bool = False) -> str:
    """The name of a dark approach."""
    return f"dark loom {l_over_v:g} ms" + (" at the finer frame rate" if fine else "")


def contrast(weber: float) -> str:
    """The name of the approach at a contrast; -.9 is the one that all others are compared with."""
    return REFERENCE if weber == -0.9 else f"dark loom at Weber {weber:g}"


def deviating(degrees: float) -> str:
    """The name of an approach that misses the eye by an angle."""
    return f"dark loom {degrees:g} deg off" if degrees else REFERENCE


def translation(speed: float = 60.0, direction: float = 0.0) -> str:
    """The name of a dark disc that crosses the field."""
    return f"dark translation {speed:g} deg/s towards {direction:g} deg"


def accelerating(profile: str) -> str:
    """The name of a dark disc that crosses the field in 1,333 ms at a growing speed."""
    return translation() if profile == "constant" else f"dark translation, {profile}"


def grating(cycles: float, hertz: float) -> str:
    """The name of a grating."""
    return f"grating {cycles:g} cyc/deg {hertz:g} Hz"


def change(part: str, rise: float, ramp: float = 0.0) -> str:
    """The name of a change of light."""
    return f"{part} {'up' if rise > 0 else 'down'} {abs(rise):g} levels" + (" in 1 s" if ramp else "")


def bar(shade: str, grows: bool) -> str:
    """The name of a bar that grows or shrinks."""
    return f"{shade} {'elongation' if grows else 'shortening'}"


def textured(name: str) -> str:
    """The same on an object of 4 x 4 checks (bars: plain) over a photograph, with noise."""
    return f"{name}, textured"


REFERENCE = loom(40.0)
LIGHT_LOOM, RECESSION, LIGHT_RECESSION = "light loom 40 ms", "dark recession 40 ms", "light recession 40 ms"
HALVED, SQUARE, CHECKS = "halved light", "square", "checks"
STILL, DRIFTING = "dark loom, photograph still", "dark loom, photograph drifting"


def finer_rate(fps: float) -> float:
    """The frame rate that a row compares with: 200 per second, or twice as many as there are."""
    return 200.0 if fps < 200 else 2 * fps


def sees(eye: Eye, cycles: float, hertz: float) -> bool:
    """Whether the eye samples a grating without aliasing."""
    return cycles / eye.pixels_per_degree < 0.5 and hertz < eye.fps / 2


def all_trials(eye: Eye, shift: float, seed: int = 0) -> Iterator[Trial]:
    """The whole exam for an eye; objects stand `shift` pixels to the right of and above where they should.

    **Arguments:** `seed`: of the noise, and of the piece of the photograph that is seen.
    """
    aside, fps = shift / eye.pixels_per_degree, float(eye.fps)
    yield from _looms(fps, aside)
    yield from _scenes(fps, aside, seed)
    yield from _translations(fps, aside, seed)
    yield from _bars(fps, aside, seed)
    yield from _gratings(eye)
    yield from _changes(fps)


def _looms(fps: float, aside: float) -> Iterator[Trial]:
    """Dark discs, and other dark objects of the same area, on a plain ground."""
    for l_over_v in L_OVER_V:
        yield _approach(loom(l_over_v), fps, aside, l_over_v=l_over_v, **DARK)
    for l_over_v in FINE_RATES:
        yield _approach(loom(l_over_v, fine=True), finer_rate(fps), aside, l_over_v=l_over_v, **DARK)
    for weber in CONTRASTS:
        if contrast(weber) != REFERENCE:
            yield _approach(contrast(weber), fps, aside, contrast=weber, background=200.0)
    yield _approach(HALVED, fps, aside, level=10.0, background=100.0)
    for degrees in DEVIATIONS[1:]:
        trial = _approach(deviating(degrees), fps, aside, deviation=degrees, **DARK)
        yield dataclasses.replace(trial, end=trial.end + LEAD - 1e3 / fps)  # it goes on moving after it has passed
    for name, look in ((SQUARE, {}), (CHECKS, {"checks": 4, "check_level": 110.0})):
        # The half-side of a square as large as the disc of half-size 1.
        side = math.sqrt(math.pi) / 2
        small, large = (
            2 * math.degrees(math.atan(side * math.tan(math.radians(angle / 2)))) for angle in (SMALL, LARGE)
        )
        look |= {"shape": "square", "l_over_v": 40 * side, "start_angle": small, "stop_angle": large}
        yield _approach(name, fps, aside, **DARK, **look)


def _scenes(fps: float, aside: float, seed: int) -> Iterator[Trial]:
    """Light and receding objects, and approaches over a photograph."""
    dark, light = (_textured_scene(seed, **look) for look in (DARK, LIGHT))
    yield _approach(LIGHT_LOOM, fps, aside, **LIGHT)
    yield _recession(RECESSION, fps, aside, **DARK)
    yield _recession(LIGHT_RECESSION, fps, aside, **LIGHT)
    yield dataclasses.replace(_approach(textured(REFERENCE), fps, aside, **dark), textured=True, seed=seed)
    yield dataclasses.replace(_approach(textured(LIGHT_LOOM), fps, aside, **light), textured=True, seed=seed)
    yield dataclasses.replace(_recession(textured(RECESSION), fps, aside, **dark), textured=True, seed=seed)
    for name, speed in ((STILL, None), (DRIFTING, 20.0)):
        yield _approach(name, fps, aside, level=20.0, background=Photograph(_gravel(seed), speed=speed))


def _translations(fps: float, aside: float, seed: int) -> Iterator[Trial]:
    """Discs of 10 degrees that cross the field."""
    for speed in SPEEDS:
        yield _crossing(translation(speed), fps, aside, speed=speed, **DARK)
    for direction in DIRECTIONS[1:]:
        yield _crossing(translation(direction=direction), fps, aside, direction=direction, **DARK)
    for profile in ("linear", "accelerating"):
        yield _crossing(accelerating(profile), fps, aside, profile=profile, **DARK)
    trial = _crossing(textured(translation()), fps, aside, **_textured_scene(seed, **DARK))
    yield dataclasses.replace(trial, textured=True, seed=seed)


def _bars(fps: float, aside: float, seed: int) -> Iterator[Trial]:
    """Bars of 16 degrees with one moving edge, on both grounds."""
    for shade, look in (("dark", DARK), ("light", LIGHT)):
        for grows in (True, False):
            family = stimuli.elongating if grows else stimuli.shortening
            edge = {"start": -40 + aside, "stop": 40 + aside, "level": look["level"]}
            name, end = bar(shade, grows), 80 / 60 * 1000
            yield Trial(name, functools.partial(family, background=look["background"], **edge), 0.0, end, fps)
            scene = _photograph(look["background"], seed)
            yield Trial(textured(name), functools.partial(family, background=scene, **edge), 0.0, end, fps, True, seed)


def _gratings(eye: Eye) -> Iterator[Trial]:
    for cycles, hertz in GRATINGS:
        if sees(eye, cycles, hertz):
            look = {"spatial_frequency": cycles, "temporal_frequency": hertz, "duration_ms": GRATING_MS}
            render = functools.partial(stimuli.grating, **look)
            yield Trial(grating(cycles, hertz), render, 0.0, GRATING_MS, float(eye.fps))


def _changes(fps: float) -> Iterator[Trial]:
    """Up from 60 and down from 200 grey levels."""
    for part, rise, ramp in CHANGES:
        ground = 60.0 if rise > 0 else 200.0
        look = {"level": ground + rise, "background": ground, "fraction": PARTS[part], "ramp_ms": ramp}
        yield Trial(change(part, rise, ramp), functools.partial(stimuli.luminance, **look), 0.0, ramp, fps)


def _approach(name: str, fps: float, aside: float, **look: Any) -> Trial:
    look = _FROM_TO | look
    begin, end = (
        -look["l_over_v"] / math.tan(math.radians(look[angle] / 2)) for angle in ("start_angle", "stop_angle")
    )
    return Trial(name, functools.partial(stimuli.looming, azimuth=aside, elevation=aside, **look), begin, end, fps)


def _recession(name: str, fps: float, aside: float, **look: Any) -> Trial:
    loom = _approach(name, fps, aside)
    backwards = {"start_angle": LARGE, "stop_angle": SMALL, "azimuth": aside, "elevation": aside}
    return Trial(name, functools.partial(stimuli.receding, **backwards, **look), 0.0, loom.end - loom.begin, fps)


def _crossing(name: str, fps: float, aside: float, *, speed: float = 60.0, **look: Any) -> Trial:
    render = functools.partial(stimuli.translating, speed=speed, azimuth=aside, elevation=aside, **look)
    return Trial(name, render, 0.0, 80 / speed * 1000, fps)


def _textured_scene(seed: int, level: float, background: float) -> dict[str, Any]:
    """Checks of 15 grey levels about the object's, over a photograph of the ground's mean."""
    checks = {"checks": 4, "level": level - 15, "check_level": level + 15}
    return checks | {"background": _photograph(background, seed)}


def _photograph(level: float, seed: int) -> Photograph:
    """Of low contrast, so that it stays within the grey levels."""
    return Photograph(_gravel(seed), level=level, contrast=0.3)


def _gravel(seed: int):
    """The photograph; by another seed turned round its edges, so that other stones lie behind the object."""
    if seed == 0:
        return "gravel"
    image = Photograph("gravel").image
    generator = np.random.default_rng(seed)
    return np.roll(np.asarray(image), [generator.integers(size) for size in image.shape], axis=(0, 1))
