"""Fits to the same data side by side: how well each explains them, with how many free parameters."""

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from lgmd2jax._channels import Channel
from lgmd2jax._network.parameter_set import Symbol
from lgmd2jax._network.parameters import symbols
from lgmd2jax._reports.digits import measured, plain
from lgmd2jax._reports.section import Section, as_html, as_text
from lgmd2jax._targets.observation import observation_symbols
from lgmd2jax.fitting._result import Fit
from lgmd2jax.fitting._uncertainty.covariance import information_criteria

_SAME = 1e-6  # relative: what nine digits of a file keep
_UNKNOWN = "-"


class Estimate(NamedTuple):
    """A parameter of one fit: its value and standard error, 0 where it was fixed, infinite where it is undetermined."""

    value: float
    standard_error: float

    def __str__(self):
        if self.standard_error == 0:
            return f"[{plain(self.value)}]"
        return measured(*self) + ("" if math.isfinite(self.standard_error) else " ?")


class Held(NamedTuple):
    """How many response properties a model holds, of those that it was judged by."""

    passed: int
    judged: int

    def __str__(self):
        return f"{self.passed} of {self.judged}"


@dataclasses.dataclass(frozen=True)
class Comparison:
    """Fits to the same stimuli and targets, side by side. All is that of the hard models, which are handed over.

    - `names`: of the fits. `curves`: the condition and the channel of each target.
    - `free`: how many parameters each fit has free. `samples`: how many independent ones the targets hold.
    - `chi2`: of each curve, in standard errors, of independent samples. `r2`: NaN for a target that does not vary.
    - `chi2_of_means`: of each curve, were the model the target's own mean; NaN for a band.
    - `aic`, `bic`: as in lmfit; NaN unless all targets are recordings whose correlation in time is known, for the
      reason in `without_criteria`.
    - `parameters`: by name the estimate of each fit, None where it acts on nothing; all that are free in any.
    - `units`: of these parameters, "" for a plain number.
    - `is_counts`: whether the targets are counts of spikes, whose chi2 is the deviance, and AIC and BIC -2 ln L + 2 p
      and + p log(n).
    - `alike`: pairs of fits that give the same answers to all stimuli, by name.
    - `left_out`: by condition R2 of each fit, predicted by a fit to others; NaN where that was not asked for.
    - `properties`: of the 22, where that was asked for.
    """

    names: tuple[str, ...]
    curves: tuple[tuple[str, Channel], ...]
    free: Int[np.ndarray, " fit"]
    samples: float
    chi2: Float[np.ndarray, "fit curve"]
    r2: Float[np.ndarray, "fit curve"]
    chi2_of_means: Float[np.ndarray, " curve"]
    aic: Float[np.ndarray, " fit"]
    bic: Float[np.ndarray, " fit"]
    without_criteria: str
    parameters: Mapping[str, tuple[Estimate | None, ...]]
    units: Mapping[str, str]
    left_out: Mapping[str, Float[np.ndarray, " fit"]]
    is_counts: bool = False
    alike: tuple[tuple[str, str], ...] = ()
    properties: tuple[Held, ...] | None = None

    @property
    def chi2_in_all(self) -> Float[np.ndarray, " fit"]:
        """Chi2 of each fit, all curves together."""
        return self.chi2.sum(axis=1)

    @property
    def r2_in_all(self) -> Float[np.ndarray, " fit"]:
        """1 - chi2/(chi2 of each target's own mean): targets of any unit, weighed by their errors; bands left out."""
        explains = np.isfinite(self.chi2_of_means)
        with np.errstate(invalid="ignore"):
            return 1 - self.chi2[:, explains].sum(axis=1) / self.chi2_of_means[explains].sum()

    @property
    def left_out_in_mean(self) -> Float[np.ndarray, " fit"]:
        """R2 of the conditions that were left out, each weighed by what there is to explain in its first target.

        NaN for a fit that lacks one of those which another fit has, as one that was stopped.
        """
        first: dict[str, float] = {}
        for (condition, _), chi2 in zip(self.curves, self.chi2_of_means, strict=True):
            first.setdefault(condition, float(chi2))
        counted = {name: r2 for name, r2 in self.left_out.items() if np.isfinite(r2).any()}
        if not counted:
            return np.full(len(self.names), np.nan)
        return np.average(list(counted.values()), axis=0, weights=[first[name] for name in counted])

    def sections(self) -> list[Section]:
        """The report's sections that have a content."""
        numbers = tuple(f"{name}|" for name in self.names)
        in_all = [
            ("free parameters", *map(str, self.free)),
            ("chi2", *map(_number, self.chi2_in_all)),
            ("R2", *map(_share, self.r2_in_all)),
            ("R2 of what was left out, in the mean", *map(_share, self.left_out_in_mean)),
            ("AIC", *map(_number, self.aic)),
            ("BIC", *map(_number, self.bic)),
        ]
        if self.properties is not None:
            in_all.append(("response properties", *map(str, self.properties)))
        asked = [row for row in in_all if set(row[1:]) != {_UNKNOWN}]
        names = [(condition, channel) for condition, channel in self.curves]
        sections = (
            Section("Fits side by side, of the hard models", ("in all", *numbers), tuple(asked), self._sentences()),
            Section(
                "chi2 of each curve",
                ("curve", "channel", *numbers),
                tuple((*name, *map(_number, row)) for name, row in zip(names, self.chi2.T, strict=True)),
            ),
            Section(
                "R2 of each curve",
                ("curve", "channel", *numbers),
                tuple((*name, *map(_share, row)) for name, row in zip(names, self.r2.T, strict=True)),
            ),
            Section(
                "R2 of each condition, predicted by a fit to others",
                ("left out", *numbers),
                tuple((name, *map(_share, row)) for name, row in self.left_out.items()),
            ),
            Section(
                "Parameters that are free in any",
                ("parameter", "unit", *numbers),
                tuple(
                    (name, self.units[name], *(_UNKNOWN if each is None else str(each) for each in row))
                    for name, row in self.parameters.items()
                ),
                (f"[]: fixed. ?: undetermined by the curves. {_UNKNOWN}: acts on nothing.",),
            ),
        )
        return [section for section in sections if section.rows]

    def _sentences(self) -> tuple[str, ...]:
        counted = f"Chi2 counts {self.samples:.4g} independent samples"
        remarks = tuple(
            f"The chi2 of {name} is not known, since results of version 0.1 lack the errors of targets; fit again."
            for name, chi2 in zip(self.names, self.chi2_in_all, strict=True)
            if np.isnan(chi2)
        )
        remarks += tuple(
            f"{one} and {other} give the same answers to all of these stimuli, so that no such data tell them apart."
            for one, other in self.alike
        )
        if self.without_criteria:
            return (f"{counted}. No AIC and BIC: {self.without_criteria}.", *remarks)
        if self.is_counts:
            criteria = "AIC and BIC are -2 ln L + 2 p and + p log(n), with p free parameters, of the Poisson process"
            return (f"{counted}, bins of spikes; it is the deviance. {criteria}.", *remarks)
        return (
            f"{counted}: residuals are thinned to one for each span within which the recordings' values are "
            "correlated. AIC and BIC are n log(chi2/n) + 2 p and + p log(n), with p free parameters, so that the scale "
            "of the errors is free.",
            *remarks,
        )

    def summary(self) -> str:
        """The report as text."""
        return as_text(self.sections())

    def __repr__(self):
        return self.summary()

    def _repr_html_(self) -> str:
        return as_html(self.sections())


def compared(fits: Mapping[str, Fit], left_out: Mapping[str, Mapping[str, float]]) -> Comparison:
    """The comparison of fits by name.

    **Arguments:** `left_out`: by fit, R2 of each condition that was left out.

    **Raises:** `ValueError` for fewer than two fits, and for fits to different data.
    """
    if len(fits) < 2:
        raise ValueError(f"fits holds {len(fits)}; give two or more to compare")
    (first_name, first), *others = fits.items()
    for name, fit in others:
        if difference := difference_of_data(first_name, first, name, fit):
            raise ValueError(f"{first_name} and {name} are fits to different data: {difference}")
    chi2 = np.array([[curve.chi2() for curve in fit.curves] for fit in fits.values()])
    free, samples = np.array([len(fit.free) for fit in fits.values()]), first.uncertainty.n_effective
    reason, is_counts = _without_criteria(first), all(curve.exposure is not None for curve in first.curves)
    likelihoods = chi2.sum(axis=1)
    if is_counts:
        likelihoods = [sum(curve.minus_two_log_likelihood() for curve in fit.curves) for fit in fits.values()]
    criteria = [
        (math.nan, math.nan)
        if reason
        else information_criteria(float(each), samples, int(count), known_errors=is_counts)
        for each, count in zip(likelihoods, free, strict=True)
    ]
    conditions = dict.fromkeys(curve.condition for curve in first.curves)
    known = [name for name in conditions if any(name in left_out.get(fit, {}) for fit in fits)]
    is_free = {name for fit in fits.values() for name in fit.free.names}
    free_symbols = {name: symbol for name, symbol in _symbols(fits.values()).items() if name in is_free}
    return Comparison(
        names=tuple(fits),
        curves=tuple((curve.condition, curve.channel) for curve in first.curves),
        free=free,
        samples=samples,
        chi2=chi2,
        r2=np.array([[curve.r2() for curve in fit.curves] for fit in fits.values()]),
        chi2_of_means=np.array([curve.chi2_of_mean for curve in first.curves]),
        aic=np.array([aic for aic, _ in criteria]),
        bic=np.array([bic for _, bic in criteria]),
        without_criteria=reason,
        is_counts=is_counts,
        parameters={name: tuple(_estimate(fit, name) for fit in fits.values()) for name in free_symbols},
        units={name: "" if symbol.unit == "1" else symbol.unit for name, symbol in free_symbols.items()},
        alike=tuple(
            (one, other)
            for (one, mine), (other, theirs) in itertools.combinations(fits.items(), 2)
            if all(_same(a.hard, b.hard) for a, b in zip(mine.curves, theirs.curves, strict=True))
        ),
        left_out={name: np.array([left_out.get(fit, {}).get(name, np.nan) for fit in fits]) for name in known},
    )


def _symbols(fits: Iterable[Fit]) -> dict[str, Symbol]:
    """What is known of parameters, as they are declared: of the LGMD2, the observation, the fits' other networks."""
    known: dict[str, Symbol] = {}
    for symbols_of in (symbols(), observation_symbols(), *(symbols(type(fit.parameters)) for fit in fits)):
        known |= {name: symbol for name, symbol in symbols_of.items() if name not in known}
    return known


def _estimate(fit: Fit, name: str) -> Estimate | None:
    """None where a parameter acts on nothing."""
    if name in fit.free.names:
        i = fit.free.names.index(name)
        error = float(fit.uncertainty.standard_errors[i])
        return Estimate(fit.values[name], error if fit.uncertainty.determined[i] else math.inf)
    owner = fit.observation if name in observation_symbols() else fit.parameters
    if name in fit.model.unused or not hasattr(owner, name):
        return None
    return Estimate(float(getattr(owner, name)), 0.0)


def _without_criteria(fit: Fit) -> str:
    """Why AIC and BIC would mean nothing, or nothing.

    Built curves have no noise, whose likelihood they would count; neighbouring values of a recording are alike, so that
    each by itself is no sample.
    """
    counts = [curve.exposure is not None for curve in fit.curves]
    if all(counts):
        return ""
    if any(counts):
        return "counts of spikes stand beside averages, whose likelihoods do not add up"
    if not all(np.isfinite(curve.sem).any() for curve in fit.curves):
        return "they are of recordings, and here a target has no standard error that was recorded"
    if fit.uncertainty.n_effective >= sum(int((curve.weight > 0).sum()) for curve in fit.curves):
        return "neighbouring values are correlated, and no correlation_ms says over which span"
    return ""


def difference_of_data(first_name: str, first: Fit, name: str, fit: Fit) -> str:
    """In what the data of two fits differ, or nothing."""
    keys = [[(curve.condition, curve.channel) for curve in each.curves] for each in (first, fit)]
    for one, (mine, theirs) in zip((first_name, name), (keys, keys[::-1]), strict=True):
        alone = [key for key in mine if key not in theirs]
        if alone:
            return f"{alone[0][0]!r}, {alone[0][1]}, is a target of {one} alone"
    if keys[0] != keys[1]:
        return "their targets are in another order"
    for mine, theirs in zip(first.curves, fit.curves, strict=True):
        if (mine.exposure is None) != (theirs.exposure is None):
            return f"{mine.condition!r} is fitted as counts of spikes by one alone"
        for field in ("time", "target", "high", "weight", "error"):
            pair = getattr(mine, field), getattr(theirs, field)
            unknown = field == "error" and any(np.isnan(values).all() for values in pair)
            if not unknown and not _same(*pair):
                return f"{field} of {mine.condition!r}, {mine.channel}, is another"
    digests = [each.stats.get("stimuli", {}) for each in (first, fit)]  # an earlier version wrote none
    for condition, digest in digests[0].items():
        if digests[1].get(condition, digest) != digest:
            return f"the stimulus of {condition!r} is another"
    return ""


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    if one.shape != other.shape:
        return False
    scale = np.abs(one[np.isfinite(one)]).max(initial=1e-12)
    return bool(np.allclose(one, other, rtol=_SAME, atol=_SAME * scale, equal_nan=True))


def _number(value: float) -> str:
    return _UNKNOWN if math.isnan(value) else f"{value:.4g}"


def _share(value: float) -> str:
    return _UNKNOWN if math.isnan(value) else f"{value:.3f}"
