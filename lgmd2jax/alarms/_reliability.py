"""Whether probabilities come true: a reliability diagram in numbers, and the Brier score."""

import dataclasses

import numpy as np
import scipy
from jaxtyping import Bool, Float, Int

from lgmd2jax._arguments.checked import checked
from lgmd2jax.alarms._counts import Share

_BINS = 10
_ROWS = 16  # of a table of calibration
_RESAMPLES = 400
_LARGEST_LOGIT = 30.0  # beyond it a probability is 0 or 1 in print
_RIDGE = 1e-6  # keeps the weights finite where the outcomes can be told apart without error


@dataclasses.dataclass(frozen=True)
class Reliability:
    """The predicted probability of contact against what happened, over the frames of clips, with 95 % intervals.

    Frames of a clip go together, so that the intervals are those over clips: of `observed` and `brier` by resampling
    clips, of `slope` and `intercept` by the sandwich estimate of the covariance, clustered by clip.

    - `predicted`: the mean probability in each bin of a tenth; `observed`: how often contact followed; `frames`: how
      many there are in it. Empty bins are left out.
    - `brier`: the mean squared error of the probability; `brier_of_the_mean`: of one that never changes.
    - `slope`, `intercept`: of the true log-odds on the predicted ones; 1 and 0 where they are calibrated.
    """

    predicted: Float[np.ndarray, " bin"]
    observed: tuple[Share, ...]
    frames: Int[np.ndarray, " bin"]
    brier: Share
    brier_of_the_mean: float
    slope: Share
    intercept: Share

    @classmethod
    @checked
    def of(
        cls,
        probability: Float[np.ndarray, " frame"],
        happens: Bool[np.ndarray, " frame"],
        clip: Int[np.ndarray, " frame"],
    ) -> "Reliability":
        """The reliability of a probability for each frame, by whether contact followed, and the number of its clip."""
        _, group = np.unique(clip, return_inverse=True)
        bins = np.minimum((probability * _BINS).astype(int), _BINS - 1)
        square = (probability - happens) ** 2

        def total(values):
            """By clip and bin."""
            sums = np.zeros((group.max() + 1, _BINS))
            np.add.at(sums, (group, bins), values)
            return sums

        count, hits, predicted, squares = map(total, (1.0, happens, probability, square))
        drawn = np.random.default_rng(0).integers(0, len(count), (_RESAMPLES, len(count)))
        weights = np.stack([np.bincount(row, minlength=len(count)) for row in drawn]).astype(float)
        present = count.sum(axis=0) > 0
        with np.errstate(invalid="ignore"):  # a resample may leave a bin empty
            shares = (weights @ hits / (weights @ count))[:, present]
        brier = weights @ squares.sum(axis=1) / (weights @ count.sum(axis=1))
        frames = count.sum(axis=0)[present]
        low, high = np.nanpercentile(shares, [2.5, 97.5], axis=0)
        observed = hits.sum(axis=0)[present] / frames
        intercept, slope = _recalibration(probability, happens, group)
        return cls(
            predicted=predicted.sum(axis=0)[present] / frames,
            observed=tuple(map(Share, observed.tolist(), low.tolist(), high.tolist())),
            frames=frames.astype(int),
            brier=Share(float(square.mean()), *map(float, np.percentile(brier, [2.5, 97.5]))),
            brier_of_the_mean=float(np.mean(happens) * (1 - np.mean(happens))),
            slope=slope,
            intercept=intercept,
        )


def logistic_fit(x: Float[np.ndarray, "row column"], happens: Bool[np.ndarray, " row"]) -> list[float]:
    """The intercept and the weights of a logistic regression, of the most likelihood."""
    mean, spread = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-12)
    design = np.column_stack([np.ones(len(x)), (x - mean) / spread])

    def loss(weights):
        z = design @ weights
        value = np.mean(np.logaddexp(0, z) - happens * z) + _RIDGE * weights[1:] @ weights[1:] / 2
        return value, design.T @ (scipy.special.expit(z) - happens) / len(z) + _RIDGE * np.append(0, weights[1:])

    def curvature(weights):
        p = scipy.special.expit(design @ weights)
        return (design.T * (p * (1 - p))) @ design / len(p) + _RIDGE * np.eye(len(weights))

    start = np.zeros(design.shape[1])
    found = scipy.optimize.minimize(loss, start, jac=True, hess=curvature, method="trust-exact").x
    weights = found[1:] / spread
    return [float(found[0] - weights @ mean), *map(float, weights)]


def calibration_table(
    predicted: Float[np.ndarray, " frame"], happens: Bool[np.ndarray, " frame"]
) -> tuple[Float[np.ndarray, " row"], Float[np.ndarray, " row"]]:
    """Predicted probability and observed frequency, by isotonic regression: a table whose columns rise.

    Each row stands for frames with the same number of predicted contacts, so that rows of high probability, which have
    few frames, are known as well as the others.
    """
    order = np.argsort(predicted)
    predicted, happens = predicted[order], happens[order]
    mass = np.cumsum(predicted)
    row = np.minimum((mass / mass[-1] * _ROWS).astype(int), _ROWS - 1)
    frames, mass, contacts = (np.bincount(row, weights, _ROWS) for weights in (None, predicted, happens))
    known = frames > 0
    share = contacts[known] / frames[known]
    return mass[known] / frames[known], scipy.optimize.isotonic_regression(share, weights=frames[known]).x


def _recalibration(probability, happens, group) -> tuple[Share, Share]:
    """Intercept and slope of the true log-odds on the predicted ones, with intervals by the sandwich over clips."""
    z = np.clip(scipy.special.logit(probability), -_LARGEST_LOGIT, _LARGEST_LOGIT)
    weights = np.array(logistic_fit(z[:, None], happens))
    design = np.column_stack([np.ones(len(z)), z])
    p = scipy.special.expit(design @ weights)
    scores = np.zeros((group.max() + 1, 2))
    np.add.at(scores, group, design * (happens - p)[:, None])
    bread = np.linalg.pinv((design.T * (p * (1 - p))) @ design)
    half = 1.96 * np.sqrt(np.diag(bread @ (scores.T @ scores) @ bread))
    intercept, slope = (Share(float(w), float(w - h), float(w + h)) for w, h in zip(weights, half, strict=True))
    return intercept, slope
