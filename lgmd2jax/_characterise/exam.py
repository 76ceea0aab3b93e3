"""All trials of an eye, in groups of equal length, and what the pixels of a model make of them."""

import dataclasses
import functools
from collections.abc import Iterator

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from tqdm import tqdm

from lgmd2jax._characterise.trials import Trial, all_trials
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.stages import Sums
from lgmd2jax._network.variants import at_frame_rate

ExamSums = tuple[Sums, ...]  # MP and F of each group of trials: all that reaches the cell


@dataclasses.dataclass(frozen=True)
class Exam:
    """The stimuli for an eye, all or those that are named. Equal exams share what is compiled.

    **Arguments:** `shift`: by which objects stand aside, in pixels, to the right and up. `seed`: of noise and texture.
    """

    eye: Eye
    shift: float = 0.0
    seed: int = 0
    only: tuple[str, ...] | None = None

    @functools.cached_property
    def groups(self) -> tuple[tuple[Trial, ...], ...]:
        """Trials of equal frame rate and number of frames."""
        groups = {}
        for trial in all_trials(self.eye, self.shift, self.seed):
            if self.only is None or trial.name in self.only:
                groups.setdefault((trial.fps, trial.count), []).append(trial)
        return tuple(tuple(trials) for trials in groups.values())

    @functools.cached_property
    def places(self) -> dict[str, tuple[int, int]]:
        """Group and place in it of each trial by name."""
        return {trial.name: (g, i) for g, group in enumerate(self.groups) for i, trial in enumerate(group)}

    def trial(self, name: str) -> Trial:
        """A trial by its name."""
        group, place = self.places[name]
        return self.groups[group][place]

    @functools.cached_property
    def _frames(self) -> dict[str, Float[np.ndarray, "time row col"]]:
        return {}

    def frames(self, trial: Trial) -> Float[np.ndarray, "time row col"]:
        """What the eye sees in a trial, rendered once."""
        if trial.name not in self._frames:
            self._frames[trial.name] = trial.frames(self.eye)
        return self._frames[trial.name]


@functools.lru_cache(maxsize=1)
def exam_of(eye: Eye, shift: float = 0.0, seed: int = 0) -> Exam:
    """The whole exam; the last one is kept with its frames, some 300 MB at 48 x 64, for the next model."""
    return Exam(eye, shift, seed)


def sums_of(exam: Exam, model: AbstractNetwork, progress: bool = False) -> ExamSums:
    """MP(t) and F(t) of every trial: the pixel stage."""
    trials = [trial for group in exam.groups for trial in group]
    results = _each(exam, model, tqdm(trials, unit="stimulus", leave=False, disable=None if progress else True))
    stacked = []
    for group in exam.groups:
        mp, f = zip(*(next(results) for _ in group), strict=True)
        stacked.append(Sums(jnp.stack(mp), jnp.stack(f)))
    return tuple(stacked)


def _each(exam: Exam, model: AbstractNetwork, trials: tqdm) -> Iterator[Sums]:
    for trial in trials:
        trials.set_description(trial.name)
        frames = jnp.asarray(exam.frames(trial))
        yield _sums(at_rate(model, exam, trial.fps), frames, jnp.asarray(1000 / trial.fps, dtype=float))


def at_rate(model: AbstractNetwork, exam: Exam, fps: float) -> AbstractNetwork:
    """The model for trials of a frame rate, the exam's or the finer one."""
    return model if fps == exam.eye.fps else at_frame_rate(dataclasses.replace(model, eye=exam.eye), fps)


@traced_once
def _sums(model: AbstractNetwork, frames, interval) -> Sums:
    return model.sums(frames, interval)[0]
