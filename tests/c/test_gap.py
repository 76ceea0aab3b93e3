"""The gap between the soft model, the hard one and its C: what is counted, on responses whose differences are known."""

import dataclasses
import functools

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax._c.gap import Film, gaps
from lgmd2jax._c.host import compiled
from tests import clips
from tests.c.programs import EYE, MODELS, files, tool

MODEL = MODELS["the paper's circuit"]


def film(name, seed):
    frames = np.round(clips.loom(seed, (40, EYE.rows, EYE.cols))).astype(np.uint8)
    return Film(name, frames, np.full(len(frames), 1000 / EYE.fps))


FILMS = [film("first", 0), film("second", 1)]


def changed(**changes):
    """A program that gives the hard response but for what is changed in the second film."""

    def program(frames, interval):
        response = MODEL(frames, interval=interval)
        channels = {name: np.array(getattr(response, name)) for name in hard.CHANNELS}
        if np.array_equal(frames, FILMS[1].frames):
            for name, change in changes.items():
                channels[name] = change(channels[name])
        return hard.Response(**channels)

    return lambda rows, cols: program


@pytest.mark.usefixtures("untyped")
def test_what_is_counted():
    def other_spikes(spikes):
        spikes[[3, 4, 7]] += 1
        return spikes

    def one_alarm_more(collision):
        assert not collision[:5].any()
        collision[2:4] = 1
        return collision

    same = gaps(MODEL, FILMS, 0.05, changed())["C"]
    assert same[0] == 0
    assert same[2:] == (0, 0)
    gap = gaps(
        MODEL, FILMS, 0.05, changed(smp_adapted=lambda u: u + 0.01, spikes=other_spikes, collision=one_alarm_more)
    )
    assert gap["C"].difference == pytest.approx(0.01)
    assert gap["C"][1:] == ("second", 3, 1)


def test_an_alarm_that_begins_later_moves_once():
    """The first model's alarm in one frame and the second's in another are one that moved, not two."""
    early, late = (dataclasses.replace(MODEL, parameters=dataclasses.replace(MODEL.parameters, N_sp=n)) for n in (1, 4))
    begins = [np.flatnonzero(np.asarray(own(FILMS[0].frames, EYE.fps).collision)) for own in (early, late)]
    assert begins[0][0] < begins[1][0]
    response = late(FILMS[0].frames, interval=FILMS[0].interval)
    channels = hard.Response(*(np.asarray(getattr(response, name)) for name in hard.CHANNELS))
    assert gaps(early, FILMS[:1], 0.05, lambda rows, cols: lambda frames, interval: channels)["C"].moved_alarms == 1


def test_the_soft_model_comes_nearer_as_it_cools_and_the_c_is_the_hard_one():
    tool("cc")
    programs = functools.cache(lambda rows, cols: compiled(files("the paper's circuit"), rows, cols))
    warm, cool = (gaps(MODEL, FILMS, temperature, programs) for temperature in (1.0, 0.01))
    assert 1e-4 < cool["soft"].difference < warm["soft"].difference
    assert cool["C"].difference < 1e-6
    assert cool["C"].other_counts == cool["C"].moved_alarms == 0
    assert set(gaps(MODEL, FILMS, 1.0, None)) == {"soft"}


def test_films_of_other_sizes_have_a_program_of_their_own():
    tool("cc")
    sizes = []

    def programs(rows, cols):
        sizes.append((rows, cols))
        return compiled(files("the paper's circuit"), rows, cols)

    wide = Film("wide", FILMS[0].frames.repeat(2, axis=2), FILMS[0].interval)
    gap = gaps(lgmd.LGMD2(MODEL.parameters), [FILMS[0], wide], 1.0, programs)["C"]
    assert sizes == [(EYE.rows, EYE.cols), (EYE.rows, 2 * EYE.cols)]
    assert gap.difference < 1e-6
