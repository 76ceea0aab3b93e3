"""Warnings point to the line of the user that led to them."""

import subprocess
import sys

PROGRAM = """
import warnings
import numpy as np
import lgmd2jax as lgmd

eye = lgmd.Eye(8, 8, 2.0, 30.0)
frames = np.linspace(0.0, 255.0, 192).reshape(3, 8, 8)
model = lgmd.LGMD2(eye=eye)
state = model.init(frames[0])
cases = [
    lambda: lgmd.Eye(8, 8, 2.0, 0.5),
    lambda: lgmd.Eye.from_field_of_view(8, 8, 70.0, 0.5),
    lambda: model(frames, 60.0),
    lambda: model(frames / 255, 30.0),
    lambda: model.init(frames[1] / 255),
    lambda: model.step(state, frames[0], 60.0),
    lambda: lgmd.Parameters(tau1=0.03),
    lambda: lgmd.stimuli.looming(eye, l_over_v=0.02, start_ms=-300.0, end_ms=60.0),
    lambda: lgmd.stimuli.Photograph(np.eye(8)),
    lambda: lgmd.at_frame_rate(model, 0.5),
]
for case in cases:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        case()
    print([(warning.filename, warning.lineno - case.__code__.co_firstlineno) for warning in caught])
"""


def test_warnings_point_to_the_line_of_the_user(tmp_path):
    """In a process without the checks of types that this suite puts between calls."""
    path = tmp_path / "mine.py"
    path.write_text(PROGRAM)
    process = subprocess.run([sys.executable, path], capture_output=True, text=True, check=True)
    assert process.stdout.splitlines() == [str([(str(path), 0)])] * PROGRAM.count("    lambda: ")
