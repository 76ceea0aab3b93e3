"""`lgmd2jax export MODEL --c DIR`: the folder, whole or not at all, and what the command says."""

import json
import re
import subprocess

import imageio.v3 as iio
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import alarms
from lgmd2jax.cli import export_c, main
from tests.c.programs import tool

EYE = lgmd.Eye(rows=10, cols=14, degrees_per_pixel=5.0, fps=50.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(k=4.0, A_ffi=0.2), eye=EYE, mechanisms=("size",))
PROTOCOL = """
eye = { preset = "locust" }
[[condition]]
name = "loom {l_over_v}"
family = "looming"
l_over_v = [20, 40]
contrast = -0.9
stop_angle = 60
start_ms = -400
end_ms = 100
"""
FILES = {"Makefile", "lgmd2.c", "lgmd2.h", "model.json", "stm32f407", "test_lgmd2.c", "test_vector.h"}


@pytest.fixture(scope="session")
def original(tmp_path_factory):
    path = tmp_path_factory.mktemp("original") / "mine.json"
    lgmd.save(MODEL, path, provenance={"recipe": "mine"})
    return path


@pytest.fixture
def export(original, tmp_path, capsys, untyped):
    """Runs the command in a folder of its own with a small protocol; returns status, output and error."""
    (tmp_path / "looms.toml").write_text(PROTOCOL)

    def run(*options, model=original, folder=tmp_path / "robot"):
        status = main(["export", str(model), "--c", str(folder), "--protocol", str(tmp_path / "looms.toml"), *options])
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_models_own_eye(export, original, tmp_path):
    tool("cc")
    status, out, _ = export(folder=tmp_path / "deep" / "robot")
    folder = tmp_path / "deep" / "robot"
    assert status == 0
    assert {path.name for path in folder.iterdir()} == FILES
    assert (folder / "model.json").read_bytes() == original.read_bytes()
    wrote, ram, changes, gap, _, soft, c = out.splitlines()
    assert wrote.startswith(f"wrote {folder}: C99 for 10 x 14 pixels of 5 degrees at 50 fps; there: make test")
    assert re.fullmatch(r"RAM: [\d,]+ bytes, of the state [\d,]+, of the frame 140", ram)
    assert changes == "all parameters as they are: they belong to this eye"
    assert gap == "gap to the hard model over 2 stimuli and clips, 52 frames:"
    assert re.fullmatch(r"  soft, temperature 0.05 +0?\.\d+ +\d+ +\d+  loom [24]0", soft)
    in_c = re.fullmatch(r"  C +(\S+) +0 +0  loom [24]0", c)
    assert in_c is not None
    assert float(in_c[1]) < 1e-6
    tool("make")
    done = subprocess.run(["make", "-s", "test"], cwd=folder, capture_output=True, text=True)
    assert done.stdout == "test vector: 24 frames of 8 x 10 came out\n"


def test_another_eye(export, tmp_path):
    """Twice the field at half the rate: k and A_ffi by the area, k and the thresholds of changes by the interval."""
    status, out, _ = export("--rows", "20", "--cols", "14", "--degrees-per-pixel", "5", "--fps", "25")
    assert status == 0
    assert "changed for this eye: sigma1 0.1 -> 0.01, T_s 10 -> 20, T_sfa 0.001 -> 0.002, N_sp 6 -> 3, " in out
    assert "A_ffi 0.2 -> 0.1, " in out
    assert "N_ts 4 -> 1" in out
    there = lgmd.load(tmp_path / "robot" / "model.json")
    assert there.eye == lgmd.Eye(20, 14, 5.0, 25.0)
    assert float(there.parameters.k) == 4.0
    assert json.loads((tmp_path / "robot" / "model.json").read_text())["provenance"]["recipe"] == "mine"
    assert ".A_ffi = 0.1f" in (tmp_path / "robot" / "lgmd2.c").read_text()
    assert "#define LGMD2_ROWS 20\n" in (tmp_path / "robot" / "lgmd2.h").read_text()


def test_only_stimuli_that_were_asked_for_must_suit_the_eye(capsys):
    """The shipped gratings have .05 and .1 cycles a degree, of which pixels of 8 degrees show the first alone."""
    gratings = [each for each in lgmd.load_protocol("lgmd2").conditions if each.name.startswith("grating")]
    eye = lgmd.Eye(10, 14, 8.0, 50.0)
    shown = [film.name for film in export_c._films(gratings, eye, [], optional=True)]
    assert shown == ["grating 0.05 cyc/deg, 4 Hz"]
    assert "left out of the comparison: condition 'grating 0.1 cyc/deg, 4 Hz'" in capsys.readouterr().out
    with pytest.raises(ValueError, match="spatial_frequency aliases"):
        list(export_c._films(gratings, eye, [], optional=False))


def test_the_urgency_goes_with_the_eye_that_it_was_calibrated_for(export, original, tmp_path):
    calibrated = tmp_path / "calibrated.json"
    calibrated.write_bytes(original.read_bytes())
    alarms.Urgency(400.0, 150.0, 0.0, 1.0, 2.0, 3.0, 4.0).save(calibrated)
    status, out, _ = export(model=calibrated)
    assert status == 0
    assert "the urgency" not in out
    assert "the probability of contact within 400 ms" in (tmp_path / "robot" / "lgmd2.h").read_text()
    status, out, _ = export("--fps", "25", model=calibrated)
    assert status == 0
    assert "the urgency was calibrated for the model's own eye, and is left out" in out.splitlines()
    assert "output->urgency = NAN;" in (tmp_path / "robot" / "lgmd2.c").read_text()


def test_a_preset_gets_its_eye_here(export):
    own = ("--rows", "10", "--cols", "14", "--degrees-per-pixel", "5")
    status, out, _ = export(*own, "--fps", "30", model="preset:lgmd2")
    assert status == 0
    assert "the model has no eye: its parameters are taken to belong to this one, and stay as they are" in out


def test_a_clip_of_your_own(export, tmp_path):
    tool("cc")
    frames = np.full((20, 24, 32, 3), 200, np.uint8)
    for t in range(5, 20):
        frames[t, 12 - t // 2 : 12 + t // 2, 16 - t // 2 : 16 + t // 2] = 20
    iio.imwrite(tmp_path / "crash.mp4", frames, plugin="pyav", codec="libx264", fps=30)
    status, out, _ = export("--clip", str(tmp_path / "crash.mp4"))
    assert status == 0
    assert "over 3 stimuli and clips, 72 frames" in out


def test_without_a_compiler_a_line_says_so(export, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    status, out, _ = export()
    assert status == 0
    assert "there is no C compiler here (cc, or CC): how far the C is from the hard model is not known" in out
    assert out.splitlines()[-1].startswith("  soft, ")


def test_an_earlier_export_is_replaced_whole_or_not_at_all(export, tmp_path, monkeypatch):
    """What else is there stays."""

    def fail(*_):
        raise OSError("no space left")

    robot = tmp_path / "robot"
    assert export()[0] == 0
    first = contents(robot)
    (robot / "lgmd2.c").write_text("spoilt")
    (robot / "main.c").write_text("int main(void) { return 0; }")
    assert export()[0] == 0
    assert contents(robot) == first | {(robot / "main.c").relative_to(robot): b"int main(void) { return 0; }"}
    second = contents(robot)
    monkeypatch.setattr("lgmd2jax.cli.export_c.sources", fail)
    assert export()[0] == 1
    assert contents(robot) == second
    assert {path.name for path in tmp_path.iterdir()} == {"looms.toml", "robot"}


FIELD = ("--rows", "72", "--cols", "99")
REFUSALS = {
    "a size without a field": (FIELD, {}, "the field of view is not known, and k .* give --degrees-per-pixel too"),
    "no eye at all": ((), {"model": "preset:lgmd2"}, "give --rows and --cols and --degrees-per-pixel too"),
    "no rate": (
        (*FIELD, "--degrees-per-pixel", ".7"),
        {"model": "preset:lgmd2"},
        "frame rate is not known; give --fps",
    ),
    "an eye that is none": (
        (*FIELD, "--degrees-per-pixel", "0"),
        {},
        "degrees_per_pixel is 0.0; give a positive number",
    ),
    "two rows": (("--rows", "2", "--cols", "9", "--degrees-per-pixel", "1"), {}, "rows is 2; an eye has"),
    "too many pixels": (
        ("--rows", "5000", "--cols", "5000", "--degrees-per-pixel", "1"),
        {},
        "a frame has 25,000,000 pixels and may have 16,777,216",
    ),
    "too little RAM": (("--ram", "2000"), {}, r"the state takes [\d,]+ bytes and the frame 140, together .* 2,000"),
    "another network": ((), {"model": "preset:yue_rind"}, "the model is a YueRindLGMD1"),
    "no model": ((), {"model": "nowhere"}, "no such file: nowhere"),
    "no clip": (("--clip", "nowhere.mp4"), {}, "nowhere.mp4"),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_a_mistake_is_one_line_and_leaves_nothing(export, tmp_path, name):
    options, given, message = REFUSALS[name]
    status, out, err = export(*options, **given)
    assert (status, out) == (1, "")
    assert re.search(message, err)
    assert err.count("\n") == 1
    assert {path.name for path in tmp_path.iterdir()} == {"looms.toml"}


def test_a_corrupt_model_is_one_line_and_leaves_nothing(export, original, tmp_path):
    damaged = tmp_path / "damaged.json"
    for text, message in (
        (original.read_text().replace('"k": 4.0', '"k": 5.0'), "is not a hand-over file"),
        (original.read_text()[:200], "is not a JSON file"),
        ('{"format": "onnx"}', "is not a hand-over file"),
    ):
        damaged.write_text(text)
        status, out, err = export(model=damaged)
        assert (status, out) == (1, "")
        assert err.count("\n") == 1
        assert f"damaged.json {message}" in err
        assert not (tmp_path / "robot").exists()


def test_a_folder_of_something_else_stays(export, tmp_path):
    (tmp_path / "file").write_text("mine")
    notes = tmp_path / "notes"
    notes.mkdir()
    (notes / "lgmd2.c").write_text("mine")
    for folder, message in ((tmp_path / "file", "exists and is not a folder"), (notes, "holds something else")):
        before = contents(tmp_path)
        status, out, err = export(folder=folder)
        assert (status, out) == (1, "")
        assert message in err
        assert contents(tmp_path) == before


def test_options_of_c_belong_to_c(original, tmp_path, capsys):
    assert main(["export", str(original), "--python", str(tmp_path / "robot"), "--ram", "5"]) == 1
    assert "--ram belongs to --c" in capsys.readouterr().err
    assert not (tmp_path / "robot").exists()
    with pytest.raises(SystemExit) as stop:
        main(["export", str(original), "--python", "a", "--c", "b"])
    assert stop.value.code == 2
