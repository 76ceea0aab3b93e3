"""How programs of ours ask XLA to compile: the loop over frames as one kernel, with the same response."""

import json
import os
import subprocess
import sys

import numpy as np

import lgmd2jax as lgmd
from benchmarks._task import FPS, SMALL, film
from lgmd2jax._xla import FLAGS, set_flags

PROGRAM = """
import json, os
from lgmd2jax._xla import set_flags
set_flags()
import lgmd2jax as lgmd
from benchmarks._kernels import work_per_frame
from benchmarks._task import FPS, SMALL, film
smp = lgmd.LGMD2()(film(SMALL, 60), FPS).smp_adapted
print(json.dumps({"flags": os.environ["XLA_FLAGS"], "whole": work_per_frame(SMALL).whole, "smp": smp.tolist()}))
"""


def told(**environment):
    kept = {name: value for name, value in os.environ.items() if name != "XLA_FLAGS"}
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=kept | environment, capture_output=True, text=True, check=True
    )
    return json.loads(run.stdout)


def test_a_loop_over_frames_is_one_kernel_only_where_it_was_asked_for():
    asked, as_ever = told(), told(XLA_FLAGS="")
    assert (asked["flags"], asked["whole"]) == (FLAGS, True)
    assert (as_ever["flags"], as_ever["whole"]) == ("", False)
    expected = lgmd.LGMD2()(film(SMALL, 60), FPS).smp_adapted
    for found in (asked, as_ever):
        np.testing.assert_allclose(found["smp"], expected, rtol=1e-5)


def test_flags_of_the_user_are_kept(monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", "--xla_dump_to=/nowhere")
    set_flags()
    assert os.environ["XLA_FLAGS"] == "--xla_dump_to=/nowhere"
