"""The sections of a fit's report, in the manner of lmfit and iminuit."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import get_args

import numpy as np
import scipy

from lgmd2jax._channels import TARGETS, Channel
from lgmd2jax._network.parameters import ParameterSet, symbols
from lgmd2jax._reports.digits import measured, plain
from lgmd2jax._reports.section import Section
from lgmd2jax._targets.observation import Observation, observation_symbols
from lgmd2jax.fitting._cells import interval_cell, r2_cell, unit_cell
from lgmd2jax.fitting._curve import BAND_GRADES, DISAGREEMENT, GRADES, OF_COUNTS, Curve, Grade, Kind, tallies
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._residuals import residuals_of
from lgmd2jax.fitting._run import Run
from lgmd2jax.fitting._search.descent import FINAL
from lgmd2jax.fitting._uncertainty.covariance import CONFIDENCE, Uncertainty

_CHANCE = 1e-3  # of a chi2 as large as it is, below which the misfit is not consistent with the errors
_CORRELATED, _MOST = 0.5, 10  # from which a correlation has a row, and of how many


def status(result: str, loss: float, u: Uncertainty, curves: Sequence[Curve]) -> tuple[str, ...]:
    """The verdict in a few words each: valid or not, why it stopped, misfit, grades, bounds, what is undetermined.

    A fit is valid whose last descent came to its end, at a finite loss at which there are standard errors, and whose
    misfit is consistent with the errors of the targets; where these are unknown, no target is missed.
    """
    missed = sum(curve.grade == "missed" for curve in curves)
    fits = consistent(u) if u.absolute else not missed
    valid = result in FINAL and math.isfinite(loss) and not u.reason and fits
    bounds = [name for name, side in zip(u.names, u.on_bound, strict=True) if side]
    loose = [name for name, known in zip(u.names, u.determined, strict=True) if not known]
    apart = sum(curve.gap > DISAGREEMENT for curve in curves)
    return (
        "valid" if valid else "NOT VALID",
        result,
        *([] if u.reason else [_misfit(u)]),
        f"targets: {grades(curves)}",
        f"at a bound: {', '.join(bounds)}" if bounds else "none at a bound",
        f"no standard errors: {u.reason}"
        if u.reason
        else f"undetermined: {', '.join(loose)}"
        if loose
        else "all determined",
        f"soft and hard differ in {apart} of {len(curves)} curves" if apart else "soft and hard agree",
    )


def warning(status: Sequence[str]) -> tuple[str, ...]:
    """What to do with a fit that is not valid."""
    if status[0] == "valid":
        return ()
    return ("Not valid: these are the best values that were found. Read the remarks before you use them.",)


def grades(curves: Sequence[Curve]) -> str:
    """How many targets have which grade, the best first."""
    counts = Counter(curve.grade for curve in curves)
    return ", ".join(f"{counts[grade]} {grade}" for grade in get_args(Grade) if counts[grade])


def consistent(u: Uncertainty) -> bool:
    """Whether chance alone would make chi2 as large as that in more than a thousandth of all cases."""
    degrees = max(u.degrees_of_freedom, 1)  # in bands there may be none left
    return bool(scipy.stats.chi2.sf(u.chi2, degrees) >= _CHANCE)


def _misfit(u: Uncertainty) -> str:
    if not u.absolute:
        return "errors unknown: scaled to the misfit"
    if consistent(u):
        return "misfit consistent with the errors"
    return f"misfit {math.sqrt(u.chi2 / max(u.degrees_of_freedom, 1)):.3g} times the errors"


def free_section(
    free: Free, values: Mapping[str, float], start: Mapping[str, float], u: Uncertainty, nonlinear: Sequence[str]
) -> Section:
    """The free parameters; `nonlinear` are those within whose intervals the curves are nonlinear."""
    rows = []
    for i, parameter in enumerate(free.parameters):
        name, error = parameter.name, float(u.standard_errors[i])
        rows.append(
            (
                name,
                measured(values[name], error) if u.determined[i] and not u.reason else plain(values[name]),
                interval_cell(u, i),
                unit_cell(parameter.symbol.unit),
                plain(start[name]),
                f"{parameter.low:g} .. {parameter.high:g}",
                _flags(int(u.on_bound[i]), parameter.prior, name in nonlinear),
            )
        )
    columns = ("free", "value +- s.e.|", f"{CONFIDENCE:.0%} interval|", "unit", "start|", "bounds|", "remark")
    return Section("Free parameters", columns, tuple(rows))


def _flags(side: int, prior: tuple[float, float] | None, nonlinear: bool) -> str:
    flags = [f"at {'lower' if side < 0 else 'upper'} bound"] if side else []
    flags += [f"prior {prior[0]:g} +- {prior[1]:g}"] if prior else []
    return ", ".join(flags + (["nonlinear"] if nonlinear else []))


def given_section(
    free: Free, parameters: ParameterSet, observation: Observation, channels: Sequence[Channel]
) -> Section:
    """What follows a free parameter, and the observation where it stays fixed."""
    rows, known = [], symbols(type(parameters))
    for name, tie in free.ties.items():
        owner, symbol = (parameters, known[name]) if name in known else (observation, observation_symbols()[name])
        follows = tie.to if tie.factor == 1 else f"{tie.factor:g} {tie.to}"
        rows.append((name, plain(float(getattr(owner, name))), unit_cell(symbol.unit), f"tied: {name} = {follows}"))
    if "rate" in channels:
        rows += [
            (name, plain(float(getattr(observation, name))), unit_cell(symbol.unit), "fixed")
            for name, symbol in observation_symbols().items()
            if name not in free.names and name not in free.ties
        ]
    return Section("Tied parameters and fixed observation", ("given", "value|", "unit", "how"), tuple(rows))


def statistics_section(u: Uncertainty, curves: Sequence[Curve], rules: Mapping[str, int]) -> Section:
    """Chi2 and what follows from it. `rules`: how samples and errors arose, each with the number of its curves."""
    data = sum(int((curve.weight > 0).sum()) for curve in curves)
    rows = (
        ("data points", f"{data}", "chi2", f"{u.chi2:.5g}"),
        ("independent samples", f"{u.n_effective:.5g}", "reduced chi2", f"{u.reduced_chi2:.4g}"),
        ("free parameters", f"{len(u.names)}", "AIC", f"{u.aic:.5g}"),
        ("degrees of freedom", f"{u.degrees_of_freedom:.5g}", "BIC", f"{u.bic:.5g}"),
    )
    sentences = tuple(
        f"{rule[0].upper()}{rule[1:]} ({count} of {len(curves)} curves)." for rule, count in rules.items()
    )
    return Section("Goodness of fit, of the soft model", ("count", "number|", "statistic", "value|"), rows, sentences)


def curve_section(curves: Sequence[Curve]) -> Section:
    """How close soft and hard model, and silence, come to each target that is a curve."""
    rows = [
        (
            curve.condition,
            curve.channel,
            *(r2_cell(curve.r2(kind)) for kind in ("soft", "hard")),
            *(f"{curve.rmse(kind):.3g}" for kind in ("soft", "hard", "silence")),
            unit_cell(TARGETS[curve.channel].unit),
            f"{curve.gap:.1%}",
            curve.grade,
        )
        for curve in curves
        if not curve.is_band
    ]
    columns = ("curve", "channel", "R2 soft|", "hard|", "RMSE soft|", "hard|", "silence|", "unit", "gap|", "grade")
    title = "Curves (gap: of soft and hard, as a share of the span)"
    counts = (OF_COUNTS,) if any(curve.exposure is not None for curve in curves) else ()
    return Section(title, columns, tuple(rows), (*GRADES, *counts) if rows else ())


def band_section(curves: Sequence[Curve]) -> Section:
    """The share of the samples within each band, and within all bands that stand for the same words."""
    rows = [
        (
            curve.condition,
            curve.channel,
            f"{(curve.weight > 0).sum()}",
            *(f"{curve.inside(kind):.1%}" for kind in ("soft", "hard", "silence")),
            f"{np.abs(curve.distance()[curve.weight > 0]).max():.3g}",
            unit_cell(TARGETS[curve.channel].unit),
            f"{curve.gap:.1%}",
            curve.grade,
        )
        for curve in curves
        if curve.is_band
    ]
    columns = ("band", "channel", "samples|", "within: soft|", "hard|", "silence|", "farthest outside|")
    columns += ("unit", "gap|", "grade")
    sentences = tuple(
        f'"{tally.quote}": {tally.hard:.1%} of {tally.samples} samples within (soft {tally.soft:.1%}), none farther '
        f"outside than {tally.farthest:.3g}."
        for tally in tallies(curves)
    )
    title = "Bands (gap: of soft and hard, as a share of the span)"
    return Section(title, columns, tuple(rows), (*sentences, *BAND_GRADES) if rows else ())


def residual_section(curves: Sequence[Curve], kind: Kind) -> Section:
    """Where a model misses each target most, and over how long its residuals are correlated."""
    rows = []
    for curve in curves:
        time, values = rest = residuals_of(curve, kind)
        largest = int(np.argmax(np.abs(values)))
        lag = rest.autocorrelation[1] if len(values) > 1 else math.nan
        rows.append(
            (
                curve.condition,
                curve.channel,
                f"{values.mean():+.3g}",
                f"{values[largest]:+.3g}",
                unit_cell(TARGETS[curve.channel].unit) if curve.exposure is None else "s.e. (deviance)",
                f"{time[largest]:.0f}",
                "-" if math.isnan(lag) else f"{lag:+.2f}",
                "-" if math.isnan(lag) else f"{rest.correlation_ms:.0f}",
            )
        )
    columns = ("residuals of", "channel", "mean|", "largest|", "unit", "at ms|", "autocorrelation|")
    columns += ("correlated over ms|",)
    sentences = (
        "Autocorrelation: of neighbouring samples. Noise is correlated over the span of the recording's own smoothing; "
        "a longer correlation shows what the circuit does not follow.",
    )
    return Section(f"Residuals of the {kind} model", columns, tuple(rows), sentences)


def search_section(
    runs: Sequence[Run], best_count: int, screened: int, temperatures: Sequence[float], loss: float, soft_loss: float
) -> Section:
    """How many starts were searched and descended, and the losses that came of it."""
    return Section(
        "Search",
        sentences=(
            f"{screened} starts screened, {len(runs)} descended; the best was found {best_count} of {len(runs)} times.",
            f"{sum(run.steps for run in runs)} steps of the solver, at temperatures "
            f"{', '.join(f'{temperature:g}' for temperature in temperatures)}.",
            f"Half the sum of squares: {loss:.5g} for the model that is handed over, {soft_loss:.5g} for the "
            f"soft one at temperature {temperatures[-1]:g}.",
        ),
    )


def correlation_section(u: Uncertainty) -> Section:
    """The largest correlations."""
    pairs = [(u.names[i], u.names[j], float(u.correlation[i, j])) for i in range(len(u.names)) for j in range(i)]
    pairs = [pair for pair in pairs if abs(pair[2]) > _CORRELATED]  # NaN is not
    pairs.sort(key=lambda pair: -abs(pair[2]))
    rows = tuple((other, name, f"{value:+.3f}") for name, other, value in pairs[:_MOST])
    more = (f"{len(pairs) - _MOST} more are above {_CORRELATED:g}.",) if len(pairs) > _MOST else ()
    return Section(f"Correlations above {_CORRELATED:g}", ("of", "and", "value|"), rows, more)
