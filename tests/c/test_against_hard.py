"""What the C computes, beside the hard model in double precision, on 100,000 random frames and on uneven clocks."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax import hard
from lgmd2jax._c.host import compiled
from lgmd2jax._network.low_pass import coefficient
from lgmd2jax._network.structure import structure_of
from tests import clips
from tests.c.programs import EYE, MODELS, files, tool

CLIPS, FRAMES = 2_000, 50
CHANNELS = hard.CHANNELS


@functools.cache
def random_films():
    """Clips in each frame of which some of the pixels, all to none, get another grey level of the clip's range."""

    def levels():
        return generator.integers(low, high, (CLIPS, EYE.rows, EYE.cols))

    generator = np.random.default_rng(0)
    low = generator.integers(0, 200, (CLIPS, 1, 1))
    high = low + 1 + np.ceil(generator.random((CLIPS, 1, 1)) ** 2 * (255 - low)).astype(int)
    films = [levels()]
    for _ in range(FRAMES - 1):
        share = (generator.random((CLIPS, 1, 1)) < 0.6) * generator.random((CLIPS, 1, 1)) ** 4
        films.append(np.where(generator.random(films[0].shape) < share, levels(), films[-1]))
    return np.stack(films, axis=1).astype(np.uint8)


def hard_responses(model, films):
    """The responses, and in which frames no threshold lies within rounding of single precision."""
    v, size = model.parameters, "size" in model.mechanisms
    lasts = 1.0 if "lamina" in model.mechanisms else coefficient(v.tau1, jnp.asarray(1000 / EYE.fps), model.low_pass)
    step = lasts * v.T_p

    def margin(layers):
        of_size = jnp.abs(layers.d_on + layers.d_off - step).min() if size else jnp.inf
        return jnp.minimum(jnp.abs(layers.s - v.T_s).min(), of_size)

    response = jax.jit(jax.vmap(lambda film: model(film, EYE.fps, record=margin)))(films)
    channels = {name: np.asarray(getattr(response, name)) for name in CHANNELS}
    rises = np.diff(channels["smp"], axis=1, prepend=0.5)
    clear = (np.asarray(response.recorded) > 1e-5) & (np.abs(rises - float(v.T_sfa)) > 1e-6)
    if "shunt" not in model.mechanisms:
        clear &= np.abs(channels["ffi"] / float(v.A_ffi if size else v.T_ffi) - 1) > 1e-6
    return channels, clear


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("the paper's circuit", marks=pytest.mark.slow),
        pytest.param("persistence, exact low-pass", marks=pytest.mark.slow),
        "all mechanisms",
        pytest.param("size behind a lamina", marks=pytest.mark.slow),
        pytest.param("habituation behind a lamina", marks=pytest.mark.slow),
    ],
)
def test_a_hundred_thousand_random_frames(name, record_property, untyped):
    """Equal, but for clips in which a frame lies within rounding of a threshold, from there on: these are counted."""
    tool("cc")
    films, model = random_films(), MODELS[name]
    expected, clear = hard_responses(model, films)
    program, interval = compiled(files(name), EYE.rows, EYE.cols), np.full(FRAMES, 1000 / EYE.fps)
    responses = [program(film, interval) for film in films]
    here = {channel: np.stack([getattr(response, channel) for response in responses]) for channel in CHANNELS}

    comparable = np.logical_and.accumulate(clear, axis=1)
    u = expected["smp_adapted"]
    first, second = float(model.parameters.T_sp), float(model.parameters.T_sp + model.parameters.sigma_sp)
    near = np.minimum(np.abs(u - first), np.abs(u - second)) < 1e-5
    other = (here["spikes"] != expected["spikes"]) | (here["collision"] != expected["collision"])
    strays = other & comparable & ~near
    worst = np.max(np.abs(here["mp"] - expected["mp"])[comparable] / np.maximum(expected["mp"][comparable], 1e-9))
    record_property(
        "table",
        f"{name}: {comparable.sum():,} of {clear.size:,} frames compared, the others follow a tie; MP to {worst:.1g}; "
        f"U' within 1e-5 of a threshold in {near.sum()}; other spikes or alarms: {other.sum()} in all, "
        f"{(other & near).sum()} of these near, {strays.sum()} elsewhere",
    )
    assert comparable.mean() > 0.995
    assert worst < 1e-4
    assert not strays.any()
    assert np.abs(here["smp_adapted"] - u)[comparable & ~near].max() < 1e-5
    counts = [(expected["spikes"] == count).sum() for count in (1, 2)]
    assert min(*counts, expected["collision"].sum()) > 50  # there is something to compare


@pytest.mark.parametrize("name", MODELS)
def test_an_uneven_clock(name):
    tool("cc")
    model = MODELS[name]
    frames = np.round(clips.loom(1, (60, EYE.rows, EYE.cols))).astype(np.uint8)
    interval = np.random.default_rng(1).choice([2.5, 10.0, 20.0, 60.0], len(frames))
    values = {key: float(value) for key, value in vars(model.parameters).items()}
    oracle = hard.HardLGMD2(values, **structure_of(model))
    expected = hard.Response.over_time(oracle.step(f, ms) for f, ms in zip(frames, interval, strict=True))
    response = compiled(files(name), EYE.rows, EYE.cols)(frames, interval)
    assert hard.first_difference(response, expected, 1e-5) is None
    np.testing.assert_allclose(response.mp_sides, expected.mp_sides, rtol=1e-5, atol=1e-5 * expected.mp.max())
    assert np.ptp(expected.mp_sides, axis=1).max() > 0.1 * expected.mp.max()  # the sides are told apart
    assert len(np.unique(expected.smp_adapted)) > 5


def test_frames_of_another_size_are_refused():
    tool("cc")
    program = compiled(files("the paper's circuit"), EYE.rows, EYE.cols)
    with pytest.raises(ValueError, match=r"frames has shape \(2, 15, 12\); the program is compiled for 12 x 15"):
        program(np.zeros((2, 15, 12), np.uint8), np.ones(2))


def test_what_does_not_compile_is_one_line():
    tool("cc")
    broken = files("the paper's circuit") | {"lgmd2.c": "#error out of order\n#error twice\n"}
    with pytest.raises(ValueError, match=r"does not compile lgmd2\.c: .*out of order") as refusal:
        compiled(broken, 8, 10)
    assert "\n" not in str(refusal.value)
    assert "twice" not in str(refusal.value)


def test_without_a_compiler_it_says_so(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(ValueError, match="there is no C compiler"):
        compiled(files("the paper's circuit"), 8, 10)
