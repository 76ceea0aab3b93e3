"""The arguments of `lgmd2jax arena`."""

import argparse

from lgmd2jax.cli.options.model_option import MODEL_HELP
from lgmd2jax.cli.options.output import new_file

_EXAMPLES = """\
examples:
  lgmd2jax arena                                  20 arenas, each with a robot of each detector
  lgmd2jax arena --seeds 100 --json arena.json    100 arenas, and the numbers as a file
  lgmd2jax arena --figure arena.png               also four arenas from above, with trajectories of the fitted model
  lgmd2jax arena --turn away                      turn away from the side of more evidence, not at random
  lgmd2jax arena --model mine/model.json          a model of your own in the place of the fitted one

The world is the paper's: 110 x 110 cm, white walls and 10 to 20 cylinders with dense dark patterns, a robot of 4 cm, a
camera of 72 x 99 pixels, 70 degrees wide, at 30 frames a second, for a minute. The robot drives on until an alarm or a
contact, turns by 180 to 270 degrees to a random side, and drives on. The paper gives no speed: it is 6 cm/s here.
Patterns, noise and flicker of the light are random too. A contact counts once; in a turn no alarm counts.

Detectors: none; table1, the paper's model; lgmd2, the fitted one; lgmd1, that of Yue & Rind; difference, a threshold on
the mean change of the image. The settings of all four were chosen by one rule out of as many candidates (Table I's
within its ranges) in arenas of other seeds than those of the evaluation: fits/arena/detectors.json, written by
python -m benchmarks.arena --train. A model that you name is taken to the robot's camera and left as it is.

Intervals are of 95 %, by bootstrap over arenas. Coverage is the share of the free floor's cells of 5 cm that the robot
came to, so that one that spins wins nothing. Beside each number stands its ratio to that of the robot without a
detector in the same arenas.
"""


def add(commands: argparse._SubParsersAction) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "arena",
        help="let a robot drive by the alarms of models, and count its collisions",
        description="Let a robot drive by the alarms of each detector in random arenas: collisions and coverage.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("--seeds", type=int, default=20, metavar="N", help="how many arenas (default: %(default)s)")
    parser.add_argument(
        "--seconds", type=float, default=60.0, metavar="S", help="duration of a trip (default: %(default)g)"
    )
    parser.add_argument(
        "--model",
        metavar="MODEL",
        help=f"the model in the place of the fitted one: {MODEL_HELP}",
    )
    parser.add_argument(
        "--turn",
        choices=("random", "away"),
        default="random",
        help="where the robot turns at an alarm: to a random side, or away from the side of more evidence by 45 to "
        "135 degrees (default: %(default)s)",
    )
    parser.add_argument("--json", type=new_file, metavar="FILE", help="also write the numbers, by detector")
    parser.add_argument("--figure", type=new_file, metavar="FILE", help="also draw trajectories in the first arenas")
