"""Plain detectors: what they measure on clips whose change and expansion are known."""

import importlib.util
import sys
import types

import numpy as np
import pytest

from lgmd2jax._compute.cluster import need
from lgmd2jax.alarms import LabelFile, LabelledClip
from lgmd2jax.alarms._baselines import baseline, difference, divergence
from lgmd2jax.cli import main


def test_difference_is_the_mean_absolute_change():
    frames = np.zeros((4, 3, 4))
    frames[1, 0, 0], frames[2:, 1, 1] = 24, 12
    clip = LabelledClip.of("c", frames, 10)
    assert difference(clip).tolist() == [0, 2, 3, 0]


def test_evidence_is_the_mean_of_the_last_150_ms_by_the_clock():
    frames = np.repeat(np.array([0.0, 6, 6, 18, 18])[:, None, None], 3, axis=1).repeat(3, axis=2)
    time = np.array([0.0, 100, 150, 400, 500])
    clip = LabelledClip.of("c", frames, 10, time=time)
    (trace,) = baseline("difference", [clip]).evidence  # of changes 0, 6, 0, 12, 0
    np.testing.assert_allclose(trace, [0, 3, 3, 12, 6])


def zoom(rate, count=8, shape=(30, 40), fps=20.0):
    """A smooth texture that grows by `rate` a second, about the middle."""
    y, x = (np.arange(n) - (n - 1) / 2 for n in shape)
    frames = []
    for t in range(count):
        scale = np.exp(rate * t / fps)
        pattern = np.cos(x[None] / scale * 0.7) + np.cos(y[:, None] / scale * 0.6 + 0.5)
        frames.append(127 + 50 * pattern)
    return LabelledClip.of("c", np.array(frames), fps)


def test_divergence_is_that_of_a_texture_that_grows():
    pytest.importorskip("cv2", reason="flow needs the extra 'baselines'")
    for rate in (0.5, 1.0):
        assert np.median(divergence(zoom(rate))[1:]) == pytest.approx(2 * rate, rel=0.35)
    assert abs(np.median(divergence(zoom(0.0))[1:])) < 0.05


def test_a_package_that_another_thread_is_importing_is_installed(monkeypatch):
    """Clips are looked at in threads, of which each asks for OpenCV while the first one imports it."""
    monkeypatch.setitem(sys.modules, "half", types.ModuleType("half"))
    with pytest.raises(ValueError, match="__spec__"):
        importlib.util.find_spec("half")
    need("half", extra="baselines")


def test_without_opencv_the_error_names_the_extra_before_anything_is_decoded(monkeypatch, capsys):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "cv2" else find(name))
    monkeypatch.setattr(LabelFile, "load", None)
    with pytest.raises(ValueError, match=r"pip install 'lgmd2jax\[baselines\]'"):
        divergence(zoom(0.5))
    assert main(["watch", "video", "--baselines"]) == 1
    assert capsys.readouterr().err == "lgmd2jax: this needs cv2: pip install 'lgmd2jax[baselines]'\n"
