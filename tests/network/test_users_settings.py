"""Stream and clip agree also as users compile: conftest leaves most of XLA's optimisations out, they do not."""

import os
import subprocess
import sys
from pathlib import Path

import jax
import pytest

from tests.clips import ROUNDING

ROOT = Path(__file__).parents[2]
PROGRAM = """
import equinox as eqx, jax, numpy as np, lgmd2jax as lgmd
assert not jax.config.jax_enable_x64
channels = ("mp", "ffi", "smp", "smp_adapted", "spikes", "collision")
frames = np.random.default_rng(4).uniform(10, 245, (7, 24, 32)).astype(np.float32)
every = dict(n_p=1, low_pass="exact", mechanisms=("size", "shunt", "lag", "membrane", "rate"))
values = lgmd.Parameters(theta1=.4, theta2=1.3, theta3=.02, T_ffi=60, k=40, T_sp=.6, u=.7, T_s=15, T_p=90, A_ffi=.4)
for network in (
    lgmd.LGMD2(values),
    lgmd.LGMD2(values, lgmd.Soft(.5), **every),
    lgmd.LGMD2(values, lgmd.Soft(.5), mechanisms=("size", "lamina", "habituation")),
):
    clip, state = network(frames, 30.), network.init(frames[0])
    assert clip.smp.dtype == np.float32 and np.ptp(clip.smp) > 0
    within = eqx.filter_jit(lambda network, frames: network(frames, 30.))(network, frames)
    closed = eqx.filter_jit(lambda state, frame: network.step(state, frame, 30.))
    for t, frame in enumerate(frames):
        _, again = closed(state, frame)
        state, now = network.step(state, frame, 30.)
        for name in channels:
            values = [np.asarray(getattr(each, name)) for each in (now, again)]
            values += [np.asarray(getattr(each, name))[t] for each in (clip, within)]
            apart = max(abs(float(value) - float(values[0])) for value in values)
            assert apart <= ROUNDING * abs(float(values[0])), (type(network).__name__, name, t, values)
"""


@pytest.mark.skipif(
    jax.__version_info__ < (0, 10, 2), reason="before 0.10.2 JAX rounded a sum in a loop otherwise, by the last bit"
)
def test_stream_clip_and_jit_agree():
    """In single precision, to the bit before JAX 0.12.

    With the flags of the command line sums may round otherwise in a loop than outside of it.
    """
    names = ("XLA_FLAGS", "JAX_ENABLE_X64", "JAX_DISABLE_MOST_OPTIMIZATIONS")
    environment = {name: value for name, value in os.environ.items() if name not in names}
    environment |= {"PYTHONPATH": str(ROOT), "JAX_PLATFORMS": "cpu"}
    line = [sys.executable, "-c", f"ROUNDING = {ROUNDING}{PROGRAM}"]
    ran = subprocess.run(line, env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[-2000:]
