"""A store is recognised by what its stimulus does: code and all that it captured."""

import enum
import functools
import os
import subprocess
import sys
import threading
import types
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax._compute.fingerprint import fingerprint

LEVEL = 200.0


def enclosed(background, extra=0.0):
    def renderer(eye, *, contrast):
        return lgmd.stimuli.looming(eye, contrast=contrast, background=background + extra)

    return renderer


def with_default(background):
    def renderer(eye, *, contrast, background=background):
        return lgmd.stimuli.looming(eye, contrast=contrast, background=background)

    return renderer


def renders(eye, *, contrast, background=200.0):
    return lgmd.stimuli.looming(eye, contrast=contrast, background=background)


def of_a_global(eye, *, contrast):
    return lgmd.stimuli.looming(eye, contrast=contrast, background=LEVEL)


class Screen:
    """A renderer with a state of its own."""

    def __init__(self, background):
        self.background = background

    def __call__(self, eye, *, contrast):
        return renders(eye, contrast=contrast, background=self.background)

    def show(self, eye, *, contrast):
        return self(eye, contrast=contrast)


class Kept(Screen):
    """The same with a property that is computed once."""

    lock = threading.Lock()

    @functools.cached_property
    def twice(self):
        return 2 * self.background


class Slotted:
    """The same without a dictionary."""

    __slots__ = ("background",)

    def __init__(self, background):
        self.background = background


def decorated(background):
    @functools.wraps(renders)
    def renderer(*arguments, **keywords):
        return renders(*arguments, **keywords, background=background)

    return renderer


def of_a_class(background):
    class Local:
        def __call__(self, eye, *, contrast):
            return renders(eye, contrast=contrast, background=background)

    return Local()


def of_a_class_attribute(background):
    class Base:
        level = background

    class Local(Base):
        def show(self, eye, *, contrast):
            return renders(eye, contrast=contrast, background=self.level)

    return Local().show


def of_a_property(background):
    class Local:
        @property
        def level(self):
            return background

    return Local()


def of_a_static_method(background):
    class Local:
        @staticmethod
        def show(eye, *, contrast):
            return renders(eye, contrast=contrast, background=background)

    return Local


def with_an_attribute(background):
    def renderer(eye, *, contrast):
        return renders(eye, contrast=contrast, background=vars(renderer)["level"])

    vars(renderer)["level"] = background
    return renderer


class Decorated(Screen):
    """A decorator with a state of its own."""

    def __init__(self, background):
        functools.update_wrapper(self, renders)
        super().__init__(background)


class Listed(list):
    """A list with a state of its own."""

    def __init__(self, background):
        super().__init__([1.0])
        self.background = background


MAKERS = [
    enclosed,
    of_a_class,
    of_a_class_attribute,
    of_a_property,
    of_a_static_method,
    with_an_attribute,
    Decorated,
    Listed,
    lambda level: np.ma.masked_array([1.0, 2.0], [level > 100, False]),
    lambda level: enum.Enum("Background", {"level": level}).level,
    with_default,
    decorated,
    Screen,
    Slotted,
    lambda level: functools.partial(renders, background=level),
    lambda level: Screen(level).show,
    lambda level: jax.jit(enclosed(level)),
    lambda level: eqx.filter_jit(enclosed(level)),
    lambda level: jax.custom_jvp(enclosed(level)),
    lambda level: jax.vmap(enclosed(level)),
    lambda level: enclosed(np.sin if level > 100 else np.cos),
    lambda level: enclosed(jnp.sin if level > 100 else jnp.cos),
    lambda level: enclosed(int | str if level > 100 else int | float),
    lambda level: enclosed(np.full(3, level)),
    lambda level: enclosed({"levels": [level, 3]}),
    lambda level: enclosed({level, "text", "other"}),
    lambda level: enclosed(enclosed(enclosed(level))),
    lambda level: enclosed(functools.partial(Screen(level).show, contrast=1)),
    lambda level: enclosed(1.0, extra=level),
    lambda level: eval(f"lambda eye, contrast: contrast + {level}"),
    lambda level: enclosed(jnp.asarray(level)),
    lambda level: enclosed(lgmd.LGMD2(lgmd.Parameters(tau1=level))),
    lambda level: enclosed(jax.random.key(int(level))),
    lambda level: enclosed(np.random.default_rng(int(level))),
]


@pytest.mark.parametrize("maker", MAKERS)
def test_another_value_is_another_stimulus_and_the_same_one_is_not(maker):
    assert fingerprint(maker(200.0)) == fingerprint(maker(200.0))
    assert fingerprint(maker(200.0)) != fingerprint(maker(60.0))


def test_globals_count_as_far_as_they_are_named(monkeypatch):
    before, other = fingerprint(of_a_global), fingerprint(renders)
    monkeypatch.setattr(f"{__name__}.LEVEL", 60.0)
    assert fingerprint(of_a_global) != before
    assert fingerprint(renders) == other


def test_variables_of_other_modules_of_ones_own_count():
    settings, inner = types.ModuleType("settings_of_mine"), types.ModuleType("settings_of_mine.inner")
    vars(settings)["inner"] = inner
    vars(inner)["level"] = 200.0

    def renderer(eye, *, contrast):
        return renders(eye, contrast=contrast, background=settings.inner.level)

    before = fingerprint(renderer)
    assert fingerprint(renderer) == before
    vars(inner)["level"] = 60.0
    assert fingerprint(renderer) != before


def test_what_is_kept_of_a_property_does_not_count():
    screen = Kept(200.0)
    before = fingerprint(screen)
    assert screen.twice == 400.0
    assert fingerprint(screen) == before


def test_values_that_look_alike_differ():
    values = [1, 1.0, True, "1", None, (1,), [1], {1}, {1: 1}, np.ones(1), np.ones(1, "f4"), np.ones((1, 1)), b"1"]
    assert len({fingerprint(value) for value in values}) == len(values)
    assert fingerprint({"a": 1, "b": 2}) == fingerprint({"b": 2, "a": 1})
    same = [1.0]
    assert fingerprint([same, same]) == fingerprint([[1.0], [1.0]])


def test_a_circle_ends():
    circle: list[Any] = [1]
    circle.append(circle)
    other: list[Any] = [2]
    other.append(other)
    assert fingerprint(circle) != fingerprint(other)


def test_what_cannot_be_told_is_refused(tmp_path):
    with (
        open(tmp_path / "file", "w") as file,
        pytest.raises(ValueError, match="an object of type TextIOWrapper has no content that can be compared"),
    ):
        fingerprint(enclosed(file))


def test_it_is_the_same_in_another_process():
    """Order of sets and addresses of objects differ there."""
    program = (
        "from tests.compute.test_fingerprint import *; "
        "print(fingerprint([maker(200.0) for maker in MAKERS[:-4]]), fingerprint(lgmd.stimuli.looming))"
    )
    texts = [
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    ]
    assert texts[0] == texts[1] != ""


def test_the_store_of_another_factory_is_refused(tmp_path):
    eye = lgmd.Eye(rows=10, cols=13, degrees_per_pixel=7.0, fps=50.0)
    axis: dict[str, Any] = {"contrast": [-0.9, -0.5]}
    first = lgmd.sweep(lgmd.LGMD2(), enclosed(200.0), eye, **axis, store=tmp_path / "sweep.zarr").load()
    with pytest.raises(ValueError, match=r"sweep\.zarr holds another sweep"):
        lgmd.sweep(lgmd.LGMD2(), enclosed(60.0), eye, **axis, store=tmp_path / "sweep.zarr")
    again = lgmd.sweep(lgmd.LGMD2(), enclosed(200.0), eye, **axis, store=tmp_path / "sweep.zarr")
    assert again.identical(first)
    other = lgmd.sweep(lgmd.LGMD2(), enclosed(60.0), eye, **axis, store=tmp_path / "other.zarr")
    assert np.abs(other.peak - first.peak).max() > 1e-3
