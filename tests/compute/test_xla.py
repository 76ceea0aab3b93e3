"""How programs of ours ask XLA to compile: the loop over frames as one kernel, with the same response."""

import json
import os
import subprocess
import sys

import jax.numpy as jnp
import numpy as np

import lgmd2jax as lgmd
from benchmarks import _library
from benchmarks._kernels import work_per_frame
from benchmarks._task import FPS, SMALL, film
from lgmd2jax._compute.xla import FLAGS, set_flags
from tests.releases import AFTER_JAX_0_10

PROGRAM = """
import json, os
import jax
import lgmd2jax as lgmd, lgmd2jax.cli
from lgmd2jax._compute.xla import set_flags
set_flags()
from benchmarks import _library
from benchmarks._kernels import work_per_frame
from benchmarks._task import FPS, SMALL, film
frames = jax.numpy.asarray(film(SMALL, 60))
smp, slopes = lgmd.LGMD2()(frames, FPS).smp_adapted.tolist(), jax.tree.map(float, _library.gradient()(frames))
told = {"flags": os.environ["XLA_FLAGS"], "whole": work_per_frame(SMALL).whole, "smp": smp, "slopes": vars(slopes)}
print(json.dumps(told))
"""


def test_the_loop_over_frames_is_one_kernel_and_the_response_the_same_with_its_slopes():
    unset = {name: value for name, value in os.environ.items() if name != "XLA_FLAGS"}
    told = subprocess.run([sys.executable, "-c", PROGRAM], env=unset, capture_output=True, text=True, check=True)
    told = json.loads(told.stdout)
    assert (told["flags"], told["whole"]) == (FLAGS.split()[0] if AFTER_JAX_0_10 else FLAGS, True)
    assert work_per_frame(SMALL).whole == AFTER_JAX_0_10  # here nobody asked for it; later releases do it unasked
    frames = jnp.asarray(film(SMALL, 60))
    np.testing.assert_allclose(told["smp"], lgmd.LGMD2()(frames, FPS).smp_adapted, rtol=1e-5)
    for name, slope in vars(_library.gradient()(frames)).items():
        np.testing.assert_allclose(told["slopes"][name], slope, rtol=1e-3, err_msg=name)


def test_flags_of_the_user_are_kept(monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", "--xla_dump_to=/nowhere")
    set_flags()
    assert os.environ["XLA_FLAGS"] == "--xla_dump_to=/nowhere"
