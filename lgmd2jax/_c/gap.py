"""How far the soft model, the hard one and its C lie apart, on films in whole grey levels, as a camera gives them."""

import dataclasses
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, UInt8

from lgmd2jax._c.host import Program
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.thresholds import Hard, Soft
from lgmd2jax._signals import stretches


class Film(NamedTuple):
    """What a camera saw, and for each frame ms since the one before."""

    name: str
    frames: UInt8[np.ndarray, "time row col"]
    interval: Float[np.ndarray, " time"]


class Gap(NamedTuple):
    """How far one model is from the hard one.

    - `difference`: the largest of U', the adapted potential; `film`: in which it is.
    - `other_counts`: frames with another number of spikes (soft ones rounded).
    - `moved_alarms`: alarms that do not begin in the same frame, those of one model alone included.
    """

    difference: float
    film: str
    other_counts: int
    moved_alarms: int


Programs = Callable[[int, int], Program]  # the C for frames of so many rows and columns


def gaps(model: LGMD2, films: Iterable[Film], temperature: float, programs: Programs | None) -> dict[str, Gap]:
    """The gap of the soft model and, where there are programs, of the C, each over all films.

    **Arguments:** `temperature` of the soft model; `programs`: the model in C, for each size of a frame.
    """
    hard, soft = (dataclasses.replace(model, thresholds=thresholds) for thresholds in (Hard(), Soft(temperature)))
    by_name: dict[str, list[Gap]] = {"soft": []} | ({} if programs is None else {"C": []})
    for film in films:
        expected = hard(film.frames, interval=film.interval)
        by_name["soft"].append(_gap(film, soft(film.frames, interval=film.interval), expected))
        if programs is not None:
            in_c = programs(*film.frames.shape[1:])(film.frames, film.interval)
            by_name["C"].append(_gap(film, in_c, expected))
    return {name: _over_films(each) for name, each in by_name.items()}


def _gap(film: Film, response, expected) -> Gap:
    """**Arguments:** a `Response` of the library, or of `hard.py`."""
    difference = np.abs(np.asarray(response.smp_adapted) - np.asarray(expected.smp_adapted)).max()
    other_counts = np.count_nonzero(np.round(response.spikes) != np.asarray(expected.spikes))
    one, other = _beginnings(response.collision), _beginnings(expected.collision)
    return Gap(float(difference), film.name, int(other_counts), max(len(one - other), len(other - one)))


def _beginnings(collision) -> set[int]:
    return {first for first, _ in stretches(np.asarray(collision) > 0.5)}


def _over_films(each: list[Gap]) -> Gap:
    widest = max(each, key=lambda gap: gap.difference)
    return widest._replace(
        other_counts=sum(gap.other_counts for gap in each), moved_alarms=sum(gap.moved_alarms for gap in each)
    )
