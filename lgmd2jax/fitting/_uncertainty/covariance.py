"""How well a fit determines its parameters: covariance, intervals, stiff and sloppy directions."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
import scipy
from jaxtyping import Bool, Float, Int

CONFIDENCE = 0.95  # of intervals
# Variance of a value of which only its bounds are known, in the unit box.
BOX_VARIANCE = 1 / 12
# Of the box, within which a value counts as on its bound.
_ON_BOUND = 1e-6
# Smallest singular value of the Jacobian, its columns scaled to norm 1, that counts as a direction of its own.
_RANK = 1e-10
# Of the box: a direction with a larger standard error is called loose. At most so many are named.
_LOOSE, _MOST = 0.1, 3
# Share of a direction's largest component below which a component is left out of its words.
_TELLING = 0.3


@dataclasses.dataclass(frozen=True)
class Uncertainty:
    """What the curves tell of the free parameters at the best fit, by linearisation.

    - `names`, `values`: of the free parameters, in their own units. `slopes`: their derivatives in the unit box.
    - `standard_errors`: infinite without influence. `intervals`: of 95 %, symmetric in the unit box and cut at its
      walls; of counts of spikes those of the profile likelihood, since their information changes within an interval.
    - `covariance`, `correlation`: a parameter on a bound is held when the others' errors are computed, and has no
      correlation with them here; its own error is that of all parameters together.
    - `determined`: False for a parameter without influence, for one that others can replace, and for one whose
      interval is the whole range. `on_bound`: -1 at the lower bound, 1 at the upper one, else 0.
    - `information`: J^T J / variance, with J the slopes of the residuals in the unit box; `gradient` that of chi2 /
      variance, 0 at an optimum within the box; `covariance_z` the covariance there.
    - `spectrum`, `directions`: eigenvalues of the information, falling, and eigenvectors in columns: stiff to sloppy;
      1 / sqrt(eigenvalue) is the standard error along a direction.
    - `variance`: of a residual; 1 where the errors are `absolute`, else the reduced chi2.
    - `n_effective`: independent samples, `degrees_of_freedom` those that are left. `chi2`, `reduced_chi2`, `aic`,
      `bic`: of independent samples (definitions as in lmfit).
    - `reason`: empty, or why there are no errors.

    Of a band, a sample within says that the response lies there and no more. It adds nothing to chi2 and to the
    information, and leaves no degree of freedom, so that samples within do not make the residual variance of those
    outside look small. `n_effective` counts it, since BIC asks how much was asked of the model. With bands -2 ln L is
    chi2 by the errors that were given (a density flat within the band, with Gaussian flanks), and AIC and BIC are chi2
    and their penalties; lmfit's n ln(chi2/n) would ask for the variance of samples of which most have none.

    Of counts of spikes chi2 is Pearson's, and -2 ln L in AIC and BIC that of the Poisson process.
    """

    names: tuple[str, ...]
    values: Float[np.ndarray, " free"]
    slopes: Float[np.ndarray, " free"]
    standard_errors: Float[np.ndarray, " free"]
    intervals: Float[np.ndarray, "free 2"]
    covariance: Float[np.ndarray, "free free"]
    correlation: Float[np.ndarray, "free free"]
    determined: Bool[np.ndarray, " free"]
    on_bound: Int[np.ndarray, " free"]
    information: Float[np.ndarray, "free free"]
    gradient: Float[np.ndarray, " free"]
    covariance_z: Float[np.ndarray, "free free"]
    spectrum: Float[np.ndarray, " free"]
    directions: Float[np.ndarray, "free free"]
    absolute: bool
    variance: float
    n_effective: float
    degrees_of_freedom: float
    chi2: float
    reduced_chi2: float
    aic: float
    bic: float
    reason: str


def linearised_uncertainty(
    names: tuple[str, ...],
    z: Float[np.ndarray, " free"],
    value: Callable[[Float[np.ndarray, " free"]], Float[np.ndarray, " free"]],
    slopes: Float[np.ndarray, " free"],
    jacobian: Float[np.ndarray, "n free"],
    residuals: Float[np.ndarray, " n"],
    *,
    n_effective: float | int,
    absolute: bool,
    priors: int = 0,
    inside: float | None = None,
    minus_two_log_likelihood: float | None = None,
) -> Uncertainty:
    """Covariance by Gauss and Newton: variance (J^T J)^-1.

    **Arguments:**

    - `z`: the point in the unit box; `value` maps such points to the parameters' own units, `slopes` is its derivative.
    - `jacobian`, `residuals`: in standard errors, the slopes by z; rows without weight left out. The last `priors`
      rows are penalties: each saves a degree of freedom, and keeps its own width whatever the residual variance.
    - `n_effective`: how many independent samples the rows make; correlated ones are fractions, weighed as such.
    - `absolute`: errors are known; otherwise the residual variance is their scale.
    - `inside`: how many of the independent samples lie within a band; None where no target is one.
    - `minus_two_log_likelihood`: where targets are counts, for AIC and BIC; else chi2 stands for it.
    """
    count, data = len(names), len(residuals) - priors
    chi2 = float(np.square(residuals[:data]).sum())
    degrees = n_effective - (inside or 0) - max(count - priors, 0)
    reduced = chi2 / degrees if degrees > 0 else np.nan
    variance = 1.0 if absolute else reduced
    if minus_two_log_likelihood is None:
        aic, bic = information_criteria(chi2, n_effective, count, known_errors=inside is not None)
    else:
        aic, bic = information_criteria(minus_two_log_likelihood, n_effective, count, known_errors=True)

    on_bound = np.where(z <= _ON_BOUND, -1, np.where(z >= 1 - _ON_BOUND, 1, 0))
    reason = _reason(jacobian, residuals, variance)
    if reason:
        information, gradient = np.full((count, count), np.nan), np.full(count, np.nan)
        covariance_z, spectrum, directions = np.diag(np.full(count, np.inf)), information[0], information
    else:
        scale = variance or 1.0
        weights = np.append(np.full(data, 1 / np.sqrt(scale)), np.ones(priors))
        rows = weights[:, None] * jacobian
        information, gradient = rows.T @ rows, 2 * rows.T @ (weights * residuals)
        spectrum, directions = _spectrum(rows)
        covariance_z = _covariance(rows, on_bound != 0) * (variance / scale)
        covariance_z[np.isnan(np.diag(covariance_z)), np.isnan(np.diag(covariance_z))] = np.inf
    errors_z = np.sqrt(np.diag(covariance_z))
    if not reason and np.isinf(errors_z).all():
        reason = "no parameter is determined by these curves"

    law = scipy.stats.norm if absolute else scipy.stats.t(max(degrees, np.finfo(float).tiny))
    reach = law.ppf(0.5 + CONFIDENCE / 2) * errors_z
    ends = [np.clip(z + sign * reach, 0, 1) for sign in (-1, 1)]
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance_z / np.outer(errors_z, errors_z)
    np.fill_diagonal(correlation, 1)
    return Uncertainty(
        names=names,
        values=value(z),
        slopes=slopes,
        standard_errors=errors_z * slopes,
        intervals=np.stack([value(end) for end in ends], axis=1),
        covariance=covariance_z * np.outer(slopes, slopes),
        correlation=correlation,
        determined=np.isfinite(errors_z) & (ends[1] - ends[0] < 1),
        on_bound=on_bound,
        information=information,
        gradient=gradient,
        covariance_z=covariance_z,
        spectrum=spectrum,
        directions=directions,
        absolute=absolute,
        variance=float(variance),
        n_effective=float(n_effective),
        degrees_of_freedom=float(degrees),
        chi2=chi2,
        reduced_chi2=float(reduced),
        aic=aic,
        bic=bic,
        reason=reason,
    )


def information_criteria(
    chi2: float, samples: float | int, free: int, *, known_errors: bool = False
) -> tuple[float, float]:
    """AIC and BIC of a fit with so many free parameters (as in lmfit).

    **Arguments:** `chi2` and `samples` of independent samples. `known_errors`: their scale is not free, so that `chi2`
    counts as -2 ln L.
    """
    if not samples:
        return np.nan, np.nan
    likelihood = chi2 if known_errors else samples * np.log(max(chi2 / samples, 1e-250))
    return float(likelihood + 2 * free), float(likelihood + free * np.log(samples))


def prediction_band(u: Uncertainty, slopes: Float[np.ndarray, "time free"]) -> Float[np.ndarray, " time"]:
    """The standard error of a curve from that of the parameters; `slopes` are the curve's in the unit box.

    Along a direction that the fit left open the error is that of a value that may lie anywhere between its bounds.
    NaN where there are no errors.
    """
    return np.sqrt(np.square(slopes @ u.directions) @ variance_along(u))


def variance_along(u: Uncertainty) -> Float[np.ndarray, " free"]:
    """The variance along each of the `directions`, at most that of a value that may lie anywhere in the box."""
    return np.minimum(np.square(_reaches(u.spectrum)), BOX_VARIANCE)


def sentences(u: Uncertainty) -> list[str]:
    """The spectrum in words: parameters without influence, loose directions, the stiffest one.

    Along a direction the curves change by less than their errors as long as chi2 rises by less than 1.
    """
    if u.reason:
        return []
    silent = np.diag(u.information) == 0
    said = [
        f"{name} has no influence on these curves: any value between its bounds fits as well."
        for name, without in zip(u.names, silent, strict=True)
        if without
    ]
    moving = np.flatnonzero(~silent & (u.on_bound == 0))
    if not moving.size:
        return said
    spectrum, directions = np.linalg.eigh(u.information[np.ix_(moving, moving)])
    reaches = _reaches(spectrum)
    for reach, direction in list(zip(reaches, directions.T, strict=True))[:_MOST]:
        if reach >= _LOOSE:
            names, change, _ = _change(u, moving, direction, min(reach, 1.0), most=0.1)
            verdict = "trade off" if len(names) > 1 else "is loose"
            said.append(f"{_listed(names)} {verdict}: {change} changes the curves by less than their errors.")
    names, change, step = _change(u, moving, directions[:, -1], 1.0, most=0.01)
    times = f"{step / reaches[-1]:.2g} times their errors"
    return [*said, f"The curves are most sensitive to {_listed(names)}: {change} changes them by {times}."]


def _reason(jacobian: np.ndarray, residuals: np.ndarray, variance: float) -> str:
    if not (np.isfinite(jacobian).all() and np.isfinite(residuals).all()):
        return "the curves or their slopes are not finite at the best fit"
    return "" if np.isfinite(variance) else "there are no more independent samples than free parameters"


def _spectrum(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues, falling, and eigenvectors of rows^T rows, without squaring the condition."""
    count = rows.shape[1]
    _, singular, across = np.linalg.svd(np.vstack([rows, np.zeros((count, count))]), full_matrices=False)
    return singular**2, across.T


def _covariance(rows: np.ndarray, held: np.ndarray) -> np.ndarray:
    """(rows^T rows)^-1 of those that are not held, with these fixed; that of the held ones is their own alone."""
    covariance = np.diag(np.diag(_inverse(rows)))
    covariance[np.ix_(~held, ~held)] = _inverse(rows[:, ~held])
    return covariance


def _inverse(rows: np.ndarray) -> np.ndarray:
    """(rows^T rows)^-1, columns of any scale; NaN for those that a direction without influence runs through."""
    norms = np.linalg.norm(rows, axis=0)
    norms = np.where(norms > 0, norms, 1)
    spectrum, directions = _spectrum(rows / norms)
    known = np.sqrt(spectrum) > _RANK
    inverse = (directions[:, known] / spectrum[known]) @ directions[:, known].T / np.outer(norms, norms)
    lost = np.linalg.norm(directions[:, ~known], axis=1) > np.sqrt(_RANK)
    inverse[lost] = inverse[:, lost] = np.nan
    return inverse


def _reaches(spectrum: np.ndarray) -> np.ndarray:
    """The standard error along each direction."""
    positive = np.where(spectrum <= 0, 1, spectrum)
    return np.where(spectrum <= 0, np.inf, 1 / np.sqrt(positive))


def _change(u: Uncertainty, moving, direction, step: float, most: float) -> tuple[list[str], str, float]:
    """A step along a direction in words, so short that no parameter changes by more than the fraction `most`."""
    largest = np.argmax(np.abs(direction))
    direction = direction / direction[largest]
    shares = {}
    for i in np.argsort(-np.abs(direction)):
        if abs(direction[i]) >= _TELLING:
            value, slope = abs(u.values[moving[i]]), u.slopes[moving[i]]
            by_range = value < 0.1 * slope  # near zero a percentage of the value says nothing
            share = direction[i] if by_range else direction[i] * slope / value
            shares[u.names[moving[i]]] = share, " of its range" if by_range else ""
    length = float(np.linalg.norm(direction))
    step = min(step / length, most / max(float(abs(share)) for share, _ in shares.values()))
    parts = [
        f"{'raising' if share > 0 else 'lowering'} {name} by {100 * abs(share) * step:.2g} %{unit}"
        for name, (share, unit) in shares.items()
    ]
    return list(shares), _listed(parts), step * length


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
