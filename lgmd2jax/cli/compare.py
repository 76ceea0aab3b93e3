"""`lgmd2jax compare FIT FIT ...`: fits to the same data side by side."""

import argparse

from lgmd2jax._files.atomic import all_replaced
from lgmd2jax._results.comparison import compare, write_csv, write_json


def run(options: argparse.Namespace) -> None:
    """Compare the fits, write what was asked for, and print the tables."""
    from lgmd2jax._figures.comparison import comparison_figure
    from lgmd2jax._figures.style import check_figure_path

    if options.figure:
        check_figure_path(options.figure)
    writers = ((options.json, write_json), (options.csv, write_csv), (options.figure, comparison_figure))
    writers = [(path, write) for path, write in writers if path is not None]
    with all_replaced(path for path, _ in writers) as files:
        comparison = compare(options.fits, properties=options.properties, progress=True)
        for path, write in writers:
            write(files[path], comparison)
    print(comparison.summary())
    if writers:
        print("\nwrote " + ", ".join(str(path) for path, _ in writers))
