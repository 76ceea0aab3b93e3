"""The arguments of `lgmd2jax looming DATA`."""

import argparse

from lgmd2jax.cli.options.output import new_file
from lgmd2jax.cli.options.trials_option import add_trials

_EXAMPLES = """\
examples:
  lgmd2jax looming spikes.csv                          columns animal, trial, l_over_v_ms, spike_ms; a row a spike
  lgmd2jax looming recordings/                         trials.csv and spikes.csv of a session's clock
  lgmd2jax looming trials.txt --time-unit s            a column a trial, named A_lv20_trial3
  lgmd2jax looming spikes.csv --json law.json --figure law.png

The unit of the times must stand in the name of their column, as spike_ms or "time (s)", or be given: seconds are never
taken for milliseconds. Times count from collision, or from the column --event, such as impact_s.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "looming",
        help="the law of peak times of recorded trials: alpha, delta and the threshold angle",
        description="Fit the law of peak times to recorded trials, for each animal and for all:\n"
        "collision - peak = alpha l/|v| - delta, with the threshold angle 2 atan(1/alpha), r2, intervals by bootstrap\n"
        "over trials, and what was left out by which rule.",
        epilog=_EXAMPLES,
    )
    add_trials(parser)
    parser.add_argument("--json", type=new_file, metavar="FILE", help="also write all values")
    parser.add_argument("--figure", type=new_file, metavar="FILE", help="also draw the lines")
    parser.add_argument(
        "--kernel-ms",
        type=float,
        metavar="MS",
        help="s.d. of the Gaussian that makes rates, of which the peak is timed (default: a kernel of sixth order, "
        "whose width follows l/|v|)",
    )
    parser.add_argument("--resamples", type=int, default=1000, metavar="N", help="bootstrap samples (default: 1000)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the bootstrap (default: 0)")
