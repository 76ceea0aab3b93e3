"""The same sweep on one device, on four, and on the workers of a Dask cluster, one of which is killed."""

import os
import signal
import subprocess
import sys
import threading
import time
from typing import Any

import numpy as np
import pytest
import xarray
from distributed import Client, LocalCluster

import lgmd2jax as lgmd

SHOWN: dict[str, Any] = {"start_ms": -400.0, "end_ms": 60.0}
AXES: dict[str, Any] = {"contrast": np.linspace(-0.9, -0.1, 9), "l_over_v": np.linspace(10.0, 40.0, 7)} | SHOWN
MANY: dict[str, Any] = AXES | {"contrast": np.linspace(-0.9, -0.1, 60)}

ON_FOUR = """
import sys, jax, numpy as np, lgmd2jax as lgmd
jax.config.update("jax_enable_x64", True)
jax.config.update("jax_num_cpu_devices", 4)
jax.config.update("jax_disable_most_optimizations", True)
eye = lgmd.Eye(rows=10, cols=13, degrees_per_pixel=7.0, fps=50.0)
axes = {"contrast": np.linspace(-0.9, -0.1, 9), "l_over_v": np.linspace(10.0, 40.0, 7)}
axes |= {"start_ms": -400.0, "end_ms": 60.0}
lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **axes, store=sys.argv[1], block=26)
print(jax.local_device_count())
"""


def same(found, expected):
    assert list(found.data_vars) == list(expected.data_vars)
    for name in expected.data_vars:
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-10, err_msg=name)


def test_four_devices_give_what_one_gives(eye, tmp_path):
    """A process of its own, since the number of devices is fixed at the start; 26 lanes do not divide by four."""
    run = [sys.executable, "-c", ON_FOUR, str(tmp_path / "four.zarr")]
    done = subprocess.run(run, capture_output=True, text=True, timeout=120)
    assert (done.stdout.strip(), done.returncode) == ("4", 0), done.stderr
    found = xarray.open_zarr(tmp_path / "four.zarr", chunks=None, consolidated=False)
    same(found, lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **AXES)[list(found.data_vars)])


@pytest.fixture(scope="module")
def client():
    settings = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0", "memory_limit": None}
    with LocalCluster(**settings) as cluster, Client(cluster) as client:
        yield client


@pytest.mark.slow
def test_two_workers_give_what_one_process_gives(eye, client, capsys):
    settings: dict[str, Any] = AXES | {"parameters": {"tau1": [10.0, 50.0]}, "channels": ["mp"]}
    found = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **settings, client=client, block=40, progress=True)
    assert "/126 [" in capsys.readouterr().err
    same(found, lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **settings))


def test_a_worker_that_is_killed_is_made_up_for(eye, client, tmp_path):
    store, killed = tmp_path / "it.zarr", []

    def kill():
        until = time.monotonic() + 60
        while time.monotonic() < until and not (store / "finished/blocks/c").is_dir():
            time.sleep(0.001)
        killed.append(next(iter(client.run(os.getpid).values())))
        os.kill(killed[0], signal.SIGKILL)
        left.append(len(list((store / "finished/blocks/c").iterdir())))

    left = []
    thread = threading.Thread(target=kill)
    thread.start()
    found = lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **MANY, client=client, store=store, block=2)
    thread.join()
    assert killed
    assert 0 < left[0] < 210
    assert np.asarray(found.peak.notnull()).all()
    same(found, lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **MANY))


def test_what_is_no_client_is_refused(eye, untyped):
    nobody: Any = "here"
    with pytest.raises(ValueError, match="client is 'here'; give a dask"):
        lgmd.sweep(lgmd.LGMD2(), lgmd.stimuli.looming, eye, **AXES, client=nobody)
