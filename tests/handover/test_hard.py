"""The NumPy model that runs on a robot."""

import ast
import json
import os
import pathlib
import shutil
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from lgmd2jax import hard
from tests import clips
from tests.handover.conftest import FRAMES, MODEL

SOURCE = pathlib.Path(hard.__file__)


def test_it_streams_what_it_computes_for_a_clip(path):
    model = hard.load(path)
    clip = model(FRAMES)
    assert clip.spikes.dtype.kind == "i"
    assert clip.collision.dtype == bool
    assert clip.spikes.sum() > 0
    model.reset()
    for t, frame in enumerate(FRAMES):
        now = model.step(frame, interval=20.0)
        assert (now.mp, now.ffi, now.smp_adapted, now.spikes) == (
            clip.mp[t], clip.ffi[t], clip.smp_adapted[t], clip.spikes[t],
        )  # fmt: skip
    expected = MODEL(FRAMES)
    np.testing.assert_allclose(clip.smp_adapted, expected.smp_adapted, rtol=1e-12)
    np.testing.assert_array_equal(clip.spikes, expected.spikes)
    np.testing.assert_array_equal(clip.collision, expected.collision)


def test_it_is_one_file_with_numpy_alone(path, tmp_path):
    source = pathlib.Path(hard.__file__)
    nodes = list(ast.walk(ast.parse(source.read_text())))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    names += [str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)]
    imports = {name.split(".")[0] for name in names}
    assert imports - set(sys.stdlib_module_names) == {"numpy"}
    robot = tmp_path / "robot"
    robot.mkdir()
    shutil.copy(source, robot)
    shutil.copy(path, robot)
    np.save(robot / "frames.npy", FRAMES)
    program = (
        "import sys, numpy, hard; response = hard.load('model.json')(numpy.load('frames.npy'));"
        "assert not {'jax', 'lgmd2jax', 'equinox'} & set(sys.modules); print(response.mp.tolist())"
    )
    out = subprocess.run([sys.executable, "-c", program], cwd=robot, capture_output=True, text=True, check=True).stdout
    np.testing.assert_allclose(json.loads(out), MODEL(FRAMES).mp, rtol=1e-12)


def test_it_keeps_its_state_when_a_frame_is_refused(path):
    model, twin = hard.load(path), hard.load(path)
    for t, frame in enumerate(FRAMES):
        if t == 5:
            for bad in (frame[:3], frame * np.nan, frame[0]):
                with pytest.raises(ValueError, match="frame"):
                    model.step(bad)
        assert model.step(frame) == twin.step(frame)


def test_it_at_another_rate_warns(path):
    with pytest.warns(UserWarning, match="belong to 50 frames per second, not 30"):
        hard.load(path)(FRAMES, 30.0)


@pytest.mark.parametrize("name", ["plain", "rich"])
def test_a_buffer_may_be_filled_again(path, others, name):
    """As by a camera's driver, in the dtype in which no conversion makes a copy, however the pixels lie in it."""
    file = path if name == "plain" else others / "rich.json"
    frames = clips.loom(shape=(20, 15, 17))
    for buffer in (np.empty_like(frames[0]), np.empty((15, 17), order="F"), np.empty((30, 34, 3))[::-2, ::2, 1]):
        model, fresh = hard.load(file), hard.load(file)
        for frame in frames:
            buffer[:] = frame
            assert model.step(buffer) == fresh.step(frame.copy())
            buffer[:] = 0
    assert model(frames).mp.max() > 1000


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    "interval", ["33", 0, -1.0, float("nan"), float("inf"), 10**400, True, [33.0, 33.0], 3j], ids=repr
)
def test_an_interval_that_is_none_is_refused(path, interval):
    model, twin = hard.load(path), hard.load(path)
    assert model.step(FRAMES[0]) == twin.step(FRAMES[0])
    with pytest.raises(ValueError, match="interval is"):
        model.step(FRAMES[1], interval)
    assert model.step(FRAMES[1]) == twin.step(FRAMES[1])
    single: Any = np.float32(20)
    assert model.step(FRAMES[2], single) == twin.step(FRAMES[2], 20.0)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    "frame", ["frame.png", None, {}, [[1, 2, 3], [1, 2]], [[10**400] * 3] * 3, 7, FRAMES], ids=lambda it: f"{it!r:.20}"
)
def test_a_frame_that_is_none_is_refused(path, frame):
    with pytest.raises(ValueError, match="frame "):
        hard.load(path).step(frame)


def test_a_masked_frame_is_refused(path):
    """NumPy would take what is masked for pixels."""
    with pytest.raises(ValueError, match="frame is masked; fill"):
        hard.load(path).step(np.ma.masked_greater(FRAMES[0], 100))


def test_it_is_written_in_python_3_8():
    """Its grammar, and none of the later functions that are likely to creep in."""
    tree = ast.parse(SOURCE.read_text(), feature_version=(3, 8))
    annotations = [node.annotation for node in ast.walk(tree) if isinstance(node, (ast.AnnAssign, ast.arg))]
    annotations += [node.returns for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    not_run = {id(inner) for note in annotations if note is not None for inner in ast.walk(note)}
    for node in ast.walk(tree):
        if id(node) in not_run:
            continue
        if isinstance(node, ast.BinOp):
            assert not isinstance(node.op, ast.BitOr), f"line {node.lineno}: | of dictionaries or types"
        if isinstance(node, ast.keyword):
            assert node.arg != "strict"
        if isinstance(node, ast.Attribute):
            assert node.attr not in ("removeprefix", "removesuffix", "bit_count", "lcm", "pairwise", "cache")
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name):
            assert node.value.id not in ("list", "dict", "tuple", "set", "Iterable", "Mapping", "Sequence"), node.lineno


def test_it_runs_on_the_python_of_a_robot(path, others, tmp_path):
    """On 3.8 with NumPy 1.17, say: LGMD2JAX_ROBOT_PYTHON names the interpreter."""
    python = os.environ.get("LGMD2JAX_ROBOT_PYTHON")
    if not python:
        pytest.skip("no old Python is named; set LGMD2JAX_ROBOT_PYTHON to one that has NumPy")
    shutil.copy(SOURCE, tmp_path)
    shutil.copy(path, tmp_path / "plain.json")
    shutil.copy(others / "rich.json", tmp_path)
    program = (
        "import hard, numpy; frames = numpy.load('frames.npy');"
        "print([hard.load(name)(frames).smp_adapted.tolist() for name in ('plain.json', 'rich.json')])"
    )
    np.save(tmp_path / "frames.npy", FRAMES)
    out = subprocess.run(
        [python, "-W", "error", "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    expected = [hard.load(tmp_path / name)(FRAMES).smp_adapted for name in ("plain.json", "rich.json")]
    np.testing.assert_allclose(json.loads(out.stdout), expected, rtol=1e-12)
