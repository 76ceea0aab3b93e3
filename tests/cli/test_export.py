"""`lgmd2jax export`: a folder that runs by itself, whole or not at all, and nobody else's files."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax._files import catalogue as _catalogue
from lgmd2jax.cli import main
from tests import clips

EYE = lgmd.Eye(rows=7, cols=9, degrees_per_pixel=2.0, fps=50.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(k=10.0, T_ffi=80.0), eye=EYE)
SOURCE = Path(hard.__file__).read_bytes()


@pytest.fixture(scope="session")
def original(tmp_path_factory):
    path = tmp_path_factory.mktemp("original") / "mine.json"
    lgmd.save(MODEL, path, provenance={"recipe": "mine"})
    return path


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_the_robot_needs_nothing_but_numpy(original, tmp_path, capsys):
    """Run as the three printed lines say, in isolation, with NumPy and without the packages beside it."""
    folder = tmp_path / "deep" / "robot"
    assert main(["export", str(original), "--python", str(folder)]) == 0
    assert contents(folder) == {"model.json": original.read_bytes(), "hard.py": SOURCE}
    heading, *lines = capsys.readouterr().out.splitlines()
    assert heading == f"wrote {folder}/model.json and {folder}/hard.py; there, with NumPy alone:"
    assert len(lines) == 3
    assert "7 x 9 at 50 fps" in lines[2]
    only_numpy = tmp_path / "site"
    only_numpy.mkdir()
    for package in Path(np.__file__).parents[1].glob("numpy*"):
        (only_numpy / package.name).symlink_to(package)
    frames = np.round(clips.loom(0, (12, 7, 9))).astype(int)
    load, *use = (line.strip() for line in lines)
    program = [
        f"import json, sys; sys.path += [{str(only_numpy)!r}, '.']",
        load,
        use[0],
        "out = []",
        "for frame in json.loads(sys.stdin.read()):",
        f"    {use[1]}",
        "    out.append([now.mp, now.smp_adapted, now.spikes])",
        "assert not {'jax', 'lgmd2jax'} & set(sys.modules)",
        "print(json.dumps(out))",
    ]
    result = subprocess.run(
        [sys.executable, "-I", "-S", "-c", "\n".join(program)],
        cwd=folder, input=json.dumps(frames.tolist()), capture_output=True, text=True, check=True,
    )  # fmt: skip
    expected = MODEL(frames.astype(np.uint8))
    channels = np.transpose([expected.mp, expected.smp_adapted, expected.spikes])
    assert channels[:, 2].any()
    np.testing.assert_allclose(json.loads(result.stdout), channels, rtol=1e-12)


def test_a_preset_and_a_shipped_fit(original, tmp_path, monkeypatch, capsys):
    shipped = tmp_path / "clone" / "fits" / "mine"
    shipped.mkdir(parents=True)
    (shipped / "model.json").write_bytes(original.read_bytes())
    monkeypatch.setattr(_catalogue, "folder", lambda kind: tmp_path / "clone" / kind)
    monkeypatch.chdir(tmp_path)
    assert main(["export", "mine", "--python", "robot"]) == 0
    assert contents(tmp_path / "robot")["model.json"] == original.read_bytes()
    capsys.readouterr()
    assert main(["export", "preset:light_selective", "--python", "robot"]) == 0
    assert "model.step(frame, interval=33.3)" in capsys.readouterr().out
    assert set(contents(tmp_path / "robot")) == {"model.json", "hard.py"}
    model = hard.load(tmp_path / "robot" / "model.json")
    assert (model.parameters["theta1"], model.parameters["theta2"], model.fps) == (1, 0, None)


def test_an_earlier_export_is_replaced_whatever_its_version(original, tmp_path):
    (tmp_path / "model.json").write_text(json.dumps({"format": hard.FORMAT, "version": 0}))
    (tmp_path / "hard.py").write_text(f'FORMAT = "{hard.FORMAT}"\n')
    (tmp_path / "main.py").write_text("import hard")
    assert main(["export", str(original), "--python", str(tmp_path)]) == 0
    assert contents(tmp_path) == {
        "model.json": original.read_bytes(), "hard.py": SOURCE, "main.py": b"import hard",
    }  # fmt: skip


@pytest.mark.parametrize("name", ["model.json", "hard.py"])
def test_what_is_something_else_stays(original, tmp_path, capsys, name):
    (tmp_path / name).write_text('{"weights": [1, 2]}')
    assert main(["export", str(original), "--python", str(tmp_path)]) == 1
    captured = capsys.readouterr()
    assert f"{name} is something else, and would be lost; move it away" in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert contents(tmp_path) == {name: b'{"weights": [1, 2]}'}


def test_a_mistake_is_one_line_and_leaves_nothing(original, tmp_path, capsys):
    damaged = tmp_path / "damaged.json"
    damaged.write_text(original.read_text().replace('"k": 10.0', '"k": 11.0'))
    (tmp_path / "file").touch()
    robot = tmp_path / "robot"
    for model, folder, message in [
        (damaged, robot, "test vector differs"),
        ("nowhere", robot, "no such file: nowhere"),
        ("preset:lgm2", robot, "preset is 'lgm2'"),
        (original, tmp_path / "file", "file is not a folder"),
    ]:
        assert main(["export", str(model), "--python", str(folder)]) == 1
        captured = capsys.readouterr()
        assert message in captured.err
        assert captured.err.count("\n") == 1
        assert not robot.exists()
    with pytest.raises(SystemExit) as stop:
        main(["export", str(original)])
    assert stop.value.code == 2


def test_a_failure_half_way_leaves_the_old_folder(original, tmp_path, monkeypatch):
    assert main(["export", str(original), "--python", str(tmp_path)]) == 0
    before = contents(tmp_path)

    def fail(*_):
        raise OSError("no space left")

    monkeypatch.setattr("lgmd2jax.cli.export.save", fail)
    assert main(["export", "preset:lgmd2", "--python", str(tmp_path)]) == 1
    assert contents(tmp_path) == before
