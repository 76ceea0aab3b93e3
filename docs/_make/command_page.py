"""The page of the command line, from what argparse knows of it."""

import argparse

from lgmd2jax.cli.main import _parser

_INTRODUCTION = """\
# Command line

`lgmd2jax COMMAND --help` prints what stands here. A model, a protocol or a recipe is named by its path, or, where it is
shipped, by its bare name: `lgmd2jax fit dcmd`. Every command also takes `--traceback` and `--no-compilation-cache`.
"""
_EVERYWHERE = ("help", "traceback", "no_compilation_cache")  # arguments of every command


def command_page() -> str:
    """Each command with its description, arguments and examples."""
    parser = _parser()
    parts = [_INTRODUCTION, _fence(parser.epilog)]
    (commands,) = (it for it in parser._actions if isinstance(it, argparse._SubParsersAction))
    for name, command in commands.choices.items():
        parts += [f"## lgmd2jax {name}", command.description or "", _fence(command.format_usage()), _table(command)]
        parts += [_fence(command.epilog)] if command.epilog else []
    return "\n\n".join(parts)


def _fence(text: str | None) -> str:
    return f"```text\n{(text or '').strip()}\n```"


def _table(command: argparse.ArgumentParser) -> str:
    rows = ["| argument | meaning |", "|---|---|"]
    for action in command._actions:
        if action.dest in _EVERYWHERE:
            continue
        formatter = command._get_formatter()
        written = ", ".join(action.option_strings) or formatter._metavar_formatter(action, action.dest)(1)[0]
        if action.option_strings and action.nargs != 0:
            written += " " + formatter._format_args(action, action.dest.upper())
        meaning = formatter._expand_help(action) if action.help else ""
        rows.append(f"| `{_plain(written)}` | {_cell(meaning)} |")
    return "\n".join(rows)


def _plain(value) -> str:
    return str(value).replace("|", "\\|")


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*").replace("_", "\\_")
