"""The shipped files are found by name and by path, in a clone and in an installed wheel."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from lgmd2jax._files import catalogue as _catalogue
from lgmd2jax._files.catalogue import folder, locate, results_folder
from lgmd2jax._protocol.protocol import load_protocol

LABELLED = {"crash", "video"}  # files of labelled clips, read by lgmd2jax.alarms
SHIPPED = sorted({path.stem for path in folder("stimuli").glob("*.toml")} - LABELLED)


def test_what_is_shipped():
    assert {"paper", "looming", "robot", "cluttered"} <= set(SHIPPED)


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_protocol_loads_by_its_bare_name(name):
    protocol = load_protocol(name)
    assert protocol.name == name
    assert protocol.conditions == load_protocol(folder("stimuli") / f"{name}.toml").conditions


@pytest.fixture
def catalogue(tmp_path, monkeypatch):
    """A package in a clone that ships one protocol and one fit, seen from an empty current folder."""
    package = tmp_path / "clone" / "lgmd2jax"
    for file in ("stimuli/looming.toml", "fits/dcmd.toml", "fits/dcmd/model.json"):
        (package.parent / file).parent.mkdir(parents=True, exist_ok=True)
        (package.parent / file).touch()
    package.mkdir()
    (tmp_path / "here").mkdir()
    monkeypatch.setattr(_catalogue, "_PACKAGE", package)
    monkeypatch.chdir(tmp_path / "here")
    return package.parent


def test_bare_names_are_looked_up(catalogue):
    assert locate("looming", "stimuli") == catalogue / "stimuli/looming.toml"
    assert locate("dcmd", "fits") == catalogue / "fits/dcmd.toml"
    assert locate("dcmd", "fits", "/model.json") == catalogue / "fits/dcmd/model.json"


def test_a_file_comes_before_the_shipped_one_and_a_folder_does_not(catalogue):
    Path("looming").touch()
    assert locate("looming", "stimuli") == Path("looming")
    Path("dcmd").mkdir()
    assert locate("dcmd", "fits") == catalogue / "fits/dcmd.toml"


def test_a_wheel_carries_its_own(catalogue):
    carried = catalogue / "lgmd2jax/catalogue/stimuli"
    carried.mkdir(parents=True)
    (carried / "looming.toml").touch()
    assert locate("looming", "stimuli") == carried / "looming.toml"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("loming", "no such file: loming; by name there is 'looming'"),
        ("./looming", "no such file: ./looming"),
        ("looming.toml", "no such file: looming.toml; by name there is 'looming'"),
        ("../here", "../here is a folder"),
    ],
)
def test_what_is_not_there_is_said(catalogue, name, message):
    with pytest.raises(FileNotFoundError, match="^" + message.replace(".", r"\.")):
        locate(name, "stimuli")


def test_results_go_beside_the_file_or_here(catalogue):
    mine = catalogue / "mine.toml"
    mine.touch()
    assert results_folder(mine) == catalogue
    assert results_folder("looming") == Path()
    assert results_folder(mine, "elsewhere") == Path("elsewhere")


@pytest.mark.slow
def test_an_installed_wheel_knows_the_catalogue(tmp_path):
    """The wheel, unpacked and imported from a folder that is not the clone."""
    project = Path(__file__).parents[2]
    build = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--quiet", "--wheel-dir", str(tmp_path), str(project)]
    subprocess.run(build, check=True)
    with zipfile.ZipFile(next(tmp_path.glob("*.whl"))) as wheel:
        wheel.extractall(tmp_path / "site")
    code = "import lgmd2jax as lgmd; print(lgmd.__file__); print(len(lgmd.load_protocol('looming').conditions))"
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "site")}
    result = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, check=True, capture_output=True, text=True
    )
    file, count = result.stdout.split()
    assert Path(file).is_relative_to(tmp_path / "site")
    assert int(count) == len(load_protocol("looming").conditions)


def test_a_folder_of_result_folders_names_them(catalogue):
    for animal in ("Mia", "Nox"):
        Path("mine", animal).mkdir(parents=True)
        Path("mine", animal, "model.json").touch()
    with pytest.raises(FileNotFoundError, match=r"^mine holds no model.json; choose 'mine/Mia' or 'mine/Nox'$"):
        locate("mine", "fits", "/model.json")
    Path("empty").mkdir()
    with pytest.raises(FileNotFoundError, match=r"^empty holds no model.json$"):
        locate("empty", "fits", "/model.json")
