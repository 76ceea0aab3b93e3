"""What README.md and the pages in docs/ say works when it is pasted."""

import fnmatch
import re
import shlex
import subprocess
import sys
import tomllib

import pytest

from lgmd2jax.cli import main
from tests.examples import BLOCKS, COMMANDS, FILES, PROGRAMS, ROOT, is_slow

SLOW_PROGRAMS = [pytest.param(it, marks=pytest.mark.slow) if is_slow(it) else it for it in PROGRAMS]
SLOW_COMMANDS = [pytest.param(it, marks=pytest.mark.slow) if is_slow(it) else it for it in COMMANDS]


# What a program prints, by its first line of code, where numbers are known: the peak of Table I and its spikes; a slope
# that falls with k, and responses that grow with contrast; a camera that saw nothing yet.
PRINTED = {
    "import lgmd2jax as lgmd\n\neye = lgmd.Eye(rows=48, cols=64, degrees_per_pixel=2.0, fps=30.0)\n": (
        r"0\.9373\d* 8\.0\n"
    ),
    "import jax, lgmd2jax as lgmd\n\neye": r"-0\.0082\d*\n(\[0\.5\s+0\.904\d*\s+0\.961\d*\s+(0\.96\d+\s*){5}\]\n)?",
    "import lgmd2jax as lgmd\nfrom lgmd2jax import hard": r"0\.5 False\n",
}


@pytest.mark.parametrize("program", SLOW_PROGRAMS, ids=[f"program {i}" for i in range(len(PROGRAMS))])
def test_programs_run(program, tmp_path):
    done = subprocess.run([sys.executable, "-W", "error", "-c", program], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert "nan" not in done.stdout
    for start, printed in PRINTED.items():
        assert not program.startswith(start) or re.fullmatch(printed, done.stdout), done.stdout


@pytest.mark.parametrize("command", SLOW_COMMANDS)
def test_commands_run(command, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("lgmd2jax.alarms._decoding.cache_folder", lambda: tmp_path / "cache")
    place = tmp_path / "clone"
    place.mkdir()
    (place / "stimuli").symlink_to(ROOT / "stimuli")
    for name, text in FILES.items():
        (place / name).write_text(text)
    monkeypatch.chdir(place)
    assert main(shlex.split(command)[1:]) == 0, capsys.readouterr().err
    said = capsys.readouterr().out
    left = [path.name for path in place.iterdir() if path.name not in ("stimuli", *FILES)]
    if "watch" in command:
        assert "correct on 1 of 1 clips" in said
    else:
        assert left
    assert shown_by_git(left) == []


def shown_by_git(names):
    """Those of the names that .gitignore does not name, as files or folders of a clone."""
    patterns = (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()
    patterns = [pattern.strip("/") for pattern in patterns if not pattern.startswith("#")]
    return [name for name in names if not any(fnmatch.fnmatch(name, pattern) for pattern in patterns)]


def test_the_shipped_clip_and_its_labels_are_what_the_readme_shows():
    (shown,) = (block for language, block in BLOCKS if language == "toml" and "crash.mp4" in block)
    assert tomllib.loads(shown) == tomllib.loads((ROOT / "stimuli/crash.toml").read_text(encoding="utf-8"))
    assert (ROOT / "stimuli/crash.mp4").stat().st_size < 50_000


def test_what_runs_in_every_worker_prints_nothing():
    """The workers of a cluster import the program: what it prints stands behind the guard."""
    (program,) = (program for program in PROGRAMS if "Client(" in program)
    before, _, _ = program.partition('if __name__ == "__main__":')
    assert "print(" not in before


def test_there_is_something_to_test():
    assert len(PROGRAMS) == 8
    assert len(COMMANDS) == 14
    assert list(FILES) == ["rates.toml", "rates_fit.toml"]


def test_the_readme_is_short():
    """One page that links to the others; what needs room stands in docs/."""
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) < 150


def test_links_of_the_readme_lead_somewhere():
    links = re.findall(r"\]\(([^)#:]+)\)", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert len(links) > 20
    assert [link for link in links if not (ROOT / link).exists()] == []
