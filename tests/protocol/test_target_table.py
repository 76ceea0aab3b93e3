"""Targets as tables of a protocol, and curves from CSV files."""

import dataclasses

import jax
import numpy as np
import pytest
from pydantic import TypeAdapter

import lgmd2jax as lgmd
from lgmd2jax._protocol.target_table import target
from lgmd2jax._schemas.check import check
from lgmd2jax._schemas.protocol import TARGET
from lgmd2jax._targets.band import Band
from lgmd2jax._targets.csv_files import read_target
from lgmd2jax._targets.looming_law import LoomingLaw
from lgmd2jax._targets.model_target import ModelTarget
from lgmd2jax._targets.observation import Observation
from lgmd2jax._targets.rest import Onset, Rest
from lgmd2jax._targets.spike_trains import SpikeTrains
from lgmd2jax._targets.target import Target
from lgmd2jax._targets.weighted import Weighted

CSV = "t_ms,rate,sem,hole\n-10,1,.1,1\n0,2,.2,\n10,4,.4,1\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "targets").mkdir()
    (tmp_path / "targets" / "curve.csv").write_text(CSV)
    (tmp_path / "spikes.csv").write_text("animal,trial,time_ms\nA,1,3\n")
    return tmp_path


def test_a_recorded_curve(folder):
    made = target({"file": "targets/curve.csv", "channel": "rate", "column": "rate", "sem": "sem"}, folder)
    assert isinstance(made, Target)
    np.testing.assert_array_equal(made.time, [-10, 0, 10])
    np.testing.assert_array_equal(made.values, [1, 2, 4])
    np.testing.assert_array_equal(made.sem, [0.1, 0.2, 0.4])
    assert not made.interpolate
    assert made.error is None


def test_a_weighting_wraps_its_target(folder):
    table = {"file": "targets/curve.csv", "channel": "smp", "column": "rate", "interpolate": True}
    weighting = {"error": 2, "weight": 3, "from_ms": -5, "until_ms": 5.5, "correlation_ms": 71}
    made = target(table | weighting, folder)
    assert isinstance(made, Weighted)
    assert isinstance(made.target, Target)
    assert made.target.interpolate
    assert dataclasses.replace(made, target=Rest()) == Weighted(Rest(), **weighting)


def test_spike_times(folder):
    made = target({"spikes": "spikes.csv", "kernel_ms": 30, "channel": "rate"}, folder)
    assert made == SpikeTrains([[[3.0]]], 30.0)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ({"law": "looming", "peak": 0.3, "delta": 25}, LoomingLaw(peak=0.3, delta=25)),
        ({"law": "looming", "peak": 9, "channel": "rate", "rest": 4}, LoomingLaw(peak=9, channel="rate", rest=4)),
        ({"law": "rest", "channel": "spikes"}, Rest(channel="spikes")),
        ({"law": "onset", "peak": 0.1, "decay_ms": 90, "at_ms": 30}, Onset(peak=0.1, decay_ms=90, at_ms=30)),
        ({"law": "rest", "weight": 2}, Weighted(Rest(), weight=2)),
        ({"law": "band", "low": 0.5, "high": float("inf")}, Band(low=0.5, high=float("inf"))),
        (
            {
                "law": "band",
                "segments_ms": [[-10, 0], [5.5, 9]],
                "low": 0.5,
                "high": [0.6, 1],
                "quote": "q",
                "error": 0.1,
            },
            Weighted(Band(segments_ms=((-10, 0), (5.5, 9)), low=0.5, high=(0.6, 1), quote="q"), error=0.1),
        ),
    ],
)
def test_laws(folder, table, expected):
    assert target(table, folder) == expected


def test_what_a_model_answers(folder):
    made = target(
        {
            "model": "preset:balanced",
            "parameters": {"tau1": 20, "k": 0.3},
            "temperature": 0.5,
            "channel": "rate",
            "observation": {"gain": 90, "latency": 12.5},
            "noise": 2,
            "seed": 7,
        },
        folder,
    )
    assert isinstance(made, ModelTarget)
    for name, value in {"theta1": 1.0, "tau1": 20.0, "k": 0.3, "tau3": 500.0}.items():
        assert getattr(made.model.parameters, name) == value
    assert isinstance(made.model.thresholds, lgmd.Soft)
    assert made.model.thresholds.temperature == 0.5
    assert made.channel == "rate"
    assert made.observation == Observation(gain=90, latency=12.5)
    assert made.noise == 2
    assert made.key is not None
    np.testing.assert_array_equal(jax.random.key_data(made.key), jax.random.key_data(jax.random.key(7)))


def test_a_model_by_its_file_beside_the_protocol(folder):
    lgmd.save(lgmd.LGMD2(lgmd.Parameters(k=0.7)), folder / "model.json")
    made = target({"model": "model.json"}, folder)
    assert isinstance(made, ModelTarget)
    assert made.model.parameters.k == 0.7
    assert isinstance(made.model.thresholds, lgmd.Hard)


FILE = {"file": "targets/curve.csv", "channel": "rate", "column": "rate"}
LAW = {"law": "looming", "peak": 0.3}
MODEL = {"model": "preset:lgmd2"}
MISTAKES = [
    ({}, r"\{\}: give one of file, spikes, law, model as its source"),
    (FILE | {"law": "rest"}, "give one of file, spikes, law, model as its source"),
    ({"file": 3}, "file = 3: must be a text; column is missing; add it; channel is missing"),
    (FILE | {"file": "no.csv"}, "file = 'no.csv': cannot be read: No such file"),
    (FILE | {"file": "."}, "file = '.': cannot be read: .* is a folder; give a file"),
    ({"file": "targets/curve.csv", "channel": "rate"}, "column is missing"),
    ({"file": "targets/curve.csv", "column": "rate"}, "channel is missing"),
    (FILE | {"colum": "rate"}, "colum = 'rate': unknown key; did you mean 'column'"),
    (FILE | {"wieght": 1}, "wieght = 1: unknown key; did you mean 'weight'"),
    (FILE | {"peak": 1}, "peak = 1: unknown key"),
    (FILE | {"column": "rat"}, "curve.csv: no column 'rat'; choose 'rate'"),
    (FILE | {"sem": "s"}, "curve.csv: no column 's'; choose 'sem'"),
    (FILE | {"column": "hole"}, "curve.csv: column 'hole' holds '' in row 2, which is no finite number"),
    (FILE | {"channel": "rates"}, "channel = 'rates': choose 'rate'"),
    (FILE | {"interpolate": "yes"}, "interpolate = 'yes': must be true or false"),
    (FILE | {"error": -1}, "error = -1: must be above 0"),
    (FILE | {"error": "big"}, "error = 'big': must be a number"),
    (FILE | {"weight": -1}, "weight = -1: must be 0 or more"),
    (FILE | {"from_ms": 3, "until_ms": 2}, "from_ms is 3.0 and until_ms 2.0"),
    (LAW | {"law": "loming"}, "law = 'loming': choose 'looming'"),
    ({"law": "looming"}, "peak is missing"),
    (LAW | {"alfa": 3}, "alfa = 3: unknown key; did you mean 'alpha'"),
    (LAW | {"alpha": "x"}, "alpha = 'x': must be a number"),
    (LAW | {"alpha": -2}, "alpha is -2.0; give a positive number"),
    (LAW | {"channel": "smpp"}, "channel = 'smpp': choose 'smp'"),
    ({"law": "onset", "peak": 1, "decay_ms": 0}, "decay_ms is 0.0 ms"),
    ({"law": "band", "low": 0.5}, "high is missing"),
    ({"law": "band", "low": 0.7, "high": 0.6}, "low is 0.7 and high 0.6 in segment 1; swap them"),
    ({"law": "band", "low": [0.5, "x"], "high": 0.6}, r"low\[1\] = 'x': must be a number"),
    ({"law": "band", "low": 0.5, "high": 0.6, "quote": 3}, "quote = 3: must be a text"),
    ({"law": "band", "low": 0.5, "high": 0.6, "segments_ms": 3}, "segments_ms = 3: must be a list"),
    ({"law": "band", "low": 0.5, "high": 0.6, "segments_ms": [[0, "end"]]}, r"\[0\]\[1\] = 'end': must be a number"),
    ({"spikes": "spikes.csv", "channel": "smp"}, "channel = 'smp': choose 'rate'"),
    ({"spikes": "spikes.csv", "kernel_ms": 0}, "spikes.csv: kernel_ms is 0.0 ms; give a positive number"),
    ({"spikes": "spikes.csv", "trail": "a"}, "trail = 'a': unknown key; did you mean 'trial'"),
    ({"spikes": "no.csv"}, "spikes = 'no.csv': cannot be read"),
    ({"model": "preset:lgmd3"}, "preset is 'lgmd3'; choose 'lgmd2'"),
    ({"model": "no.json"}, "model = 'no.json': cannot be read: no such file"),
    (MODEL | {"parameters": 3}, "parameters = 3: must be a table"),
    (MODEL | {"parameters": {"kk": 1}}, "parameters.kk = 1: unknown key; did you mean 'k'"),
    (MODEL | {"parameters": {"k": -1}}, "k is -1 grey level"),
    (MODEL | {"temperature": 0}, "temperature = 0: must be above 0"),
    (MODEL | {"temperature": "hot"}, "temperature = 'hot': must be a number"),
    (MODEL | {"channel": "rate"}, "channel is 'rate', which needs an observation"),
    (MODEL | {"channel": "rate", "observation": {"gian": 3}}, "observation.gian = 3: unknown key; did you mean 'gain'"),
    (MODEL | {"channel": "rate", "observation": {"gain": -3}}, "observation.gain = -3: must be above 0"),
    (MODEL | {"noise": -1}, "noise = -1: must be 0 or more"),
    (MODEL | {"seed": 1.5}, "seed = 1.5: must be a whole number"),
    (MODEL | {"sead": 1}, "sead = 1: unknown key; did you mean 'seed'"),
]


def checked_target(table, folder):
    """The target of a table as a protocol reads it."""
    check(TypeAdapter(TARGET), table)
    return target(table, folder)


@pytest.mark.parametrize(("table", "message"), MISTAKES)
def test_mistakes_are_named_in_one_line(folder, table, message, untyped):
    with pytest.raises(ValueError, match=message) as caught:
        checked_target(table, folder)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,a\n0,1\n0,2\n", r"c.csv: time\[1\] is 0; give times that increase"),
        ("t,a\n0,1\n5\n", "c.csv: row 2 has 1 cells and the header 2"),
        ("t,a\n0,inf\n", "c.csv: column 'a' holds 'inf' in row 1"),
        ("t,a\nx,1\n", "c.csv: column 't' holds 'x' in row 1"),
        ("t,a\n", "c.csv: no rows"),
        ('t,a\n0,"1\n', "c.csv: not a CSV file"),
    ],
)
def test_curves_that_are_none_are_refused(tmp_path, text, message):
    (tmp_path / "c.csv").write_text(text)
    with pytest.raises(ValueError, match=message):
        read_target(tmp_path / "c.csv", column="a", channel="rate")
    (tmp_path / "c.csv").write_bytes(b"t,a\n\xff,1\n")
    with pytest.raises(ValueError, match=r"c\.csv: not a CSV file"):
        read_target(tmp_path / "c.csv", column="a", channel="rate")


def test_the_shipped_recordings_read(data):
    protocol = lgmd.load_protocol("dcmd")
    assert [condition.parameters["l_over_v"] for condition in protocol.conditions] == [3.75, 5, 7.5, 15]
    recorded = np.genfromtxt(data / "dcmd_looming_psth.csv", delimiter=",", names=True, deletechars="")
    for condition in protocol.conditions:
        stimulus = condition.render()
        (curve,) = (target.on(stimulus) for target in condition.targets)
        time = np.asarray(stimulus.time)
        column = f"rate_lv{condition.parameters['l_over_v']:g}"
        np.testing.assert_allclose(curve.values, np.interp(time, recorded["t_ms"], recorded[f"{column}_mean"]))
        assert curve.sem is not None
        np.testing.assert_allclose(curve.sem, np.interp(time, recorded["t_ms"], recorded[f"{column}_sem"]))
        # The stimulus starts a frame before the recording; all else counts alike.
        np.testing.assert_allclose(curve.scale, np.where(time < -1195, 0, 1 / 3.5))
        np.testing.assert_allclose(curve.thinning[curve.weight > 0], 71 / (1000 / 60))
        assert 80 < np.max(curve.values) < 100
