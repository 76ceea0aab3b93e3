"""The sections of a report about what is computed after a fit: profiles, score test, predictions, law, truth."""

import dataclasses
import math
from collections.abc import Mapping, Sequence

import numpy as np

from lgmd2jax._network.parameters import ParameterSet, symbols
from lgmd2jax._reports.digits import plain, rounded
from lgmd2jax._reports.section import Section
from lgmd2jax._targets.observation import observation_symbols
from lgmd2jax.fitting._cells import interval_cell, r2_cell, unit_cell
from lgmd2jax.fitting._curve import Curve
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._law_fit import LawComparison
from lgmd2jax.fitting._uncertainty.covariance import CONFIDENCE, Uncertainty
from lgmd2jax.fitting._uncertainty.profile import Profile
from lgmd2jax.fitting._uncertainty.score import Score

_PROMISING = 5  # fixed parameters that have a row


@dataclasses.dataclass(frozen=True)
class Supplement:
    """Results that a report tells besides the fit's own.

    - `profiles`: the profile-likelihood interval of a parameter, by its name.
    - `scores`: of the fixed parameters, what freeing each would promise, the best first.
    - `left_out`: R2 of a condition, by its name, predicted by a fit to all others.
    - `looming_law`: the looming law fitted to the same recordings.
    - `truth`: the known values of a twin's parameters.
    - `unfinished`: what is still to come, such as draws, each in a few words.
    """

    profiles: Mapping[str, Profile] = dataclasses.field(default_factory=dict)
    scores: Sequence[Score] = ()
    left_out: Mapping[str, float] = dataclasses.field(default_factory=dict)
    looming_law: LawComparison | None = None
    truth: Mapping[str, float] = dataclasses.field(default_factory=dict)
    unfinished: tuple[str, ...] = ()


def score_section(scores: Sequence[Score], parameters: ParameterSet) -> Section:
    """The fixed parameters that promise most."""
    known = symbols(type(parameters)) | observation_symbols()
    rows = tuple(
        (
            score.name,
            unit_cell(known[score.name].unit),
            plain(score.value),
            f"{score.better:.3g}",
            f"{score.decrease:.3g}",
            f"{score.probability:.1g}",
        )
        for score in scores[:_PROMISING]
    )
    columns = ("fixed", "unit", "value|", "better|", "chi2 falls by|", "p|")
    sentences = (
        "A score test: to first order, with all free parameters following. p: how often chance alone lowers chi2 as "
        "much. A long step keeps less than it promises: free the parameter and fit again.",
    )
    return Section("Fixed parameters that, freed, would lower chi2 most", columns, rows, sentences if rows else ())


def profile_section(profiles: Mapping[str, Profile], free: Free, u: Uncertainty) -> Section:
    """Intervals by profile likelihood beside those of the table of free parameters."""
    rows = []
    for name, profile in profiles.items():
        i = free.names.index(name)
        low, high = (
            "open" if is_open else rounded(end, float(u.values[i]), float(u.standard_errors[i]))
            for end, is_open in zip(profile.interval, profile.is_open, strict=True)
        )
        rows.append((name, f"{low} .. {high}", interval_cell(u, i), unit_cell(free.parameters[i].symbol.unit)))
    columns = ("parameter", "by profile|", f"as in the table, {CONFIDENCE:.0%}|", "unit")
    is_open = any(end for profile in profiles.values() for end in profile.is_open)
    sentences = ("Open: chi2 does not rise so far up to the bound.",) if is_open else ()
    return Section("Profile-likelihood intervals", columns, tuple(rows), sentences)


def left_out_section(left_out: Mapping[str, float]) -> Section:
    """R2 of each condition by a fit to the others."""
    rows = tuple((name, r2_cell(r2)) for name, r2 in left_out.items())
    return Section("Each condition predicted by a fit to all others", ("left out", "R2|"), rows)


def law_section(law: LawComparison | None, curves: Sequence[Curve], left_out: Mapping[str, float]) -> Section:
    """The network beside eta, which has five free numbers and knows the angle of the object."""
    title = "Beside the looming law, seen through the same observation"
    if law is None:
        return Section(title)
    hard = {curve.condition: curve.r2() for curve in curves if curve.channel == "rate"}
    rows = tuple(
        (
            name,
            *(r2_cell(r2) for r2 in (hard[name], law.r2[name], left_out.get(name, math.nan), law.left_out[name])),
            *(f"{time:+.1f}" for time in peaks),
        )
        for name, peaks in law.peaks.items()
    )
    columns = ("approach", "R2 network|", "law|", "left out: network|", "law|")
    columns += ("peak in ms: recorded|", "network|", "law|")
    fitted, observation = law.law, law.law.observation
    means = [float(np.mean(list(r2.values()))) for r2 in (left_out, law.left_out) if r2]
    return Section(
        title,
        columns,
        rows,
        (
            *(
                f"Peaks, {name}: {line.alpha:.2f} l/|v| - {line.delta:.1f} ms before collision, r2 {line.r2:.3f}."
                for name, line in law.lines.items()
            ),
            f"Left out, in the mean: {' and '.join(r2_cell(mean) for mean in means)}"
            + (" (network, law)." if len(means) > 1 else " (law)."),
            f"The law: alpha {fitted.alpha:.2f}, gain (l/|v|)^{fitted.exponent:.2f} and "
            f"{float(observation.gain):.0f} spikes/s at 40 ms, baseline {float(observation.baseline):.1f} spikes/s, "
            f"latency with delta {float(observation.latency):.0f} ms.",
        ),
    )


def truth_section(truth: Mapping[str, float], free: Free, values: Mapping[str, float], u: Uncertainty) -> Section:
    """How far a twin's parameters are from their known values."""
    rows = []
    for name, true_value in truth.items():
        i = free.names.index(name)
        parameter, error, off = free.parameters[i], float(u.standard_errors[i]), values[name] - true_value
        in_errors = f"{off / error:+.2f}" if math.isfinite(error) and error > 0 else "-"
        of_range = f"{off / (parameter.high - parameter.low):+.3%}"
        rows.append((name, f"{true_value:.6g}", f"{values[name]:.6g}", of_range, in_errors))
    columns = ("parameter", "truth|", "fitted|", "off, of its range|", "off, in s.e.|")
    return Section("Known truth", columns, tuple(rows))
