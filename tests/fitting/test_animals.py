"""One fit an animal: which trials go where, and what is told of all."""

import csv
from typing import Any

import jax
import numpy as np
import pytest
from matplotlib.axes import Axes

import lgmd2jax as lgmd
from lgmd2jax.fitting import _animals
from lgmd2jax.fitting._animals import conditions_by_animal
from tests.fitting.fits import curve, fit_with

EYE = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=8.0, fps=60.0)
FREE = lgmd.Free(theta2=None, gain=lgmd.Log(10, 200))
LOOM = lgmd.stimuli.looming(EYE, l_over_v=20.0, contrast=-0.9, start_ms=-300.0, end_ms=100.0)
KEY = jax.random.key(0)


def trains(*animals: str, likelihood: Any = "normal"):
    return lgmd.SpikeTrains([[[float(i)]] for i in range(len(animals))], 20.0, likelihood, animals)


@pytest.fixture(scope="module")
def fits():
    generator = np.random.default_rng(0)
    places = {name: [0.5 + 0.1 * generator.normal(), 0.4] for name in ("a", "b", "c", "d")}
    return lgmd.AnimalFits({name: fit_with(FREE, [curve()], z=z, misfit=0.5) for name, z in places.items()})


def test_trials_go_to_their_animals_and_what_has_none_to_all():
    law = lgmd.Rest("smp_adapted")
    weighted = lgmd.Weighted(trains("a", "b"), weight=2)
    divided = conditions_by_animal([(LOOM, [weighted, law]), (LOOM, trains("b", "c")), (LOOM, law)])
    assert list(divided) == ["a", "b", "c"]
    assert [number for number, _ in divided["a"]] == [0, 2]
    assert [number for number, _ in divided["b"]] == [0, 1, 2]
    (_, (_, (own, common))), *_ = divided["b"]
    assert own == lgmd.Weighted(lgmd.SpikeTrains([[[1.0]]]), weight=2)
    assert common == law
    with pytest.raises(ValueError, match="no target knows its animals; give spike trains"):
        conditions_by_animal([(LOOM, law)])


def test_each_animal_has_a_fit_of_its_own(monkeypatch, untyped):
    """In place of the fit: what it was given."""
    asked = {}

    def fit(model, conditions, free, **settings):
        (_, (target,)) = conditions[0]
        asked[target.animals] = settings
        if target.animals == ("bad",):
            raise ValueError("too little")
        return fit_with(FREE, [curve()])

    monkeypatch.setattr(_animals, "fit", fit)
    found = lgmd.fit_each(lgmd.LGMD2(), [(LOOM, trains("a", "b"))], FREE, key=KEY, by="animal", descend=1)
    assert (list(found), len(found), found.unfinished) == (["a", "b"], 2, ())
    assert asked == {("a",): {"key": KEY, "descend": 1}, ("b",): {"key": KEY, "descend": 1}}
    with pytest.raises(ValueError, match="by is 'cell'; choose 'animal'"):
        lgmd.fit_each(lgmd.LGMD2(), [(LOOM, trains("a"))], FREE, key=KEY, by="cell")  # pyright: ignore[reportArgumentType]


def test_a_fit_that_was_stopped_counts_for_no_animal(monkeypatch, untyped):
    """In place of the fit: the best so far of the second animal, during which Ctrl-C was pressed."""

    def fit(model, conditions, free, **settings):
        (_, (target,)) = conditions[0]
        return fit_with(FREE, [curve()], result="converged" if target.animals == ("a",) else "stopped by hand")

    monkeypatch.setattr(_animals, "fit", fit)
    found = lgmd.fit_each(lgmd.LGMD2(), [(LOOM, trains("a", "b", "c"))], FREE, key=KEY)
    assert (list(found), found.unfinished) == (["a"], ("b", "c"))
    with pytest.raises(KeyboardInterrupt):
        lgmd.fit_each(lgmd.LGMD2(), [(LOOM, trains("b", "c"))], FREE, key=KEY)


def test_a_memory_holds_the_work_of_all_animals(monkeypatch, untyped):
    """In place of the fit: what it keeps."""

    def fit(model, conditions, free, *, memory, **settings):
        (_, (target,)) = conditions[0]
        assert not memory
        memory["start"] = target.animals
        return fit_with(FREE, [curve()])

    monkeypatch.setattr(_animals, "fit", fit)
    arguments, memory = (lgmd.LGMD2(), [(LOOM, trains("a", "b"))], FREE), {}
    lgmd.fit_each(*arguments, key=KEY, memory=memory)
    assert memory == {"animal a: start": ("a",), "animal b: start": ("b",)}
    with pytest.raises(ValueError, match="memory is kept by this process"):
        lgmd.fit_each(*arguments, key=KEY, memory=memory, processes=2)


def test_the_population_is_that_of_random_effects_on_the_scale_of_the_fit(fits):
    z = np.array([fit.z[0] for fit in fits.fits.values()])
    errors = np.array([np.sqrt(fit.uncertainty.covariance_z[0, 0]) for fit in fits.fits.values()])
    over, each = lgmd.fitting.random_effects(z, errors), fits.population["theta2"]
    np.testing.assert_allclose(each.mean, 1 + 5 * over.mean)
    np.testing.assert_allclose(each.spread, 5 * over.spread)
    np.testing.assert_allclose(each.interval, 1 + 5 * np.array(over.interval))
    assert fits.population["gain"].mean == pytest.approx(10 * 20**0.4)
    assert each.animals == 4


def test_tables_and_figure_show_every_animal(fits, tmp_path):
    report = fits.summary()
    assert "4 animals, a fit each" in report
    assert "Over animals" in report
    assert "nan" not in report
    fits.write_csv(tmp_path / "animals.csv")
    with open(tmp_path / "animals.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["animal"] for row in rows[:5]] == ["a", "b", "c", "d", "population"]
    assert float(rows[0]["value"]) == pytest.approx(fits["a"].values["theta2"])
    assert float(rows[4]["spread"]) == pytest.approx(fits.population["theta2"].spread)
    axes = fits.plot(tmp_path / "animals.pdf")
    assert isinstance(axes, Axes)
    assert len(axes.figure.axes) == 2
    assert [label.get_text() for label in axes.get_yticklabels()] == ["a", "b", "c", "d", "mean"]


def test_one_animal_has_no_population(fits):
    alone = lgmd.AnimalFits({"a": fits["a"]})
    assert np.isnan(alone.population["theta2"].mean)
    assert "Over animals" not in alone.summary()


@pytest.mark.slow
def test_processes_and_a_cluster_give_the_same_fits():
    from dask.distributed import Client, LocalCluster

    model = lgmd.LGMD2(lgmd.Parameters(T_s=5.0, k=0.4), lgmd.Soft(1.0), eye=EYE)
    spikes = lgmd.SpikeTrains([[[-20.0, 0, 20, 40]], [[-30.0, 10, 25]]], 20.0, "poisson", ["a", "b"])
    settings: dict[str, Any] = {"key": KEY, "pixel_points": 1, "cell_points": 16, "descend": 1}
    free = lgmd.Free(gain=None, baseline=None)
    here = lgmd.fit_each(model, [(LOOM, spikes)], free, **settings)
    processes = lgmd.fit_each(model, [(LOOM, spikes)], free, processes=2, **settings)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster, Client(cluster) as client:
        there = lgmd.fit_each(model, [(LOOM, spikes)], free, client=client, **settings)
    for other in (processes, there):
        for animal in ("a", "b"):
            np.testing.assert_allclose(other[animal].z, here[animal].z, rtol=1e-6)
    assert np.any(here["a"].z != here["b"].z)
