"""How the model of a command is named."""

import argparse

MODEL_HELP = "a result folder or its model.json, the name of a shipped fit, or preset:NAME"


def add_model(parser: argparse.ArgumentParser) -> None:
    """The options --model and --set."""
    parser.add_argument("--model", default="preset:lgmd2", help=f"{MODEL_HELP} (default: %(default)s)")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="set one parameter of the model, such as T_sp=.65; may be given again for another",
    )
