"""A folder of results appears whole, in one step."""

import os
import subprocess
import sys
import textwrap

import pytest

from lgmd2jax._files.folder import replaced_folder

OWN = ("fit.json", "a.txt")


def write(folder, text):
    (folder / "fit.json").write_text(text)
    (folder / "a.txt").write_text(text)


def test_a_new_folder_an_old_one_and_what_stands_beside(tmp_path):
    target = tmp_path / "fit"
    with replaced_folder(target, "fit.json", OWN) as new:
        write(new, "one")
        assert not target.exists()
    (target / "notes.md").write_text("mine")
    with replaced_folder(target, "fit.json", OWN) as new:
        (new / "fit.json").write_text("two")
        assert (target / "fit.json").read_text() == "one"
    assert (target / "fit.json").read_text() == "two"
    assert sorted(path.name for path in target.iterdir()) == ["fit.json", "notes.md"]
    assert [path.name for path in tmp_path.iterdir()] == ["fit"]


def test_a_failure_changes_nothing(tmp_path):
    target = tmp_path / "fit"
    with replaced_folder(target, "fit.json", OWN) as new:
        write(new, "one")

    def fail():
        with replaced_folder(target, "fit.json", OWN) as new:
            (new / "fit.json").write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert (target / "fit.json").read_text() == "one"
    assert [path.name for path in tmp_path.iterdir()] == ["fit"]


def test_what_is_not_a_fits_own_is_refused(tmp_path):
    other, file = tmp_path / "other", tmp_path / "file"
    other.mkdir()
    (other / "precious.txt").write_text("keep")
    file.write_text("keep")
    for path, message in (
        (other, "something else than results"),
        (file, "is not a folder"),
        (tmp_path / "no" / "fit", "does not exist; make it first"),
    ):
        with pytest.raises(ValueError, match=message), replaced_folder(path, "fit.json", OWN):
            pass
    assert (other / "precious.txt").read_text() == "keep"


@pytest.mark.skipif(sys.platform == "win32", reason="kill -9 is for POSIX systems")
def test_a_kill_at_any_moment_leaves_an_old_or_a_new_folder(tmp_path):
    target = tmp_path / "fit"
    program = textwrap.dedent("""
        import itertools, pathlib, sys
        from lgmd2jax._files.folder import replaced_folder
        print("ready", flush=True)
        for count in itertools.count():
            with replaced_folder(pathlib.Path(sys.argv[1]), "fit.json", ("fit.json", "a.txt")) as new:
                for name in ("fit.json", "a.txt"):
                    (new / name).write_text(str(count) * 1000)
    """)
    environment = os.environ | {"JAX_PLATFORMS": "cpu"}
    for _ in range(3):
        with subprocess.Popen(
            [sys.executable, "-c", program, str(target)], stdout=subprocess.PIPE, env=environment
        ) as process:
            assert process.stdout is not None
            process.stdout.readline()
            while not target.exists():
                assert process.poll() is None
            for _ in range(200):
                one, two = ((target / name).read_text() for name in ("fit.json", "a.txt"))
                assert len(one) >= 1000
                assert two
            process.kill()
        assert (target / "fit.json").read_text() == (target / "a.txt").read_text()
