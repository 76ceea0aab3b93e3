"""Sweeps against single calls, their labels, their gradients, and what they refuse."""

import datetime
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd
import pytest
import quantities as pq
import xarray

import lgmd2jax as lgmd

CONTRASTS, SPEEDS = [-0.9, -0.5, 0.2], [10.0, 40.0]
WINDOW: dict[str, Any] = {"start_ms": -600.0, "end_ms": 100.0}


def single(model, eye, **shown):
    """The summaries of one response, written once more with NumPy."""
    stimulus = lgmd.stimuli.looming(eye, **shown)
    response, time = model(stimulus.frames, stimulus.fps), np.asarray(stimulus.time)
    u, alarms = np.asarray(response.smp_adapted), time[np.asarray(response.collision) > 0]
    return {
        "peak": u.max(),
        "peak_time": time[u.argmax()] if u.max() > 0.5 else np.nan,
        "spike_count": np.asarray(response.spikes).sum(),
        "first_alarm": alarms[0] if alarms.size else np.nan,
        "integral": (u - 0.5).sum() * 1000 / eye.fps,
    }


def test_a_grid_is_what_single_calls_give(eye):
    model = lgmd.LGMD2(lgmd.Parameters(T_sp=0.6, N_sp=4.0))
    found = lgmd.sweep(model, lgmd.stimuli.looming, eye, contrast=CONTRASTS, l_over_v=SPEEDS, **WINDOW, block=4)
    assert found.sizes == {"contrast": 3, "l_over_v": 2}
    for contrast in CONTRASTS:
        for speed in SPEEDS:
            expected = single(model, eye, contrast=contrast, l_over_v=speed, **WINDOW)
            at = found.sel(contrast=contrast, l_over_v=speed)
            for name, value in expected.items():
                np.testing.assert_allclose(at[name], value, rtol=1e-9, err_msg=f"{name} {contrast} {speed}")
    assert found.spike_count.max() > 3
    assert np.isfinite(found.first_alarm).any()
    assert np.isnan(found.first_alarm).any()


def test_models_and_parameters_are_axes_too(eye):
    models = {"dark": lgmd.LGMD2(), "light": lgmd.LGMD2(lgmd.preset("light_selective"))}
    axes: dict[str, Any] = {"parameters": {"tau1": [10.0, 50.0], "T_s": 5.0}, "contrast": CONTRASTS}
    found = lgmd.sweep(models, lgmd.stimuli.looming, eye, **axes, **WINDOW, channels=["mp", "smp_adapted"])
    assert found.smp_adapted.dims == ("model", "tau1", "T_s", "contrast", "time")
    for name, model in models.items():
        parameters = jax.tree.map(lambda leaf: leaf, model.parameters)
        values = {symbol: getattr(parameters, symbol) for symbol in lgmd.symbols()}
        changed = lgmd.LGMD2(lgmd.Parameters(**values | {"tau1": 50.0, "T_s": 5.0}))
        shown = lgmd.stimuli.looming(eye, contrast=0.2, **WINDOW)
        expected = changed(shown.frames, shown.fps)
        at = found.sel(model=name, tau1=50.0, T_s=5.0, contrast=0.2)
        np.testing.assert_allclose(at.smp_adapted, expected.smp_adapted, rtol=1e-9)
        np.testing.assert_allclose(at.mp, expected.mp, rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(at.time, shown.time)
    assert np.max(np.abs(found.peak.sel(model="dark") - found.peak.sel(model="light"))) > 0.01


def test_a_list_of_models_and_a_stack_are_the_same(eye):
    values = [1.0, 2.0, 4.0]
    stack = jax.vmap(lambda theta2: lgmd.LGMD2(lgmd.Parameters(theta2=theta2)))(jnp.array(values))
    listed = [lgmd.LGMD2(lgmd.Parameters(theta2=value)) for value in values]
    one, other = (lgmd.sweep(it, lgmd.stimuli.looming, eye, contrast=CONTRASTS, **WINDOW) for it in (stack, listed))
    assert one.identical(other)
    by_parameter = lgmd.sweep(
        lgmd.LGMD2(), lgmd.stimuli.looming, eye, parameters={"theta2": values}, contrast=CONTRASTS, **WINDOW
    )
    np.testing.assert_array_equal(by_parameter.integral, one.integral)


def test_the_unit_of_inhibition_follows_the_structure(eye):
    shown = {"contrast": [-0.9], "l_over_v": 40.0, "channels": ["ffi"]}
    units = [
        lgmd.sweep(lgmd.LGMD2(mechanisms=mechanisms), lgmd.stimuli.looming, eye, **shown).ffi.attrs["units"]
        for mechanisms in ((), ("size",))
    ]
    assert units == ["grey level", "1"]


def test_axes_and_results_have_units(eye):
    found = lgmd.sweep(
        lgmd.LGMD2(), lgmd.stimuli.looming, eye, parameters={"tau1": [20]}, contrast=[-0.5], l_over_v=(10, 20)
    )
    units = {name: found[name].attrs["units"] for name in (*found.coords, *found.data_vars)}
    assert units["tau1"] == units["l_over_v"] == units["peak_time"] == units["first_alarm"] == "ms"
    assert units["contrast"] == "Weber"
    assert "delay" in found.tau1.attrs["long_name"]


def test_one_window_covers_the_whole_grid(eye):
    found = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, l_over_v=[40.0, 10.0], channels=["mp"])
    windows = [np.asarray(lgmd.stimuli.looming(eye, l_over_v=value).time) for value in (10.0, 40.0)]
    assert float(found.time[0]) == min(window[0] for window in windows)
    assert float(found.time[-1]) == max(window[-1] for window in windows)


def test_the_gradient_of_a_summary_over_the_grid(eye):
    def mean(name, theta2):
        model = lgmd.LGMD2(lgmd.Parameters(theta2=theta2, k=20.0, T_ffi=50.0), lgmd.Soft())
        axes: dict[str, Any] = WINDOW | {"contrast": CONTRASTS, "l_over_v": SPEEDS}
        return lgmd.surfaces(model, lgmd.stimuli.looming, eye, **axes)[name].mean()

    for name in ("peak", "integral"):
        slope = jax.grad(lambda value, name=name: mean(name, value))(2.0)
        difference = (mean(name, 2.0 + 1e-5) - mean(name, 2.0 - 1e-5)) / 2e-5
        assert abs(slope) > 1e-4
        np.testing.assert_allclose(slope, difference, rtol=1e-6)


def test_surfaces_are_the_arrays_of_a_sweep(eye):
    axes = {"contrast": CONTRASTS, "l_over_v": SPEEDS, **WINDOW}
    found = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **axes, block=1)
    arrays = lgmd.surfaces(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **axes)
    for name, values in arrays.items():
        np.testing.assert_allclose(found[name], values, rtol=1e-12, err_msg=name)


def test_another_sweep_of_the_same_shape_compiles_nothing(eye):
    traced = []

    def shown(eye, *, contrast):
        traced.append(contrast)
        return lgmd.stimuli.looming(eye, contrast=contrast, **WINDOW)

    lgmd.sweep(lgmd.LGMD2(), shown, eye, contrast=[-0.9, -0.1])
    first = len(traced)
    lgmd.sweep(lgmd.LGMD2(lgmd.Parameters(tau1=20.0)), shown, eye, contrast=[-0.8, -0.3])
    assert len(traced) - first < first  # its corners and its shape alone


def test_a_bar_is_shown_where_it_is_asked_for(eye, capsys):
    lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, contrast=CONTRASTS, **WINDOW, progress=True)
    assert "/3 [" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ({}, "nothing is swept"),
        ({"contrst": [-0.5]}, "looming takes no 'contrst', choose 'contrast'"),
        ({"tau1": [5.0]}, "looming takes no 'tau1'; write parameters={'tau1': ...}"),
        ({"parameters": {"tau9": [5.0]}}, "parameters has 'tau9', which is not a parameter; choose 'tau1'"),
        ({"parameters": {"tau1": [5.0, -1.0]}}, r"tau1 is -1; it must lie in \(0, inf\) ms"),
        ({"contrast": []}, "contrast has shape"),
        ({"contrast": [-0.5, float("nan")]}, "contrast holds nan; give finite values"),
        ({"contrast": [[-0.5, 0.2]]}, "contrast has shape"),
        ({"contrast": [-0.5, 3.0]}, "contrast is 3.0 on a background of 200"),
        ({"shape": ["disc", "square"]}, "an axis is a list of numbers"),
        ({"contrast": [-0.5], "channels": ["smp_adaptd"]}, "choose 'smp_adapted'"),
        ({"contrast": [-0.5], "block": 0}, "block is 0"),
    ],
)
def test_bad_input_is_said_in_one_line(eye, untyped, axes, message):
    with pytest.raises(ValueError, match=message) as error:
        lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **axes)
    assert "\n" not in str(error.value)


def test_models_of_other_structure_are_refused(eye):
    models = {"hard": lgmd.LGMD2(), "soft": lgmd.LGMD2(thresholds=lgmd.Soft())}
    with pytest.raises(ValueError, match="model soft has another structure"):
        lgmd.sweep(models, lgmd.stimuli.looming, eye, contrast=[-0.5])


def test_a_missing_package_names_the_extra(eye, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"this needs xarray: pip install 'lgmd2jax\[sweep\]'"):
        lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, contrast=[-0.5])


@pytest.mark.parametrize(
    "values",
    [
        lambda: (-0.9, -0.5),
        lambda: (value for value in (-0.9, -0.5)),
        lambda: {-0.9: 1, -0.5: 2}.keys(),
        lambda: map(float, ["-0.9", "-0.5"]),
        lambda: pd.Series([-0.9, -0.5]),
        lambda: xarray.DataArray([-0.9, -0.5]),
    ],
)
def test_whatever_holds_several_values_is_an_axis(eye, values):
    settings: dict[str, Any] = {"start_ms": -200.0, "end_ms": 60.0}
    surface = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, contrast=values(), **settings)
    assert surface.contrast.values.tolist() == [-0.9, -0.5]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({-0.9, -0.5}, "contrast is a set, which has no order; give a list"),
        (frozenset({-0.9}), "contrast is a set"),
        ([datetime.date(2026, 1, 1)], "contrast is .*, which has a unit or a date; give plain numbers"),
        (pd.to_datetime(["2026-01-01"]), "contrast is .*, which has a unit or a date"),
        ([10, 20] * pq.ms, "contrast is .*, which has a unit or a date"),
        (pd.to_timedelta([1, 2], unit="s"), "contrast is .*, which has a unit or a date"),
        (["a", "b"], "contrast is .*; an axis is a list of numbers"),
        ([[1, 2], [3]], "contrast is .*; an axis is a list of numbers"),
        (iter([]), r"contrast has shape \(0,\)"),
    ],
)
def test_what_is_no_axis_is_refused_in_one_line(eye, values, message):
    with pytest.raises(ValueError, match=message) as caught:
        lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, contrast=values)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("renderer", "message"),
    [("loming", "renderer is 'loming'; give a function, .*; choose 'looming'"), (None, "renderer is None; give a")],
)
def test_what_renders_nothing_is_refused(eye, renderer, message, untyped):
    with pytest.raises(ValueError, match=message):
        lgmd.sweep(lgmd.LGMD2(), renderer, eye, contrast=[-0.9, -0.5])
