"""The hard model with Table I on the paper's synthetic stimuli: the selectivity that the paper reports.

The peak SMP of every condition is a table in the summary of the run.
"""

import dataclasses

import numpy as np
import pytest

from lgmd2jax import LGMD2, load_protocol

REST = 0.505
SPIKE = 0.78  # T_sp of Table I


@dataclasses.dataclass(frozen=True)
class Seen:
    """What the cell did in one condition: SMP after adaptation, while the picture changes and after."""

    smp: np.ndarray
    time: np.ndarray
    begin: int
    end: int
    alarm: bool

    @property
    def peak(self) -> float:
        return self.smp[self.begin : self.end + 1].max()

    @property
    def rebound(self) -> float:
        return self.smp[self.end + 1 :].max()

    def above(self, level: float) -> float:
        """For how long, in ms, the SMP is above a level."""
        return np.sum(self.smp > level) * (self.time[1] - self.time[0])


@pytest.fixture(scope="module")
def seen() -> dict[str, Seen]:
    """Every condition by name."""
    model, results = LGMD2(), {}
    for condition in load_protocol("paper").conditions:
        stimulus = condition.render()
        response = model(stimulus.frames, stimulus.fps)
        changes = 1 + np.flatnonzero(np.abs(np.diff(stimulus.frames, axis=0)).max(axis=(1, 2)) > 1e-6)
        smp, time = np.asarray(response.smp_adapted), np.asarray(stimulus.time)
        results[condition.name] = Seen(smp, time, changes[0], changes[-1], bool(response.collision.any()))
    return results


def test_every_condition_is_shown_in_a_table(seen, record_property):
    rows = [f"{'condition':<50}{'peak SMP':>9}{'at ms':>7}{'after':>7}{'above .55, ms':>15}{'alarm':>7}"]
    for name, result in seen.items():
        peak = result.begin + np.argmax(result.smp[result.begin : result.end + 1])
        at = f"{result.time[peak]:.0f}" if result.peak > REST else "-"
        rows.append(
            f"{name:<50}{result.peak:9.3f}{at:>7}{result.rebound:7.3f}{result.above(0.55):15.0f}"
            f"{'yes' if result.alarm else '-':>7}"
        )
    record_property("table", "\n".join(rows))
    assert len(rows) == 1 + 53


def test_dark_approach_excites_until_the_inhibition_cuts_it(seen):
    approach = seen["dark approach"]
    assert approach.peak > 0.9
    assert approach.alarm
    last = approach.smp[(approach.time > -100) & (approach.time <= 0)]
    assert last.max() <= REST


@pytest.mark.parametrize("name", ["dark recession", "light approach"])
def test_dark_recession_and_light_approach_leave_it_at_rest(seen, name):
    assert seen[name].smp.max() <= REST


def test_light_recession_is_answered_briefly(seen):
    recession = seen["light recession"]
    assert recession.peak > 0.9
    assert recession.above(0.55) < 300
    assert not recession.alarm


@pytest.mark.parametrize("shade", ["dark", "light"])
def test_one_clip_of_both_shows_the_same(seen, shade):
    both = seen[f"{shade} approach and recession"]
    comes, goes = both.smp[both.time < 0].max(), both.smp[both.time > 600].max()
    assert (comes > 0.9, goes <= REST) == ((True, True) if shade == "dark" else (False, False))


@pytest.mark.parametrize("shade", ["dark", "light"])
def test_translation_is_answered_at_its_beginning_alone_and_in_no_preferred_direction(seen, shade):
    right, left = (seen[f"{shade} translation {direction} deg"] for direction in (0, 180))
    for run in (right, left):
        assert SPIKE < run.peak < 0.82
        assert run.smp[run.time > 400].max() < 0.55
        assert not run.alarm
    np.testing.assert_allclose(right.smp, left.smp, atol=1e-3)


def test_only_edges_that_darken_are_answered(seen):
    for name in ("dark elongating", "light shortening"):
        assert seen[name].peak > 0.75
        assert seen[name].smp[seen[name].time > 400].max() < 0.55
        assert not seen[name].alarm
    for name in ("light elongating", "dark shortening"):
        assert seen[name].smp.max() <= REST


@pytest.mark.parametrize("change", ["darkening", "lighting"])
@pytest.mark.parametrize("fraction", ["0.25", "1"])
def test_slow_ramps_leave_it_at_rest_and_a_step_down_bursts_as_the_gate_reopens(seen, change, fraction):
    assert seen[f"{change} and back, 1000 ms, {fraction} of the field"].smp.max() <= REST
    step = seen[f"{change} and back, 0 ms, {fraction} of the field"]
    assert step.smp[step.begin] <= REST
    assert step.smp.max() > 0.9
    assert step.above(0.55) <= 101
    darkens = step.time[step.begin] if change == "darkening" else step.time[step.end]
    assert 0 < step.time[np.argmax(step.smp)] - darkens <= 101


def test_gratings_leave_it_at_rest_while_they_move_and_burst_once_as_they_stop(seen):
    gratings = {name: run for name, run in seen.items() if name.startswith("grating")}
    assert len(gratings) == 11
    for run in gratings.values():
        assert run.peak <= REST
        assert run.above(0.55) <= 67
        assert run.smp[run.time > run.time[run.end] + 200].max() <= REST


def test_contrast_matters_less_as_the_edge_is_faster(seen):
    contrasts, speeds = (-0.2, -0.4, -0.6, -0.8, -1), (30, 60, 120, 240)
    peaks = np.array([[seen[f"contrast {c:g}, edge {s} px/s"].peak for s in speeds] for c in contrasts])
    assert np.all(np.diff(peaks, axis=0) > -1e-3)
    assert np.all(np.diff(peaks, axis=1) > 0)
    assert np.all(np.diff(np.ptp(peaks, axis=0)) < 0)
