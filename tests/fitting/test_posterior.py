"""Posterior draws against what is known exactly, and the file as ArviZ reads it."""

import json

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import xarray

from lgmd2jax._results.posterior_nc import write_posterior
from lgmd2jax.fitting._uncertainty.posterior import draw_posterior

SLOPES = np.array([[40.0, 30, 0], [0, 25, 5], [0, 0, 30], [10, -10, 10]])
CENTRE = np.array([0.3, 0.5, 0.7])


def straight(slopes, z):
    return slopes @ (z - CENTRE)


def draw(slopes, z=CENTRE, variance=1.0, seed=0):
    residuals = jax.tree_util.Partial(straight, jnp.asarray(slopes))  # arrays are arguments: compiled once
    return draw_posterior(residuals, z, key=jax.random.key(seed), variance=variance, chains=2, draws=600, warmup=300)


@pytest.fixture(scope="module")
def sample():
    """1,200 draws of a Gaussian posterior, whose mean and covariance are known."""
    return draw(SLOPES, variance=0.8)


def test_a_straight_model_has_its_covariance(sample):
    assert sample.z.shape == (2, 600, 3)
    assert not sample.diverging.any()
    assert (sample.r_hat < 1.02).all()
    assert (sample.effective > 300).all()
    z = sample.z.reshape(-1, 3)
    covariance = 0.8 * np.linalg.inv(SLOPES.T @ SLOPES)
    errors = np.sqrt(np.diag(covariance))
    assert (np.abs(z.mean(axis=0) - CENTRE) < 4 * errors / np.sqrt(sample.effective)).all()
    np.testing.assert_allclose(np.sqrt(np.diag(np.cov(z.T))), errors, rtol=0.15)
    np.testing.assert_allclose(np.corrcoef(z.T), covariance / np.outer(errors, errors), atol=0.1)


@pytest.mark.slow
def test_without_data_every_value_between_the_bounds_is_as_likely():
    sample = draw(np.zeros((4, 3)), z=np.array([0.0, 0.5, 1.0]))  # also starts on the bounds
    z = sample.z.reshape(-1, 3)
    for i in range(3):
        shares, _ = np.histogram(z[:, i], bins=4, range=(0, 1))
        expected, sigma = len(z) / 4, np.sqrt(sample.effective[i] * 3 / 16) * len(z) / sample.effective[i]
        assert (np.abs(shares - expected) < 4 * sigma).all()


@pytest.mark.slow
def test_the_key_decides():
    again, other = draw(SLOPES, variance=0.8), draw(SLOPES, variance=0.8, seed=1)
    np.testing.assert_array_equal(again.z, draw(SLOPES, variance=0.8).z)
    assert (again.z != other.z).any()


def test_finished_chains_are_not_drawn_again_and_those_of_other_data_are_not_taken():
    class Interrupted(dict):
        def __setitem__(self, key, value):
            super().__setitem__(key, value)
            raise KeyboardInterrupt

    settings = {"key": jax.random.key(0), "chains": 2, "draws": 20, "warmup": 20}
    residuals, memory = jax.tree_util.Partial(straight, jnp.asarray(SLOPES)), Interrupted()
    with pytest.raises(KeyboardInterrupt):
        draw_posterior(residuals, CENTRE, **settings, memory=memory)
    resumed = json.loads(json.dumps(memory))
    (first,) = resumed
    resumed[first][0][0][0] += 1  # marks the finished chain
    again, whole = (draw_posterior(residuals, CENTRE, **settings, memory=kept) for kept in (resumed, None))
    logit = np.log(again.z / (1 - again.z)) - np.log(whole.z / (1 - whole.z))
    np.testing.assert_allclose(logit[0, 0, 0], 1)
    logit[0, 0, 0] = 0
    np.testing.assert_allclose(logit, 0, atol=1e-9)
    other = jax.tree_util.Partial(straight, jnp.asarray(2 * SLOPES))
    draws = draw_posterior(other, CENTRE, **settings, memory=resumed)
    np.testing.assert_array_equal(draws.z, draw_posterior(other, CENTRE, **settings).z)
    assert len(resumed) == 4


def test_too_few_draws_are_refused():
    with pytest.raises(ValueError, match="1 chains of 600 draws are too few; give at least 2 chains"):
        draw_posterior(lambda z: z, CENTRE, key=jax.random.key(0), chains=1, draws=600)


def test_the_file_has_the_layout_that_arviz_reads(tmp_path, sample):
    path = tmp_path / "posterior.nc"
    names = ("theta2", "tau1", "k")
    statistics = {name: getattr(sample, name) for name in ("energy", "diverging", "acceptance_rate", "tree_depth")}
    draws = {name: 10 * sample.z[..., i] for i, name in enumerate(names)}
    write_posterior(path, draws, {"tau1": "ms"}, statistics)
    assert [path.name for path in tmp_path.iterdir()] == ["posterior.nc"]
    read = xarray.open_dataset(path, group="posterior", engine="h5netcdf")
    assert (read["tau1"].dims, read["tau1"].attrs["units"]) == (("chain", "draw"), "ms")
    read.close()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::FutureWarning")  # of importing arviz
def test_arviz_summarises_the_file(tmp_path, sample):
    arviz = pytest.importorskip("arviz")
    write_posterior(
        tmp_path / "posterior.nc",
        {"theta2": sample.z[..., 0], "k": sample.z[..., 2]},
        {"theta2": "grey level"},
        {"energy": sample.energy, "diverging": sample.diverging},
    )
    data = arviz.from_netcdf(tmp_path / "posterior.nc")
    np.testing.assert_array_equal(data.posterior["k"], sample.z[..., 2])
    assert data.sample_stats["diverging"].dtype == bool
    summary = arviz.summary(data)
    np.testing.assert_allclose(summary.loc["theta2", "mean"], sample.z[..., 0].mean(), atol=1e-3)
    np.testing.assert_allclose(summary.loc["theta2", "r_hat"], sample.r_hat[0], atol=0.01)
    assert (arviz.bfmi(data) > 0.3).all()
