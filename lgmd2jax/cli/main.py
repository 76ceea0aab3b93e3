"""The command line: `lgmd2jax COMMAND ...`. Each command reads, calls the library, and names what it wrote."""

import argparse
import sys

import jax

from lgmd2jax._compute.xla import set_flags
from lgmd2jax._video.remarks import clip_warnings_as_lines
from lgmd2jax.cli import (
    characterise as _command_characterise,
    export as _command_export,
    fit as _command_fit,
    predict as _command_predict,
    respond as _command_respond,
    stimuli as _command_stimuli,
    sweep as _command_sweep,
    watch as _command_watch,
)


class _Parser(argparse.ArgumentParser):
    """Keeps the lines of its examples, and says what is wrong in one line, as the commands do, not the usage again."""

    def __init__(self, **settings):
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **settings)

    def error(self, message):
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit status: 0, else with one line on standard error."""
    parser = _Parser(prog="lgmd2jax", description="The LGMD2 collision detector of juvenile locusts.")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in (
        _command_respond,
        _command_watch,
        _command_fit,
        _command_predict,
        _command_characterise,
        _command_sweep,
        _command_stimuli,
        _command_export,
    ):
        command.add(commands)
    options = parser.parse_args(arguments)
    set_flags()
    jax.config.update("jax_enable_x64", True)
    try:
        with clip_warnings_as_lines():
            options.run(options)
    except (ValueError, OSError) as error:
        print(f"lgmd2jax: {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("lgmd2jax: stopped; nothing was written", file=sys.stderr)
        return 130
    return 0
