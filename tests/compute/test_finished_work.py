"""Finished work on disk, and what a kill leaves of it."""

import pytest

from lgmd2jax._compute.finished_work import FileMemory


def test_entries_come_back_to_the_bit(tmp_path):
    path = tmp_path / "starts.jsonl"
    memory = FileMemory(path, "digest", resume=False)
    memory["run 1"] = {"z": [0.1, 1 / 3], "loss": 1e-300}
    memory["run 2"] = {"z": [], "loss": float("inf")}
    again = FileMemory(path, "digest", resume=True)
    assert dict(again) == {"run 1": {"z": [0.1, 1 / 3], "loss": 1e-300}, "run 2": {"z": [], "loss": float("inf")}}
    anew = FileMemory(path, "digest", resume=False)
    assert dict(anew) == {}
    anew["run 3"] = 1
    assert dict(FileMemory(path, "digest", resume=True)) == {"run 3": 1}


def test_a_torn_last_line_is_dropped(tmp_path):
    path = tmp_path / "starts.jsonl"
    memory = FileMemory(path, "digest", resume=False)
    memory["a"], memory["b"] = 1, 2
    path.write_text(path.read_text()[:-4])
    again = FileMemory(path, "digest", resume=True)
    assert dict(again) == {"a": 1}
    again["c"] = 3
    assert dict(FileMemory(path, "digest", resume=True)) == {"a": 1, "c": 3}


def test_the_work_of_another_recipe_is_refused_and_kept(tmp_path):
    path = tmp_path / "starts.jsonl"
    FileMemory(path, "one", resume=False)["a"] = 1
    before = path.read_text()
    with pytest.raises(ValueError, match="another recipe"):
        FileMemory(path, "two", resume=True)
    assert path.read_text() == before
    FileMemory(path, "one", resume=True).forget()
    assert not path.exists()
