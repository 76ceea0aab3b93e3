"""The arguments of `lgmd2jax compare FIT FIT ...`."""

import argparse

from lgmd2jax.cli.options.output import new_file

_EXAMPLES = """\
examples:
  lgmd2jax compare results/plain results/size results/shunt --figure circuits.png
  lgmd2jax compare plain size --properties --csv circuits.csv     also how many of the 22 properties each model holds

AIC and BIC are given for recordings only, of residuals that are thinned to independent ones: where the targets have
standard errors of their own and a correlation_ms. R2 of conditions that were left out is given for fits whose recipe
asks for it ([validation] leave_one_out).
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "compare",
        help="compare fits to the same data",
        description="Compare fits to the same stimuli and targets: chi2 and R2 of each curve and in all,\n"
        "parameters with their errors, R2 of conditions that were left out, AIC and BIC.",
        epilog=_EXAMPLES,
    )
    parser.add_argument(
        "fits", metavar="FIT", nargs="+", help="the folder of a fit, its fit.json, or the name of a shipped one"
    )
    parser.add_argument("--properties", action="store_true", help="also count the response properties of each model")
    parser.add_argument("--json", type=new_file, metavar="FILE", help="also write all numbers, by fit")
    parser.add_argument(
        "--csv", type=new_file, metavar="FILE", help="also write all numbers as a table, a column a fit"
    )
    parser.add_argument("--figure", type=new_file, metavar="FILE", help="also draw them, one colour a fit")
