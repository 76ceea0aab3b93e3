"""The urgency of a fitted model: in its hand-over file, with a diagram and the numbers that say whether it holds."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path

from lgmd2jax._files.atomic import replaced, write_json
from lgmd2jax._handover.model_file import load
from lgmd2jax._results.fit_json import plain
from lgmd2jax.alarms import LabelledClip, Reliability, fit_urgency

URGENCY_FILES = ("urgency.json", "reliability.png")


def add_urgency(
    folder: Path, clips: Sequence[LabelledClip], held_out: Sequence[LabelledClip], within_ms: float | int
) -> str:
    """Calibrate the urgency of the model in a folder, and add it.

    **Arguments:** `held_out`: clips that the model was not fitted on, in which is counted how often that comes true
    which is said; each is judged by the counts of the others.

    **Returns:** how well it does, in a few lines.
    """
    from lgmd2jax._figures.alarms import reliability_figure  # needs matplotlib

    path = folder / "model.json"
    model = load(path)
    urgency, found = fit_urgency(model, clips, within_ms).recalibrated(model, held_out)
    content = {"urgency": dataclasses.asdict(urgency), "held_out": plain(dataclasses.asdict(found))}
    numbers, diagram = (folder / name for name in URGENCY_FILES)
    with replaced(numbers) as table, replaced(diagram) as figure:
        write_json(table, content)
        reliability_figure(figure, found, urgency.within_ms)
        urgency.save(path)
    return _summary(found, within_ms)


def _summary(found: Reliability, within_ms: float) -> str:
    brier, slope, offset = found.brier, found.slope, found.intercept
    return (
        f"urgency: probability of contact within {within_ms:g} ms, on {found.frames.sum()} frames of held-out clips\n"
        f"  Brier score {brier.value:.4f} ({brier.low:.4f} .. {brier.high:.4f}); "
        f"of a constant probability {found.brier_of_the_mean:.4f}\n"
        f"  observed over predicted log-odds: slope {slope.value:.2f} ({slope.low:.2f} .. {slope.high:.2f}), "
        f"intercept {offset.value:.2f} ({offset.low:.2f} .. {offset.high:.2f})"
    )
