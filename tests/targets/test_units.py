"""Numbers that have a unit of their own are converted by it, and never taken for another one."""

import datetime
import types

import neo
import numpy as np
import pandas as pd
import pint
import pytest
import quantities as pq
import xarray

import lgmd2jax as lgmd
from lgmd2jax._arguments.units import duration, has_unit, levels, times

REGISTRY = pint.UnitRegistry()
SECONDS, MS = np.array([0.01, 0.02, 0.5]), np.array([10.0, 20.0, 500.0])


def astropy(values, sizes):
    """As astropy and unyt convert."""

    def to_value(unit):
        if unit not in sizes:
            raise TypeError(f"not convertible to {unit}")
        return np.asarray(values) * sizes[unit]

    return types.SimpleNamespace(to_value=to_value)


class Brian(np.ndarray):
    """As brian2's quantities: SI values, and a dimension."""

    dim: object

    @classmethod
    def of(cls, values, dimension):
        array = np.asarray(values, dtype=float).view(cls)
        array.dim = type("Dimension", (), {"__repr__": lambda _: dimension})()
        return array

    def has_same_dimensions(self, other):
        raise NotImplementedError


def by_type(values) -> str:
    """A name that is the same in every process; an address is not."""
    return type(values).__name__


@pytest.mark.parametrize(
    "values",
    [
        MS,
        MS.tolist(),
        MS.astype(np.float32),
        pd.Series(MS),
        neo.SpikeTrain(SECONDS * pq.s, t_stop=1 * pq.s),
        neo.SpikeTrain(MS * 1e3 * pq.us, t_stop=1 * pq.s),
        SECONDS * pq.s,
        [0.01 * pq.s, 20 * pq.ms, 0.5 * pq.s],
        REGISTRY.Quantity(SECONDS, "s"),
        [REGISTRY.Quantity(value, "ms") for value in MS],
        astropy(SECONDS, {"ms": 1e3, "s": 1}),
        Brian.of(SECONDS, "second"),
        types.SimpleNamespace(times=lambda: SECONDS),
        pd.Series(pd.to_timedelta(MS, unit="ms")),
        pd.to_timedelta(SECONDS, unit="s"),
        pd.to_timedelta(MS, unit="ms").to_numpy(),
        [pd.Timedelta(value, unit="ms") for value in MS],
        pd.Series([pd.Timedelta(value, unit="ms") for value in MS], dtype=object),
        [datetime.timedelta(seconds=value) for value in SECONDS],
        (MS * 1000).astype(int).astype("m8[us]"),
        xarray.DataArray(SECONDS, attrs={"units": "s"}),
        xarray.DataArray(MS, attrs={"units": "milliseconds"}),
        xarray.DataArray(MS),
    ],
    ids=by_type,
)
def test_times_are_in_ms_whatever_they_come_in(values):
    np.testing.assert_allclose(times(values, "time"), MS, rtol=1e-12)


@pytest.mark.parametrize(
    "values",
    [
        MS,
        MS * pq.Hz,
        MS / pq.s,
        MS / 1000 * pq.kHz,
        MS * pq.dimensionless,
        REGISTRY.Quantity(MS, "1/s"),
        REGISTRY.Quantity(MS, ""),
        astropy(MS, {"Hz": 1.0}),
        astropy(MS, {"": 1.0}),
        Brian.of(MS, "second ** -1"),
        xarray.DataArray(MS, attrs={"units": "spikes/s"}),
        xarray.DataArray(MS / 1000, attrs={"units": "kHz"}),
        xarray.DataArray(MS, attrs={"units": "1"}),
    ],
    ids=by_type,
)
def test_rates_are_in_spikes_a_second(values):
    np.testing.assert_allclose(levels(values, "values"), MS, rtol=1e-12)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (MS * pq.mV, "time has another unit than ms: Unable to convert"),
        (MS * pq.Hz, "time has another unit than ms"),
        (REGISTRY.Quantity(MS, "mV"), "time has another unit than ms: Cannot convert"),
        (astropy(MS, {"V": 1.0}), "time has another unit than ms: not convertible to ms"),
        (Brian.of(MS, "volt"), "time has another unit than ms: the dimension is volt"),
        (
            xarray.DataArray(MS, attrs={"units": "degrees"}),
            "time has another unit than ms: the attribute units is",
        ),
        (pd.to_datetime(["2026-01-01", "2026-01-02"]), "time has another unit than ms: these are dates"),
        (pd.Series(pd.to_datetime(["2026-01-01"])), "these are dates"),
        ([datetime.datetime(2026, 1, 1)], "these are dates"),
        ([pd.Timestamp("2026-01-01")], "these are dates"),
        (["a"], r"time is \['a'\]; give times in ms, or with a unit"),
        ([None, {}], r"time is \[None, {}\]; give times"),
    ],
)
def test_another_unit_is_refused_in_one_line(values, message):
    with pytest.raises(ValueError, match=message) as error:
        times(values, "time")
    assert "\n" not in str(error.value)


def test_rates_are_no_times():
    with pytest.raises(ValueError, match="values has another unit than Hz or 1"):
        levels(SECONDS * pq.s, "values")
    with pytest.raises(ValueError, match="these are durations"):
        levels(pd.to_timedelta(MS, unit="ms"), "values")


def test_a_single_duration_keeps_its_type_unless_it_has_a_unit():
    assert duration(20, "kernel_ms") == 20
    assert isinstance(duration(20, "kernel_ms"), int)
    for value in (0.02 * pq.s, REGISTRY.Quantity(20, "ms"), pd.Timedelta("20ms"), datetime.timedelta(seconds=0.02)):
        assert duration(value, "kernel_ms") == pytest.approx(20, rel=1e-12)
    assert duration(pd.Timedelta("700ns"), "kernel_ms") == pytest.approx(7e-4)


def test_what_numpy_would_drop_is_known():
    for values in (1, 2.0, None, MS, MS.tolist(), [], "20 ms", pd.Series(MS), xarray.DataArray(MS)):
        assert not has_unit(values)
    for values in (1 * pq.ms, [1 * pq.ms], pd.Timedelta("1s"), [pd.Timestamp("2026-01-01")], np.array([1], "m8[s]")):
        assert has_unit(values)


TAKES_PLAIN_NUMBERS = {
    "from_ms": lambda value: lgmd.Weighted(lgmd.Rest(), from_ms=value),
    "correlation_ms": lambda value: lgmd.Weighted(lgmd.Rest(), correlation_ms=value),
    "decay_ms": lambda value: lgmd.Onset(peak=0.8, decay_ms=value),
    "segments_ms": lambda value: lgmd.Band(segments_ms=[[0, value]], low=0.5, high=0.6),
    "low": lambda value: lgmd.Band(low=[value], high=[0.9]),
    "start_ms": lambda value: lgmd.Trial("a", "1", {}, np.zeros(1), start_ms=value, end_ms=1.0),
    "spikes_ms": lambda value: lgmd.Trial("a", "1", {}, np.ones(3) * value, start_ms=0.0, end_ms=1.0),
    "within_ms": lambda value: lgmd.alarms.fit_urgency(lgmd.LGMD2(), [], within_ms=value),
    "duration_ms": lambda value: lgmd.alarms.Rendering(3, duration_ms=value),
}


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize("value", [0.2 * pq.s, 0.2 * pint.UnitRegistry().s, pd.Timedelta(0.2, "s")], ids=str)
@pytest.mark.parametrize("name", TAKES_PLAIN_NUMBERS)
def test_a_unit_is_not_dropped_where_it_is_not_converted(name, value):
    """A number of quantities is an array of NumPy's to which 0.2 s were 0.2."""
    with pytest.raises(ValueError, match=rf"^{name}\b.* is .*; give"):
        TAKES_PLAIN_NUMBERS[name](value)
