"""The LGMD1 of Yue & Rind wherever a model is taken: misuse, frame rates, fits, the exam, commands."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._handover.named import model_named, with_parameters
from lgmd2jax.cli import characterise as command, main
from tests import clips
from tests.oracle import CHANNELS


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda it: it(np.zeros((4, 5)), 30.0), r"frames has shape \(4, 5\)"),
        (lambda it: it(np.zeros((1, 4, 5)), 30.0), "frames holds one frame"),
        (lambda it: it(np.zeros((4, 2, 5)), 30.0), "at least 3 rows"),
        (lambda it: it(np.full((4, 5, 5), np.nan), 30.0), "not finite"),
        (lambda it: it(np.zeros((4, 5, 5))), "fps is missing"),
        (lambda it: it(np.zeros((4, 5, 5)), 0), "fps is 0"),
        (lambda it: it.step(it.init(np.zeros((4, 5))), np.zeros((5, 5)), 30.0), r"frame has shape \(5, 5\), the state"),
        (
            lambda it: eqx.tree_at(lambda m: m.parameters.T_de, it, jnp.asarray(-1.0))(np.zeros((4, 5, 5)), 30),
            "T_de is -1",
        ),
        (lambda it: lgmd.YueRindLGMD1(N_sp=0), "N_sp is 0"),
        (lambda it: dataclasses.replace(it, parameters=lgmd.Parameters()), "parameters is"),
        (lambda it: lgmd.YueRindParameters(T_sp=0.4), r"T_sp is 0.4; it must lie in \(0.5, 1\)"),
        (lambda it: lgmd.YueRindLGMD1(lgmd.YueRindParameters(u=-50.0)), "stable"),
        (lambda it: lgmd.ablate(it, "sfa"), "mechanism is 'sfa'; choose"),
        (lambda it: lgmd.characterise(it), "no eye"),
        (lambda it: with_parameters(it, ["tau1=3"]), "parameter is 'tau1'; choose"),
    ],
)
def test_misuse_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call(lgmd.YueRindLGMD1())


def test_parameters_declare_themselves():
    defaults, text = lgmd.YueRindParameters(), repr(lgmd.YueRindLGMD1())
    for name, symbol in lgmd.symbols(lgmd.YueRindParameters).items():
        low, high = symbol.bounds
        assert low <= float(getattr(defaults, name)) <= high
        assert symbol.contains(high)
        assert symbol.source
        assert f"{name} " in text
    for name in ("u", "T_ffi", "k", "T_sp"):  # the roles that both networks have
        assert lgmd.symbols()[name].unit == lgmd.symbols(lgmd.YueRindParameters)[name].unit


def test_another_frame_rate():
    eye = lgmd.Eye(rows=60, cols=80, degrees_per_pixel=None, fps=30.0)
    network = lgmd.at_frame_rate(lgmd.YueRindLGMD1(eye=eye), 60.0)
    p = network.parameters
    assert (float(p.T_de), float(p.T_ffi), float(p.k), float(p.Delta_C)) == (7.5, 5.0, 0.5, 0.005)
    np.testing.assert_allclose((1 / (1 + np.exp(p.u))) ** 2, 1 / (1 + np.e))
    assert (network.N_sp, network.eye and network.eye.fps) == (8, 60.0)


@pytest.mark.slow
def test_a_fit_recovers_its_parameters():
    eye = lgmd.Eye(rows=12, cols=16, degrees_per_pixel=6.0, fps=40.0)
    window: dict[str, Any] = {"start_ms": -600, "end_ms": 100}
    shown = [lgmd.stimuli.looming(eye, contrast=it, **window) for it in (-0.9, 0.2)]
    truth = lgmd.YueRindLGMD1(lgmd.YueRindParameters(W_I=0.5, k=4.0), lgmd.Soft(), eye=eye)
    conditions = [(it, lgmd.ModelTarget(model=truth, channel="smp")) for it in shown]
    start = lgmd.YueRindLGMD1(lgmd.YueRindParameters(k=1.5), lgmd.Soft(), eye=eye)
    settings: dict[str, Any] = {"pixel_points": 2, "cell_points": 2, "descend": 1}
    fit = lgmd.fit(start, conditions, lgmd.Free(W_I=None, k=(0.5, 20)), key=jax.random.key(0), **settings)
    assert isinstance(fit.model, lgmd.YueRindLGMD1)
    assert fit.values == pytest.approx({"W_I": 0.5, "k": 4.0}, rel=1e-6)
    np.testing.assert_allclose(fit.predict(shown[0], "smp"), truth(shown[0].frames, 40.0).smp, atol=1e-6)
    assert "W_I" in fit.summary()
    with pytest.raises(ValueError, match="free parameter is 'theta2'; choose"):
        lgmd.fit(start, conditions, lgmd.Free(theta2=None), key=jax.random.key(0))


def test_names_of_both_networks_take_the_bounds_of_the_one_that_is_fitted():
    free = lgmd.Free(T_sp=None, k=None)
    assert free.parameters[0].high == 0.85
    assert free.of(lgmd.YueRindParameters).parameters[0].high == 0.95
    assert free.of(lgmd.Parameters) is free
    assert lgmd.Free(W_I=None, T_sp=None).parameters[1].high == 0.95
    with pytest.raises(ValueError, match="free parameter is"):
        lgmd.Free(W_I=None, theta2=None)


@pytest.mark.slow
def test_the_exam():
    eye = lgmd.Eye(rows=24, cols=32, degrees_per_pixel=4.0, fps=30.0)
    network = lgmd.at_frame_rate(lgmd.YueRindLGMD1(eye=eye), 100.0)
    found = lgmd.ablations(network)
    assert list(found) == ["intact", "without ffi", "without lateral"]
    intact = found["intact"]
    assert intact.neuron == "LGMD1"
    assert [it.number for it in intact.rows if it.passed is None] == [9, 10, 11, 12]
    assert intact[9].values[0] > 0.9  # light looms as dark ones
    assert intact[13].values[1] > 0.9  # translation to its end
    assert intact[14].values == (1.0, 1.0)  # nothing adapts
    assert intact.plain()["rows"] == found["without ffi"].plain()["rows"]  # it acts on spikes alone


def test_commands_take_it_by_name(tmp_path, monkeypatch, capsys):
    asked = []

    def answer(model, **_):
        asked.append(model)
        raise OSError("seen")

    monkeypatch.setattr(command, "characterise", answer)
    assert main(["characterise", "preset:yue_rind"]) == 1
    assert capsys.readouterr().err == "lgmd2jax: seen\n"
    assert isinstance(asked[0], lgmd.YueRindLGMD1)
    assert asked[0].eye == lgmd.Eye.preset("locust")
    assert float(asked[0].parameters.T_de) == pytest.approx(4.5)

    assert main(["export", "preset:yue_rind", "--python", str(tmp_path / "robot")]) == 1
    assert "run only the LGMD2" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []

    assert main(["characterise", "preset:yue"]) == 1
    assert "preset is 'yue'; choose 'yue_rind'" in capsys.readouterr().err
    assert float(with_parameters(model_named("preset:yue_rind"), ["T_sp=.8"]).parameters.T_sp) == 0.8


def test_a_clip_is_answered_on_the_command_line(tmp_path, monkeypatch, capsys):
    pytest.importorskip("av", reason="reading video needs the extra 'video'")
    iio = pytest.importorskip("imageio.v3")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loom").mkdir()
    frames = clips.loom(shape=(24, 36, 48)).astype(np.uint8)
    for i, frame in enumerate(frames):
        iio.imwrite(tmp_path / "loom" / f"{i}.png", frame)
    files = ["--csv", "a.csv", "--figure", "a.png", "--overlay", "a.mp4"]
    assert main(["respond", "loom", "--model", "preset:yue_rind", "--fps", "30", *files]) == 0
    assert sorted(it.name for it in tmp_path.iterdir()) == ["a.csv", "a.mp4", "a.png", "loom"]
    rows = np.genfromtxt("a.csv", delimiter=",", names=True)
    response = lgmd.YueRindLGMD1()(frames, 30.0)
    for channel in CHANNELS:
        np.testing.assert_allclose(rows[channel], getattr(response, channel), rtol=1e-6)
    assert response.spikes.sum() > 0
    assert f"spikes    {int(response.spikes.sum())}" in capsys.readouterr().out
