"""How well a model does on labelled clips: the alarms of each, hits against false alarms, and time before contact."""

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from lgmd2jax._arguments.checked import checked
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._signals import stretches
from lgmd2jax.alarms._clip import ClipLabels, LabelledClip, Stretch
from lgmd2jax.alarms._clip_batch import ClipBatch, batches_of
from lgmd2jax.alarms._counts import Counts, Score
from lgmd2jax.alarms._evidence import evidence, spikes_for_alarm
from lgmd2jax.alarms._reasons import Drive, FalseAlarm, Miss, active_part, drive_of, false_alarms, misses


class Verdict(NamedTuple):
    """What a model did on a clip.

    - `alarms`: first and last frame, as in the file, of each stretch in which the alarm is on.
    - `hits`: for each window, whether the alarm was raised in it.
    - `false_alarms`: how often it was raised or stood in a silence.
    - `warning_ms`: from the first alarm in a window to contact; NaN without either.
    - `margin`: how far T_sp may move until something here changes, in units of U'; negative where something is wrong.
    - `fps`: frames a second that differ from the one before.
    - `misses`, `raised`: why each missed window was missed, and where in the field each false alarm came from; empty
      for evidence whose drive is not known.
    """

    clip: str
    alarms: tuple[Stretch, ...]
    hits: tuple[bool, ...]
    false_alarms: int
    warning_ms: float
    margin: float
    fps: float = math.nan
    misses: tuple[Miss, ...] = ()
    raised: tuple[FalseAlarm, ...] = ()

    @property
    def right(self) -> bool:
        """Whether all windows are hit and all silences kept."""
        return all(self.hits) and not self.false_alarms


@dataclasses.dataclass(frozen=True)
class Evaluation:
    """What a detector does on labelled clips: its evidence for an alarm in every frame, so that any T_sp can be judged.

    ```python
    labels = lgmd.alarms.load_labels("video")
    evaluation = labels.evaluate(lgmd.LGMD2(eye=labels.eye))
    print(evaluation.score())          # hits and false alarms a minute, with intervals
    evaluation.verdicts()[0].misses    # why windows of the first clip were missed
    ```

    - `clips`: the labels of each clip.
    - `evidence`: for each clip a value a frame: the largest T_sp at which there would be an alarm (`evidence`).
    - `T_sp`: the model's own; there is an alarm where the evidence reaches it.
    - `drives`: what acted on the cell in each frame of every clip; none for evidence of another origin.
    """

    clips: tuple[ClipLabels, ...]
    evidence: tuple[Float[np.ndarray, " _time"], ...]
    T_sp: float
    drives: tuple[Drive, ...] = ()

    def verdicts(self) -> tuple[Verdict, ...]:
        """What the model does on each clip."""
        drives = self.drives or [None] * len(self.clips)
        return tuple(
            _verdict(clip, trace, drive, self.T_sp)
            for clip, trace, drive in zip(self.clips, self.evidence, drives, strict=True)
        )

    @checked
    def operating_curve(
        self, thresholds: Float[np.ndarray, " threshold"]
    ) -> tuple[Float[np.ndarray, " threshold"], Float[np.ndarray, " threshold"]]:
        """For each T_sp, the share of windows that are hit, and the false alarms a minute of what must be silent."""
        judged = zip(self.clips, self.evidence, strict=True)
        peaks = [trace[inside].max() for clip, trace in judged for inside in clip.in_windows()]
        hits = _reaching(np.array(peaks, float), thresholds)
        return hits / max(self.windows, 1), self.raised(thresholds) / max(self.silent_minutes, 1e-9)

    @checked
    def raised(self, thresholds: Float[np.ndarray, " threshold"]) -> Int[np.ndarray, " threshold"]:
        """How many false alarms each threshold raises, all clips together.

        One begins in each silent frame that reaches the threshold where the frame before did not, or was not silent.
        """
        lowest = np.full(1, -np.inf)
        before = [
            np.concatenate([lowest, np.where(silent, trace, -np.inf)[:-1]])[silent]
            for trace, silent in zip(self.evidence, map(ClipLabels.in_silence, self.clips), strict=True)
        ]
        now = self.silent_evidence
        return _reaching(now, thresholds) - _reaching(np.minimum(now, np.concatenate([*before, now[:0]])), thresholds)

    @property
    def silent_evidence(self) -> Float[np.ndarray, " frame"]:
        """The evidence in all frames that must be silent."""
        judged = zip(self.clips, self.evidence, strict=True)
        return np.concatenate([np.zeros(0), *(trace[clip.in_silence()] for clip, trace in judged)])

    @checked
    def among(self, chosen: Bool[np.ndarray, " clip"]) -> "Evaluation":
        """The evaluation of some of the clips."""
        clips, evidence, drives = (
            tuple(itertools.compress(each, chosen)) for each in (self.clips, self.evidence, self.drives)
        )
        return dataclasses.replace(self, clips=clips, evidence=evidence, drives=drives)

    def score(self) -> Score:
        """Hits and false alarms a minute at the model's own T_sp, with their 95 % intervals (Wilson's, Garwood's)."""
        return self.counts().score()

    @checked
    def counts(self, threshold: float | None = None) -> Counts:
        """Hits and false alarms of each clip at a threshold, by default the model's own T_sp."""
        threshold = self.T_sp if threshold is None else threshold
        hits, false = np.array([self.counts_of(clip, threshold) for clip in range(len(self.clips))]).T
        windows = np.array([len(clip.windows) for clip in self.clips])
        return Counts(hits, windows, false, np.array([clip.silent_minutes for clip in self.clips]))

    @checked
    def counts_of(self, clip: int, threshold: float) -> tuple[int, int]:
        """The windows hit and the false alarms of one clip, by its number from 0, at a threshold."""
        labels, on = self.clips[clip], self.evidence[clip] >= threshold
        hits = int((labels.in_windows() & on).any(axis=1).sum())
        return hits, len(stretches(on & labels.in_silence()))

    @property
    def windows(self) -> int:
        """How many alarms are wanted."""
        return sum(len(clip.windows) for clip in self.clips)

    @property
    def silent_minutes(self) -> float:
        """For how long all clips together must be silent, in minutes."""
        return sum(clip.silent_minutes for clip in self.clips)


@dataclasses.dataclass(frozen=True)
class HeldOutScores:
    """What models do on held-out clips.

    - `minutes`: how long the clips must be silent. `windows`: how many alarms are wanted.
    - `scores`: by the model's name.
    """

    minutes: float
    windows: int
    scores: Mapping[str, Score]

    @classmethod
    @checked
    def of(cls, evaluations: Mapping[str, Evaluation]) -> "HeldOutScores":
        """The scores of models, from their evaluations on the same clips."""
        first = next(iter(evaluations.values()))
        scores = {name: evaluation.score() for name, evaluation in evaluations.items()}
        return cls(first.silent_minutes, first.windows, scores)


@checked
def evaluate(model: LGMD2, clips: Sequence[LabelledClip]) -> Evaluation:
    """Run a model over labelled clips; of a file of labels, `LabelFile.evaluate` does so without holding all frames.

    **Raises:** `ValueError` for no clips.
    """
    if not clips:
        raise ValueError("clips is empty; give at least one")
    traces: dict[int, np.ndarray] = {}
    drives: dict[int, Drive] = {}
    for batch in batches_of(clips):
        padded, drive = jax.device_get(_judged(model, batch, spikes_for_alarm(model)))
        for place, member in enumerate(batch.members):
            length = len(clips[member].frames)
            traces[member] = padded[place, :length]
            drives[member] = Drive(*(channel[place, :length] for channel in drive))
    order = range(len(clips))
    T_sp = float(model.parameters.T_sp)
    return Evaluation(tuple(clips), tuple(traces[i] for i in order), T_sp, tuple(drives[i] for i in order))


@traced_once
def _judged(model: LGMD2, batch: ClipBatch, N_sp: int) -> tuple[Float[Array, "clip time"], Drive]:
    """The evidence in every frame, and what acted on the cell."""
    pixels = batch.frames[0, 0].size

    def judged(sums, part, interval):
        response = model.respond(sums, interval, pixels)
        trace = evidence(response.smp_adapted, model.parameters.sigma_sp, N_sp, model.N_ts)
        return trace, drive_of(model, sums.mp, response.ffi, part, interval, pixels, N_sp)

    return jax.vmap(judged)(*batch.recorded(model, active_part), batch.interval)


def _reaching(
    evidence: Float[np.ndarray, " frame"], thresholds: Float[np.ndarray, " threshold"]
) -> Int[np.ndarray, " threshold"]:
    """How often the evidence reaches each threshold."""
    return len(evidence) - np.searchsorted(np.sort(evidence), thresholds)


def _verdict(clip: ClipLabels, trace: np.ndarray, drive: Drive | None, T_sp: float) -> Verdict:
    on, silence, inside = trace >= T_sp, clip.in_silence(), clip.in_windows()
    margins = [float(trace[window].max()) - T_sp for window in inside]
    if silence.any():
        margins.append(T_sp - float(trace[silence].max()))
    in_time = np.flatnonzero(on & inside.any(axis=0))
    warning = math.nan
    if clip.contact_ms is not None and len(in_time):
        warning = clip.contact_ms - float(clip.time[in_time[0]])
    return Verdict(
        clip=clip.name,
        alarms=tuple((int(clip.index[a]), int(clip.index[b])) for a, b in stretches(on)),
        hits=tuple(bool((window & on).any()) for window in inside),
        false_alarms=len(stretches(on & silence)),
        warning_ms=warning,
        margin=min(margins, default=math.nan),
        fps=clip.fps,
        misses=() if drive is None else misses(clip, trace, drive, T_sp),
        raised=() if drive is None else false_alarms(clip, trace, drive, T_sp),
    )
