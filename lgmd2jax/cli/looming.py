"""`lgmd2jax looming DATA`: the law of peak times straight from recorded trials."""

import argparse
import json

from lgmd2jax._files.atomic import all_replaced
from lgmd2jax.cli.trials_data import trials_of


def run(options: argparse.Namespace) -> None:
    """Estimate the law, write what was asked for, and print the table."""
    from lgmd2jax._figures.looming import looming_figure
    from lgmd2jax._figures.style import check_figure_path

    if options.figure:
        check_figure_path(options.figure)
    outputs = [path for path in (options.json, options.figure) if path is not None]
    with all_replaced(outputs, options.data) as files:
        law = trials_of(options).looming_law(options.kernel_ms, resamples=options.resamples, seed=options.seed)
        if options.json:
            text = json.dumps(law.plain(), indent=1, allow_nan=False, ensure_ascii=False)
            files[options.json].write_text(text + "\n", encoding="utf-8")
        if options.figure:
            looming_figure(files[options.figure], law)
    print(law.summary())
    if outputs:
        print("\nwrote " + ", ".join(map(str, outputs)))
