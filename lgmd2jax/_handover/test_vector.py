"""The test vector of a hand-over file: a short clip, and the response that whatever loads the file must give to it.

What excites one parameter set leaves another silent, so the clip is searched for among seeded ones. It is one that

- keeps clear of thresholds: moved a little, none of them changes the response, so float32 and C pass;
- exercises most branches: forbid one, and the response changes;
- tells most neighbours apart: with a threshold a quarter higher or lower (T_sfa: ten times), the response changes.
"""

import copy
import math
from typing import Any

import numpy as np
from jaxtyping import Float

from lgmd2jax import hard

FRAMES, ROWS, COLS = 24, 8, 10
TOLERANCE = 1e-5  # float32 stays below 1e-6
CLEARANCE = 3e-5
CLIPS, UNRELATED = 160, 40  # how many are tried; after the first ones, each is a variation of the best
FPS_WITHOUT_EYE = 30.0

Frames = Float[np.ndarray, "time row col"]
Plan = Float[np.ndarray, "time 7"]


def make_test_vector(model: hard.HardLGMD2, fps: float | None) -> dict[str, Any]:
    """The test vector of a model as it stands in the hand-over file. Equal models have equal ones.

    **Arguments:** `fps` of the eye, None without one.
    """
    fps = FPS_WITHOUT_EYE if fps is None else fps
    trial = _search(model, 1000 / fps)
    response = {name: getattr(trial.response, name).tolist() for name in hard.CHANNELS}
    for name in ("mp", "ffi", "smp", "smp_adapted"):
        response[name] = [float(f"{value:.9g}") for value in response[name]]
    return {"fps": fps, "tolerance": TOLERANCE, "frames": trial.frames.astype(int).tolist(), "response": response}


def random_clip(generator: np.random.Generator) -> Frames:
    """A clip of which nothing is known but that much changes in it, and little."""
    texture = generator.random((FRAMES, ROWS, COLS))
    varied, weak = generator.random(2)
    return _clip(_random_plan(generator, varied, weak), texture)


def _random_plan(generator: np.random.Generator, varied: float, weak: float) -> Plan:
    """Even or varied, weak or strong."""
    plan = varied * generator.random((FRAMES, 7)) + (1 - varied) * generator.random(7)
    plan[:, 1:4] **= 8.0 ** (2 * weak - 1)
    return plan


class _Trial:
    """A clip on trial: the response to it, and what that becomes with other thresholds.

    The maps of the S layer depend on no threshold, so they are computed once.
    """

    def __init__(self, model: hard.HardLGMD2, frames: Frames, interval: float):
        self.frames, self._model, self._interval = frames, copy.copy(model), interval
        self._s, self._f = self._maps(self._model)
        self._mp = [self._model._potential(s) for s in self._s]
        self.response = hard.Response.over_time(self._steps({}))
        channels = np.array(self.response[: len(hard.CHANNELS)], float)
        self._moments = channels.T.tolist()
        self._largest = [*np.abs(channels[:-2]).max(axis=1).tolist(), 0, 0]  # spikes and alarm may not differ

    def _maps(self, model):
        model._start(self.frames[0])
        return zip(*(model._pixels(frame, self._interval) for frame in self.frames), strict=True)

    def _steps(self, thresholds):
        """What the cell does in frame after frame with other thresholds."""
        model = copy.copy(self._model)
        model.parameters = {**model.parameters, **thresholds}
        model._start(self.frames[0])
        f = self._f
        if "T_p" in thresholds:
            _, f = self._maps(model)
            model._start(self.frames[0])
        mp = [model._potential(s) for s in self._s] if "T_s" in thresholds else self._mp
        return (model._cell(*sums, self.frames[0].size, self._interval) for sums in zip(mp, f, strict=True))

    def _changes(self, tolerance, name, value):
        """Whether the response is another one with this threshold: looked at up to the first frame that differs."""
        limits = [tolerance * largest for largest in self._largest]
        return hard.first_beyond(self._steps({name: value}), self._moments, limits) is not None

    def is_clear(self) -> bool:
        """Whether no rounding can carry a value across a threshold.

        A rise of 0, at rest, is exact, so T_sfa may come close to it. N_sp is compared with whole numbers.
        """
        v = self._model.parameters
        s = min(CLEARANCE * float(np.abs(self._s).max()), v["T_s"] / 2)
        relative = {name: CLEARANCE * v[name] for name in ("T_ffi", "A_ffi", "T_p") if name in v}
        shifts = {
            "T_s": (-s, s),
            **{name: (-shift, shift) for name, shift in relative.items()},
            "T_sfa": (-min(CLEARANCE, abs(v["T_sfa"]) / 2), CLEARANCE),
            "T_sp": (-CLEARANCE, CLEARANCE),
            "sigma_sp": (-CLEARANCE, CLEARANCE),
        }
        moved = ((name, v[name] + shift) for name in self._thresholds() if name in shifts for shift in shifts[name])
        return not any(self._changes(TOLERANCE / 10, name, value) for name, value in moved)

    def branches(self) -> list[tuple[str, float]]:
        """The branches that are exercised, of two at each threshold: the response changes where one is forbidden."""
        return list(self._shown(self._ends()))

    def neighbours(self) -> list[tuple[str, float]]:
        """The neighbouring thresholds with which the response changes."""
        return list(self._shown(self._near()))

    def shows_more_than(self, beaten: set[tuple[str, float]], branches: list[tuple[str, float]]) -> bool:
        """Whether the clip shows one of what it can show that others do not show better, `branches` known already."""
        near = (value for value in self._near() if value not in beaten)
        return not beaten.issuperset(branches) or any(True for _ in self._shown(near))

    def _ends(self):
        return (
            (name, end) for name in self._thresholds() for end in (0.0 if name == "sigma_sp" else -math.inf, math.inf)
        )

    def _near(self):
        v, factors = self._model.parameters, dict.fromkeys(self._thresholds(), 1.25) | {"T_sfa": 10.0}
        return ((name, v[name] * by) for name, factor in factors.items() for by in (factor, 1 / factor))

    def _thresholds(self):
        """Those at which something jumps: the shunt has none, and what codes size has its own."""
        size, shunt = "size" in self._model.mechanisms, "shunt" in self._model.mechanisms
        inhibition = () if shunt else ("A_ffi",) if size else ("T_ffi",)
        return ("T_s", *inhibition, *(("T_p",) if size else ()), "T_sfa", "T_sp", "sigma_sp", "N_sp")

    def _shown(self, thresholds):
        return ((name, value) for name, value in thresholds if self._changes(TOLERANCE, name, value))


@np.errstate(all="ignore")  # where a set overflows, it is not clear of thresholds
def _search(model: hard.HardLGMD2, interval: float) -> _Trial:
    """The clear trial with most branches, then most neighbours; a clip that stands still where none is clear.

    The best trial for each of them is kept, and each serves in turn: what varies it may combine it with the rest.
    """
    generator = np.random.default_rng(0)
    texture = generator.random((FRAMES, ROWS, COLS))
    time = np.arange(FRAMES)[:, None]
    still = np.zeros((FRAMES, 7))
    first = (0, 0), _Trial(model, _clip(still, texture), interval), still
    best = {}
    for number in range(CLIPS):
        # What excites the set is not known beforehand.
        plan = _random_plan(generator, *generator.random(2))
        if number >= UNRELATED:
            start, end = np.sort(generator.integers(0, FRAMES + 1, 2))
            bases = list({id(entry): entry for entry in best.values()}.values()) or [first]
            plan = np.where((time >= start) & (time < end), plan, bases[number % len(bases)][2])
        trial = _Trial(model, _clip(plan, texture), interval)
        branches = trial.branches()
        beaten = {shown for shown, entry in best.items() if entry[0][0] > len(branches)}
        if not trial.shows_more_than(beaten, branches):
            continue
        neighbours = trial.neighbours()
        entry = (len(branches), len(neighbours)), trial, plan
        better = [shown for shown in branches + neighbours if entry[0] > best.get(shown, first)[0]]
        if better and trial.is_clear():
            best |= dict.fromkeys(better, entry)
    return max(best.values(), key=lambda entry: entry[0], default=first)[1]


def _clip(plan: Plan, texture: Frames) -> Frames:
    """Whole grey levels 0..255: in each frame a textured rectangle turns darker or brighter, or nothing moves.

    **Arguments:** `plan` holds for each frame, in [0, 1): whether something moves, its contrast, height and width, the
    direction, the place from above and from the left. `texture` lies in [0, 1).
    """
    frame = np.round(108 + 40 * texture[0])
    frames = [frame]
    for (moves, contrast, height, width, direction, above, left), rough in zip(plan[1:], texture[1:], strict=True):
        if moves > 0.4:
            either_way = np.where(rough < 0.5, 1, -1)
            sign = 1 if direction < 0.4 else -1 if direction < 0.8 else either_way
            step = sign * 125**contrast * (1 + rough)  # 1..250 grey levels
            step = np.where((frame + step < 0) | (frame + step > 255), -step, step)
            rows, cols = int(1 + height * ROWS), int(1 + width * COLS)
            top, side = int(above * (ROWS - rows + 1)), int(left * (COLS - cols + 1))
            place = np.s_[top : top + rows, side : side + cols]
            frame = frame.copy()
            frame[place] = np.round(np.clip(frame + step, 0, 255))[place]
        frames.append(frame)
    return np.array(frames)
