"""The arguments of `lgmd2jax predict FOLDER PROTOCOL -o CSV`."""

import argparse

from lgmd2jax.cli.options.output import new_file

_EXAMPLES = """\
examples:
  lgmd2jax predict dcmd looming -o curves.csv            a shipped fit, a shipped protocol
  lgmd2jax predict fits/mine unseen.toml -o unseen.csv   a result folder, a protocol of your own
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "predict",
        help="compute what a fitted model answers to other stimuli",
        description="Write the channel that was fitted (a firing rate with the gain, the latency and the smoothing of\n"
        "the fit) for every condition of a protocol, as a CSV file with the columns condition, time_ms, value.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("folder", metavar="FOLDER", help="the folder of a fit, or the name of a shipped one")
    parser.add_argument("protocol", metavar="PROTOCOL", help="a TOML file, or the name of a shipped protocol")
    parser.add_argument("-o", "--output", type=new_file, metavar="CSV", required=True, help="the file to write")
