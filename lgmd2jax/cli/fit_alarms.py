"""`lgmd2jax fit RECIPE` for a recipe of kind "alarms": from labelled clips to a model that a robot runs."""

import argparse
import functools
import itertools
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Bool

from lgmd2jax._compute.cluster import is_installed
from lgmd2jax._compute.finished_work import Memory
from lgmd2jax._files.folder import check_folder
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._results.alarm_folder import AlarmFolder
from lgmd2jax._results.results_folder import MARKER, SEARCH
from lgmd2jax._results.urgency import URGENCY_FILES, add_urgency
from lgmd2jax.alarms import (
    AlarmFit,
    AlarmRecipe,
    Comparison,
    Detector,
    Evaluation,
    HeldOutScores,
    LabelledClip,
    detectors,
    evaluate,
    load_labels,
)
from lgmd2jax.alarms._detectors import MODEL, TABLE_I, TITLES
from lgmd2jax.cli.recipe_results import check_eyes, clips_bar, folder_of, kept_work, records, write_stopped

_HELD_OUT = "the scores on held-out clips"
_URGENCY = "the urgency"
_WITHOUT = "Recorded clips, each source judged by a fit without it"
_TRAINING = 200  # fitted clips on which detectors choose their thresholds


def check_options(options: argparse.Namespace) -> None:
    """Raise `ValueError` for options about own clips that have no effect, or contradict each other."""
    for name, given in (("--clips-weight", options.clips_weight is not None), ("--clips-only", options.clips_only)):
        if given and options.clips is None:
            raise ValueError(f"{name} is given without clips of your own; name their file: --clips FILE")
    if options.clips_only and options.clips_weight is not None:
        raise ValueError("--clips-only leaves no other clips to weigh against; leave out --clips-weight")
    if options.clips_weight is not None and not (np.isfinite(options.clips_weight) and options.clips_weight > 0):
        raise ValueError(f"--clips-weight is {options.clips_weight:g}; give a positive number")


def run(options: argparse.Namespace, recipe: AlarmRecipe, start: float) -> None:
    """Make the fit, write its folder, add its scores on held-out clips, and print the report."""
    folder = folder_of(options, recipe.name)
    check_folder(folder, MARKER)
    if recipe.within_ms is None and (folder / URGENCY_FILES[0]).is_file():
        print(f"{folder} has an urgency, which this fit drops; keep one by [urgency] in the recipe", flush=True)
    # First, so that wrong labels show before the others are rendered.
    own = () if options.clips is None else _own_clips(options.clips, recipe)
    clips = own if options.clips_only else (*recipe.file.load(clips_bar), *own)
    if own and not options.clips_only:
        recipe = recipe.weighing(options.clips_weight or recipe.weights.get("recorded", 1))
    digest = recipe.digest(clips)
    with kept_work(folder, digest, options.resume) as memory:
        alarms = sum(len(clip.windows) for clip in clips)
        print(f"fitting {', '.join(recipe.free.names)} to {len(clips)} clips with {alarms} alarms wanted", flush=True)
        if not any(clip.silent for clip in clips):
            print("no clip has a silence, so that a model that always fires would be correct", flush=True)
        fit = recipe.run(clips, progress=True, memory=memory)
        left = [_HELD_OUT] if recipe.validation is not None or fit.without else []
        left += [] if recipe.within_ms is None else [_URGENCY]
        notes, provenance = records(recipe, digest, start, folder)
        results = AlarmFolder(fit, folder, recipe.name, notes)
        if fit.stopped:
            provenance["unfinished"] = SEARCH
            write_stopped(folder, lambda: results.begin([SEARCH, *left], provenance), fit.summary())
        results.begin(left, provenance)
        results.draw(left)
        held_out = recipe.held_out()
        scores, comparisons = _comparisons(fit, clips, held_out, memory)
        if left:
            results.add(left[1:], scores, comparisons)
        if recipe.within_ms is not None:
            print(add_urgency(folder, clips, held_out, recipe.within_ms))
            results.add((), scores, comparisons)
    print(fit.summary(scores, comparisons))
    print(f"\nwrote {folder}/ in {time.monotonic() - start:.0f} s; open {folder}/report.html")


def _own_clips(path: Path, recipe: AlarmRecipe) -> tuple[LabelledClip, ...]:
    """The clips of another file; they may have a size of their own, but parameters belong to a rate and a scale."""
    file = load_labels(path)
    check_eyes(file.eye, str(path), recipe.file.eye, "the recipe", "use the recipe's in the [eye] of the labels")
    return file.load(clips_bar)


def _comparisons(
    fit: AlarmFit, clips: Sequence[LabelledClip], held_out: Sequence[LabelledClip], memory: Memory
) -> tuple[HeldOutScores | None, dict[str, Comparison]]:
    """The fitted model beside the paper's and plain detectors: on clips that no fit saw, and source by source.

    Where no silence says how often a detector may alarm, there is no comparison. `memory`: keeps what each detector
    did, as of the fit.
    """
    others = functools.partial(_kept, memory, functools.partial(_others, fit.model))
    scores, comparisons = None, {}
    if held_out:
        own = _kept(memory, lambda some: {MODEL: evaluate(fit.model, some)}, "the model, held out", held_out)
        shown = {**own, **others("detectors, held out", held_out)}
        scores = HeldOutScores.of({"fitted": shown[MODEL], **{TITLES[name]: shown[name] for name in TABLE_I}})
        words, training = _training(fit, clips, others)
        if scores.minutes and training[MODEL].evaluation.silent_minutes:
            title = f"Held-out clips: {scores.windows} windows, {scores.minutes:.1f} minutes of silence"
            comparisons[title] = Comparison.of(_detectors(shown), (words, training))
    recorded = np.array([clip.source is not None for clip in clips])
    if fit.without and fit.evaluation.among(recorded).silent_minutes:
        sources = list(itertools.compress(clips, recorded))
        judged = _beside(fit, recorded, others("detectors, recorded clips", sources))
        comparisons[_WITHOUT] = Comparison.of(judged, None if recorded.all() else _training(fit, clips, others))
    return scores, comparisons


def _training(
    fit: AlarmFit, clips: Sequence[LabelledClip], others: Callable[[str, Sequence[LabelledClip]], dict[str, Evaluation]]
) -> tuple[str, dict[str, Detector]]:
    """Some of the fitted clips, in words, and what each detector does on them: rendered ones, if any."""
    rendered = np.array([clip.source is None for clip in clips])
    chosen = rendered if rendered.any() else np.ones(len(clips), bool)
    chosen &= np.cumsum(chosen) <= _TRAINING
    some = list(itertools.compress(clips, chosen))
    return f"{len(some)} of the fitted clips", _beside(fit, chosen, others("detectors, fitted clips", some))


def _beside(fit: AlarmFit, chosen: Bool[np.ndarray, " clip"], others: Mapping[str, Evaluation]) -> dict[str, Detector]:
    """The fitted model on the chosen clips, by what each source may be judged, and others beside it."""
    return {MODEL: Detector(fit.evaluation, fit.without).among(chosen), **_detectors(others)}


def _kept(
    memory: Memory,
    judge: Callable[[Sequence[LabelledClip]], Mapping[str, Evaluation]],
    key: str,
    clips: Sequence[LabelledClip],
) -> dict[str, Evaluation]:
    """What detectors do on clips: judged once, then taken from the memory, when a stopped fit is resumed."""
    if key not in memory:
        memory[key] = {
            name: {"T_sp": each.T_sp, "evidence": [trace.tolist() for trace in each.evidence]}
            for name, each in judge(clips).items()
        }
    return {
        name: Evaluation(tuple(clips), tuple(np.array(trace, float) for trace in each["evidence"]), each["T_sp"])
        for name, each in memory[key].items()
    }


def _detectors(evaluations: Mapping[str, Evaluation]) -> dict[str, Detector]:
    return {name: Detector(evaluation) for name, evaluation in evaluations.items()}


def _others(model: LGMD2, clips: Sequence[LabelledClip]) -> dict[str, Evaluation]:
    """What the detectors do that the model is compared with; without OpenCV that of the optical flow is left out."""
    return detectors(clips, model, flow=is_installed("cv2"))
