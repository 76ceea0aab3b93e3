"""Detectors side by side on the same clips: at their own thresholds, and at equal budgets of false alarms."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy
from jaxtyping import Bool, Float, Int

from lgmd2jax._arguments.checked import checked
from lgmd2jax.alarms._clip import ClipLabels
from lgmd2jax.alarms._counts import Counts, Share
from lgmd2jax.alarms._evaluation import Evaluation

BUDGETS = (1.0, 2.0, 4.0)  # false alarms a minute
INTERVALS = (
    "95 % intervals, Wilson's of the windows hit, Garwood's of the false alarms, of the difference by a paired "
    "bootstrap over sources"
)
_FOLDS = 20  # at most: of more sources, several are left out together
_RESAMPLES = 5000


@checked
@dataclasses.dataclass(frozen=True)
class Detector:
    """What a detector does on clips.

    - `evaluation`: by the detector as it is handed over, with its own threshold; infinite where it has none.
    - `without`: for each source, by what was fitted without it; empty for what is not fitted to these clips.
    """

    evaluation: Evaluation
    without: Mapping[str, Evaluation] = dataclasses.field(default_factory=dict)

    @checked
    def for_source(self, source: str | None) -> Evaluation:
        """The evaluation by which a source may be judged."""
        return self.evaluation if source is None else self.without.get(source, self.evaluation)

    @checked
    def among(self, chosen: Bool[np.ndarray, " clip"]) -> "Detector":
        """What the detector does on some of the clips."""
        without = {source: evaluation.among(chosen) for source, evaluation in self.without.items()}
        return Detector(self.evaluation.among(chosen), without)

    @checked
    def counts(self, thresholds: Float[np.ndarray, " clip"]) -> Counts:
        """Hits and false alarms of all clips, each at its own threshold and by what may judge its source."""
        judged = [
            self.for_source(clip.source).counts_of(number, float(threshold))
            for number, (clip, threshold) in enumerate(zip(self.evaluation.clips, thresholds, strict=True))
        ]
        hits, false = np.array(judged).T
        return dataclasses.replace(self.evaluation.counts(), hits=hits, false_alarms=false)


class Outcome(NamedTuple):
    """What a detector did on all clips.

    - `threshold`: the least and the largest that were used.
    - `more_hits`: how much larger a share of the windows the first detector hits at the same budget; None for it.
    """

    counts: Counts
    threshold: tuple[float, float]
    more_hits: Share | None = None


class Compared(NamedTuple):
    """What a detector did at its own threshold, where it has one, and at each budget of false alarms a minute."""

    evaluation: Evaluation
    own: Outcome | None
    at_budgets: Mapping[float, Outcome]


@dataclasses.dataclass(frozen=True)
class Comparison:
    """Detectors on the same clips, by name; the others are compared with the first.

    - `training`: on which clips the thresholds for the budgets were chosen, in words.
    """

    clips: tuple[ClipLabels, ...]
    detectors: Mapping[str, Compared]
    training: str

    @classmethod
    @checked
    def of(
        cls, detectors: Mapping[str, Detector], training: tuple[str, Mapping[str, Detector]] | None = None
    ) -> "Comparison":
        """Compare detectors on their clips.

        At a budget each has the lowest threshold that keeps within it on clips that are none of those judged.

        **Arguments:** `training`: words for clips that are not judged, and what each detector does on them. The
        threshold for a source is chosen on these and on the other sources that are judged; that for a clip without a
        source, on these alone where they are given.

        **Raises:** `ValueError` for clips without any silence.
        """
        clips = next(iter(detectors.values())).evaluation.clips
        if not sum(clip.silent_minutes for clip in clips):
            raise ValueError("no clip has a silence, in which false alarms are counted; give at least one")
        groups = _groups(clips)
        folds, words = _folds(clips, groups, None if training is None else training[0])
        compared: dict[str, Compared] = {}
        for name, detector in detectors.items():
            at_budgets = {}
            for budget in BUDGETS:
                thresholds = _chosen(detector, budget, folds, None if training is None else training[1][name])
                counts, gain = detector.counts(thresholds), None
                if compared:
                    first = next(iter(compared.values()))
                    gain = more_hits(first.at_budgets[budget].counts, counts, groups)
                at_budgets[budget] = Outcome(counts, _ends(thresholds), gain)
            compared[name] = Compared(detector.evaluation, _own(detector), at_budgets)
        return cls(clips, compared, words)

    def content(self) -> dict[str, Any]:
        """All numbers as plain data.

        ```
        {"thresholds_from": words,
         "interval": words,
         "detectors": {"model": {"threshold": [least, largest],
                                 "hits": {"count", "windows", "value", "low", "high"},
                                 "false_alarms_per_minute": {"count", "minutes", "value", "low", "high"},
                                 "budgets": {"1": {the same, and "model_hits_more": {"value", "low", "high"}},
                                             "2": .., "4": ..}},
                       "table1_T_sp_0.78": .., "table1_T_sp_0.65": .., "difference": .., "divergence": ..},
         "clips": [{"name", "source", "fps", "windows", "silent_minutes", "hits", "false_alarms"}, ..]}
        ```

        Values are shares of the windows, and rates a minute, each with the ends of its 95 % interval. The numbers of a
        detector are those at its own threshold; one that has none gets that of the smallest budget. Those of a clip are
        the first detector's, at its own.
        """
        first = next(iter(self.detectors.values()))
        judged = first.own or first.at_budgets[BUDGETS[0]]
        clips = [
            {
                "name": clip.name,
                "source": clip.source,
                "fps": clip.fps,
                "windows": len(clip.windows),
                "silent_minutes": clip.silent_minutes,
                "hits": int(hits),
                "false_alarms": int(false),
            }
            for clip, hits, false in zip(self.clips, judged.counts.hits, judged.counts.false_alarms, strict=True)
        ]
        detectors = {
            name: _content(detector.own or detector.at_budgets[BUDGETS[0]])
            | {"budgets": {f"{budget:g}": _content(outcome) for budget, outcome in detector.at_budgets.items()}}
            for name, detector in self.detectors.items()
        }
        return {"thresholds_from": self.training, "interval": INTERVALS, "detectors": detectors, "clips": clips}


def threshold_within(evaluation: Evaluation, budget: float | int) -> float:
    """The lowest threshold that keeps within a budget of false alarms a minute, as every higher one does.

    Very low thresholds keep an alarm on for good, which is raised once in a silence: these are not looked for. The
    threshold lies in the middle between the last evidence that is too much and the next above.
    """
    levels = np.unique(evaluation.silent_evidence)[::-1]
    too_many = np.flatnonzero(evaluation.raised(levels) > budget * evaluation.silent_minutes)
    if not len(too_many):
        return float(levels[-1])
    last = too_many[0]
    return float((levels[last] + levels[last - 1]) / 2) if last else float(np.nextafter(levels[0], np.inf))


def more_hits(ours: Counts, others: Counts, groups: Int[np.ndarray, " clip"]) -> Share:
    """How much larger the share of windows is that `ours` hits, with the interval of a paired bootstrap over groups.

    In each resample whole groups of clips are drawn, with what both detectors did on them. NaN for what cannot be
    known: without windows, and the interval where they are of one group.
    """
    hits, other_hits, windows = (np.bincount(groups, each) for each in (ours.hits, others.hits, ours.windows))
    samples = tuple(each[windows > 0] for each in (hits, other_hits, windows))

    def gain(own, other, windows, *, axis=-1):
        return (own.sum(axis) - other.sum(axis)) / windows.sum(axis)

    if len(samples[0]) < 2:
        return Share(float(gain(*samples)) if len(samples[0]) else math.nan, math.nan, math.nan)
    interval = scipy.stats.bootstrap(
        samples, gain, paired=True, vectorized=True, n_resamples=_RESAMPLES, method="percentile", random_state=0
    ).confidence_interval
    return Share(float(gain(*samples)), float(interval.low), float(interval.high))


def _content(outcome: Outcome) -> dict[str, Any]:
    counts, score = outcome.counts, outcome.counts.score()
    hits = {"count": int(counts.hits.sum()), "windows": int(counts.windows.sum())}
    false = {"count": int(counts.false_alarms.sum()), "minutes": float(counts.minutes.sum())}
    more = {} if outcome.more_hits is None else {"model_hits_more": outcome.more_hits._asdict()}
    return {
        "threshold": list(outcome.threshold),
        "hits": hits | score.hits._asdict(),
        "false_alarms_per_minute": false | score.false_alarms._asdict(),
        **more,
    }


def _groups(clips: Sequence[ClipLabels]) -> Int[np.ndarray, " clip"]:
    """The number of each clip's source; a rendered clip is a source by itself."""
    known: dict[str, int] = {}
    return np.array([known.setdefault(clip.source or f"rendered {clip.name}", len(known)) for clip in clips])


def _folds(
    clips: Sequence[ClipLabels], groups: Int[np.ndarray, " clip"], training: str | None
) -> tuple[Int[np.ndarray, " clip"] | None, str]:
    """Which clips are judged together by thresholds of the others, and words for it; None for no others."""
    folds = groups % _FOLDS
    if training is not None:
        return (folds, f"{training} and the other sources") if any(clip.source for clip in clips) else (None, training)
    minutes = np.bincount(folds, [clip.silent_minutes for clip in clips])
    if np.all(minutes.sum() - minutes > 0):
        return folds, "the clips of the other sources"
    return None, "the same clips, since no silence is left without one of the sources"


def _chosen(
    detector: Detector, budget: float, folds: Int[np.ndarray, " clip"] | None, training: Detector | None
) -> Float[np.ndarray, " clip"]:
    """The threshold for each clip."""
    clips = detector.evaluation.clips
    if folds is None:
        return np.full(len(clips), threshold_within((training or detector).evaluation, budget))
    keys = [(fold, clip.source if detector.without else None) for fold, clip in zip(folds, clips, strict=True)]
    known = {}
    for fold, source in dict.fromkeys(keys):
        others = detector.for_source(source).among(folds != fold)
        if training is not None:
            others = _together(training.for_source(source), others)
        known[fold, source] = threshold_within(others, budget)
    return np.array([known[key] for key in keys])


def _together(some: Evaluation, others: Evaluation) -> Evaluation:
    """What a detector does on two sets of clips; what drove it is left out."""
    return Evaluation((*some.clips, *others.clips), (*some.evidence, *others.evidence), some.T_sp)


def _own(detector: Detector) -> Outcome | None:
    if math.isinf(detector.evaluation.T_sp):
        return None
    thresholds = np.array([detector.for_source(clip.source).T_sp for clip in detector.evaluation.clips])
    return Outcome(detector.counts(thresholds), _ends(thresholds))


def _ends(values: Float[np.ndarray, " clip"]) -> tuple[float, float]:
    return float(values.min()), float(values.max())
