"""The command line as a whole: light help, exit statuses, mistakes told from faults, Ctrl-C."""

import importlib
import os
import re
import signal
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

import lgmd2jax as lgmd
from lgmd2jax._video.clip_files import FORMS
from lgmd2jax.alarms import load_labels
from lgmd2jax.cli import export as command, main
from lgmd2jax.cli.main import _COMMANDS, _MODULES
from lgmd2jax.cli.options import stimuli as stimuli_options

_NAMES_OF_MODULES = {module: name for name, module in _MODULES.items()}
MODULES = [each.__name__.rpartition(".")[2] for each in _COMMANDS]
NAMES = [_NAMES_OF_MODULES.get(module, module) for module in MODULES]


def in_a_process(program):
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)


def test_help_and_version_load_nothing_heavy():
    program = f"""
import sys
from lgmd2jax.cli import main
for line in (["--help"], ["--version"], ["fit"], *([name, "--help"] for name in {NAMES})):
    try:
        main(line)
    except SystemExit as end:
        assert end.code == (2 if line == ["fit"] else 0), line
assert not {{"jax", "numpy", "tqdm", "matplotlib"}} & set(sys.modules), set(sys.modules)
"""
    process = in_a_process(program)
    assert process.returncode == 0, process.stderr
    assert f"\nlgmd2jax {version('lgmd2jax')}\n" in process.stdout


def test_the_module_of_a_command_has_its_name():
    for name in MODULES:
        assert callable(importlib.import_module(f"lgmd2jax.cli.{name}").run)


def test_the_forms_of_a_clip_are_those_that_are_written():
    assert set(stimuli_options.FORMS) == set(FORMS)


@pytest.mark.parametrize("name", NAMES)
def test_help_fits_a_screen_and_its_examples_are_of_this_command(name, capsys):
    with pytest.raises(SystemExit, match="0"):
        main([name, "--help"])
    text = capsys.readouterr().out
    examples = text.partition("examples:\n")[2].partition("\n\n")[0]
    assert re.findall(r"^  lgmd2jax (\w+)", examples, re.MULTILINE)
    assert set(re.findall(r"^  lgmd2jax (\w+)", examples, re.MULTILINE)) == {name}
    assert max(map(len, text.splitlines())) <= 120


LOADERS = {"fit": lgmd.load_recipe, "sweep": lgmd.load_recipe, "stimuli": lgmd.load_protocol, "watch": load_labels}


@pytest.mark.parametrize("name", LOADERS)
def test_the_file_that_help_shows_loads(name, tmp_path, capsys):
    with pytest.raises(SystemExit, match="0"):
        main([name, "--help"])
    (content,) = re.findall(r"^A .*\bfile.*:\n((?:  .*\n)+)", capsys.readouterr().out, flags=re.MULTILINE)
    (tmp_path / "mine.toml").write_text(content.replace("mine-stimuli.toml", "lgmd2"))
    (tmp_path / "crash.mp4").touch()
    assert LOADERS[name](tmp_path / "mine.toml").name == "mine"


# Flags


def test_xla_is_told_before_jax_begins_to_load(tmp_path):
    program = f"""
import os, sys
os.environ.pop("XLA_FLAGS", None)

class Witness:
    def find_spec(name, *_):
        if name == "jax":
            print("XLA_FLAGS", os.environ.get("XLA_FLAGS"))

sys.meta_path.insert(0, Witness)
from lgmd2jax.cli import main
raise SystemExit(main(["export", "preset:lgmd2", "--python", {str(tmp_path)!r}]))
"""
    process = in_a_process(program)
    assert process.returncode == 0, process.stderr
    assert process.stdout.startswith("XLA_FLAGS --xla_backend_extra_options=")


# Errors


def runs(monkeypatch, body):
    """Let `export` run a line as if it stood in the library, which is what its module's name says."""
    place = {"__name__": "lgmd2jax.made_up"}
    exec("import contextlib, jax, jax.numpy as jnp, numpy as np\ndef run(options):\n " + body, place)
    monkeypatch.setattr(command, "run", place["run"])


EXPORT = ["export", "preset:lgmd2", "--python", "robot"]
REFUSALS = {
    "a line of ours": "raise ValueError('k is -1;\\n give more')",
    "from another error": "\n try:\n  int('one')\n except ValueError as error:\n"
    "  raise ValueError('k is -1; give more') from error",
    "through with": "\n with contextlib.ExitStack() as stack:\n  stack.callback(print)\n"
    "  raise ValueError('k is -1; give more')",
    "under jit": "\n @jax.jit\n def f(x):\n  raise ValueError('k is -1; give more')\n f(1.0)",
    "in the files": "raise FileNotFoundError('k is -1; give more')",
}
FAULTS = {
    "of a reader": "\n from lgmd2jax._words import within\n with within('mine.toml'):\n  int('one')",
    "of a reader, a wrong type": "\n from lgmd2jax._words import within\n with within('mine.toml'):\n  len(3)",
    "Python's own": "int('one')",
    "of unpacking": "a, b = (1, 2, 3)",
    "NumPy's": "np.zeros(3).reshape(2)",
    "JAX's": "jnp.zeros(3).reshape(2)",
    "JAX's under jit": "jax.jit(lambda x: jnp.zeros(3).reshape(2))(1.0)",
    "another kind": "{}['k']",
}


@pytest.mark.parametrize("body", REFUSALS.values(), ids=REFUSALS)
def test_a_mistake_of_the_user_is_its_message_in_one_line(monkeypatch, capsys, body):
    runs(monkeypatch, body)
    assert main(EXPORT) == 1
    assert capsys.readouterr().err == "lgmd2jax: k is -1; give more\n"


@pytest.mark.parametrize("error", ["ValueError", "FileNotFoundError"])
def test_what_a_reader_refuses_names_its_file(monkeypatch, capsys, error):
    runs(monkeypatch, f"\n from lgmd2jax._words import within\n with within('mine.toml'):\n  raise {error}('k = -1')")
    assert main(EXPORT) == 1
    assert capsys.readouterr().err == "lgmd2jax: mine.toml: k = -1\n"


@pytest.mark.parametrize("body", FAULTS.values(), ids=FAULTS)
def test_a_fault_of_the_library_is_told_as_one(monkeypatch, capsys, body):
    runs(monkeypatch, body)
    assert main(EXPORT) == 70
    error = capsys.readouterr().err
    assert re.fullmatch(r"lgmd2jax: internal error, \w+: .+; please report it, with what --traceback shows\n", error)


@pytest.mark.parametrize("line", [["--traceback", *EXPORT], [*EXPORT, "--traceback"]])
@pytest.mark.parametrize(("body", "status"), [("raise ValueError('mine')", 1), ("int('one')", 70)])
def test_traceback_shows_where(monkeypatch, capsys, line, body, status):
    runs(monkeypatch, body)
    assert main(line) == status
    first, *_, last = capsys.readouterr().err.splitlines()
    assert first == "Traceback (most recent call last):"
    assert last.startswith("lgmd2jax: ")


def test_what_the_system_refuses_is_told_by_path_and_in_words(monkeypatch, capsys):
    runs(monkeypatch, "open('/proc/none/of/that')")
    assert main(EXPORT) == 1
    assert capsys.readouterr().err == "lgmd2jax: /proc/none/of/that: No such file or directory\n"


def exported(name):
    """A program that exports to a folder of this name."""
    arguments = ["export", "preset:lgmd2", "--python", name]
    return f"import sys; from lgmd2jax.cli import main; sys.argv[1:] = {arguments!a}; sys.exit(main())"


def test_a_reader_that_has_gone_is_no_error(tmp_path):
    """As behind `| head`: what was written for it is dropped, without a word."""
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-c", exported("robot")]
    with os.fdopen(write, "wb") as pipe:
        process = subprocess.run(command, cwd=tmp_path, stdout=pipe, stderr=subprocess.PIPE, text=True)
    assert (process.returncode, process.stderr) == (141, "")
    assert (tmp_path / "robot/model.json").is_file()


def test_a_name_that_the_terminal_cannot_show_is_no_error(tmp_path):
    environment, command = os.environ | {"PYTHONIOENCODING": "ascii"}, [sys.executable, "-c", exported("rob\xf3t")]
    process = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert (process.returncode, process.stderr) == (0, "")
    assert r"wrote rob\xf3t/model.json" in process.stdout
    assert (tmp_path / "rob\xf3t/model.json").is_file()


def test_a_name_that_is_not_in_utf_8_is_refused(tmp_path, capsys):
    """As from an old disk: neither a report nor a figure can hold it."""
    assert main(["export", "preset:lgmd2", "--python", str(tmp_path / "rob\udcf3t")]) == 1
    assert "rob\\udcf3t' is no name in UTF-8, in which results are written; rename it" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_the_library_itself_is_told_from_what_it_calls(tmp_path, capsys):
    """The same by real lines of it: a preset that is none, and a file that the system refuses to open."""
    assert main(["export", "preset:lgm2", "--python", str(tmp_path)]) == 1
    assert main(["predict", str(tmp_path), "looming", "-o", str(tmp_path / "a.csv")]) == 1
    assert "internal error" not in capsys.readouterr().err


# Ctrl-C


@pytest.mark.skipif(sys.platform == "win32", reason="signals are for POSIX systems")
@pytest.mark.parametrize("module", ["numpy", "numpy._core.multiarray", "jaxlib._jax", "equinox", "lgmd2jax.hard"])
def test_ctrl_c_while_modules_load_is_one_line(module, tmp_path):
    """Amid the set-up of an extension module an exception would be lost or crash the process."""
    program = f"""
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # which a job in the background ignores

class Hand:
    def find_spec(name, *_):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)

from lgmd2jax.cli import main
sys.meta_path.insert(0, Hand)
sys.argv = ["lgmd2jax", "export", "preset:lgmd2", "--python", {str(tmp_path / "robot")!r}]
raise SystemExit(main())
"""
    process = in_a_process(program)
    assert (process.returncode, process.stderr) == (130, "lgmd2jax: stopped; nothing was written\n")
    assert not (tmp_path / "robot").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="signals are for POSIX systems")
@pytest.mark.parametrize("module", ["lgmd2jax.cli", "argparse", "lgmd2jax.cli.options.sweep"])
def test_ctrl_c_before_the_command_line_is_read_is_one_line(module):
    """The installed program is the one that pyproject.toml states."""
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))
    begins, _, function = project["project"]["scripts"]["lgmd2jax"].partition(":")
    program = f"""
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)

class Hand:
    def find_spec(name, *_):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Hand)
from {begins} import {function}
sys.argv = ["lgmd2jax", "--version"]
raise SystemExit({function}())
"""
    process = in_a_process(program)
    assert (process.returncode, process.stdout) == (130, "")
    assert process.stderr == "lgmd2jax: stopped; nothing was written\n"


def test_ctrl_c_in_a_command_is_one_line_and_leaves_the_handler(monkeypatch, capsys):
    before = signal.getsignal(signal.SIGINT)
    runs(monkeypatch, "raise KeyboardInterrupt")
    monkeypatch.setattr(sys, "argv", ["lgmd2jax", *EXPORT])
    assert main() == 130
    assert capsys.readouterr().err == "lgmd2jax: stopped; nothing was written\n"
    assert signal.getsignal(signal.SIGINT) is before


def test_ctrl_c_after_files_are_written_names_them(monkeypatch, tmp_path, capsys):
    """Amid the last lines, when all that was asked for is there."""

    def press(*_):
        raise KeyboardInterrupt

    folder = tmp_path / "robot"
    with monkeypatch.context() as patched:
        patched.setattr(command, "print", press, raising=False)
        assert main(["export", "preset:lgmd2", "--python", str(folder)]) == 130
    said = f"lgmd2jax: stopped; wrote {folder / 'hard.py'}, {folder / 'model.json'}\n"
    assert capsys.readouterr().err == said
    runs(monkeypatch, "raise KeyboardInterrupt")
    assert main(EXPORT) == 130
    assert capsys.readouterr().err == "lgmd2jax: stopped; nothing was written\n"


@pytest.mark.parametrize("line", ["respond a.mp4 --csv out.csv/", "predict dcmd dcmd -o out/", "arena --figure a.png/"])
def test_a_file_to_write_has_no_name_of_a_folder(line, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(line.split())
    name = line.split()[-1]
    assert f": {name} is the name of a folder; give that of a file; see lgmd2jax" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="signals are for POSIX systems")
@pytest.mark.parametrize(
    "where",
    ["gc.callbacks.append(press); gc.collect()", "Finalized()", "weakref.ref(Plain(), press)"],
    ids=["collection", "finalizer", "weak reference"],
)
def test_ctrl_c_where_python_drops_exceptions_is_not_lost(where):
    """JAX has a callback of the collector, which took a Ctrl-C of a sweep."""
    program = """
import gc, os, signal, sys, time, weakref
signal.signal(signal.SIGINT, signal.default_int_handler)
from lgmd2jax.cli import export, main

def press(*_):
    if not pressed:
        pressed.append(True)
        os.kill(os.getpid(), signal.SIGINT)

class Plain:
    pass

class Finalized:
    __del__ = press

def run(options):
    WHERE
    for _ in range(1000):
        time.sleep(0.01)
    print("it went on")

pressed, export.run = [], run
sys.argv = ["lgmd2jax", "export", "preset:lgmd2", "--python", "nowhere"]
raise SystemExit(main())
"""
    process = in_a_process(program.replace("WHERE", where))
    assert (process.returncode, process.stdout) == (130, "")
    assert process.stderr == "lgmd2jax: stopped; nothing was written\n"


def test_it_runs_as_a_module(tmp_path):
    line = [sys.executable, "-m", "lgmd2jax.cli", "--version"]
    assert (
        subprocess.run(line, capture_output=True, text=True, check=True).stdout == f"lgmd2jax {version('lgmd2jax')}\n"
    )


@pytest.mark.parametrize("arguments", ["", '["looming", "--help"]'])
def test_only_the_program_itself_spares_what_it_loads_the_search_for_garbage(arguments):
    program = f"""
import gc, sys
from lgmd2jax.cli import main
sys.argv = ["lgmd2jax", "looming", "--help"]
try:
    main({arguments})
except SystemExit:
    print(gc.isenabled(), gc.get_freeze_count() > 0)
"""
    assert in_a_process(program).stdout.splitlines()[-1] == f"True {not arguments}"
