"""The next stimulus: against the covariance of a fit to all data, and by what the curves leave open."""

import numpy as np

from lgmd2jax.fitting._uncertainty.covariance import linearised_uncertainty
from lgmd2jax.fitting._uncertainty.next_stimulus import rank

NAMES = ("tau1", "theta2", "k")


def known(jacobian):
    """The uncertainty of data with known errors, in the unit box."""
    n, p = jacobian.shape
    given = NAMES[:p], np.full(p, 0.5), lambda z: z, np.ones(p), jacobian, np.zeros(n)
    return linearised_uncertainty(*given, n_effective=n, absolute=True)


def test_errors_shrink_as_in_a_fit_to_all_data():
    old, new = np.random.default_rng(0).normal(size=(2, 40, 3)) * 30  # errors so small that the bounds say nothing
    (candidate,) = rank(known(old), [new], ["loom"])
    before, after = known(old), known(np.vstack([old, new]))
    expected = after.standard_errors / before.standard_errors
    np.testing.assert_allclose([candidate.shrink[name] for name in NAMES], expected, rtol=1e-3)
    gain = np.linalg.slogdet(before.covariance)[1] - np.linalg.slogdet(after.covariance)[1]
    np.testing.assert_allclose(candidate.gain, gain, rtol=1e-3)


def test_what_tells_of_the_open_parameter_comes_first():
    old = np.random.default_rng(1).normal(size=(40, 3)) * [100, 100, 0]
    more_of_the_same, of_the_third = np.eye(3)[:2] * 100, np.eye(3)[2:] * 100
    nothing = np.zeros((5, 3))
    candidates = rank(known(old), [more_of_the_same, nothing, of_the_third], ["same", "nothing", "third"])
    assert [candidate.name for candidate in candidates] == ["third", "same", "nothing"]
    assert candidates[0].shrink["k"] < 0.05
    np.testing.assert_allclose(candidates[0].shrink["tau1"], 1)
    assert candidates[2].gain == 0
    assert set(candidates[2].shrink.values()) == {1.0}
