"""Starts on the workers of a cluster: the same results as in threads, kept in the same memory."""

from typing import Any

import jax
import numpy as np
import pytest
from distributed import Client, LocalCluster

import lgmd2jax as lgmd
from lgmd2jax._compute.tasks import Work
from lgmd2jax.alarms import Rendering
from tests.alarms.test_fit import EYE, FREE, SETTINGS, START, twins_of


@pytest.fixture(scope="module")
def client():
    """Two workers in this process: what travels is pickled all the same."""
    settings = {"n_workers": 2, "threads_per_worker": 1, "processes": False, "dashboard_address": ":0"}
    with LocalCluster(**settings) as cluster, Client(cluster) as client:
        yield client


class Squares:
    """A task with data of its own."""

    def __init__(self, data):
        self.data = data

    def __call__(self, number, stop):
        if number == 99:
            raise ValueError("number is 99; give another one")
        return {"loss": float(self.data[number] ** 2), "wide": bool(jax.config.read("jax_enable_x64"))}


class WaitingSquares(Squares):
    """All but the first one wait to be stopped."""

    def __call__(self, number, stop):
        if number:
            stop.wait(20)
        return super().__call__(number, stop)


def test_tasks_come_back_by_number_in_double_precision_and_are_remembered(client):
    task, memory = Squares(np.arange(9.0)), {"squares 3": {"loss": -1.0}}
    with Work(memory, False, client) as work:
        results = work.do("squares", task, [5, 3, 8, 0], first=lambda: pytest.fail("nothing is compiled here"))
    assert list(results) == [5, 3, 8, 0]
    assert [result["loss"] for result in results.values()] == [25, -1, 64, 0]
    assert all(results[number]["wide"] for number in (5, 8, 0))
    assert set(memory) == {"squares 5", "squares 3", "squares 8", "squares 0"}
    assert work.best == 0


def pressed_at(number):
    """A memory during whose writing of a task Ctrl-C is pressed."""

    class Pressed(dict):
        def __setitem__(self, key, value):
            super().__setitem__(key, value)
            if key == f"squares {number}":
                raise KeyboardInterrupt

    return Pressed()


def test_after_ctrl_c_the_finished_tasks_are_returned_and_no_other_is_begun():
    memory = pressed_at(0)
    with Work(memory, False) as work:
        results = work.do("squares", WaitingSquares(np.arange(90.0)), range(90))
        assert work.stop.is_set()
        assert 0 in results
        assert len(results) < 90
        assert work.do("more", Squares(np.arange(9.0)), range(9), first=lambda: pytest.fail("nothing is begun")) == {}


def test_ctrl_c_before_any_task_is_finished_goes_on():
    def pressed():
        raise KeyboardInterrupt

    with Work({}, False) as work, pytest.raises(KeyboardInterrupt):
        work.do("squares", Squares(np.arange(9.0)), range(9), first=pressed)
    with Work({"squares 3": {"loss": 9.0}}, False) as work:
        assert work.do("squares", Squares(np.arange(9.0)), range(9), first=pressed) == {3: {"loss": 9.0}}


def test_what_a_task_raises_is_raised_here(client):
    with Work({}, False, client) as work, pytest.raises(ValueError, match="number is 99"):
        work.do("squares", Squares(np.arange(9.0)), [1, 99])


@pytest.mark.usefixtures("untyped")
def test_what_is_no_client_is_refused():
    nobody: Any = "here"
    with pytest.raises(ValueError, match=r"client is 'here'; give a dask.distributed.Client"):
        Work({}, False, nobody)


@pytest.mark.slow
def test_fits_on_two_processes_are_those_of_threads():
    clips = twins_of(tuple(Rendering(8, seed=5).clips(EYE)))
    conditions = lgmd.load_protocol("twin").conditions[:2]
    free = lgmd.Free(k=lgmd.Log(0.1, 2), tau3=lgmd.Log(100, 1000))
    settings = {"key": jax.random.key(1), "pixel_points": 2, "cell_points": 64, "descend": 2}
    model = lgmd.LGMD2(eye=conditions[0].eye)
    here = lgmd.alarms.fit(START, clips, FREE, **SETTINGS), lgmd.fit(model, conditions, free, **settings)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster, Client(cluster) as client:
        there = (
            lgmd.alarms.fit(START, clips, FREE, **SETTINGS, client=client),
            lgmd.fit(model, conditions, free, **settings, client=client),
        )
    for a, b in zip(here, there, strict=True):
        np.testing.assert_allclose(a.z, b.z, atol=1e-6)
