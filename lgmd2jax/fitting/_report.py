"""What a fit says of itself, as text and as HTML, in the manner of lmfit and iminuit."""

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lgmd2jax._channels import TARGETS
from lgmd2jax._network.parameters import symbols
from lgmd2jax._reports.digits import measured, plain, rounded
from lgmd2jax._reports.section import Section, as_html, as_text
from lgmd2jax._targets.observation import observation_symbols
from lgmd2jax.fitting._curve import DISAGREEMENT
from lgmd2jax.fitting._descent import ENDED
from lgmd2jax.fitting._free import Freedom
from lgmd2jax.fitting._law_fit import Beside
from lgmd2jax.fitting._uncertainty.covariance import Uncertainty
from lgmd2jax.fitting._uncertainty.profile import Profile

if TYPE_CHECKING:
    from lgmd2jax.fitting._result import Fit

_CORRELATED, _MOST = 0.5, 10  # correlations from which, and how many, are told


@dataclasses.dataclass(frozen=True)
class Extra:
    """What else a report tells, where it was asked for.

    - `profiles`: the profile-likelihood interval of a parameter, by its name.
    - `left_out`: R2 of a condition, by its name, predicted by a fit to all others.
    - `beside`: the looming law fitted to the same recordings.
    - `truth`: the known values of a twin's parameters.
    """

    profiles: Mapping[str, Profile] = dataclasses.field(default_factory=dict)
    left_out: Mapping[str, float] = dataclasses.field(default_factory=dict)
    beside: Beside | None = None
    truth: Mapping[str, float] = dataclasses.field(default_factory=dict)


def text(fit: "Fit", extra: Extra | None = None) -> str:
    """The report as plain text."""
    return as_text(_sections(fit, extra or Extra()))


def html(fit: "Fit", extra: Extra | None = None) -> str:
    """The report as an HTML fragment, for a notebook or a page."""
    return as_html(_sections(fit, extra or Extra()))


def status(fit: "Fit") -> tuple[str, ...]:
    """The verdict in a few words each: valid or not, why it stopped, bounds, what is undetermined, soft against hard.

    A fit is valid whose last descent came to its end, at a finite loss at which there are standard errors.
    """
    u = fit.uncertainty
    valid = fit.result in ENDED and math.isfinite(fit.loss) and not u.reason
    bounds = [name for name, side in zip(u.names, u.on_bound, strict=True) if side]
    loose = [name for name, known in zip(u.names, u.determined, strict=True) if not known]
    apart = sum(curve.gap > DISAGREEMENT for curve in fit.curves)
    return (
        "valid" if valid else "NOT VALID",
        fit.result,
        f"at a bound: {', '.join(bounds)}" if bounds else "none at a bound",
        f"no standard errors: {u.reason}"
        if u.reason
        else f"undetermined: {', '.join(loose)}"
        if loose
        else "all determined",
        f"soft and hard differ in {apart} of {len(fit.curves)} curves" if apart else "soft and hard agree",
    )


def _sections(fit: "Fit", extra: Extra) -> list[Section]:
    sections = [
        Section(f"Fit: {' | '.join(status(fit))}"),
        _free(fit),
        _given(fit),
        _statistics(fit),
        _curves(fit),
        _search(fit),
        _correlations(fit),
        _profiles(fit, extra),
        _left_out(extra),
        _beside(fit, extra),
        _truth(fit, extra),
        Section("Remarks", sentences=tuple(fit.remarks())),
    ]
    return sections[:1] + [section for section in sections[1:] if section.rows or section.sentences]


def _free(fit: "Fit") -> Section:
    u, rows = fit.uncertainty, []
    for i, it in enumerate(fit.free.freedoms):
        value, error = fit.values[it.name], float(u.standard_errors[i])
        shown = measured(value, error) if u.determined[i] and not u.reason else plain(value)
        rows.append(
            (
                it.name,
                shown,
                _interval(u, i),
                _unit(it.symbol.unit),
                plain(fit.start[it.name]),
                _bounds(it),
                _flag(fit, i),
            )
        )
    columns = ("free", "value +- s.e.|", f"{u.confidence:.0%} interval|", "unit", "start|", "bounds|", "remark")
    return Section("Free parameters", columns, tuple(rows))


def _bounds(it: Freedom) -> str:
    return f"{it.low:g} .. {it.high:g}"


def _flag(fit: "Fit", i: int) -> str:
    side, prior = fit.uncertainty.on_bound[i], fit.free.freedoms[i].prior
    flags = [f"at {'lower' if side < 0 else 'upper'} bound"] if side else []
    flags += [f"prior {prior[0]:g} +- {prior[1]:g}"] if prior else []
    return ", ".join(flags + (["rough: curves bend"] if fit.free.names[i] in fit.curved else []))


def _interval(u: Uncertainty, i: int) -> str:
    if u.reason:
        return "unknown"
    if not u.determined[i]:
        return "undetermined"
    return " .. ".join(rounded(float(end), float(u.values[i]), float(u.standard_errors[i])) for end in u.intervals[i])


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _given(fit: "Fit") -> Section:
    """What follows a free parameter, and the observation where it stays fixed."""
    rows, known = [], symbols(type(fit.parameters))
    for name, tie in fit.free.ties.items():
        owner, symbol = (
            (fit.parameters, known[name]) if name in known else (fit.observation, observation_symbols()[name])
        )
        follows = tie.to if tie.factor == 1 else f"{tie.factor:g} {tie.to}"
        rows.append((name, plain(float(getattr(owner, name))), _unit(symbol.unit), f"tied: {name} = {follows}"))
    if "rate" in fit.channels:
        rows += [
            (name, plain(float(getattr(fit.observation, name))), _unit(symbol.unit), "fixed")
            for name, symbol in observation_symbols().items()
            if name not in fit.free.names and name not in fit.free.ties
        ]
    return Section("Tied parameters and fixed observation", ("given", "value|", "unit", "how"), tuple(rows))


def _statistics(fit: "Fit") -> Section:
    u, data = fit.uncertainty, sum(int((curve.weight > 0).sum()) for curve in fit.curves)
    rows = (
        ("data points", f"{data}", "chi2", f"{u.chi2:.5g}"),
        ("independent samples", f"{u.n_effective:.5g}", "reduced chi2", f"{u.reduced_chi2:.4g}"),
        ("free parameters", f"{len(fit.free)}", "AIC", f"{u.aic:.5g}"),
        ("degrees of freedom", f"{u.degrees_of_freedom:.5g}", "BIC", f"{u.bic:.5g}"),
    )
    rules = fit.stats.get("rules", {})  # results of an earlier version have none
    curves = len(fit.curves)
    sentences = tuple(f"{rule[0].upper()}{rule[1:]} ({count} of {curves} curves)." for rule, count in rules.items())
    return Section("Goodness of fit, of the soft model", ("count", "number|", "statistic", "value|"), rows, sentences)


def _curves(fit: "Fit") -> Section:
    rows = [
        (
            curve.condition,
            curve.channel,
            *(_share(curve.r2(kind)) for kind in ("soft", "hard")),
            *(f"{curve.rmse(kind):.3g}" for kind in ("soft", "hard")),
            _unit(TARGETS[curve.channel].unit),
            f"{curve.gap:.1%}",
        )
        for curve in fit.curves
    ]
    columns = ("curve", "channel", "R2 soft|", "hard|", "RMSE soft|", "hard|", "unit", "gap|")
    return Section("Curves (gap: of soft and hard, as a share of the span)", columns, tuple(rows))


def _share(r2: float) -> str:
    """R2; a target that does not vary has none."""
    return "flat" if math.isnan(r2) else f"{r2:.3f}"


def _search(fit: "Fit") -> Section:
    runs, temperatures = len(fit.runs), ", ".join(f"{it:g}" for it in fit.temperatures)
    return Section(
        "Search",
        sentences=(
            f"{len(fit.screened)} starts screened, {runs} descended; the best was found {fit.found} of {runs} times.",
            f"{sum(run.steps for run in fit.runs)} steps of the solver, at temperatures {temperatures}.",
            f"Half the sum of squares: {fit.loss:.5g} for the model that is handed over, {fit.soft_loss:.5g} for the "
            f"soft one at temperature {fit.temperatures[-1]:g}.",
        ),
    )


def _correlations(fit: "Fit") -> Section:
    u = fit.uncertainty
    pairs = [(u.names[i], u.names[j], float(u.correlation[i, j])) for i in range(len(u.names)) for j in range(i)]
    pairs = [pair for pair in pairs if abs(pair[2]) > _CORRELATED]  # NaN is not
    pairs.sort(key=lambda pair: -abs(pair[2]))
    rows = tuple((other, name, f"{value:+.3f}") for name, other, value in pairs[:_MOST])
    more = (f"{len(pairs) - _MOST} more are above {_CORRELATED:g}.",) if len(pairs) > _MOST else ()
    return Section(f"Correlations above {_CORRELATED:g}", ("of", "and", "value|"), rows, more)


def _profiles(fit: "Fit", extra: Extra) -> Section:
    u, rows = fit.uncertainty, []
    for name, profile in extra.profiles.items():
        i = fit.free.names.index(name)
        value, error = fit.values[name], float(u.standard_errors[i])
        low, high = (
            "open" if is_open else rounded(end, value, error)
            for end, is_open in zip(profile.interval, profile.is_open, strict=True)
        )
        rows.append((name, f"{low} .. {high}", _interval(u, i), _unit(fit.free.freedoms[i].symbol.unit)))
    columns = ("parameter", "by profile|", f"by covariance, {u.confidence:.0%}|", "unit")
    is_open = any(end for profile in extra.profiles.values() for end in profile.is_open)
    sentences = ("Open: up to the bound, chi2 does not rise so far.",) if is_open else ()
    return Section("Profile-likelihood intervals", columns, tuple(rows), sentences)


def _left_out(extra: Extra) -> Section:
    rows = tuple((name, _share(r2)) for name, r2 in extra.left_out.items())
    return Section("Each condition predicted by a fit to all others", ("left out", "R2|"), rows)


def _beside(fit: "Fit", extra: Extra) -> Section:
    """The network beside eta, which has five free numbers and knows the angle of the object."""
    title = "Beside the looming law, seen through the same observation"
    if not (it := extra.beside):
        return Section(title)
    hard = {curve.condition: curve.r2() for curve in fit.curves if curve.channel == "rate"}
    rows = tuple(
        (
            name,
            *(_share(r2) for r2 in (hard[name], it.r2[name], extra.left_out.get(name, math.nan), it.left_out[name])),
            *(f"{time:+.1f}" for time in peaks),
        )
        for name, peaks in it.peaks.items()
    )
    columns = ("approach", "R2 network|", "law|", "left out: network|", "law|")
    columns += ("peak in ms: recorded|", "network|", "law|")
    seen, law = it.law.observation, it.law
    means = [float(np.mean(list(r2.values()))) for r2 in (extra.left_out, it.left_out) if r2]
    return Section(
        title,
        columns,
        rows,
        (
            *(
                f"Peaks, {name}: {line.alpha:.2f} l/|v| - {line.delta:.1f} ms before collision, r2 {line.r2:.3f}."
                for name, line in it.lines.items()
            ),
            f"Left out, in the mean: {' and '.join(_share(mean) for mean in means)}"
            + (" (network, law)." if len(means) > 1 else " (law)."),
            f"The law: alpha {law.alpha:.2f}, gain (l/|v|)^{law.exponent:.2f} and {float(seen.gain):.0f} spikes/s at "
            f"40 ms, baseline {float(seen.baseline):.1f} spikes/s, latency with delta {float(seen.latency):.0f} ms.",
        ),
    )


def _truth(fit: "Fit", extra: Extra) -> Section:
    rows = []
    for name, truth in extra.truth.items():
        it, value = fit.free.freedoms[fit.free.names.index(name)], fit.values[name]
        error = float(fit.uncertainty.standard_errors[fit.free.names.index(name)])
        off = value - truth
        in_errors = f"{off / error:+.2f}" if math.isfinite(error) and error > 0 else "-"
        rows.append((name, f"{truth:.6g}", f"{value:.6g}", f"{off / (it.high - it.low):+.3%}", in_errors))
    columns = ("parameter", "truth|", "fitted|", "off, of its range|", "off, in s.e.|")
    return Section("Known truth", columns, tuple(rows))
