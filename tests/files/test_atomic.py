"""Files appear whole or not at all."""

import os
import stat
from pathlib import Path

import pytest

from lgmd2jax._files.atomic import all_replaced, read_json, read_toml, replaced
from lgmd2jax._files.folder import replaced_folder
from lgmd2jax._files.written import noted


def test_the_file_appears_when_the_block_ends(tmp_path):
    path = tmp_path / "result.csv"
    with replaced(path) as temporary:
        temporary.write_text("whole")
        assert not path.exists()
        assert temporary.parent == path.parent
        assert temporary.suffix == path.suffix
    assert path.read_text() == "whole"
    assert os.listdir(tmp_path) == ["result.csv"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_what_stood_there_stays_when_the_block_fails(tmp_path, error):
    path = tmp_path / "result.csv"
    path.write_text("before")

    def write_half():
        with replaced(path) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(error):
        write_half()
    assert path.read_text() == "before"
    assert os.listdir(tmp_path) == ["result.csv"]


def test_the_file_is_as_readable_as_any_other(tmp_path):
    plain = tmp_path / "plain"
    plain.touch()
    with replaced(tmp_path / "result") as temporary:
        temporary.touch()
    assert stat.S_IMODE((tmp_path / "result").stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)


def test_two_writers_do_not_share_a_temporary_file(tmp_path):
    with replaced(tmp_path / "a.csv") as first, replaced(tmp_path / "a.csv") as second:
        assert first != second
        first.write_text("first")
        second.write_text("second")
    assert (tmp_path / "a.csv").read_text() == "first"


def test_a_place_that_cannot_hold_a_file_is_refused_before_the_work(tmp_path):
    with pytest.raises(ValueError, match=r"folder .*nowhere does not exist"), replaced(tmp_path / "nowhere" / "a.csv"):
        pytest.fail("the block ran")
    with pytest.raises(ValueError, match="is not a file"), replaced(tmp_path):
        pytest.fail("the block ran")
    with pytest.raises(ValueError, match=r"cannot write .*: File name too long"), replaced(tmp_path / ("a" * 255)):
        pytest.fail("the block ran")


@pytest.mark.parametrize(("paths", "kept"), [(["a.csv", "b.png", "./a.csv"], []), (["b.png", "a.csv"], ["x/../a.csv"])])
def test_no_file_is_written_twice_or_over_what_is_read(tmp_path, monkeypatch, paths, kept):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x").mkdir()
    (tmp_path / "a.csv").write_text("recorded")
    refused = pytest.raises(ValueError, match=r"a\.csv is named twice; what is read and what is written need names")
    with refused, all_replaced([*map(Path, paths), None], [*kept, None]):
        pytest.fail("not refused")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "x"]
    assert (tmp_path / "a.csv").read_text() == "recorded"


def test_what_has_appeared_is_noted(tmp_path):
    """A file of a folder that is noted or still to appear is none, nor is one of a cache, nor what failed."""
    written = noted()
    with replaced(tmp_path / "a.csv") as file, replaced(tmp_path / "cache", is_result=False) as kept:
        file.touch()
        kept.touch()
        assert written == []
    with replaced_folder(tmp_path / "fit", "model.json", {"model.json"}) as folder:
        with replaced(folder / "model.json") as file:
            file.touch()
        assert written == [tmp_path / "a.csv"]
    with replaced(tmp_path / "fit" / "fit.png") as file:
        file.touch()
    with pytest.raises(KeyboardInterrupt), replaced(tmp_path / "b.csv"):
        raise KeyboardInterrupt
    assert written == [tmp_path / "a.csv", tmp_path / "fit"]
    noted()
    assert written == [tmp_path / "a.csv", tmp_path / "fit"]


@pytest.mark.parametrize(("read", "kind"), [(read_toml, "TOML"), (read_json, "JSON")])
def test_a_picture_is_no_text(tmp_path, read, kind):
    (tmp_path / "a.png").write_bytes(b"\x89PNG")
    with pytest.raises(ValueError, match=rf"a\.png is not a {kind} file: it holds no text in UTF-8"):
        read(tmp_path / "a.png")
