"""How recorded trials are named, and what their files do not tell."""

import argparse


def add_trials(parser: argparse.ArgumentParser) -> None:
    """The argument DATA, and options for what cannot be read from it."""
    parser.add_argument(
        "data",
        metavar="DATA",
        nargs="+",
        help="a file of CSV, Excel, Matlab, NWB, Spike2 text or what Neo reads, or a folder of text files",
    )
    parser.add_argument(
        "--time-unit", choices=("ms", "s", "us"), help="the unit of all times, where no header states it"
    )
    parser.add_argument("--animal", metavar="COLUMN", help="the column of the animals, or the name of the only one")
    parser.add_argument("--session", metavar="COLUMN", help="the column of the recordings of an animal")
    parser.add_argument("--trial", metavar="COLUMN", help="the column of the trials")
    parser.add_argument("--time", metavar="COLUMN", help="the column of the spike times")
    parser.add_argument("--l-over-v", metavar="COLUMN", help="the column of l/|v|, or its value in ms")
    parser.add_argument("--event", metavar="COLUMN", help="the column, channel or event of the collision")
    parser.add_argument(
        "--conditions", metavar="COLUMN", nargs="+", default=[], help="further columns that tell stimuli apart"
    )
    parser.add_argument(
        "--window", metavar="MS", type=float, nargs=2, help="start and end of each trial in ms from collision"
    )
    parser.add_argument("--separator", metavar="SIGN", help="between the cells of a text file (default: found)")
    parser.add_argument(
        "--decimal", choices=(".", ","), metavar="SIGN", help="the decimal sign of a text file, . or , (default: found)"
    )
    parser.add_argument("--unit", metavar="NAME", help="the neuron to read, of a file that holds several")
