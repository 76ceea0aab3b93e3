"""`lgmd2jax predict FOLDER PROTOCOL -o CSV`: what a fitted model answers to other stimuli."""

import argparse
import csv

from tqdm import tqdm

from lgmd2jax._files.atomic import replaced
from lgmd2jax._protocol.protocol import load_protocol
from lgmd2jax._results.fit_folder import load_fit


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
