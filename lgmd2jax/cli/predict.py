"""`lgmd2jax predict FOLDER PROTOCOL -o CSV`: what a fitted model answers to other stimuli."""

import argparse
import contextlib
import csv

from tqdm import tqdm

from lgmd2jax._files.atomic import all_replaced
from lgmd2jax._protocol.protocol import load_protocol
from lgmd2jax._results.fit_folder import load_fit


def run(options: argparse.Namespace) -> None:
    """Predict every condition with the handed-over model."""
    fit, protocol = load_fit(options.folder), load_protocol(options.protocol)
    with contextlib.ExitStack() as stack:
        files = stack.enter_context(all_replaced([options.output], [options.protocol]))
        writer = csv.writer(stack.enter_context(open(files[options.output], "w", newline="", encoding="utf-8")))
        writer.writerow(["condition", "time_ms", "value"])
        for condition in tqdm(protocol.conditions, unit="condition", leave=False):
            stimulus = condition.render()
            for time, value in zip(stimulus.time, fit.predict(stimulus), strict=True):
                writer.writerow([condition.name, f"{float(time):.9g}", f"{value:.9g}"])
    print(f"wrote {options.output}: {fit.channels[0]} of {len(protocol.conditions)} conditions")
