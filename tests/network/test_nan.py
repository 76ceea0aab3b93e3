"""A frame that is not finite: refused where it can be looked at, and NaN in every channel where it cannot."""

import equinox as eqx
import jax
import numpy as np
import pytest

import lgmd2jax as lgmd
from tests import clips
from tests.network.test_mechanisms import EVERY, PARAMETERS
from tests.oracle import CHANNELS

THRESHOLDS = {"hard": lgmd.Hard(), "soft": lgmd.Soft(0.5), "straight-through": lgmd.StraightThrough(0.5)}
NETWORKS = {
    **{
        f"{name}, {' '.join(mechanisms) or 'plain'}, n_p {n_p}": lgmd.LGMD2(
            PARAMETERS, thresholds, n_p=n_p, mechanisms=mechanisms
        )
        for name, thresholds in THRESHOLDS.items()
        for mechanisms, n_p in (((), 0), ((), 1), (EVERY, 1))
    },
    **{
        f"hard, {' '.join(mechanisms)}": lgmd.LGMD2(PARAMETERS, mechanisms=mechanisms)
        for mechanisms in (("size",), ("shunt",), ("lag",), ("size", "lag"), ("lamina",), ("habituation",))
    },
    "hard, silent": lgmd.LGMD2(lgmd.Parameters(theta2=0.0, T_ffi=1e-9)),
    **{f"Yue & Rind, {name}": lgmd.YueRindLGMD1(thresholds=thresholds) for name, thresholds in THRESHOLDS.items()},
}


def spoiled(where: int, value: float = np.nan) -> np.ndarray:
    """A clip with one bad pixel."""
    frames = clips.patchy(2, (8, 5, 6))
    frames[where, 2, 3] = value
    return frames


@pytest.mark.parametrize("name", NETWORKS)
def test_every_channel_is_nan_where_a_frame_is(name):
    """Under jit, nowhere before that frame; a cell that acts late is so at once."""
    run = eqx.filter_jit(lambda frames: NETWORKS[name](frames, 30.0))
    for where in (3, 7):
        response = run(spoiled(where))
        for channel in CHANNELS:
            values = np.asarray(getattr(response, channel))
            assert np.isfinite(values[:where]).all(), channel
            assert np.isnan(values[where]), channel
    assert all(np.isfinite(getattr(run(clips.patchy(2, (8, 5, 6))), channel)).all() for channel in CHANNELS)


@pytest.mark.parametrize("name", ["hard, plain, n_p 0", "hard, size lag", "Yue & Rind, hard"])
def test_it_is_refused_where_it_can_be_looked_at(name):
    network = NETWORKS[name]
    for where in (3, 7):
        with pytest.raises(ValueError, match=f"not finite, first in frame {where}"):
            network(spoiled(where), 30.0)
    frames = spoiled(1)
    state, _ = network.step(network.init(frames[0]), frames[0], 30.0)
    with pytest.raises(ValueError, match="not finite"):
        network.step(state, frames[1], 30.0)


def test_a_batch_keeps_it_to_its_clip():
    batch = np.stack([clips.patchy(2, (8, 5, 6)), spoiled(3)])
    response = jax.jit(lambda frames: jax.vmap(NETWORKS["hard, plain, n_p 1"], in_axes=(0, None))(frames, 30.0))(batch)
    for channel in CHANNELS:
        assert np.isfinite(getattr(response, channel)[0]).all()
        assert np.isnan(getattr(response, channel)[1, 3])
