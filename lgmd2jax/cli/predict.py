"""`lgmd2jax predict FOLDER PROTOCOL -o CSV`: what a fitted model answers to other stimuli."""

import argparse
import csv
from pathlib import Path

from tqdm import tqdm

from lgmd2jax._files.atomic import replaced
from lgmd2jax._protocol.protocol import load_protocol
from lgmd2jax._results.fit_folder import load_fit

_EXAMPLES = """\
examples:
  lgmd2jax predict dcmd looming -o curves.csv            a shipped fit, a shipped protocol
  lgmd2jax predict fits/mine unseen.toml -o unseen.csv   a result folder, a protocol of your own
"""


def add(commands) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "predict",
        help="the fitted curve for other stimuli",
        description="Write the fitted channel (a rate through its observation model) for every condition of a "
        "protocol, as a CSV file with the columns condition, time_ms, value.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("folder", metavar="FOLDER", help="the folder of a fit, or the name of a shipped one")
    parser.add_argument("protocol", metavar="PROTOCOL", help="a TOML file, or the name of a shipped protocol")
    parser.add_argument("-o", "--output", type=Path, metavar="CSV", required=True, help="the file to write")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Predict every condition with the handed-over model."""
    fit, protocol = load_fit(options.folder), load_protocol(options.protocol)
    with replaced(options.output) as temporary, open(temporary, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["condition", "time_ms", "value"])
        for condition in tqdm(protocol.conditions, unit="condition", leave=False):
            stimulus = condition.render()
            for time, value in zip(stimulus.time, fit.predict(stimulus), strict=True):
                writer.writerow([condition.name, f"{float(time):.9g}", f"{value:.9g}"])
    print(f"wrote {options.output}: {fit.channels[0]} of {len(protocol.conditions)} conditions")
