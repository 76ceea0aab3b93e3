"""Of many experiments, 95 % of the intervals hold the truth, however far apart the recorded values lie."""

import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax.fitting._problem import problem_of
from lgmd2jax.fitting._uncertainty.covariance import linearised_uncertainty
from lgmd2jax.stimuli import Stimulus

TRUTH, NOISE, SPAN = np.array([5.0, 60.0]), 4.0, 800.0


def basis(time):
    """A baseline and a response that is smooth on the scale of the values."""
    return np.stack([np.ones_like(time), np.exp(-0.5 * ((time - 400) / 150) ** 2)], axis=1)


def covered(rng, count, fps, shift, absolute):
    """Whether the intervals of both parameters hold the truth, in a least-squares fit of one noisy recording."""
    time, frames = np.linspace(0, SPAN, count), np.arange(0, SPAN + 1e-9, 1000 / fps) + shift
    stimulus = Stimulus(jnp.zeros((frames.size, 3, 3)), fps, jnp.asarray(frames))
    values = basis(time) @ TRUTH + NOISE * rng.normal(size=count)
    target = lgmd.Target("rate", values, time, error=NOISE if absolute else None, interpolate=True).on(stimulus)
    scale, jacobian = np.array(target.scale), basis(frames)
    counted = scale > 0
    scale /= np.sqrt(target.thinning)
    rows, right = jacobian[counted] * scale[counted, None], target.values[counted] * scale[counted]
    best, *_ = np.linalg.lstsq(rows, right)
    size = np.array([50.0, 200.0])
    samples = np.sum(counted / target.thinning)
    settings = {"n_effective": samples, "absolute": absolute, "priors": 0}
    u = linearised_uncertainty(
        ("a", "b"), best / size, lambda z: z * size, size, rows * size, rows @ best - right, **settings
    )
    low, high = np.asarray(u.intervals).T
    return (low <= TRUTH) & (high >= TRUTH)


def share(count, fps, shift, absolute, experiments):
    rng = np.random.default_rng(8)
    return np.mean([covered(rng, count, fps, shift, absolute) for _ in range(experiments)])


@pytest.mark.parametrize("absolute", [True, False])
def test_nine_values_onto_a_hundred_frames_a_second(absolute):
    """300 experiments know the share to 1 %. Were every frame a sample, it would be 40 to 50 %."""
    assert 0.92 < share(9, 100.0, 0.0, absolute, 300) < 0.98


@pytest.mark.slow
@pytest.mark.parametrize("absolute", [True, False])
@pytest.mark.parametrize(
    ("count", "fps", "shift"),
    [(9, 100.0, 0.0), (25, 100.0, 0.0), (17, 60.0, 5.0), (41, 100.0, 3.0), (54, 100.0, 3.0)],
)
def test_any_spacing_on_any_frames(count, fps, shift, absolute):
    assert 0.93 < share(count, fps, shift, absolute, 1000) < 0.97


def test_a_fit_counts_the_values():
    eye = lgmd.Eye(rows=6, cols=8, degrees_per_pixel=10.0, fps=100.0)
    stimulus = lgmd.stimuli.looming(eye, l_over_v=40.0, contrast=-0.9, start_ms=-600.0, end_ms=200.0)
    time = np.arange(-600.0, 201.0, 100.0)
    pair = (stimulus, [lgmd.Target("rate", np.zeros(9), time, interpolate=True).on(stimulus)])
    free = lgmd.Free(gain=None).of(lgmd.Parameters)
    problem = problem_of(lgmd.LGMD2(thresholds=lgmd.Soft()), lgmd.Observation(), free, [pair], "squares")
    assert problem.samples() == 9
