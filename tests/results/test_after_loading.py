"""What a loaded fit can do, as long as its data are there and are those of the fit."""

import dataclasses
import json
import shutil

import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes

import lgmd2jax as lgmd
from lgmd2jax.fitting import Profile, Supplement
from lgmd2jax.fitting._conditions import render
from lgmd2jax.fitting._curve import curve_of
from lgmd2jax.fitting._fit import digest_of
from lgmd2jax.fitting._problem import problem_of
from lgmd2jax.fitting._uncertainty.covariance import linearised_uncertainty
from lgmd2jax.fitting._uncertainty.jacobian import known_rows, sensitivity_at
from tests.fitting.fits import fit_with

EYE = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=8.0, fps=60.0)
TRUE = lgmd.Observation(baseline=5.0, gain=80.0, latency=30.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, T_sfa=5e-4, tau2=300.0, k=0.4), lgmd.Soft(1.0), eye=EYE)
FREE = lgmd.Free(gain=None, baseline=None, k=None)


def conditions(noise_seed=0):
    recorded = dataclasses.replace(TRUE, smoothing=np.asarray(30.0))
    noise = np.random.default_rng(noise_seed)
    pairs = []
    for l_over_v in (20.0, 40.0):
        stimulus = lgmd.stimuli.looming(EYE, l_over_v=l_over_v, contrast=-0.9, start_ms=-400.0, end_ms=200.0)
        response = MODEL(stimulus.frames, stimulus.fps)
        rate = np.asarray(recorded(response.smp_adapted, stimulus.time)) + noise.normal(size=len(stimulus.time))
        pairs.append((stimulus, lgmd.Target("rate", rate, error=1.0)))
    return pairs


@pytest.fixture(scope="module")
def fit():
    """A fit that ended at the truth, but for the smoothing, which is fixed at a wrong value: nothing is searched."""
    pairs = render(conditions())
    curves = [
        curve_of(stimulus, target, target.values + 1, target.values, 0 * target.values, 5.0)
        for stimulus, (target,) in pairs
    ]
    observation = dataclasses.replace(TRUE, smoothing=jnp.asarray(20.0))
    z = FREE.place(MODEL.parameters, observation)
    problem = problem_of(MODEL, observation, FREE, pairs, "squares")
    slopes = sensitivity_at(problem, jnp.asarray(z), jnp.asarray(1.0))
    u = linearised_uncertainty(
        FREE.names, z, FREE.unpacked, FREE.slopes(z), *known_rows(problem, slopes), n_effective=72, absolute=True
    )
    stats = {"loss": "squares", "stimuli": {stimulus.name: digest_of(stimulus) for stimulus, _ in pairs}}
    return dataclasses.replace(
        fit_with(FREE, curves, z=list(z), observation=observation, temperatures=(1.0,)),
        model=MODEL,
        uncertainty=u,
        stats=stats,
        problem=problem,
    )


@pytest.fixture(scope="module")
def folder(fit, tmp_path_factory):
    path = tmp_path_factory.mktemp("results") / "fit"
    lgmd.save_fit(fit, path)
    return path


def test_a_loaded_fit_has_the_data_to_the_bit(fit, folder):
    mine, theirs = (jax.tree.leaves(each._problem("profile").batches) for each in (lgmd.load_fit(folder), fit))
    assert len(mine) == len(theirs) > 0
    for one, other in zip(mine, theirs, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_a_loaded_fit_profiles_and_samples_as_the_one_that_was_made(fit, folder):
    again = lgmd.load_fit(folder)
    np.testing.assert_allclose(*(each.profile("gain").interval for each in (again, fit)), rtol=1e-9)
    draws = [each.sample(jax.random.key(1), 8, 2, warmup=20, progress=False).z for each in (again, fit)]
    np.testing.assert_allclose(*draws, rtol=1e-6)


def test_the_wrong_fixed_value_is_the_one_that_freeing_helps(fit, folder):
    """The recordings' smoothing is 30 ms; all else is right."""
    scores = lgmd.load_fit(folder).score_test()
    assert [score.name for score in scores] == [score.name for score in fit.score_test()]
    best, second, *_ = scores
    assert best.name == "smoothing"
    assert best.better == pytest.approx(30, abs=4)
    assert best.decrease > 2 * second.decrease
    assert best.probability < 1e-6
    assert not {"gain", "baseline", "k"} & {score.name for score in scores}
    assert "smoothing" in fit.summary(Supplement(scores=scores)).split("Fixed parameters that")[1]


def test_figures_are_axes_and_files_of_every_format(fit, folder, tmp_path):
    again, values = lgmd.load_fit(folder), np.linspace(0.3, 0.5, 5)
    profile = Profile(values, np.square((values - 0.4) / 0.04), (0.32, 0.48), (False, False), 3.84)
    for name, start, draw in (
        ("curves.png", b"\x89PNG", again.plot),
        ("rest.pdf", b"%PDF", again.plot_residuals),
        ("profile.svg", b"<?xml", lambda path: again.plot_profile("k", profile, path=path)),
    ):
        assert isinstance(draw(path=tmp_path / name), Axes)
        assert (tmp_path / name).read_bytes().startswith(start)
    with pytest.raises(ValueError, match=r"cannot tell the format"):
        again.plot(tmp_path / "curves.xyz")
    _, own = plt.subplots()
    assert again.plot_profile("k", profile, ax=own) is own
    np.testing.assert_array_equal(own.get_lines()[0].get_ydata(), profile.rise)
    residuals = fit.plot_residuals()
    np.testing.assert_allclose(residuals.get_lines()[0].get_ydata(), fit.curves[0].soft - fit.curves[0].target)
    plt.close("all")


def test_data_that_are_gone_or_have_changed_are_refused(folder, tmp_path):
    spoilt = shutil.copytree(folder, tmp_path / "spoilt")
    (spoilt / "data.npz").unlink()
    again = lgmd.load_fit(spoilt)
    assert again.predict(conditions()[0][0]).shape == conditions()[0][0].time.shape  # needs no data
    with pytest.raises(
        ValueError, match=r"data\.npz, with the stimuli and targets of the fit, is gone; put it back, or give"
    ):
        again.score_test()
    with pytest.raises(
        ValueError, match="have changed since the fit was made: target of 'looming 1', rate, is another"
    ):
        lgmd.load_fit(spoilt, conditions(noise_seed=1)).score_test()
    assert lgmd.load_fit(spoilt, conditions()).score_test()[0].name == "smoothing"
    with np.load(folder / "data.npz") as file:
        arrays = {name: file[name] for name in file.files}
    arrays["0/frames"][0, 0, 0, 0] += 1
    np.savez_compressed(spoilt / "data.npz", **arrays)
    with pytest.raises(ValueError, match=r"is not the one that was written with the fit"):
        lgmd.load_fit(spoilt).score_test()
    (spoilt / "data.npz").write_bytes(b"x")
    with pytest.raises(ValueError, match=r"data\.npz cannot be read"):
        lgmd.load_fit(spoilt).score_test()


def test_a_protocol_is_named_and_found_again(fit, folder, tmp_path):
    """As the command leaves it: the folder names the protocol, whose data must be those of the fit."""
    named = shutil.copytree(folder, tmp_path / "results" / "fit")
    (named / "data.npz").unlink()
    content = json.loads((named / "fit.json").read_text())
    content["data"] = {"protocol": "../../mine.toml"}
    (named / "fit.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match=r"the protocol of .*, \.\./\.\./mine\.toml, is gone"):
        lgmd.load_fit(named).score_test()
    eye = "rows = 8\ncols = 10\ndegrees_per_pixel = 8\nfps = 60"
    files = [
        "time_ms,rate\n" + "\n".join(f"{t:.9g},{v:.9g}" for t, v in zip(c.time, c.target, strict=True))
        for c in fit.curves
    ]
    tables = ""
    for number, (l_over_v, text) in enumerate(zip((20, 40), files, strict=True), start=1):
        (tmp_path / f"rate{number}.csv").write_text(text)
        tables += (
            f'[[condition]]\nname = "looming {number}"\nfamily = "looming"\nl_over_v = {l_over_v}\ncontrast = -0.9\n'
        )
        tables += "start_ms = -400\nend_ms = 200\n[[condition.target]]\n"
        tables += f'file = "rate{number}.csv"\nchannel = "rate"\ncolumn = "rate"\nerror = 1\n'
    (tmp_path / "mine.toml").write_text(f"[eye]\n{eye}\n{tables}")
    assert lgmd.load_fit(named).score_test()[0].name == "smoothing"
    (tmp_path / "mine.toml").write_text(f"[eye]\n{eye}\n{tables}".replace("-0.9", "-0.8"))
    with pytest.raises(ValueError, match="the stimulus of 'looming 1' is another"):
        lgmd.load_fit(named).score_test()


def test_shipped_fits_find_their_protocol():
    fit = lgmd.load_fit("dcmd")
    assert fit._problem("test").samples() == pytest.approx(fit.uncertainty.n_effective)
