"""The figure of recorded trials: what is drawn where."""

import contextlib

import numpy as np
from matplotlib.figure import Figure

import lgmd2jax as lgmd
from lgmd2jax._figures import trials as module


def test_animals_are_named_beside_their_trials_and_all_rates_lie_within_the_axes(monkeypatch):
    made = []

    @contextlib.contextmanager
    def drawn(path, width, height):
        made.append(Figure(figsize=(width, height)))
        yield made[0]

    monkeypatch.setattr(module, "drawn", drawn)
    spikes = {10.0: np.arange(-200.0, 0, 40), 20.0: np.arange(-200.0, 0, 4)}  # the second condition has more
    trials = lgmd.Trials(
        tuple(
            lgmd.Trial(animal, str(number), {"l_over_v": speed}, times, -400, 100)
            for animal, count in (("Mia", 3), ("Nox", 1))
            for number in range(count)
            for speed, times in spikes.items()
        )
    )
    module.trials_figure("any.png", trials)
    rasters, rates = np.reshape(made[0].axes, (2, 2))
    for axes in rasters:
        assert [label.get_text() for label in axes.get_yticklabels()] == ["Mia", "Nox"]
        np.testing.assert_allclose(axes.get_yticks(), [1, 3])  # the middles of rows 0 to 2, and of row 3
    for axes in rates:
        low, high = axes.get_ylim()
        for line in axes.get_lines()[:-1]:  # the last is the event
            assert low <= np.min(line.get_ydata())
            assert np.max(line.get_ydata()) <= high
