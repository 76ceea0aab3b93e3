"""The mechanisms that the paper's circuit does not have: against loops over pixels, in their limits, taken out."""

import dataclasses
from itertools import product
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax._network.stages import Sums
from tests import clips, oracle

# Nothing is zero, and the clip crosses every threshold.
VALUES: dict[str, Any] = {
    "theta1": 0.4, "theta2": 1.3, "theta3": 0.002, "tau1": 20.0, "tau3": 300.0, "T_s": 12.0, "T_ffi": 17.0,
    "T_sfa": 0.01, "T_sp": 0.6, "sigma_sp": 0.08, "k": 3.0, "u": 0.7, "N_sp": 2.0, "T_p": 50.0, "tau_hold": 60.0,
    "A_ffi": 0.2, "m": 3.0, "gamma": 0.7, "lag": 37.0, "tau_cell": 15.0, "tau_lamina": 60.0,
    "tau_hab": 90.0, "S_hab": 20.0,
}  # fmt: skip
PARAMETERS = lgmd.Parameters(**VALUES)
FRAMES = clips.patchy(33, (14, 5, 7))
INTERVALS = np.random.default_rng(1).uniform(15, 60, len(FRAMES))
EVERY = ("size", "shunt", "lag", "membrane", "rate")
COMBINATIONS = [
    (*size, *shunt, *lag)
    for size, shunt, lag in product(((), ("size",)), ((), ("shunt",), ("shunt", "membrane")), ((), ("lag",)))
]
WITH_LAMINA = ("size", "shunt", "lag", "membrane", "lamina", "habituation")
COMBINATIONS += [("rate",), ("size", "rate"), EVERY, ("lamina",), ("size", "lamina"), ("habituation",), WITH_LAMINA]


def structures(mechanisms) -> list[dict[str, Any]]:
    """Those that go with the mechanisms."""
    frames = (0,) if "lamina" in mechanisms else (0, 1)
    return [{"n_p": n_p, "low_pass": form} for n_p in frames for form in ("backward_euler", "exact")]


# Each combination once hard and once soft, with every structure among them; with the others where time is no matter.
CASES = [
    pytest.param(mechanisms, structure, temperature, marks=() if j == (i + 3 * soft) % len(own) else pytest.mark.slow)
    for i, mechanisms in enumerate(COMBINATIONS)
    for own in (structures(mechanisms),)
    for j, structure in enumerate(own)
    for soft, temperature in enumerate((None, 0.3))
]


def values(**changes: float) -> dict[str, float]:
    return {name: float(getattr(PARAMETERS, name)) for name in lgmd.symbols()} | changes


def as_hard(v: dict[str, float], mechanisms=(), **structure: Any) -> hard.HardLGMD2:
    """The NumPy model."""
    return hard.HardLGMD2(v, mechanisms=mechanisms, **structure)


def streamed(model: lgmd.LGMD2, frames=FRAMES, intervals=INTERVALS) -> dict[str, np.ndarray]:
    state, answers = model.init(frames[0]), []
    for frame, interval in zip(frames, intervals, strict=True):
        state, now = model.step(state, frame, interval=interval)
        answers.append([getattr(now, channel) for channel in oracle.CHANNELS])
    return dict(zip(oracle.CHANNELS, np.transpose(answers), strict=True))


def assert_equal(response, expected, tolerance=1e-10):
    """To the tolerance: of the largest value for MP and Fbar, and as it is for what lies between 0 and 2."""
    for channel in oracle.CHANNELS:
        atol = tolerance * (np.abs(expected[channel]).max() if channel in ("mp", "ffi") else 1.0)
        np.testing.assert_allclose(response[channel], expected[channel], atol=atol, rtol=0, err_msg=channel)


@pytest.mark.parametrize(("mechanisms", "structure", "temperature"), CASES, ids=str)
def test_agrees_with_loops_over_pixels(mechanisms, structure, temperature):
    """Clip and stream, by an uneven clock."""
    thresholds = lgmd.Hard() if temperature is None else lgmd.Soft(temperature)
    model = lgmd.LGMD2(PARAMETERS, thresholds, mechanisms=mechanisms, **structure)
    clock = {"intervals": INTERVALS.tolist(), "mechanisms": mechanisms}
    expected = oracle.respond(FRAMES.tolist(), None, values(), temperature, **structure, **clock)
    assert_equal(vars(model(FRAMES, interval=INTERVALS)), expected)
    assert_equal(streamed(model), expected)


@pytest.mark.parametrize(
    ("mechanisms", "structure"), [(each, structure) for each in COMBINATIONS for structure in structures(each)], ids=str
)
def test_numpy_model_agrees_with_loops_over_pixels(mechanisms, structure):
    model = as_hard(values(), mechanisms, **structure)
    response = hard.Response.over_time(
        [model.step(frame, interval) for frame, interval in zip(FRAMES, INTERVALS, strict=True)]
    )
    clock = {"intervals": INTERVALS.tolist(), "mechanisms": mechanisms}
    assert_equal(response._asdict(), oracle.respond(FRAMES.tolist(), None, values(), **structure, **clock))


@pytest.mark.parametrize("lag", [0.0, 100 / 3, 50.0, 80.0], ids=lambda ms: f"{ms:g} ms")
def test_a_lag_by_a_steady_clock(lag):
    """None, of a whole frame, of a part of one, and the longest."""
    model = lgmd.LGMD2(dataclasses.replace(PARAMETERS, lag=jnp.asarray(lag)), mechanisms=("lag",))
    expected = oracle.respond(FRAMES.tolist(), 30.0, values(lag=lag), mechanisms=("lag",))
    assert_equal(vars(model(FRAMES, 30.0)), expected)
    assert_equal(streamed(model, FRAMES, np.full(len(FRAMES), 1000 / 30)), expected)
    assert_equal(as_hard(values(lag=lag), ("lag",))(FRAMES, 30.0)._asdict(), expected)


def test_a_lag_by_a_fast_clock():
    """80 frames late at 1000 frames per second. An uneven one forgets them, unless an eye says so; not 0, but NaN."""
    frames, slow = clips.patchy(1, (120, 3, 4)), dataclasses.replace(PARAMETERS, lag=jnp.asarray(80.0))
    eye = lgmd.Eye(rows=3, cols=4, degrees_per_pixel=2.0, fps=1000.0)
    known = lgmd.LGMD2(slow, eye=eye, mechanisms=("lag",))
    expected = oracle.respond(frames.tolist(), 1000.0, values(lag=80.0), mechanisms=("lag",))
    assert_equal(vars(known(frames)), expected)
    assert np.any(known(frames).smp > 0.5)
    by_a_steady_clock = lgmd.LGMD2(slow, mechanisms=("lag",))(frames, 1000.0)
    assert_equal(vars(by_a_steady_clock), expected)
    unknown = eqx.filter_jit(lgmd.LGMD2(slow, mechanisms=("lag",)))(frames, interval=np.ones(120))
    np.testing.assert_array_equal(np.isfinite(unknown.smp), np.arange(120) < 41)


def test_a_lag_does_not_drift_in_a_long_clip():
    """In single precision a clock of hours is no better than milliseconds, but ages are."""
    single = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), lgmd.LGMD2(PARAMETERS, mechanisms=("lag",)))
    sums = Sums(*(jnp.asarray(np.random.default_rng(0).uniform(0, 20, 30_000), jnp.float32) for _ in range(2)))
    late = np.asarray(single.respond(sums, jnp.asarray(1000 / 30), 12).ffi)
    again = np.asarray(single.respond(Sums(*(x[-300:] for x in sums)), jnp.asarray(1000 / 30), 12).ffi)
    np.testing.assert_allclose(late[-100:], again[-100:], rtol=1e-5)


@pytest.mark.parametrize(("mechanisms", "n_p"), [(EVERY, 1), (WITH_LAMINA[:-1], 0)], ids=["persistence", "lamina"])
@pytest.mark.parametrize("precision", ["float32", pytest.param("float64", marks=pytest.mark.slow)])
def test_stepping_equals_the_scan_to_the_bit(precision, mechanisms, n_p):
    frames = FRAMES.astype(precision)
    model = lgmd.LGMD2(PARAMETERS, lgmd.Soft(0.5), n_p=n_p, low_pass="exact", mechanisms=mechanisms)
    clip = model(frames, interval=INTERVALS)
    for channel, course in streamed(model, frames).items():
        np.testing.assert_array_equal(course, getattr(clip, channel), err_msg=channel)


def test_the_clip_crosses_every_threshold():
    for mechanisms in ((), EVERY[:1], EVERY, ("lamina",), ("size", "lamina"), ("habituation",), WITH_LAMINA):
        out = oracle.respond(FRAMES.tolist(), None, values(), mechanisms=mechanisms, intervals=INTERVALS.tolist())
        share = 1 if "lamina" in mechanisms else INTERVALS / (INTERVALS + VALUES["tau1"])
        height = VALUES["T_p"] * share * np.ones(len(FRAMES))
        threshold = VALUES["A_ffi"] if "size" in mechanisms else VALUES["T_ffi"]
        for distance in (
            np.array(out["s"]) - VALUES["T_s"],
            np.array(out["d"]) - height[:, None, None],
            np.array(out["ffi"]) - threshold,
            np.array(out["rise"]) - VALUES["T_sfa"],
            np.array(out["collision"]) - 0.5,
        ):
            assert distance.min() < 0 < distance.max()
        assert set(out["spikes"]) == {0.0, 1.0, 2.0}


@pytest.mark.parametrize(
    ("mechanisms", "n_p"),
    [(EVERY, 1), (WITH_LAMINA, 0), pytest.param(("size",), 1, marks=pytest.mark.slow)],
    ids=str,
)
def test_soft_goes_to_hard(mechanisms, n_p):
    def model(thresholds):
        return lgmd.LGMD2(PARAMETERS, thresholds, n_p=n_p, mechanisms=mechanisms)

    wanted, differences = model(lgmd.Hard())(FRAMES, 30.0), []
    for temperature in (1.0, 0.1, 0.01, 0.001, 0.0001):
        soft = model(lgmd.Soft(temperature))(FRAMES, 30.0)
        differences.append(
            [
                np.abs(getattr(soft, name) - getattr(wanted, name)).max() / np.ptp(getattr(wanted, name))
                for name in oracle.CHANNELS
            ]
        )
    differences = np.array(differences)
    assert np.all(differences[0, :2] > 1e-3), "at temperature 1 the soft model should differ"
    assert np.all(np.diff(differences, axis=0) <= 0)
    assert np.all(differences[-1] < 1e-6)
    straight = model(lgmd.StraightThrough(0.5))(FRAMES, 30.0)
    for name in oracle.CHANNELS:
        np.testing.assert_allclose(getattr(straight, name), getattr(wanted, name), rtol=1e-12, err_msg=name)


def test_soft_size_rests_where_nothing_moves():
    """Without its value at rest, a soft threshold would count every pixel a little, and add that up."""
    still = np.repeat(FRAMES[:1], 200, axis=0)
    response = lgmd.LGMD2(PARAMETERS, lgmd.Soft(1.0), mechanisms=("size",))(still, 30.0)
    assert np.all(response.ffi == 0)


@pytest.mark.parametrize("size", [(), ("size",)], ids=str)
def test_a_steep_shunt_is_the_gate(size):
    """With m = 1e6 and gamma = 1, but for eps = 1e-3 to the power of 1, which cancels."""
    steep = dataclasses.replace(PARAMETERS, m=jnp.asarray(1e6), gamma=jnp.asarray(1.0))
    gate = lgmd.LGMD2(PARAMETERS, mechanisms=size)(FRAMES, 30.0)
    shunt = lgmd.LGMD2(steep, mechanisms=(*size, "shunt"))(FRAMES, 30.0)
    threshold = VALUES["A_ffi"] if size else VALUES["T_ffi"]
    assert np.abs(gate.ffi / threshold - 1).min() > 1e-4  # nowhere on the threshold
    assert 0 < np.sum(gate.ffi > threshold) < len(FRAMES)
    assert_equal(vars(shunt), vars(gate), 1e-12)
    plain = as_hard(values(m=1e6, gamma=1.0), (*size, "shunt"))(FRAMES, 30.0)
    assert_equal(plain._asdict(), vars(gate), 1e-12)


def test_an_unlimited_shunt_does_not_overflow():
    """Fbar from 0 to far above the threshold, at the steepest shunt that is allowed, in single precision."""
    single = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), dataclasses.replace(PARAMETERS, m=jnp.asarray(1e30)))
    frames = np.concatenate([np.full((3, 4, 5), 0.0), np.full((3, 4, 5), 255.0)]).astype(np.float32)
    value, slope = jax.value_and_grad(lambda p: lgmd.LGMD2(p, mechanisms=("shunt",))(frames, 30.0).smp.sum())(single)
    assert all(np.isfinite(leaf) for leaf in (value, *jax.tree.leaves(slope)))


def test_a_membrane_without_time_constant_is_none():
    for form in ("backward_euler", "exact"):
        fast = dataclasses.replace(PARAMETERS, tau_cell=jnp.asarray(0.0))
        without = lgmd.LGMD2(fast, low_pass=form, mechanisms=("shunt",))(FRAMES, 30.0)
        with_it = lgmd.LGMD2(fast, low_pass=form, mechanisms=("shunt", "membrane"))
        assert_equal(vars(with_it(FRAMES, 30.0)), vars(without), 1e-12)
        numpy_model = as_hard(values(tau_cell=0.0), ("shunt", "membrane"), low_pass=form)
        assert_equal(numpy_model(FRAMES, 30.0)._asdict(), vars(without), 1e-12)


@pytest.mark.parametrize("thresholds", [lgmd.Hard(), lgmd.Soft(0.5)], ids=["hard", "soft"])
def test_off_is_off_to_the_bit(thresholds):
    """The plain network, and what is left of one from which all mechanisms are taken out."""
    plain = lgmd.LGMD2(PARAMETERS, thresholds)(FRAMES, 30.0)
    for mechanisms in (EVERY, ("size",), ("lag", "shunt"), WITH_LAMINA):
        left = lgmd.ablate(lgmd.LGMD2(PARAMETERS, thresholds, mechanisms=mechanisms), *mechanisms[::-1])
        for channel in oracle.CHANNELS:
            np.testing.assert_array_equal(getattr(left(FRAMES, 30.0), channel), getattr(plain, channel))


# What the formulas are for


def at(fps: float, rows: int, cols: int, **changes: float) -> lgmd.LGMD2:
    """A model with size-coding inhibition, taken from 100 frames per second to another rate; its window stays."""
    eye = lgmd.Eye(rows, cols, 2.0, 100.0)
    model = lgmd.LGMD2(lgmd.Parameters(**changes), eye=eye, mechanisms=("size",))
    return dataclasses.replace(lgmd.at_frame_rate(model, fps), N_ts=model.N_ts, eye=None)


def smallest_step(fps: float) -> float:
    """The height of a step of luminance from which a pixel counts as changed, by bisection.

    For a small sigma1: where much of a flow is left after a frame, D goes on rising, and smaller steps count.
    """
    model, low, high = at(fps, 5, 5, sigma1=0.0457, tau1=23.1), 1.0, 100.0
    while high - low > 0.02:
        height = (low + high) / 2
        frames = np.full((24, 5, 5), 100.0)
        frames[2:, 2, 2] += height
        low, high = (low, height) if np.any(np.asarray(model(frames, fps).ffi) > 0) else (height, high)
    return high


def test_the_smallest_step_that_counts_is_the_same_at_all_frame_rates():
    heights = np.array([smallest_step(fps) for fps in (30.0, 60.0, 100.0, 200.0)])
    np.testing.assert_allclose(heights, float(lgmd.Parameters().T_p), rtol=0.05)


def test_noise_fills_more_of_the_field_at_higher_rates(record_property):
    """D adds up the changes of many frames, while a step is seen in one, so T_p has to rise with rate and noise."""
    rates = (30.0, 60.0, 100.0, 200.0)
    shares = [lgmd.inhibition_in_noise(at(fps, 12, 16), 2.0, fps) for fps in rates]
    rows = [f"{fps:4g} fps  M {share:.1%} of A_ffi" for fps, share in zip(rates, shares, strict=True)]
    record_property("table", "\n".join(["noise of 2 grey levels, T_p 19, A_ffi .09", *rows]))
    assert shares == sorted(shares)
    assert shares[0] < 0.01
    assert shares[2] > 1
    higher = eqx.tree_at(lambda model: model.parameters.T_p, at(100.0, 12, 16), jnp.asarray(38.0))
    assert lgmd.inhibition_in_noise(higher, 2.0, 100.0) < 0.01


def test_inhibition_in_noise_without_size_coding_is_the_mean_change():
    """P is the difference of two frames: its mean magnitude is 2 noise/sqrt(pi)."""
    expected = 2 * 3.0 / np.sqrt(np.pi) / float(lgmd.Parameters().T_ffi)
    assert lgmd.inhibition_in_noise(lgmd.LGMD2(), 3.0, fps=50.0) == pytest.approx(expected, rel=0.02)
    with pytest.raises(ValueError, match="fps is missing"):
        lgmd.inhibition_in_noise(lgmd.LGMD2())


def test_figures_draw_the_threshold_that_acts_in_its_unit():
    plain, size = lgmd.LGMD2(), lgmd.LGMD2(mechanisms=("size",))
    assert (plain.levels.ffi, plain.levels.inhibited_from) == (10.0, "T_ffi")
    assert (size.levels.ffi, size.levels.inhibited_from) == (pytest.approx(0.09), "A_ffi")
    assert plain.levels.spikes == size.levels.spikes
    assert (plain.channels["ffi"].unit, size.channels["ffi"].unit) == ("grey level", "1")
    assert "1/30 s" in lgmd.LGMD2(mechanisms=("rate",)).channels["ffi"].label


def test_the_share_of_the_field_does_not_depend_on_contrast():
    """A square that grows a pixel a frame covers the same share whatever its contrast, from T_p on."""
    shares = []
    for contrast in (-0.25, -0.5, -1.0):
        frames = np.full((12, 21, 21), 200.0)
        for t in range(1, 12):
            frames[t, 11 - t : 10 + t, 11 - t : 10 + t] = 200 * (1 + contrast)
        model = lgmd.LGMD2(lgmd.Parameters(tau_hold=1e6), mechanisms=("size",))
        shares.append(model(frames, 100.0).ffi)
    np.testing.assert_allclose(shares[0], shares[2], rtol=1e-4)
    np.testing.assert_allclose(shares[1], shares[2], rtol=1e-4)
    plain = lgmd.LGMD2()(np.where(frames < 100, 100.0, frames), 100.0).ffi
    assert plain[-1] < 0.6 * lgmd.LGMD2()(frames, 100.0).ffi[-1]


def test_times_and_shares_stay_at_another_frame_rate():
    eye = lgmd.Eye(rows=5, cols=7, degrees_per_pixel=2.0, fps=50.0)
    model = lgmd.LGMD2(PARAMETERS, eye=eye, mechanisms=EVERY)
    other = lgmd.at_frame_rate(model, 200.0)
    assert other.mechanisms == EVERY
    for name, symbol in lgmd.symbols().items():
        if symbol.mechanism is not None and name != "S_hab":  # which is compared with changes in a frame
            assert float(getattr(other.parameters, name)) == VALUES[name], name


def test_change_per_time_at_the_rate_of_the_reference_is_that_per_frame():
    with_it, without = (lgmd.LGMD2(PARAMETERS, mechanisms=mechanisms) for mechanisms in (("rate",), ()))
    assert_equal(vars(with_it(FRAMES, 30.0)), vars(without(FRAMES, 30.0)), 1e-15)


@pytest.mark.parametrize("fps", [10.0, 60.0])
def test_what_is_compared_with_change_per_time_stays_at_another_rate(fps):
    """And the cell sees of an edge, however often it is looked at, the same inhibition: its speed times its height."""
    eye = lgmd.Eye(rows=5, cols=200, degrees_per_pixel=1.0, fps=30.0)
    model = lgmd.LGMD2(lgmd.Parameters(T_ffi=9.0, k=0.7, tau2=5.0), eye=eye, mechanisms=("rate",))
    other = lgmd.at_frame_rate(model, fps)
    kept = {name: float(getattr(other.parameters, name)) for name in ("T_ffi", "k", "T_s", "T_sfa")}
    assert kept == pytest.approx({"T_ffi": 9.0, "k": 0.7, "T_s": 300 / fps, "T_sfa": 0.03 / fps})

    def edge(rate):
        """It crosses 60 pixels a second, whole ones in a frame at both rates."""
        place = 60 / rate * np.arange(round(rate))
        return np.where(np.arange(200.0) < place[:, None, None], 50.0, np.full((1, 5, 1), 200.0))

    one, many = (float(own(edge(rate), rate).ffi[-1]) for own, rate in ((model, 30.0), (other, fps)))
    assert many == pytest.approx(one, rel=1e-6)
    assert one == pytest.approx(150 * 60 / 200 / 30, rel=1e-6)


# Structure


@pytest.mark.parametrize(
    ("mechanisms", "mechanism", "left"),
    [
        (EVERY, "size", ("shunt", "lag", "membrane", "rate")),
        (EVERY, "shunt", ("size", "lag", "rate")),
        (EVERY, "lag", ("size", "shunt", "membrane", "rate")),
        (EVERY, "membrane", ("size", "shunt", "lag", "rate")),
        (EVERY, "rate", ("size", "shunt", "lag", "membrane")),
        (WITH_LAMINA, "lamina", ("size", "shunt", "lag", "membrane", "habituation")),
        (WITH_LAMINA, "size", ("shunt", "lag", "membrane", "lamina", "habituation")),
        (WITH_LAMINA, "habituation", ("size", "shunt", "lag", "membrane", "lamina")),
    ],
)
def test_ablation_takes_a_mechanism_out(mechanisms, mechanism, left):
    whole = lgmd.LGMD2(PARAMETERS, mechanisms=mechanisms)
    without = lgmd.ablate(whole, mechanism)
    assert without.mechanisms == left
    assert_equal(vars(without(FRAMES, 20.0)), vars(lgmd.LGMD2(PARAMETERS, mechanisms=left)(FRAMES, 20.0)), 1e-15)
    assert not np.allclose(without(FRAMES, 20.0).smp, whole(FRAMES, 20.0).smp)


def test_the_order_of_ablations_does_not_matter():
    whole = lgmd.LGMD2(PARAMETERS, mechanisms=EVERY)
    assert lgmd.ablate(whole, "shunt", "membrane").mechanisms == lgmd.ablate(whole, "membrane", "shunt").mechanisms
    without = lgmd.ablate(whole, "size", "ffi")(FRAMES, 30.0)
    assert np.any(without.smp > lgmd.ablate(whole, "size")(FRAMES, 30.0).smp)


@pytest.mark.parametrize("mechanisms", [("size",), ("size", "shunt"), ("shunt",)], ids=str)
def test_without_inhibition_nothing_is_inhibited(mechanisms):
    """Whichever threshold inhibition has, and whatever it does to the cell."""
    model = lgmd.LGMD2(PARAMETERS, mechanisms=mechanisms)
    free = lgmd.ablate(model, "ffi")(FRAMES, 30.0)
    np.testing.assert_allclose(free.ffi, model(FRAMES, 30.0).ffi, rtol=1e-12)
    drive = np.abs(free.mp) / (FRAMES[0].size * VALUES["k"])
    if "shunt" in mechanisms:
        drive = (drive + 1e-3) ** VALUES["gamma"] - 1e-3 ** VALUES["gamma"]
    np.testing.assert_allclose(free.smp, 1 / (1 + np.exp(-drive)), rtol=1e-9)


UNUSED = [*((COMBINATIONS[i], i % 2) for i in (0, 1, 4, 6, 9, 11)), (("lamina",), 0)]


@pytest.mark.parametrize(("mechanisms", "n_p"), UNUSED, ids=str)
def test_what_is_unused_changes_nothing_and_the_rest_does(mechanisms, n_p):
    model, names = lgmd.LGMD2(PARAMETERS, lgmd.Soft(1.0), n_p=n_p, mechanisms=mechanisms), list(lgmd.symbols())
    factors = 1 + 0.1 * np.eye(len(names), len(names) + 1)  # a set for each that is moved, and one as it is
    sets = jax.vmap(lambda row: lgmd.Parameters(**{name: values()[name] * row[i] for i, name in enumerate(names)}))

    def run(parameters):
        response = dataclasses.replace(model, parameters=parameters)(FRAMES, 30.0)
        return jnp.stack([getattr(response, channel) for channel in oracle.CHANNELS])

    responses = np.asarray(jax.vmap(run)(sets(jnp.asarray(factors.T))))
    changed = np.any(responses[:-1] != responses[-1], axis=(1, 2))
    assert {name for name, changes in zip(names, changed, strict=True) if not changes} == model.unused


def built(mechanisms: Any) -> lgmd.LGMD2:
    return lgmd.LGMD2(mechanisms=mechanisms)


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: built(("membrane",)), r"mechanisms is \('membrane',\); a membrane needs the shunt"),
        (lambda: built(("lamina", "rate")), r"mechanisms is \('lamina', 'rate'\); with a lamina .*: remove 'rate'"),
        (lambda: lgmd.LGMD2(n_p=2, mechanisms=("lamina",)), "n_p is 2; a lamina .*: give n_p=0"),
        (lambda: as_hard(values(), ("rate", "lamina")), "mechanisms has a lamina, .*; remove rate"),
        (lambda: as_hard(values(), ("lamina",), n_p=1), "n_p is 1; a lamina .*: give n_p=0"),
        (lambda: lgmd.Parameters(tau_lamina=0.0), r"tau_lamina is 0 ms; it must lie in \(0, inf\)"),
        (lambda: built(("size", "sice")), "mechanisms has 'sice'; choose 'size'"),
        (lambda: built(("lag", "lag")), "mechanisms has 'lag' twice; name each once"),
        (lambda: built(["size"]), r"mechanisms is \['size'\]; give a tuple"),
        (lambda: built("size"), "mechanisms is 'size'; give a tuple"),
        (lambda: built(([],)), r"mechanisms is \(\[\],\); give a tuple"),
        (lambda: built(None), "mechanisms is None; give a tuple"),
        (lambda: lgmd.ablate(lgmd.LGMD2(), "size"), "mechanism is 'size'; choose"),
        (lambda: lgmd.ablate(built(("shunt",)), "membrane"), "mechanism is 'membrane'; choose"),
        (lambda: lgmd.Parameters(T_p=0.0), "T_p is 0 grey level; it must lie in"),
        (lambda: lgmd.Parameters(lag=81.0), r"lag is 81 ms; it must lie in \[0, 80\]"),
        (lambda: lgmd.Parameters(gamma=0.0), "gamma is 0; it must lie in"),
    ],
)
def test_misuse_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
