"""Every row on a signal that is made to pass and on ones that are made to fail it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax._characterise import trials
from lgmd2jax._characterise.trials import textured
from lgmd2jax._characterise.verdicts import ROWS, judged
from tests.characterise.signals import (
    EXAM,
    added,
    bump,
    eta,
    ideal,
    onset,
    potentials,
    seen,
    step,
    unadapted,
)

STRAIGHT = trials.translation()


def looms(signal):
    """Another answer to all approaches of row 1, and to the same ones at the finer frame rate."""
    names = [(speed, fine) for speed in trials.L_OVER_V for fine in (False, True)[: 1 + (speed in trials.FINE_RATES)]]
    return {trials.loom(speed, fine): signal(speed) for speed, fine in names}


def two_thirds(speed):
    """Peaks as of a threshold on the swept area: -(l/|v|)^(2/3), for which r2 of the straight line is .99."""
    return bump(-11 * speed ** (2 / 3), (speed / 40) ** -0.1, 2 * speed)


def everywhere(signal):
    return {trials.grating(*each): signal for each in trials.GRATINGS}


# What is spoilt, and the row that must see it. Other rows may see it as well.
SPOILT = [
    (1, "two-thirds law", looms(two_thirds)),
    (2, "too steep", looms(lambda speed: eta(speed, (speed / 40) ** -0.1, alpha=9.0))),
    (2, "too late", looms(lambda speed: eta(speed, (speed / 40) ** -0.1, delta=80.0))),
    (3, "angle too small", looms(lambda speed: eta(speed, (speed / 40) ** -0.1, alpha=9.0))),
    (3, "angle not the same", looms(two_thirds)),
    (4, "second peak after", {trials.loom(80.0): added(eta(80.0, 0.93), bump(-140.0, 0.4, 15.0))}),
    (4, "second peak before", {trials.loom(80.0): added(eta(80.0, 0.93), bump(-3000.0, 0.4, 30.0))}),
    (5, "too narrow", looms(lambda speed: bump(28.7 - 4.4 * speed, (speed / 40) ** -0.1, speed))),
    (5, "too wide", looms(lambda speed: bump(28.7 - 4.4 * speed, (speed / 40) ** -0.1, 9 * speed))),
    (5, "symmetric", looms(lambda speed: bump(28.7 - 4.4 * speed, (speed / 40) ** -0.1, 4.1 * speed))),
    (6, "too steep", looms(lambda speed: eta(speed, (speed / 40) ** -0.7))),
    (6, "rising", looms(lambda speed: eta(speed, (speed / 40) ** 0.1))),
    (7, "one integral falls", {trials.loom(50.0): eta(50.0, 0.5)}),
    (8, "stays", {trials.loom(20.0): added(eta(20.0, 1.07), step(0.2, 0.0))}),
    (9, "light", {trials.LIGHT_LOOM: eta(40.0, 0.35)}),
    (9, "light, textured", {textured(trials.LIGHT_LOOM): eta(40.0, 0.35)}),
    *(
        (10, f"{what}{scene('')}", {scene(trials.RECESSION): signal})
        for scene in (str, textured)
        for what, signal in (
            ("strong", onset(0.3, 40.0)),
            ("long", onset(0.2, 400.0)),
            ("late", bump(1000.0, 0.15, 20.0)),
        )
    ),
    (11, "long", {trials.LIGHT_RECESSION: onset(0.8, 180.0)}),
    *(
        (12, f"{shade}{scene('')} {what}", {scene(trials.bar(shade, grows)): signal})
        for scene in (str, textured)
        for shade in ("dark", "light")
        for what, grows, signal in (
            ("other way", shade != "dark", onset(0.2, 200.0)),
            ("silent", shade == "dark", onset(0.0, 200.0)),
        )
    ),
    *(
        (13, f"{what}{scene('')}", {scene(STRAIGHT): signal})
        for scene in (str, textured)
        for what, signal in (("strong", onset(0.6, 150.0)), ("stays", onset(0.3, 1500.0)))
    ),
    (13, "direction", {trials.translation(direction=180.0): onset(0.27, 150.0)}),
    (15, "squared is no better", {trials.accelerating("accelerating"): onset(0.35, 150.0)}),
    (15, "linear is worse", {trials.accelerating("linear"): onset(0.25, 150.0)}),
    (15, "faster is weaker", {trials.translation(200.0): onset(0.3, 150.0)}),
    (16, "mean", everywhere(step(0.15, 300.0, 2000.0))),
    (16, "one stays", {trials.grating(0.2, 10.0): step(0.15, 300.0, 2000.0)}),
    (16, "onset", {trials.grating(0.05, 1.0): onset(0.4, 80.0)}),
    *(
        (17, trials.change(part, size, ramp), {trials.change(part, size, ramp): step(0.2, 200.0, 300.0)})
        for part in trials.PARTS
        for size, ramp in ((20.0, 0.0), (-80.0, 0.0), (140.0, 1000.0))
    ),
    (18, "not monotone", {trials.contrast(-0.3): eta(40.0, 0.95)}),
    (18, "full contrast needed", {trials.contrast(-1.0): eta(40.0, 1.1)}),
    (18, "time shifts", {trials.contrast(-0.3): eta(40.0, 0.8, delta=-20.0)}),
    (19, "weaker", {trials.HALVED: eta(40.0, 0.8)}),
    (19, "stronger", {trials.HALVED: eta(40.0, 1.2)}),
    (19, "shifted", {trials.HALVED: eta(40.0, delta=-20.0)}),
    (20, "square shifted", {trials.SQUARE: eta(40.0, delta=-20.0)}),
    (20, "square weaker", {trials.SQUARE: eta(40.0, 0.7)}),
    (20, "checks shifted", {trials.CHECKS: eta(40.0, delta=80.0)}),
    (20, "checks stronger", {trials.CHECKS: eta(40.0, 1.3)}),
    (21, "drift does nothing", {trials.DRIFTING: eta(40.0)}),
    (21, "near miss stronger", {trials.deviating(20.0): eta(40.0, 0.8)}),
    (21, "misses as strong", {trials.deviating(it): eta(40.0) for it in trials.DEVIATIONS}),
    (22, "shifted", {trials.loom(80.0, fine=True): eta(80.0, 0.93, delta=40.0)}),
]  # fmt: skip


def held(found):
    return {row.number for row, passed in zip(ROWS, found.passed, strict=True) if passed}


def test_the_exam_has_22_rows():
    assert [row.number for row in ROWS] == list(range(1, 23))
    assert {row.number for row in ROWS if row.neuron == "LGMD2"} == {9, 10, 11, 12}
    for row in ROWS:
        assert row.definition
        assert any(line.judged for line in row.lines)
        assert set("".join(line.evidence for line in row.lines)) <= set("ADMSP")


def test_an_ideal_neuron_has_all_properties():
    assert held(seen(ideal())) == set(range(1, 23))


@pytest.mark.parametrize(("row", "what", "changes"), SPOILT, ids=[f"{row} {what}" for row, what, _ in SPOILT])
def test_a_property_can_be_missed(row, what, changes):
    neuron = ideal() | changes
    assert set(changes) <= set(ideal())
    assert row not in held(seen(neuron, unadapted(ideal() | changes)))


def test_rows_that_are_not_concerned_still_hold():
    spoilt = held(seen(ideal() | {trials.HALVED: eta(40.0, 0.8), trials.LIGHT_LOOM: eta(40.0, 0.35)}))
    assert spoilt == set(range(1, 23)) - {9, 19}


@pytest.mark.parametrize(
    "before",
    [ideal(), unadapted(ideal()) | {trials.REFERENCE: eta(40.0, 1.3)}],
    ids=["translation as after", "loom much more"],
)
def test_adaptation_must_act_on_translation_and_not_on_the_loom(before):
    assert set(range(1, 23)) - held(seen(ideal(), before)) == {14}


def test_a_silent_model_passes_nothing():
    assert held(seen(ideal(), gain=0.04)) == set()


def test_a_silent_model_passes_nothing_in_a_batch_either():
    """Where XLA takes maxima over a batch on a CPU it loses NaN."""
    gains = jnp.where(jnp.arange(16) % 2, 0.4, 0.04)
    shapes = [[jnp.asarray(it) - 0.5 for it in potentials(each, gain=1.0)] for each in (unadapted(ideal()), ideal())]

    def passed(gain):
        smp, smp_adapted = ([0.5 + gain * it for it in shape] for shape in shapes)
        return judged(normalised(EXAM, smp, smp_adapted))[1].sum()

    np.testing.assert_array_equal(jax.jit(jax.vmap(passed))(gains), np.where(np.arange(16) % 2, 22, 0))


def test_one_that_is_silent_in_the_textured_scene_fails_where_that_is_asked():
    changes = {textured(trials.REFERENCE): eta(40.0, 0.1)}
    assert set(range(1, 23)) - held(seen(ideal() | changes)) == {9, 10, 12, 13}


def test_either_line_of_the_first_row_is_enough():
    row = ROWS[0]
    assert row.passed(np.array([1.0, 9.0, 0.9]))
    assert row.passed(np.array([0.7, 2.0, 0.9]))
    assert not row.passed(np.array([0.7, 9.0, 0.9]))
    assert not row.passed(np.array([np.nan, np.nan, np.nan]))


def test_bounds_belong_to_the_range():
    row = ROWS[2]
    assert row.passed(np.array([15.0, 5.0]))
    assert not row.passed(np.array([14.999, 5.0]))
    assert not row.passed(np.array([15.0, 5.001]))
