"""The model as its users call it: precision, compilation, transformations, misuse."""

import datetime
from typing import Any, cast

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import quantities as pq

import lgmd2jax as lgmd
from lgmd2jax import hard
from lgmd2jax._handover.model_file import as_hard
from tests import clips

FRAMES = clips.loom(0, (8, 7, 9))


@pytest.mark.parametrize("parameters", [jnp.float32, jnp.float64])
@pytest.mark.parametrize("frames", [np.uint8, np.int32, np.float32, np.float64])
def test_precision(frames, parameters):
    """Pixels compute in the frames' precision, the cell in the promotion with the parameters'."""
    single = jax.tree.map(lambda leaf: leaf.astype(parameters), lgmd.Parameters())
    response = lgmd.LGMD2(single)(FRAMES.astype(frames), 30.0, record=lambda layers: layers.s)
    pixels = parameters if np.issubdtype(frames, np.integer) else jnp.dtype(frames)
    assert response.recorded.dtype == pixels
    for channel in (response.mp, response.ffi, response.smp, response.smp_adapted, response.spikes, response.collision):
        assert channel.dtype == jnp.promote_types(pixels, parameters)


def test_integers_are_cast_before_they_are_subtracted():
    frames = np.round(FRAMES)
    model = lgmd.LGMD2(lgmd.Parameters(theta1=1.0, k=20.0))
    levels = frames.astype(np.uint8)
    expected = model(frames, 30.0).smp
    np.testing.assert_array_equal(model(levels, 30.0).smp, expected)
    state = model.init(levels[0])
    for level, smp in zip(levels, expected, strict=True):
        state, response = model.step(state, level, 30.0)
        assert response.smp == smp


@pytest.mark.parametrize("dtype", [">u2", ">i4", ">f4", ">f8"])
def test_the_order_of_bytes_does_not_matter(dtype):
    """Fiji, and some instruments, write the large end first."""
    model, frames = lgmd.LGMD2(), np.round(FRAMES).astype(dtype)
    native = frames.astype(frames.dtype.newbyteorder("="))
    np.testing.assert_array_equal(model(frames, 30.0).smp, model(native, 30.0).smp)
    state, expected = model.init(frames[0]), model(native, 30.0)
    for i, frame in enumerate(frames):
        state, now = model.step(state, frame, 30.0)
        assert now.smp == expected.smp[i]


@pytest.mark.parametrize("other", [{"N_ts": 7}, {"n_p": 1}, {"mechanisms": ("size",)}, {"mechanisms": ("lag",)}])
def test_a_state_of_another_structure_is_refused(other):
    """As one from before `at_frame_rate`, which changes how many frames are remembered."""
    model = lgmd.LGMD2(**other)
    state, _ = lgmd.LGMD2().step(lgmd.LGMD2().init(FRAMES[0]), FRAMES[0], 30.0)
    with pytest.raises(ValueError, match=r"belongs to a model of another structure; start again with init\(frame"):
        model.step(state, FRAMES[1], 30.0)
    own, _ = model.step(model.init(FRAMES[0]), FRAMES[0], 30.0)
    model.step(own, FRAMES[1], 30.0)


def test_the_model_itself_may_be_jitted():
    """A model hashes by value, as it is equal by value: to jit an equal one compiles nothing."""
    model = lgmd.LGMD2()
    jitted = jax.jit(model)
    np.testing.assert_array_equal(jitted(FRAMES, 30.0).smp, model(FRAMES, 30.0).smp)
    assert hash(lgmd.LGMD2()) == hash(model)
    assert hash(lgmd.LGMD2(lgmd.Parameters(k=0.3))) != hash(model)
    for changed in (lgmd.LGMD2(lgmd.Parameters(k=0.3)), lgmd.LGMD2(n_p=2)):
        np.testing.assert_array_equal(jax.jit(changed)(FRAMES, 30.0).smp, changed(FRAMES, 30.0).smp)


def test_compiles_once_for_a_shape():
    traces = []

    def record(layers):
        traces.append(1)
        return layers.s.sum()

    soft = lgmd.LGMD2(thresholds=lgmd.Soft(1.0))
    for fps, theta2, temperature in (
        (30.0, 1.0, 1.0),
        (25, 3.0, 0.5),
        (np.float32(60), 2, 2),
        (jnp.asarray(50.0), 1.5, 3),
    ):
        model = lgmd.LGMD2(lgmd.Parameters(theta2=theta2), lgmd.Soft(temperature))
        model(FRAMES + fps, fps, record=record)
    first = len(traces)
    soft(FRAMES, 30.0, record=record)
    assert len(traces) == first
    assert first <= 2  # lax.scan itself may look at its body twice

    soft(FRAMES[:, :5], 30.0, record=record)
    assert len(traces) > first


def test_what_nobody_records_costs_nothing():
    """The G layer is in the compiled program only where it is recorded."""

    def operations(record):
        run = jax.jit(lambda frames: lgmd.LGMD2()(frames, 30.0, record=record))
        analysis = run.lower(jnp.asarray(FRAMES)).compile().cost_analysis()
        return dict(analysis or {})["flops"]

    assert operations(lambda layers: layers.g) > operations(None)


def test_jit_vmap_and_filter_jit_agree():
    model = lgmd.LGMD2(lgmd.Parameters(theta1=0.4, k=20.0), lgmd.Soft())
    plain = model(FRAMES, 30.0).smp_adapted
    np.testing.assert_allclose(eqx.filter_jit(model)(FRAMES, 30.0).smp_adapted, plain, rtol=1e-12)
    np.testing.assert_allclose(jax.jit(lambda f, r: model(f, r).smp_adapted)(FRAMES, 30), plain, rtol=1e-12)
    rates = jnp.array([30.0, 60.0])
    by_rate = jax.vmap(model, in_axes=(None, 0))(jnp.asarray(FRAMES), rates).smp_adapted
    np.testing.assert_allclose(by_rate[0], plain, rtol=1e-12)
    assert not np.allclose(by_rate[1], plain)


def test_a_batch_of_parameters():
    thetas = jnp.array([0.5, 1.0, 4.0])
    models = jax.vmap(lambda theta2: lgmd.LGMD2(lgmd.Parameters(theta2=theta2, k=20.0)))(thetas)
    together = eqx.filter_vmap(lambda model: model(FRAMES, 30.0))(models)
    for i, theta2 in enumerate(thetas):
        single = lgmd.LGMD2(lgmd.Parameters(theta2=theta2, k=20.0))(FRAMES, 30.0)
        np.testing.assert_allclose(together.mp[i], single.mp, rtol=1e-12)


def test_the_eye_gives_the_frame_rate():
    eye = lgmd.Eye(rows=7, cols=9, degrees_per_pixel=2.0, fps=50.0)
    np.testing.assert_array_equal(lgmd.LGMD2(eye=eye)(FRAMES).smp, lgmd.LGMD2()(FRAMES, 50.0).smp)
    with pytest.warns(UserWarning, match="belong to 50 frames per second, not 30"):
        lgmd.LGMD2(eye=eye)(FRAMES, 30.0)


def test_another_frame_rate_is_warned_of_from_a_hundredth_on():
    model = lgmd.LGMD2(eye=lgmd.Eye(rows=7, cols=9, degrees_per_pixel=2.0, fps=50.0))
    model(FRAMES, 50.4)
    model(FRAMES, 49.6)
    for fps in (50.6, 49.4):
        with pytest.warns(UserWarning, match=f"belong to 50 frames per second, not {fps}"):
            model(FRAMES, fps)


def test_a_step_takes_the_time_since_the_last_frame():
    """One step over 80 ms relaxes the delays as the exact filter does over two of 40 ms with the same input."""
    model = lgmd.LGMD2(low_pass="exact")
    frame = jnp.full((3, 3), 100.0)
    state = model.init(frame)
    state, _ = model.step(state, frame + 50, interval=1e-9)  # loads the filters, no time passes
    once, _ = model.step(state, frame + 50, interval=80.0)
    twice, _ = model.step(model.step(state, frame + 50, interval=40.0)[0], frame + 50, interval=40.0)
    np.testing.assert_allclose(once.cell.ffi, twice.cell.ffi, rtol=1e-12)
    by_rate, _ = model.step(state, frame + 50, 12.5)
    np.testing.assert_array_equal(by_rate.cell.ffi, once.cell.ffi)


def built(**fields: Any) -> lgmd.LGMD2:
    return lgmd.LGMD2(**fields)


def test_repr_says_how_thresholds_act_and_what_the_parameters_are():
    text = repr(lgmd.LGMD2(lgmd.Parameters(k=2.5), lgmd.Soft(0.5), N_ts=3))
    assert text.startswith("LGMD2(Soft(0.5), n_p=0, low_pass='backward_euler', N_ts=3, mechanisms=(), eye=None,")
    assert "k          = 2.5" in text


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda model: model(FRAMES[0], 30.0), r"frames has shape \(7, 9\)"),
        (lambda model: model(FRAMES[None], 30.0), r"frames has shape \(1, 8, 7, 9\)"),
        (lambda model: model(FRAMES[:1], 30.0), "frames holds one frame"),
        (lambda model: model(FRAMES[:0], 30.0), "frames holds 0 frames"),
        (lambda model: model(FRAMES[:, :2], 30.0), "at least 3 rows and 3 columns"),
        (lambda model: model(FRAMES[:, :, :2], 30.0), "at least 3 rows and 3 columns"),
        (lambda model: model("clip.mp4", 30.0), "frames is 'clip.mp4'"),
        (lambda model: model(FRAMES, 30.0, record="mp"), "record is 'mp'; give a function of the layers"),
        (lambda model: model(FRAMES, fsp=30.0), "takes no 'fsp'; choose 'fps'"),
        (lambda model: model(None, 30.0), "frames is None; give an array of grey levels"),
        (lambda model: model([FRAMES[0], FRAMES[1, :5]], 30.0), "give an array of grey levels"),
        (lambda model: model(FRAMES.astype(np.longdouble), 30.0), "frames has dtype float128; give an array"),
        (lambda model: model(np.ma.masked_greater(FRAMES, 200), 30.0), "frames is masked; fill what is masked with"),
        (lambda model: model(FRAMES.astype(complex), 30.0), "dtype complex128"),
        (lambda model: model(FRAMES.astype(np.float16), 30.0), "dtype float16"),
        (lambda model: model(np.where(FRAMES > 200, np.nan, FRAMES), 30.0), "not finite, first in frame 0"),
        (lambda model: model(np.concatenate([FRAMES, FRAMES[:1] * np.inf]), 30.0), "not finite, first in frame 8"),
        (lambda model: model(FRAMES, 0), "fps is 0"),
        (lambda model: model(FRAMES, -30.0), "fps is -30.0"),
        (lambda model: model(FRAMES, np.nan), "fps is nan"),
        (lambda model: model(FRAMES, np.array([30.0, 60.0])), r"fps is array\(\[30., 60.\]"),
        (lambda model: model(FRAMES, "fast"), "fps is 'fast'"),
        (lambda model: model(FRAMES), "fps is missing"),
        (lambda model: model.step(model.init(FRAMES[0]), FRAMES[0, :5], 30.0), r"frame has shape \(5, 9\), the state"),
        (lambda model: model.step(model.init(FRAMES[0]), FRAMES[0] * np.nan, 30.0), "not finite"),
        (lambda model: model.step(FRAMES[0], FRAMES[1], 30.0), "state is array.*; give the one that init or the last"),
        (lambda model: model.step(model.init(FRAMES[0]), FRAMES[0], 30.0, interval=20.0), "both given"),
        (lambda model: model.step(model.init(FRAMES[0]), FRAMES[0], interval=0.0), "interval is 0.0"),
        (lambda model: model.init(FRAMES), r"frame has shape \(8, 7, 9\)"),
        (
            lambda model: eqx.tree_at(lambda m: m.parameters.tau1, model, jnp.asarray(-5.0))(FRAMES, 30.0),
            "tau1 is -5 ms",
        ),
        (lambda model: lgmd.LGMD2(n_p=-1), "n_p is -1"),
        (lambda model: built(N_ts=1.5), "N_ts is 1.5"),
        (lambda model: built(low_pass="forward"), "low_pass is 'forward'; choose"),
        (lambda model: built(parameters={"theta2": 2}), "parameters is"),
        (lambda model: lgmd.LGMD2(lgmd.Parameters(u=0.0), n_p=2), "stable only below 1"),
        (lambda model: lgmd.preset("lgmd1"), "preset is 'lgmd1'; choose 'lgmd2'"),
        (lambda model: lgmd.ablate(model, "fff"), "mechanism is 'fff'; choose 'ffi'"),
    ],
)
def test_misuse_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call(lgmd.LGMD2())


@pytest.mark.parametrize(
    ("frames", "rate", "words"),
    [
        (FRAMES / 255, {"fps": 30.0}, "in 0..1; were grey levels in 0..255 meant"),
        (FRAMES / 127.5 - 1, {"fps": 30.0}, "in -1..1; were grey levels in 0..255 meant"),
        (FRAMES.astype(np.uint16) * 257, {"fps": 30.0}, r"reach(es)? \d+; grey levels lie in 0..255"),
        (FRAMES, {"fps": 1 / 60}, "fps is 0.01667; were 60 meant, given as an interval in s"),
        (FRAMES, {"interval": np.full(len(FRAMES), 0.0333)}, "interval is 0.0333 ms; was 33.3 ms meant, given in s"),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_frames_and_rates_in_other_units_are_said_by_both_programs(frames, rate: Any, words):
    with pytest.warns(UserWarning, match=words):
        lgmd.LGMD2()(frames, **rate)
    robot = hard.HardLGMD2(as_hard(lgmd.LGMD2()).parameters)
    with pytest.warns(UserWarning, match=words):
        _ = robot(frames, rate["fps"]) if "fps" in rate else robot.step(frames[0], rate["interval"][0])


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize(
    "value", [datetime.timedelta(milliseconds=33), np.timedelta64(33, "ms"), 33 * pq.ms, True, "33"]
)
def test_a_rate_that_is_no_plain_number_is_refused(value: Any):
    with pytest.raises(ValueError, match=r"fps is .*; give a positive number of frames per second"):
        lgmd.LGMD2()(FRAMES, fps=value)
    with pytest.raises(ValueError, match=r"interval is .* positive numbers of ms"):
        lgmd.LGMD2()(FRAMES, interval=cast(Any, [value] * len(FRAMES)))


@pytest.mark.parametrize(
    ("frames", "fps", "parameters", "message"),
    [
        (FRAMES * np.nan, 30.0, {}, "not finite"),
        (FRAMES, -30.0, {}, "fps is not positive"),
        (FRAMES, 30.0, {"k": -1.0}, "k must lie in"),
        (FRAMES, 30.0, {"T_sp": 0.4}, "T_sp must lie in"),
        (FRAMES, 30.0, {"u": -2.0}, "persistence"),
    ],
)
def test_traced_values_are_checked_on_request(frames, fps, parameters, message):
    def run(frames, fps, leaves):
        model = eqx.tree_at(
            lambda m: [getattr(m.parameters, n) for n in leaves], lgmd.LGMD2(n_p=2), list(leaves.values())
        )
        return model(frames, fps, check=True).smp

    leaves = {name: jnp.asarray(value) for name, value in parameters.items()}
    run_jitted = eqx.filter_jit(run)
    np.testing.assert_allclose(run_jitted(FRAMES, jnp.asarray(30.0), {}), lgmd.LGMD2(n_p=2)(FRAMES, 30.0).smp)
    with pytest.raises(Exception, match=message):
        run_jitted(frames, jnp.asarray(fps), leaves)


def every_layer(layers):
    return layers


@pytest.mark.parametrize(
    ("mechanisms", "same"),
    [
        (("ffi",), lambda response: response.ffi.max() > 10),
        (("sfa",), lambda response: np.allclose(response.smp, response.smp_adapted)),
        (("lateral",), lambda response: np.allclose(response.recorded.s_on, response.recorded.on)),
        (("on",), lambda response: np.allclose(response.recorded.s, 1.5 * response.recorded.s_off)),
        (("off",), lambda response: np.allclose(response.recorded.s, 0.4 * response.recorded.s_on)),
        (("ffi", "sfa"), lambda response: np.allclose(response.smp, response.smp_adapted)),
    ],
    ids=["ffi", "sfa", "lateral", "on", "off", "ffi and sfa"],
)
def test_ablations(mechanisms, same):
    model = lgmd.LGMD2(lgmd.Parameters(theta1=0.4, theta2=1.5, theta3=0.01, k=100.0, T_ffi=79.0))
    frames = clips.noise(0, (8, 7, 9))
    ablated = lgmd.ablate(model, *mechanisms)(frames, 30.0, record=every_layer)
    assert same(ablated)
    whole = model(frames, 30.0, record=every_layer)
    if "ffi" in mechanisms:
        assert np.any((whole.smp == 0.5) & (ablated.smp > 0.5))
    else:
        assert not same(whole)
