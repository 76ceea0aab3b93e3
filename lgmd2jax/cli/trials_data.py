"""The recorded trials that a command line names."""

import argparse

from lgmd2jax._trials.load import load_trials
from lgmd2jax._trials.trials import Trials


def trials_of(options: argparse.Namespace) -> Trials:
    """The trials of DATA; what was noticed in its files is printed."""
    trials = load_trials(
        *options.data,
        time_unit=options.time_unit,
        animal=options.animal,
        session=options.session,
        trial=options.trial,
        time=options.time,
        l_over_v=options.l_over_v,
        event=options.event,
        conditions=options.conditions,
        window=None if options.window is None else tuple(options.window),
        separator=options.separator,
        decimal=options.decimal,
        unit=options.unit,
    )
    for remark in trials.remarks:
        print(f"note: {remark}")
    return trials
