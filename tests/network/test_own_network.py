"""A user's own network is asked whatever an LGMD2 is asked."""

import dataclasses
import json
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax._handover import response_vector
from tests import clips
from tests.network.toy import Dimming, DimmingParameters
from tests.oracle import CHANNELS

EYE = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=6.0, fps=20.0)
NETWORK = Dimming(eye=EYE)
SOFT = Dimming(thresholds=lgmd.Soft(1.0), eye=EYE)
FRAMES = clips.patchy(0, (14, 8, 10))


def looms(**changes: Any) -> list[lgmd.Stimulus]:
    return [
        lgmd.stimuli.looming(EYE, contrast=-0.9, l_over_v=l_over_v, start_ms=-900.0, end_ms=150.0, **changes)
        for l_over_v in (30.0, 80.0)
    ]


def test_it_answers_what_its_equations_say():
    response, excitation, v = NETWORK(FRAMES), 0.0, NETWORK.parameters
    for t, frame in enumerate(FRAMES):
        fall = FRAMES[max(t - 1, 0)] - frame
        mp = fall[fall >= 6.0].sum()
        excitation += 50 / 110 * (mp / (80 * 1.5) - excitation)
        np.testing.assert_allclose(response.mp[t], mp, rtol=1e-12)
        np.testing.assert_allclose(response.smp[t], 1 / (1 + np.exp(-excitation)), rtol=1e-12)
    spikes = np.asarray(response.spikes)
    np.testing.assert_array_equal(spikes, response.smp >= v.T_sp)
    in_a_row = np.convolve(spikes, np.ones(3))[: len(spikes)] == 3
    np.testing.assert_array_equal(response.collision, in_a_row)
    assert 0 < in_a_row.sum() < spikes.sum() < len(spikes)


def test_a_stream_is_the_clip_to_the_bit():
    clip, state = NETWORK(FRAMES, record=lambda counted: counted), NETWORK.init(FRAMES[0])
    for t, frame in enumerate(FRAMES):
        state, now = NETWORK.step(state, frame, record=lambda counted: counted)
        for channel in (*CHANNELS, "recorded"):
            np.testing.assert_array_equal(getattr(now, channel), getattr(clip, channel)[t], err_msg=channel)


def test_batches_of_clips_and_of_parameters():
    batch = np.stack([FRAMES, clips.patchy(1, FRAMES.shape)])
    together = jax.vmap(NETWORK)(batch)
    np.testing.assert_allclose(together.smp[1], NETWORK(batch[1]).smp, rtol=1e-12)
    sets = jax.vmap(lambda k: Dimming(DimmingParameters(k=k), eye=EYE))(jnp.array([1.0, 3.0]))
    responses = eqx.filter_vmap(lambda network: network(FRAMES))(sets)
    np.testing.assert_allclose(responses.smp[1], Dimming(DimmingParameters(k=3.0), eye=EYE)(FRAMES).smp, rtol=1e-12)


def test_derivatives_are_central_differences():
    def curve(values):
        parameters = DimmingParameters(**dict(zip(lgmd.symbols(DimmingParameters), values, strict=True)))
        response = dataclasses.replace(SOFT, parameters=parameters)(FRAMES)
        return jnp.stack([response.mp / 1000, response.smp, response.spikes, response.collision])

    values = jnp.array([6.0, 60.0, 1.5, 0.7])
    slopes = jax.jit(jax.jacrev(curve))(values)
    run = jax.jit(curve)
    for i in range(4):
        step = np.zeros(4)
        step[i] = 1e-5 * values[i]
        expected = (run(values + step) - run(values - step)) / (2 * step[i])
        assert np.any(expected)
        np.testing.assert_allclose(slopes[..., i], expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_a_fit_finds_its_truth_and_is_loaded(tmp_path):
    truth = Dimming(DimmingParameters(T_dim=9.0, tau=90.0, k=3.0), lgmd.Soft(), eye=EYE)
    conditions = [(each, lgmd.ModelTarget(model=truth, channel="smp")) for each in looms()]
    free = lgmd.Free(T_dim=None, tau=None, k=None)
    settings: dict[str, Any] = {"pixel_points": 2, "cell_points": 8, "descend": 1}
    fit = lgmd.fit(SOFT, conditions, free, key=jax.random.key(0), **settings)
    assert isinstance(fit.model, Dimming)
    assert fit.values == pytest.approx({"T_dim": 9.0, "tau": 90.0, "k": 3.0}, rel=1e-5)
    assert "T_dim" in fit.summary()
    lgmd.save_fit(fit, tmp_path / "own")
    loaded = lgmd.load_fit(tmp_path / "own", network=Dimming)
    assert isinstance(loaded.model, Dimming)
    assert loaded.values == pytest.approx(fit.values)
    with pytest.raises(ValueError, match=r"its network is 'Dimming'; .* load_fit\(folder, network=Dimming\)"):
        lgmd.load_fit(tmp_path / "own")
    with pytest.raises(ValueError, match="free parameter is 'T_s'; choose"):
        lgmd.fit(SOFT, conditions, lgmd.Free(T_s=None), key=jax.random.key(0))


def test_it_is_swept():
    pytest.importorskip("xarray")
    grid: dict[str, Any] = {"contrast": [-0.9, -0.3], "l_over_v": [30.0, 80.0], "start_ms": -900.0, "end_ms": 150.0}
    swept = lgmd.sweep(NETWORK, lgmd.stimuli.looming, EYE, parameters={"k": [1.0, 4.0]}, **grid)
    assert swept.peak.dims == ("k", "contrast", "l_over_v")
    fast, slow = (Dimming(DimmingParameters(k=4.0), eye=EYE)(each.frames).smp.max() for each in looms())
    np.testing.assert_allclose(swept.peak.sel(k=4.0, contrast=-0.9), [fast, slow], rtol=1e-6)


def test_it_is_characterised():
    """As any LGMD, where it does not say otherwise; light is nothing to it."""
    found = lgmd.characterise(NETWORK)
    assert found.neuron == "LGMD1"
    assert len(found.rows) == 22
    assert np.isfinite(found.reference)
    assert found.reference > 0
    assert not found[9].passed


def test_its_mechanisms_are_taken_out():
    assert float(lgmd.ablate(NETWORK, "threshold").parameters.T_dim) == 0
    without = lgmd.ablate(NETWORK, "border")
    assert without.border == "left out"
    assert without(FRAMES).mp.sum() < NETWORK(FRAMES).mp.sum()
    with pytest.raises(ValueError, match="mechanism is 'ffi'; choose 'threshold' or 'border'"):
        lgmd.ablate(NETWORK, "ffi")


def test_another_frame_rate():
    fine = lgmd.at_frame_rate(NETWORK, 40.0)
    assert {name: float(getattr(fine.parameters, name)) for name in lgmd.symbols(DimmingParameters)} == {
        "T_dim": 3.0, "tau": 60.0, "k": 0.75, "T_sp": pytest.approx(0.7),
    }  # fmt: skip
    assert (fine.N_alarm, fine.border, fine.eye and fine.eye.fps) == (6, "counted", 40.0)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("own") / "model.json"
    lgmd.save(dataclasses.replace(NETWORK, border="left out"), path)
    return path


def test_it_is_saved_and_loaded(path):
    content = json.loads(path.read_text())
    assert content["network"] == "Dimming"
    assert content["structure"] == {"N_alarm": 3, "border": "left out"}
    loaded = lgmd.load(path, network=Dimming)
    assert isinstance(loaded, Dimming)
    assert (loaded.border, loaded.eye) == ("left out", EYE)
    assert jax.tree.all(jax.tree.map(jnp.array_equal, loaded.parameters, NETWORK.parameters))


def test_a_file_without_a_clear_clip_is_told(tmp_path, monkeypatch):
    """Where the least movement of a parameter is a jump, a clip that stands still is left."""
    monkeypatch.setattr(response_vector, "_NEAR", 0.9)
    monkeypatch.setattr(response_vector, "_CLIPS", 3)
    with pytest.warns(UserWarning, match="none of 3 test clips stays clear of the thresholds of this Dimming"):
        lgmd.save(NETWORK, tmp_path / "model.json")
    vector = json.loads((tmp_path / "model.json").read_text())["test_vector"]
    assert np.ptp(vector["frames"], axis=0).max() == 0
    assert set(vector["response"]["smp"]) == {0.5}
    assert lgmd.load(tmp_path / "model.json", network=Dimming).eye == EYE


def test_a_file_is_refused_by_name_where_its_network_is_not_known(path):
    with pytest.raises(ValueError, match=r"network is 'Dimming'; for one of your own .* load\(path, network=Dimming\)"):
        lgmd.load(path)
    with pytest.raises(ValueError, match="its network is 'Dimming', not 'YueRindLGMD1'"):
        lgmd.load(path, network=lgmd.YueRindLGMD1)
    with pytest.raises(ValueError, match="its network is 'Dimming'; this program runs only the LGMD2"):
        hard.load(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda content: content["parameters"].update(k=1.6), "the response to its test vector differs"),
        (lambda content: content["parameters"].update(tau=61.0), "the response to its test vector differs"),
        (lambda content: content["structure"].update(border="counted"), "the response to its test vector differs"),
        (lambda content: content["parameters"].update(theta1=1.0), "parameter theta1 is unknown"),
        (lambda content: content["parameters"].pop("k"), "parameter k is missing"),
        (lambda content: content["structure"].update(border="doubled"), "border is 'doubled'; choose"),
        (lambda content: content["structure"].update(N_alarm=0), "N_alarm is 0; give a whole number of spikes"),
    ],
)
def test_a_file_with_other_values_is_refused(path, tmp_path, untyped, change, message):
    content = json.loads(path.read_text())
    change(content)
    (tmp_path / "changed.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match=message):
        lgmd.load(tmp_path / "changed.json", network=Dimming)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"N_alarm": 0}, "N_alarm is 0; give a whole number of spikes, 1"),
        ({"border": "kept"}, "border is 'kept'; choose 'left out' or 'counted'"),
        ({"parameters": lgmd.Parameters()}, "parameters is Parameters"),
        ({"thresholds": 3}, "thresholds is 3; give Thresholds"),
        ({"eye": 3}, "eye is 3; give Eye or None"),
    ],
)
def test_misuse_is_refused(fields, message):
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(NETWORK, **fields)


def test_a_nan_shows():
    frames = FRAMES.copy()
    frames[5, 2, 2] = np.nan
    response = eqx.filter_jit(NETWORK)(frames)
    assert all(np.isnan(getattr(response, channel)[5]) for channel in CHANNELS)
    with pytest.raises(ValueError, match="not finite, first in frame 5"):
        NETWORK(frames)
