"""Stores: what is on disk is the sweep, also after a kill, a full disk, and in another folder's place."""

import errno
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
import zarr

import lgmd2jax as lgmd
from lgmd2jax._sweep import store as _store
from lgmd2jax._sweep.blocks import Plan

AXES: dict[str, Any] = {
    "contrast": [-0.9, -0.5, -0.1],
    "l_over_v": [10.0, 20.0, 40.0],
    "start_ms": -400.0,
    "end_ms": 60.0,
}

SCRIPT = """
import sys, jax, lgmd2jax as lgmd
jax.config.update("jax_disable_most_optimizations", True)
eye = lgmd.Eye(rows=24, cols=32, degrees_per_pixel=3.0, fps=50.0)
axes = {"contrast": [-0.9 + 0.04 * i for i in range(20)], "l_over_v": [10.0 + i for i in range(10)]}
lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **axes, start_ms=-900.0, end_ms=90.0, store=sys.argv[1], block=10)
"""


def finished(path):
    return np.asarray(zarr.open_array(path, path="finished/blocks", mode="r")[:]).sum() if path.is_dir() else 0


def test_a_store_holds_what_memory_holds(eye, tmp_path):
    settings = {**AXES, "channels": ["smp"], "block": 2}
    stored = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **settings, store=tmp_path / "it.zarr")
    inside = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **settings)
    assert list(stored.data_vars) == list(inside.data_vars)
    for name in inside.variables:
        np.testing.assert_array_equal(stored[name], inside[name])
        assert stored[name].attrs == inside[name].attrs
    assert finished(tmp_path / "it.zarr") == 6
    assert [path.name for path in tmp_path.iterdir()] == ["it.zarr"]


def test_names_of_models_are_stored(eye, tmp_path):
    models = {"table I": lgmd.LGMD2(), "balanced": lgmd.LGMD2(lgmd.preset("balanced"))}
    stored = lgmd.sweep(models, lgmd.stimuli.looming, eye, **AXES, store=tmp_path / "it.zarr")
    assert stored.model.values.tolist() == list(models)


def test_what_is_finished_is_not_computed_again(eye, tmp_path, monkeypatch):
    first = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **AXES, store=tmp_path / "it.zarr").load()
    monkeypatch.setattr("lgmd2jax._sweep.blocks.Plan.compute", None)
    again = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **AXES, store=tmp_path / "it.zarr")
    assert again.identical(first)


@pytest.mark.parametrize("lose", [Path.unlink, lambda chunk: chunk.write_bytes(b"")], ids=["gone", "empty"])
def test_a_chunk_that_was_lost_is_computed_again(eye, tmp_path, monkeypatch, lose):
    """In the place of a file that is gone Zarr reads NaN; an empty one, as a power cut leaves, it cannot read."""
    settings = {**AXES, "channels": ["smp"], "block": 2, "store": tmp_path / "it.zarr"}
    first = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **settings).load()
    lose(tmp_path / "it.zarr/smp/c/1/0/0")
    computed = []
    compute = Plan.compute
    monkeypatch.setattr(Plan, "compute", lambda plan, number: computed.append(number) or compute(plan, number))
    again = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **settings)
    assert again.identical(first)
    assert len(computed) == 1


def test_a_block_of_nothing_but_nan_is_not_taken_for_lost(eye, tmp_path, monkeypatch):
    """A cell that never fires has no time of an alarm."""
    quiet = lgmd.LGMD2(lgmd.Parameters(T_ffi=1e-6))
    first = lgmd.sweep(quiet, lgmd.stimuli.looming, eye, **AXES, store=tmp_path / "it.zarr").load()
    assert any(np.isnan(first[name]).all() for name in first.data_vars)
    monkeypatch.setattr("lgmd2jax._sweep.blocks.Plan.compute", None)
    assert lgmd.sweep(quiet, lgmd.stimuli.looming, eye, **AXES, store=tmp_path / "it.zarr").identical(first)


def test_a_full_disk_is_one_line_and_leaves_what_is_there(eye, tmp_path, monkeypatch):
    settings = {**AXES, "store": tmp_path / "it.zarr", "block": 3}
    write = _store._write
    count = iter(range(100))

    def fills_up(group, *block):
        if next(count) == 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(group, *block)

    monkeypatch.setattr(_store, "_write", fills_up)
    with pytest.raises(ValueError, match="No space left on device; what is stored stays: run again") as error:
        lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **settings)
    assert "\n" not in str(error.value)
    monkeypatch.undo()
    assert finished(settings["store"]) == 2
    stored = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **settings)
    np.testing.assert_array_equal(stored.peak, lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **AXES).peak)


@pytest.mark.parametrize(
    "other",
    [
        {"contrast": [-0.9, -0.5, -0.2]},
        {"parameters": {"tau1": 20.0}},
        {"channels": ["mp"]},
        {"background": 150.0},
        {"model": lgmd.LGMD2(lgmd.Parameters(k=0.5))},
        {"model": lgmd.LGMD2(N_ts=5)},
    ],
)
def test_the_store_of_another_sweep_is_refused(eye, tmp_path, other):
    model = {"model": lgmd.LGMD2()}
    settings = {"renderer": lgmd.stimuli.looming, "eye": eye, **AXES, "store": tmp_path / "it.zarr"}
    before = lgmd.sweep(**model, **settings).load()
    with pytest.raises(ValueError, match=r"it\.zarr holds another sweep"):
        lgmd.sweep(**model | settings | other)
    assert lgmd.sweep(**model, **settings).identical(before)


def test_a_folder_of_something_else_is_refused(eye, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ValueError, match="holds something else than a sweep"):
        lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **AXES, store=tmp_path)
    with pytest.raises(ValueError, match="nowhere does not exist"):
        lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **AXES, store=tmp_path / "nowhere" / "it.zarr")
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.slow
def test_a_killed_sweep_goes_on_and_is_the_same_to_the_bit(tmp_path):
    whole, killed = tmp_path / "whole.zarr", tmp_path / "killed.zarr"

    def start(path):
        return subprocess.Popen([sys.executable, "-c", SCRIPT, str(path)])

    uninterrupted, process = start(whole), start(killed)
    until = time.monotonic() + 120
    while finished(killed) < 3 and process.poll() is None and time.monotonic() < until:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert 3 <= finished(killed) < 20
    assert start(killed).wait(timeout=120) == 0
    assert uninterrupted.wait(timeout=120) == 0
    one, other = (xarray.open_zarr(path, chunks=None, consolidated=False).load() for path in (whole, killed))
    for name in one.data_vars:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name
    assert np.ptp(one.peak.values) > 0.05
