"""Collisions, coverage and the choice among candidates, by hand."""

import dataclasses
import json

import numpy as np
import pytest

from lgmd2jax._files.catalogue import folder
from lgmd2jax.arena import Budget, Layout, Outcome, Space, random_layout
from lgmd2jax.arena._layout import FEWEST, GAP_CM, MOST, SIDE_CM
from lgmd2jax.arena._scores import share_visited
from lgmd2jax.arena._settings import SETTINGS
from lgmd2jax.arena._training import BUDGET, FIRST_SEED, SPACES, Range, ranking


def outcome(contacts, metres, share):
    return Outcome(np.array(contacts), np.zeros(len(contacts), int), np.array(metres), np.array(share))


def test_collisions_are_all_by_all_metres_with_an_interval_around():
    some = outcome([0, 3, 1, 2], [1.0, 3.0, 2.0, 2.0], [0.1, 0.2, 0.3, 0.2])
    rate = some.collisions_per_metre
    assert rate.value == 6 / 8
    assert 0 < rate.low < rate.value < rate.high <= 1
    assert some.coverage.value == pytest.approx(0.2)
    twice = outcome([0, 6, 2, 4], [1.0, 3.0, 2.0, 2.0], [0.05, 0.1, 0.15, 0.1])
    assert tuple(twice.collisions_by(some)) == pytest.approx((2, 2, 2))  # arena by arena
    assert tuple(twice.coverage_by(some)) == pytest.approx((0.5, 0.5, 0.5))


def test_the_interval_is_as_wide_as_theory_has_it():
    share = np.random.default_rng(0).normal(0.3, 0.05, 400)
    coverage = outcome(np.ones(400, int), np.ones(400), share).coverage
    half_width = 1.96 * share.std() / 20
    assert (coverage.high - coverage.low) / 2 == pytest.approx(half_width, rel=0.1)


def test_the_floor_counts_where_the_robot_fits():
    layout = random_layout(0)
    empty = Layout(np.empty((0, 2)), np.empty(0), layout.patches, layout.start, 0.0, 0.0, 0.0, 100.0, 0.0)
    cells = (SIDE_CM / 5) ** 2
    assert share_visited(empty, np.array([[7.0, 7.0], [8.0, 9.0], [12.0, 7.0]])) == 2 / cells
    middle = np.stack(np.meshgrid(*2 * [np.arange(2.5, SIDE_CM, 5)]), axis=-1).reshape(-1, 2)
    assert share_visited(empty, middle) == 1
    assert share_visited(layout, middle[layout.free(middle)]) == 1


def test_arenas_are_those_of_the_paper():
    for seed in range(20):
        layout = random_layout(seed)
        assert FEWEST <= len(layout.radii) <= MOST
        apart = np.linalg.norm(layout.centres[:, None] - layout.centres, axis=2) - layout.radii - layout.radii[:, None]
        assert (apart[~np.eye(len(apart), dtype=bool)] >= GAP_CM).all()
        assert layout.free(layout.start[None]).all()
        again = random_layout(seed)
        np.testing.assert_array_equal(layout.patches, again.patches)
        assert (layout.heading, layout.noise) == (again.heading, again.noise)


def test_the_fewest_collisions_count_among_those_that_cover_enough():
    outcomes = [outcome([contacts], [1.0], [share]) for contacts, share in ((0, 0.1), (2, 0.9), (1, 0.8), (0, 0.2))]
    assert ranking(outcomes, 0.75) == [2, 1, 3, 0]


def test_ranges_are_searched_to_their_ends():
    ends = np.array([0.0, 1 - 1e-9])
    np.testing.assert_allclose(Range(2, 8).at(ends), [2, 8])
    np.testing.assert_allclose(Range(2, 8, log=True).at(ends), [2, 8])
    assert Range(2, 8, whole=True).at(ends).tolist() == [2, 8]


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Range(3, 2), "the first must be below the second"),
        (lambda: Range(0, 2, log=True), "must be positive"),
        (lambda: Budget(arenas=0), "arenas is 0; give 1 or more"),
        (lambda: Budget(candidates=4), "finalists is 6; give no more than the 4 candidates"),
        (lambda: Space("preset:lgmd2", {}).detector({"t_sp": 0.7}), "ranges has 't_sp'; choose 'T_sp'"),
        (lambda: Space(None, {}).detector({"T_sp": 0.7}), "ranges has 'T_sp'; choose 'threshold'"),
    ],
)
def test_what_cannot_be_searched_is_refused(make, told):
    with pytest.raises(ValueError, match=told):
        make()


def test_the_shipped_settings_lie_in_their_ranges_and_were_chosen_by_one_budget():
    known = json.loads((folder("fits") / SETTINGS).read_text())
    assert set(known) == set(SPACES)
    assert all(each["budget"] == dataclasses.asdict(BUDGET) for each in known.values())
    assert FIRST_SEED >= 1_000_000
    for name, each in known.items():
        assert set(each["settings"]) == set(SPACES[name].ranges)
        for parameter, value in each["settings"].items():
            within = SPACES[name].ranges[parameter]
            assert 0.999 * within.low <= value <= 1.001 * within.high
