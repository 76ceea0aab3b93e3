"""What a reader must know before trusting the numbers of a fit: a function a subject, each gives a sentence or none."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from lgmd2jax.fitting import _report
from lgmd2jax.fitting._curve import DISAGREEMENT, Curve
from lgmd2jax.fitting._search.descent import FINAL
from lgmd2jax.fitting._uncertainty.covariance import Uncertainty


def on_search(result: str, stats: Mapping[str, Any]) -> Iterator[str]:
    """That the candidate was chosen by a score, or that the descent came to no end."""
    if choice := stats.get("choice"):
        yield (
            f"Of {choice['candidates']} candidates this one was chosen for its score of {choice['score']:g}; the "
            f"least loss is {choice['least_loss']:.4g}, with a score of {choice['score_of_least_loss']:g}. Errors "
            "and intervals are those of the curves alone, near the chosen point."
        )
    elif result not in FINAL:
        yield f"The last descent did not converge: {result}."


def on_bounds(values: Mapping[str, float], u: Uncertainty) -> Iterator[str]:
    """Which parameters lie on a bound."""
    sides = zip(values.items(), u.on_bound, strict=True)
    bounds = [f"{name} ({value:.4g})" for (name, value), side in sides if side]
    if bounds:
        yield f"On a bound: {', '.join(bounds)}. Wider bounds may fit better."


def on_misfit(u: Uncertainty) -> Iterator[str]:
    """That the curves differ from the targets by more than the errors of these explain."""
    if u.absolute and not u.reason and not _report.consistent(u):
        yield (
            f"The misfit is not consistent with the errors of the targets (chi2 {u.chi2:.3g} for "
            f"{u.degrees_of_freedom:.4g} degrees of freedom): the model, or the errors, are wrong, and "
            "the intervals, which believe them, are too narrow."
        )


def on_missed_targets(curves: Sequence[Curve], stats: Mapping[str, Any], best: int, descents: int) -> Iterator[str]:
    """Which targets are missed, and whether that is the model's fault or the search's.

    **Arguments:** `best`: how many of the `descents` ended at the best loss.
    """
    if missed := [curve for curve in curves if curve.grade == "missed"]:
        count = f"{len(missed)} of {len(curves)} targets {'is' if len(missed) == 1 else 'are'} missed"
        yield f"{count}, {_why_missed(stats, best, descents)}: {_listed(missed)}. The table says by how much."


def on_hard_and_soft(curves: Sequence[Curve]) -> Iterator[str]:
    """Where the hard model, which is handed over, differs from the soft one, which was fitted."""
    if apart := [curve for curve in curves if curve.gap > DISAGREEMENT]:
        largest = max(curve.gap for curve in apart)
        yield (
            f"Soft and hard model differ, by {largest:.0%} of the span at most: {_listed(apart)}. Grades are those "
            "of the hard model; errors and intervals are those of the soft one, and hold less well."
        )


def on_noise(stats: Mapping[str, Any], threshold: str) -> Iterator[str]:
    """That the noise of a camera inhibits the cell. `threshold`: the parameter from which it is inhibited."""
    if loud := stats.get("inhibition_in_noise"):
        yield (
            f"The conditions' noise alone, {loud['noise']:g} grey levels at {loud['fps']:g} frames per second, "
            f"brings the inhibition to {loud['share']:.0%} of {threshold}: let "
            f"{'T_p' if threshold == 'A_ffi' else threshold} rise."
        )


def on_nonlinear(names: Sequence[str]) -> Iterator[str]:
    """Whose intervals need a profile."""
    if names:
        yield (
            f"The curves are nonlinear within the intervals of {', '.join(names)}: profile-likelihood "
            "intervals are right there, by profile in the recipe's [uncertainty] or Fit.profile."
        )


def _why_missed(stats: Mapping[str, Any], best: int, descents: int) -> str:
    """What the search says of targets that are missed: that none can be met takes descents that agree."""
    agreeing = f"{best} of {descents} descents"
    if "choice" in stats:
        return "for the candidate was not chosen by its loss"
    if best > max(descents / 2, 1):
        return f"and the model cannot meet them within its bounds, as {agreeing} agree"
    return f"and a wider search may do better, as {agreeing} ended here"


def _listed(curves: Sequence[Curve]) -> str:
    """The conditions of some curves, each with its channels."""
    channels: dict[str, dict[str, None]] = {}
    for curve in curves:
        channels.setdefault(curve.condition, {})[curve.channel] = None
    return ", ".join(f"{condition} ({', '.join(names)})" for condition, names in channels.items())
