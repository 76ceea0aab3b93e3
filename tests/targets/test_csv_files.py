"""Curves and spike times from CSV files, as laboratories' software writes them; values by pandas."""

import warnings

import numpy as np
import pandas as pd
import pytest
from pydantic import TypeAdapter

import lgmd2jax as lgmd
from lgmd2jax._protocol.target_table import target
from lgmd2jax._schemas.check import check
from lgmd2jax._schemas.protocol import TARGET

TIME = np.arange(-50.0, 60.0, 10.0)
TABLE = pd.DataFrame({"time_ms": TIME, "rate": np.round(np.sin(TIME / 30), 4), "sem": 0.5})


@pytest.fixture
def write(tmp_path):
    def written(text):
        (tmp_path / "c.csv").write_text(text, encoding="utf-8")
        return tmp_path / "c.csv"

    return written


@pytest.mark.parametrize(
    ("text", "settings"),
    [
        (TABLE.to_csv(), {}),  # pandas' default: a column of row numbers without a name comes first
        (TABLE.reset_index().to_csv(index=False), {}),
        (TABLE[["rate", "sem", "time_ms"]].to_csv(index=False), {}),
        (TABLE.set_index("time_ms").to_csv(), {}),
        (TABLE.to_csv(index=False, sep=";"), {}),
        (TABLE.to_csv(sep="\t"), {}),
        (TABLE.to_csv(index=False, sep="|"), {}),
        (TABLE.to_csv(index=False, sep=" "), {}),
        (TABLE.to_csv(index=False, sep=";", decimal=","), {"decimal": ","}),
        (TABLE.to_csv(index=False, sep="~"), {"separator": "~"}),
        (TABLE.assign(time_s=TIME / 1000).drop(columns="time_ms").to_csv(), {}),
        (TABLE.rename(columns={"time_ms": "Time (ms)"}).to_csv(), {}),
        (TABLE.assign(time_ms=TIME / 1000).rename(columns={"time_ms": "Time [s]"}).to_csv(), {}),
        (TABLE.assign(time_ms=TIME / 1000).rename(columns={"time_ms": "t"}).to_csv(), {"time_unit": "s"}),
        (TABLE.assign(time_ms=1000 * TIME).rename(columns={"time_ms": "timeUs"}).to_csv(), {}),
        (TABLE.rename(columns={"time_ms": "x"}).to_csv(), {"time": "x"}),
        (TABLE.assign(other_time_ms=3).to_csv(), {"time": "time_ms"}),
        (TABLE.assign(rate=TABLE.rate / 1000, sem=0.0005).to_csv(), {"unit": "spikes/ms"}),
        (TABLE.to_csv().replace("time_ms", "# time_ms"), {}),
        (
            pd.concat([TABLE.assign(v=v, rate=TABLE.rate * v) for v in (2.5, 1.0, 40)]).to_csv(),
            {"where": {"v": 1}},
        ),
        (
            pd.concat([TABLE.assign(cell=c, speed=v) for c in "AB" for v in (10, 20)]).to_csv(),
            {"where": {"cell": "B", "speed": "20.0"}},
        ),
    ],
)
def test_a_curve_is_read_however_it_was_written(write, text, settings):
    read = lgmd.read_target(write(text), column="rate", sem="sem", channel="rate", **settings)
    assert read.time is not None
    np.testing.assert_allclose(read.time, TIME, rtol=1e-12)
    np.testing.assert_allclose(read.values, TABLE.rate, rtol=1e-12)
    assert read.sem is not None
    np.testing.assert_allclose(read.sem, np.full(11, 0.5), rtol=1e-12)


@pytest.mark.parametrize(
    ("text", "settings", "message"),
    [
        (",rate\n0,1\n1,2\n", {}, "no column is named like a time; name it by time = '...', one of '', 'rate'"),
        ("frame,rate\n0,1\n1,2\n", {}, "no column is named like a time; .* one of 'frame', 'rate'"),
        ("time_ms,t,rate\n0,0,1\n", {}, "columns 'time_ms' and 't' are named like a time; name it by time"),
        ("time_ms,rate,rate\n0,1,5\n1,2,6\n", {}, "2 columns are named 'rate'; give each a name of its own"),
        ("time_ms,rate, rate\n0,1,5\n1,2,6\n", {}, "2 columns are named 'rate'"),
        ("time_h,rate\n0,1\n1,2\n", {}, "column 'time_h' counts in 'h', which is not a unit of time here"),
        ("time (frames),rate\n0,1\n1,2\n", {}, r"column 'time \(frames\)' counts in 'frames'"),
        ("time [days],rate\n0,1\n1,2\n", {}, "counts in 'days'"),
        ("t_ms,rate (spikes/bin)\n0,1\n1,2\n", {"column": "rate (spikes/bin)"}, "has the unit 'spikes/bin', which is"),
        ("t_ms,rate (kHz)\n0,1\n", {"column": "rate (kHz)", "unit": "Hz"}, "unit is 'Hz', but the column is named"),
        ("t_ms,u [mV]\n0,1\n", {"column": "u [mV]", "channel": "smp"}, "has the unit 'mV', which is none of the"),
        ("time_ms,time_ms,rate\n0,0,1\n", {}, "2 columns are named 'time_ms'"),
        ("t;rate,x\n0;1,2\n", {}, "cells could be separated by ',' or ';'; give the separator"),
        ("t;rate\n0,5;1,5\n", {}, "'0,5' in row 1, which is no finite number; give decimal = ','"),
        ("t;rate\n0;1.500\n", {"decimal": ","}, "'1.500' in row 1, which is no finite number"),
        ("t,rate\n0,1_000\n", {}, "'1_000' in row 1, which is no finite number"),
        ("t,rate\n0,1\n", {"separator": ";"}, "there is one column, 't,rate', separated by ';'; give another"),
        ("t,rate\n0,1\n", {"separator": ";;"}, "separator is ';;' and decimal '.'; give one character each"),
        ("t,rate\n0,1\n", {"separator": ",", "decimal": ","}, "separator is ',' and decimal ','"),
        ("t,rate\n0,1\n", {"decimal": "comma"}, "decimal is 'comma'; give '.' or ','"),
        ("t,rate\n0,1\n", {"time_unit": "h"}, "time_unit is 'h'; give 'ms', 's', 'us' or 'min'"),
        ("t_ms,rate\n0,1\n", {"time_unit": "s"}, "time_unit is 's', but the column is named 't_ms'; correct one"),
        ("t,rate\n0,1\n", {"unit": "mV"}, "unit is 'mV', which is none of the channel 'rate'"),
        (
            "t,rate,v\n0,1,5\n9,1,5\n0,2,10\n9,2,10\n",
            {},
            "times come again, and column 'v' holds 2 values .* v = 5 }",
        ),
        ("t,rate\n0,1\n9,1\n0,2\n", {}, r"time\[2\] is 0; give times that increase"),
        ("t,rate,v\n0,1,5\n", {"where": {"v": 7}}, "where: no row has v = 7; those that are left have '5'"),
        ("t,rate,v\n0,1,5\n", {"where": {"w": 7}}, "no column 'w'; choose"),
        ("t,rate,v\n0,1,5\n9,x,10\n", {"where": {"v": 10}}, "column 'rate' holds 'x' in row 2"),
    ],
)
def test_what_could_be_read_wrongly_is_refused(write, text, settings, message):
    with pytest.raises(ValueError, match=message) as caught:
        lgmd.read_target(write(text), **{"column": "rate", "channel": "rate", **settings})
    assert str(caught.value).startswith(str(write(text)))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("column", [1, [], ["rate", 2], None])
def test_a_column_goes_by_its_name(write, untyped, column):
    with pytest.raises(ValueError, match=r"column is .*; give .* a tuple of names$"):
        lgmd.read_target(write("t,rate\n0,1\n"), column=column, channel="rate")


def test_the_unit_in_the_name_of_a_column_counts(write):
    for name, values in (("rate (kHz)", "0.5"), ("rate [spikes/s]", "500"), ("rate (DCMD)", "500")):
        read = lgmd.read_target(write(f"t_ms,{name}\n0,{values}\n"), column=name, channel="rate")
        np.testing.assert_allclose(read.values, [500.0])


@pytest.mark.parametrize(
    ("channel", "value", "words"),
    [("smp", 70, "reach from 0.6 to 70"), ("smp_adapted", -65, "in 0.5 to 1; convert percent or mV")],
)
def test_values_that_a_potential_never_has_are_said(write, channel, value, words):
    with pytest.warns(UserWarning, match=words):
        lgmd.read_target(write(f"t_ms,u\n0,{value}\n9,0.6\n"), column="u", channel=channel)


def test_a_column_a_trial_makes_a_mean_with_its_error(write):
    rng = np.random.default_rng(0)
    trials = pd.DataFrame(rng.normal(20, 4, (200, 5)).round(5), columns=[f"trial {i}" for i in range(1, 6)])
    table = trials.assign(t=np.arange(200.0))
    read = lgmd.read_target(write(table.to_csv()), column=list(trials.columns), channel="rate")
    np.testing.assert_allclose(read.values, trials.mean(axis=1), rtol=1e-12)
    variance = trials.var(axis=1)
    assert read.sem is not None
    np.testing.assert_allclose(read.sem, np.sqrt((4 * variance + 4 * variance.mean()) / 8 / 5), rtol=1e-12)
    np.testing.assert_allclose(np.mean(read.sem), 4 / np.sqrt(5), rtol=0.05)
    assert read.sem_rule == "s.e.m. over 5 trials, drawn towards one that all times share"
    one = lgmd.read_target(write(table.to_csv()), column=["trial 2"], channel="rate")
    assert one.sem is None
    with pytest.raises(ValueError, match="the trials are all equal"):
        lgmd.read_target(write(table.to_csv()), column=["trial 2", "trial 2"], channel="rate")


SPIKES = pd.DataFrame(
    [
        {"animal": a, "trial": k, "v": v, "time_ms": t}
        for a in "AB"
        for v in (10, 20)
        for k in (1, 2)
        for t in (v + k, 2.0 * v + k, 90.0 if a == "A" else -4.0)
    ]
)


def test_spikes_of_one_stimulus_among_several(write):
    read = lgmd.read_spike_trains(write(SPIKES.to_csv()), where={"v": 20})
    assert read.trials == [[[21.0, 41.0, 90.0], [22.0, 42.0, 90.0]], [[21.0, 41.0, -4.0], [22.0, 42.0, -4.0]]]
    with pytest.warns(UserWarning, match=r"'v' holds 2 values \('10', '20'\), all of which are read as one recording"):
        lgmd.read_spike_trains(write(SPIKES.to_csv()))
    # Trials that go on counting over the stimuli hide them no better.
    with pytest.warns(UserWarning, match="where = { v = 10 }"):
        lgmd.read_spike_trains(write(SPIKES.assign(trial=SPIKES.trial + SPIKES.v).to_csv()))


def test_what_is_told_of_each_spike_is_no_condition(write):
    one = SPIKES[SPIKES.v == 20]
    number = one.groupby(["animal", "trial"]).cumcount()
    table = one.assign(spike=number, amplitude=np.linspace(1, 2, len(one)), observer="me")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lgmd.read_spike_trains(write(table.to_csv()))


@pytest.mark.parametrize(
    ("text", "settings"),
    [
        ("a;b;c\n-3,5;1;\n4;;\n", {"columns": ["a", "b", "c"], "decimal": ","}),
        ("a,b,c\n-0.0035,0.001,\n0.004,,\n", {"columns": ["a", "b", "c"], "time_unit": "s"}),
        ("animal,trial,spike_time_s\nX,1,-0.0035\nX,1,0.004\nX,2,0.001\nX,3,\n", {}),
        ("animal,trial,time\nX,1,-0.0035\nX,1,0.004\nX,2,0.001\nX,3,\n", {"time_unit": "s"}),
    ],
)
def test_spikes_by_columns_and_by_rows_are_the_same(write, text, settings):
    assert lgmd.read_spike_trains(write(text), **settings).trials == [[[-3.5, 4.0], [1.0], []]]


def test_a_protocol_says_the_same(write, tmp_path):
    curves = pd.concat([TABLE.assign(v=v, rate=TABLE.rate * v, again=TABLE.rate * v + 1) for v in (2.5, 40)])
    write(curves.to_csv(sep=";", decimal=","))
    table = {
        "file": "c.csv",
        "channel": "rate",
        "column": "rate",
        "where": {"v": "2.5"},
        "decimal": ",",
        "time": "time_ms",
    }
    read = target(table, tmp_path)
    assert isinstance(read, lgmd.Target)
    np.testing.assert_allclose(read.values, 2.5 * TABLE.rate, rtol=1e-12)
    read = target(table | {"column": ["rate", "again"]}, tmp_path)
    assert isinstance(read, lgmd.Target)
    np.testing.assert_allclose(read.values, 2.5 * TABLE.rate + 0.5, rtol=1e-12)
    write(SPIKES.to_csv())
    read = target({"spikes": "c.csv", "where": {"v": 20, "animal": "A"}}, tmp_path)
    assert isinstance(read, lgmd.SpikeTrains)
    assert read.trials == [[[21.0, 41.0, 90.0], [22.0, 42.0, 90.0]]]
    for wrong, message in (
        ({"where": 3}, "where = 3: must be a table"),
        ({"where": {"v": [1]}}, r"where\.v = \[1\]: must be a number"),
        ({"column": [1]}, r"column\[0\] = 1: must be a text"),
        ({"interpolate": 1}, "interpolate = 1: must be true or false"),
    ):
        with pytest.raises(ValueError, match=message):
            check(TypeAdapter(TARGET), table | wrong)
