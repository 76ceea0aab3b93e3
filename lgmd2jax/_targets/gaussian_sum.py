"""A sum of Gaussians at many places, by the fast Gauss transform."""

import numpy as np
from jaxtyping import Float

_WIDTH, _TERMS = 0.5, 16  # of a bin, in sqrt(2) standard deviations, and of its series: together exact to 1e-14
_BINS = 14  # on either side of a time, beyond which a Gaussian is below 1e-18


def gaussian_sum(
    centres: Float[np.ndarray, " centre"], places: Float[np.ndarray, " place"], s: float | int
) -> Float[np.ndarray, " place"]:
    """Sum over the centres c of exp(-(x - c)^2/(2 s^2)) at each place x, in time and memory of centres *plus* places.

    Centres fall into bins. Seen from x, each bin is a series of Hermite functions h_n(v) = H_n(v) exp(-v^2) about its
    middle: exp(-(v - u)^2) = sum over n of u^n/n! h_n(v), of which the moments u^n/n! are summed once.

    Source: Greengard & Strain 1991.
    """
    if not centres.size or not places.size:
        return np.zeros(places.shape)
    c, x = (np.asarray(values, dtype=float) / (np.sqrt(2) * s) for values in (centres, places))
    first = np.floor(x.min() / _WIDTH) - _BINS
    bins = np.floor(c / _WIDTH) - first
    count = int(np.floor(x.max() / _WIDTH) + _BINS + 1 - first)
    near = (bins >= 0) & (bins < count)
    bins = bins[near].astype(int)
    offset = c[near] - (bins + first + 0.5) * _WIDTH
    around = (np.floor(x / _WIDTH) - first).astype(int)[:, None] + np.arange(-_BINS, _BINS + 1)
    v = x[:, None] - (around + first + 0.5) * _WIDTH
    before, hermite = np.zeros_like(v), np.exp(-np.square(v))
    power, total = np.ones_like(offset), np.zeros(x.shape)
    for n in range(_TERMS):
        moments = np.bincount(bins, power, minlength=count)
        total += (hermite * moments[around]).sum(axis=1)
        before, hermite = hermite, 2 * (v * hermite - n * before)
        power = power * offset / (n + 1)
    return total
