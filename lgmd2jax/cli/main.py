"""The command line: `lgmd2jax COMMAND ...`. Each command reads, calls the library, and names what it wrote."""

import argparse
import contextlib
import gc
import importlib
import io
import os
import sys
import traceback
import warnings
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

from lgmd2jax._compute.kept_programs import keep_programs
from lgmd2jax._compute.xla import set_flags
from lgmd2jax._ctrl_c import STOPPED, ended_by_ctrl_c, interrupted_by_ctrl_c
from lgmd2jax._files.written import noted
from lgmd2jax._words import Remark, is_refusal
from lgmd2jax.cli.options import (
    arena,
    calibrate,
    characterise,
    compare,
    export,
    fit,
    import_trials,
    live,
    looming,
    predict,
    respond,
    stimuli,
    sweep,
    watch,
)
from lgmd2jax.cli.warning import warn

_COMMANDS = (
    respond,
    live,
    watch,
    import_trials,
    looming,
    fit,
    calibrate,
    predict,
    compare,
    characterise,
    sweep,
    stimuli,
    arena,
    export,
)
_MODULES = {"import": "import_trials"}  # of commands whose name is none of a module
_EXAMPLES = """\
examples:
  lgmd2jax respond crash.mp4        run the paper's model on a video
  lgmd2jax stimuli looming          draw the stimuli of a shipped protocol
  lgmd2jax fit twin                 fit a model by a shipped recipe
  lgmd2jax respond --help           what a command takes, with examples

environment:
  JAX_COMPILATION_CACHE_DIR             where compiled programs are kept; by default the user's folder for caches
  JAX_ENABLE_COMPILATION_CACHE=false    the same as --no-compilation-cache

exit status:
  0    done
  1    something that was given is wrong: one line says what, and how to mend it
  2    the command line is wrong
  70   a fault of lgmd2jax itself: please report it, with what --traceback shows
  130  stopped by Ctrl-C
  141  nobody reads the output any more, as behind | head
"""


class _Parser(argparse.ArgumentParser):
    """Keeps the lines of its examples, and says what is wrong in one line, as the commands do, not the usage again."""

    def __init__(self, **settings):
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **settings)
        self.add_argument(
            "--traceback",
            action="store_true",
            default=argparse.SUPPRESS,  # so that it may stand before the command or after it
            help="in an error, also show where in the program it arose",
        )
        self.add_argument(
            "--no-compilation-cache",
            action="store_true",
            default=argparse.SUPPRESS,
            help="neither read nor keep compiled programs, which make later starts faster",
        )

    def error(self, message):
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit status: 0, else with one line on standard error.

    **Arguments:** `arguments`: what follows `lgmd2jax`; None: those of the process, which is this program then.

    **Raises:** `SystemExit` for `--help`, `--version`, and what argparse refuses.
    """
    whole = arguments is None
    if whole and isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names that the terminal cannot show, as standard error does
    options = argparse.Namespace(traceback=False, no_compilation_cache=False)
    written = noted()
    try:
        _check_names(sys.argv[1:] if arguments is None else arguments)
        with _remarks_as_lines():
            with _beginning() if whole else contextlib.nullcontext():
                _parser().parse_args(arguments, options)
                command = _loaded(options.command, keep=not options.no_compilation_cache)
            with interrupted_by_ctrl_c() if whole else contextlib.nullcontext():
                command.run(options)
                print(end="", flush=True)  # so that a reader that has gone is known here, and not when Python ends
    except (Exception, KeyboardInterrupt) as error:
        if type(error) is BrokenPipeError:  # of Python's own output; ffmpeg's is a subclass
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # for what is left to be written
            return 141
        if options.traceback:
            traceback.print_exception(error)
        message, status = _explanation(error, written)
        print(f"lgmd2jax: {' '.join(message.split())}", file=sys.stderr)
        return status
    return 0


def _check_names(words: list[str]) -> None:
    """Raise `ValueError` for a word that no report and no figure can show: the name of a file that is not in UTF-8."""
    for word in words:
        if any("\udc80" <= letter <= "\udcff" for letter in word):
            raise ValueError(f"{word!a} is no name in UTF-8, in which results are written; rename it")


@contextlib.contextmanager
def _remarks_as_lines() -> Iterator[None]:
    """Within the block a `Remark`, or another warning for the user, is one line, as the commands' own warnings are."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", Remark)
        show = warnings.showwarning

        def line(message, category, *place, **rest):
            if issubclass(category, Remark) or category is UserWarning:
                warn(message)
            else:
                show(message, category, *place, **rest)

        warnings.showwarning = line
        yield


def _parser() -> _Parser:
    parser = _Parser(
        prog="lgmd2jax",
        description="The LGMD2 collision detector of juvenile locusts: run it on video, fit it, hand it over.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {version('lgmd2jax')}")
    commands = parser.add_subparsers(dest="command", title="commands", metavar="COMMAND", required=True)
    for command in _COMMANDS:
        command.add(commands)
    return parser


@contextlib.contextmanager
def _beginning() -> Iterator[None]:
    """Within the block Ctrl-C ends the process, and what is made is never looked through for garbage.

    Modules stay: looking through them again and again takes a tenth of a short command.
    """
    gc.disable()
    try:
        with ended_by_ctrl_c():
            yield
    finally:
        gc.freeze()
        gc.enable()


def _loaded(command: str, *, keep: bool) -> ModuleType:
    """The module of a command, with JAX, which takes seconds: not to be waited for by who asks for help."""
    set_flags()
    if keep:
        keep_programs()
    else:
        os.environ["JAX_ENABLE_COMPILATION_CACHE"] = "false"
    import jax

    jax.config.update("jax_enable_x64", True)
    return importlib.import_module(f"lgmd2jax.cli.{_MODULES.get(command, command)}")


def _explanation(error: BaseException, written: Sequence[Path]) -> tuple[str, int]:
    """What is said of an error, and the exit status."""
    if isinstance(error, KeyboardInterrupt):
        return f"stopped; wrote {', '.join(map(str, written))}" if written else STOPPED, 130
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror, 1
    if isinstance(error, OSError) or is_refusal(error):
        return str(error), 1
    return f"internal error, {type(error).__name__}: {error}; please report it, with what --traceback shows", 70
