"""The command line: `lgmd2jax COMMAND ...`, a module a command."""

from lgmd2jax.cli.main import main as main
