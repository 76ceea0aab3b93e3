"""Every row on a signal that is made to pass and on ones that are made to fail it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.curves import normalise
from lgmd2jax._characterise.properties import ROWS
from lgmd2jax._characterise.row import EVIDENCE
from lgmd2jax._characterise.trials import textured
from lgmd2jax._characterise.verdicts import judge
from tests.characterise.signals import (
    EXAM,
    before_adaptation,
    bump,
    eta,
    examine,
    ideal,
    onset,
    plus,
    potentials,
    step,
)


def looms(signal):
    """Another answer to all approaches of row 1, and to the same ones at the finer frame rate."""
    names = [(speed, fine) for speed in trials.L_OVER_V for fine in (False, True)[: 1 + (speed in trials.FINE_RATES)]]
    return {trials.loom(speed, fine): signal(speed) for speed, fine in names}


def two_thirds(speed):
    """Peaks as of a threshold on the swept area: -(l/|v|)^(2/3), for which r2 of the straight line is .99."""
    return bump(-11 * speed ** (2 / 3), (speed / 40) ** -0.1, 2 * speed)


# What is spoilt, and the row that must tell it, beyond the bounds of `test_bounds`. Other rows may tell it as well.
SPOILT = [
    (1, "two-thirds law", looms(two_thirds)),
    (3, "angle not the same", looms(two_thirds)),
    (4, "second peak after", {trials.loom(80.0): plus(eta(80.0, 0.93), bump(-140.0, 0.4, 15.0))}),
    (4, "second peak before", {trials.loom(80.0): plus(eta(80.0, 0.93), bump(-3000.0, 0.4, 30.0))}),
    (5, "symmetric", looms(lambda speed: bump(28.7 - 4.4 * speed, (speed / 40) ** -0.1, 4.1 * speed))),
    (10, "late", {trials.RECESSION: bump(1000.0, 0.15, 20.0)}),
    (12, "the other edge alone", {trials.bar("dark", True): onset(0.0, 200.0)}),
    (16, "one of the gratings", {trials.grating(0.2, 10.0): step(0.15, 300.0, 2000.0)}),
    (18, "earlier for one contrast", {trials.contrast(-0.3): eta(40.0, 0.8, delta=-20.0)}),
    (21, "misses as strong", {trials.deviating(degrees): eta(40.0) for degrees in trials.DEVIATIONS}),
    (22, "shifted", {trials.loom(80.0, fine=True): eta(80.0, 0.93, delta=40.0)}),
]


def rows_that_hold(measurements):
    return {row.number for row, passed in zip(ROWS, measurements.passed, strict=True) if passed}


def test_the_exam_has_22_rows():
    assert [row.number for row in ROWS] == list(range(1, 23))
    assert {row.number for row in ROWS if row.neuron == "LGMD2"} == {9, 10, 11, 12}
    assert [row.number for row in ROWS if row.holds_if == "any line holds"] == [1]
    for row in ROWS:
        assert any(line.judged for line in row.lines)
        assert len({line.label for line in row.lines}) == len(row.lines)
        assert set("".join(line.evidence for line in row.lines)) <= set(EVIDENCE)


def listed(values) -> str:
    return ", ".join(f"{value:g}".replace("0.", ".") for value in values)


STATED = {
    1: f"{trials.L_OVER_V[0]:g} to {trials.L_OVER_V[-1]:g} ms",
    15: f"{listed(trials.SPEEDS)} deg/s",
    16: f"{listed(sorted({cycles for cycles, _ in trials.GRATINGS}))} cyc/deg at "
    f"{listed(sorted({hertz for _, hertz in trials.GRATINGS}))} Hz",
    18: f"Weber {listed(trials.CONTRASTS[:1])} to {listed(trials.CONTRASTS[-1:])}",
    19: f"instead of {trials.DARK['level']:g} on {trials.DARK['background']:g}",
    21: f"{listed(trials.DEVIATIONS)} deg off",
    22: "l/|v| of {:g}, {:g} and {:g} ms".format(*trials.FINE_RATES),
}


@pytest.mark.parametrize(("number", "words"), STATED.items())
def test_definitions_state_the_stimuli_that_are_shown(number, words):
    assert words in ROWS[number - 1].definition


def test_each_row_has_its_own_definition():
    definitions = [row.definition for row in ROWS]
    assert len(set(definitions)) == 22
    assert all(definition.endswith(".") and definition.strip() == definition for definition in definitions)


def test_an_ideal_neuron_has_all_properties():
    assert rows_that_hold(examine(ideal())) == set(range(1, 23))


@pytest.mark.parametrize(("row", "what", "changes"), SPOILT, ids=[f"{row} {what}" for row, what, _ in SPOILT])
def test_a_property_can_be_missed(row, what, changes):
    neuron = ideal() | changes
    assert set(changes) <= set(ideal())
    assert row not in rows_that_hold(examine(neuron, before_adaptation(ideal() | changes)))


def test_rows_that_are_not_concerned_still_hold():
    rows = rows_that_hold(examine(ideal() | {trials.HALVED: eta(40.0, 0.8), trials.LIGHT_LOOM: eta(40.0, 0.35)}))
    assert rows == set(range(1, 23)) - {9, 19}


@pytest.mark.parametrize(
    "before",
    [ideal(), before_adaptation(ideal()) | {trials.REFERENCE: eta(40.0, 1.3)}],
    ids=["translation as after", "loom much more"],
)
def test_adaptation_must_act_on_translation_and_not_on_the_loom(before):
    assert set(range(1, 23)) - rows_that_hold(examine(ideal(), before)) == {14}


def test_a_silent_model_passes_nothing():
    assert rows_that_hold(examine(ideal(), gain=0.04)) == set()


def test_a_silent_model_passes_nothing_in_a_batch_either():
    """Where XLA takes maxima over a batch on a CPU it loses NaN."""
    gains = jnp.where(jnp.arange(16) % 2, 0.4, 0.04)
    shapes = [[smp - 0.5 for smp in potentials(neuron, gain=1.0)] for neuron in (before_adaptation(ideal()), ideal())]

    def passed(gain):
        smp, smp_adapted = ([0.5 + gain * curve for curve in shape] for shape in shapes)
        return judge(normalise(EXAM, smp, smp_adapted))[1].sum()

    np.testing.assert_array_equal(jax.jit(jax.vmap(passed))(gains), np.where(np.arange(16) % 2, 22, 0))


def test_one_that_is_silent_in_the_textured_scene_fails_where_that_is_asked():
    changes = {textured(trials.REFERENCE): eta(40.0, 0.1)}
    assert set(range(1, 23)) - rows_that_hold(examine(ideal() | changes)) == {9, 10, 12, 13}


def test_either_line_of_the_first_row_is_enough():
    row = ROWS[0]
    assert row.holds(np.array([1.0, 9.0, 0.9]))
    assert row.holds(np.array([0.7, 2.0, 0.9]))
    assert not row.holds(np.array([0.7, 9.0, 0.9]))
    assert not row.holds(np.array([np.nan, np.nan, np.nan]))


def test_bounds_belong_to_the_range():
    row = ROWS[2]
    assert row.holds(np.array([15.0, 5.0]))
    assert not row.holds(np.array([14.999, 5.0]))
    assert not row.holds(np.array([15.0, 5.001]))
