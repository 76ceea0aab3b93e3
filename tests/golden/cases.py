"""The cases of the golden outputs: what each computes, by the public API alone, so that modules may move behind it."""

import contextlib
import csv
import dataclasses
import io
import json
import pathlib
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import imageio.v3 as iio
import jax
import jax.numpy as jnp
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax import alarms, hard, stimuli
from lgmd2jax.cli import main

Outputs = dict[str, np.ndarray]
Case = Callable[[], Outputs]

FOLDER = pathlib.Path(__file__).parent
OUTPUTS = FOLDER / "outputs.npz"
MODEL_FILE = FOLDER / "model_v1.json"
FIT_FOLDER = FOLDER / "fit_v1"
FIT_FILES = ("model.json", "fit.json", "curves.csv")

CHANNELS = ("mp", "ffi", "smp", "smp_adapted", "spikes", "collision")
NINE_DIGITS = "(nine digits)"  # ends the name of what is known no better
CASES: dict[str, Case] = {}


def case(compute: Case) -> Case:
    """A function whose outputs are kept, under its name."""
    CASES[compute.__name__] = compute
    return compute


# What is shown, and to what


def clip() -> np.ndarray:
    """A dark square that grows ever faster, a light bar that crosses, and noise: 30 frames of 16 x 20."""
    generator = np.random.default_rng(7)
    frames = np.repeat(generator.uniform(150, 200, (1, 16, 20)), 30, axis=0)
    row, col = np.mgrid[:16, :20]
    distance = np.maximum(np.abs(row - 7), np.abs(col - 12))
    for t in range(30):
        frames[t] += np.where((row >= 11) & (np.abs(col - 0.7 * t) < 1.5), 40, 0)
        frames[t] = np.where(distance <= 10 / max(24 - t, 1.5), 30 + 0.1 * frames[t], frames[t])
    return np.round(np.clip(frames + generator.uniform(-6, 6, frames.shape), 0, 255), 3)


FRAMES = clip()
FPS = 30.0
EYE = lgmd.Eye(rows=16, cols=20, degrees_per_pixel=4.0, fps=FPS)
SMALL = lgmd.Eye(rows=10, cols=13, degrees_per_pixel=7.0, fps=50.0)
# Nothing is zero, and the clip crosses every threshold.
VALUES = {
    "theta1": 0.4,
    "theta2": 1.3,
    "theta3": 0.002,
    "T_s": 8.0,
    "T_ffi": 14.0,
    "k": 5.0,
    "T_sp": 0.7,
    "sigma_sp": 0.08,
    "u": 0.7,
    "N_sp": 4.0,
}
PARAMETERS = lgmd.Parameters(**VALUES)
YUE_RIND = lgmd.YueRindParameters(T_de=6.0, k=2.0, alpha_ffi=0.3, T_ffi=20.0, T_sp=0.7, u=0.7)
LOOMS: dict[str, Any] = {"contrast": -0.9, "start_ms": -500.0, "end_ms": 200.0}


def lgmd2_models() -> dict[str, lgmd.LGMD2]:
    """Every kind of thresholds, every structure, every preset."""
    models = {
        "hard": lgmd.LGMD2(PARAMETERS),
        "soft 1": lgmd.LGMD2(PARAMETERS, lgmd.Soft(1.0)),
        "soft .2": lgmd.LGMD2(PARAMETERS, lgmd.Soft(0.2)),
        "straight-through": lgmd.LGMD2(PARAMETERS, lgmd.StraightThrough(0.5)),
        "soft, other widths": lgmd.LGMD2(PARAMETERS, lgmd.Soft(0.5, lgmd.Widths(s=0.4, spikes=0.07))),
        "hard, persistent": lgmd.LGMD2(PARAMETERS, n_p=1),
        "soft, persistent": lgmd.LGMD2(PARAMETERS, lgmd.Soft(0.5), n_p=1),
        "soft, persistent over two": lgmd.LGMD2(PARAMETERS, lgmd.Soft(0.5), n_p=2),
        "hard, exact": lgmd.LGMD2(PARAMETERS, low_pass="exact"),
        "soft, exact, persistent": lgmd.LGMD2(PARAMETERS, lgmd.Soft(0.5), n_p=1, low_pass="exact"),
        "hard, N_ts 0": lgmd.LGMD2(PARAMETERS, N_ts=0),
        "soft, N_ts 7": lgmd.LGMD2(PARAMETERS, lgmd.Soft(0.5), N_ts=7),
        "hard, eye": lgmd.LGMD2(PARAMETERS, eye=EYE),
    }
    return models | {f"preset {name}": lgmd.LGMD2(lgmd.preset(name)) for name in lgmd.PRESETS}


def yue_rind_models() -> dict[str, lgmd.YueRindLGMD1]:
    """The other network with every kind of thresholds."""
    return {
        "default": lgmd.YueRindLGMD1(),
        "hard": lgmd.YueRindLGMD1(YUE_RIND),
        "soft 1": lgmd.YueRindLGMD1(YUE_RIND, lgmd.Soft(1.0)),
        "soft .2, N_sp 2": lgmd.YueRindLGMD1(YUE_RIND, lgmd.Soft(0.2), N_sp=2),
        "straight-through": lgmd.YueRindLGMD1(YUE_RIND, lgmd.StraightThrough(0.5)),
    }


def layers_summed(layers: lgmd.Layers) -> dict[str, jax.Array]:
    """Sum and weighted sum of each map of the LGMD2, by its name."""
    return _sums(layers, lgmd.Layers)


def yue_rind_layers_summed(layers: lgmd.YueRindLayers) -> dict[str, jax.Array]:
    """Sum and weighted sum of each map of the other network, by its name."""
    return _sums(layers, lgmd.YueRindLayers)


def _sums(layers: Any, kind: type[Any]) -> dict[str, jax.Array]:
    maps = {field.name: getattr(layers, field.name) for field in dataclasses.fields(kind)}
    weights = {name: jnp.cos(jnp.arange(it.size, dtype=it.dtype).reshape(it.shape)) for name, it in maps.items()}
    return {name: jnp.stack([it.sum(), (it * weights[name]).sum()]) for name, it in maps.items()}


def of_response(response: lgmd.Response, prefix: str = "") -> Outputs:
    """The channels of a response by their names, and what was recorded."""
    found = {f"{prefix}{name}": np.asarray(getattr(response, name)) for name in CHANNELS}
    return found | {f"{prefix}recorded {name}": np.asarray(it) for name, it in (response.recorded or {}).items()}


def of_parameters(parameters: Any, kind: type, prefix: str = "") -> Outputs:
    """The leaves of a set of parameters, or of its derivatives, by their symbols."""
    return {f"{prefix}{name}": np.asarray(getattr(parameters, name)) for name in lgmd.symbols(kind)}


def text(value: str) -> np.ndarray:
    """Text as an array, which is compared as it is."""
    return np.array(value)


def plain(content: Any, prefix: str) -> Iterator[tuple[str, np.ndarray]]:
    """JSON as named arrays: lists of numbers whole, with NaN for null; the keys of every object, as text."""
    if isinstance(content, dict):
        yield f"{prefix}/keys", text(" ".join(content))
        for name, it in content.items():
            yield from plain(it, f"{prefix}/{name}")
    elif isinstance(content, str):
        yield prefix, text(content)
    elif isinstance(content, list) and not _numeric(content):
        yield f"{prefix}/count", np.array(len(content))
        for number, it in enumerate(content):
            yield from plain(it, f"{prefix}/{number}")
    else:
        array = np.array(_without_null(content))
        yield prefix, array if array.dtype.kind in "ib" else array.astype(float)


def _numeric(content: Any) -> bool:
    """Whether these are numbers, or lists of numbers of one shape."""
    try:
        return np.array(_without_null(content)).dtype.kind in "fib"
    except ValueError:
        return False


def _without_null(content: Any) -> Any:
    if isinstance(content, list):
        return [_without_null(it) for it in content]
    return np.nan if content is None else content


@contextlib.contextmanager
def scratch() -> Iterator[pathlib.Path]:
    """A folder for files that are read again at once."""
    with tempfile.TemporaryDirectory() as name:
        yield pathlib.Path(name)


# Responses


@case
def calls() -> Outputs:
    """Responses of the LGMD2 to a clip."""
    found = {}
    for name, model in lgmd2_models().items():
        found |= of_response(model(FRAMES, FPS), f"{name}: ")
    return found


@case
def calls_recorded() -> Outputs:
    """Responses with the layers recorded, and at another frame rate."""
    found = {}
    for name in ("hard", "soft .2", "soft, exact, persistent"):
        response = lgmd2_models()[name](FRAMES, 50.0, record=layers_summed)
        found |= of_response(response, f"{name}: ")
    for name in ("hard", "soft 1"):
        response = yue_rind_models()[name](FRAMES, 50.0, record=yue_rind_layers_summed)
        found |= of_response(response, f"Yue & Rind, {name}: ")
    return found


@case
def calls_yue_rind() -> Outputs:
    """Responses of the LGMD1 of Yue & Rind to a clip."""
    found = {}
    for name, model in yue_rind_models().items():
        found |= of_response(model(FRAMES, FPS), f"{name}: ")
    return found


@case
def calls_8_bit() -> Outputs:
    """Responses to 8-bit frames, which compute in the precision of the parameters."""
    frames = np.round(FRAMES).astype(np.uint8)
    found = of_response(lgmd2_models()["hard"](frames, FPS), "hard: ")
    found |= of_response(lgmd2_models()["soft, persistent"](frames, FPS), "soft, persistent: ")
    return found | of_response(yue_rind_models()["hard"](frames, FPS), "Yue & Rind: ")


@case
def calls_single_precision() -> Outputs:
    """Responses to float32 frames, with parameters of either precision; whole grey levels, so that sums are exact."""
    frames, found = np.round(FRAMES).astype(np.float32), {}
    models = {"hard": lgmd2_models()["hard"], "soft": lgmd2_models()["soft 1"], "Yue & Rind": yue_rind_models()["hard"]}
    for name, model in models.items():
        found |= of_response(model(frames, FPS), f"{name}: ")
        single = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), model)
        found |= of_response(single(frames, FPS), f"{name}, single: ")
    return found


@case
def batches() -> Outputs:
    """Responses under `vmap`, over clips and over parameters."""
    clips = np.stack([FRAMES, 255 - FRAMES, FRAMES[:, ::-1], np.roll(FRAMES, 4, axis=2)])
    found = {}
    for name, model in {"soft": lgmd2_models()["soft .2"], "Yue & Rind": yue_rind_models()["hard"]}.items():
        found |= of_response(jax.vmap(model, in_axes=(0, None))(clips, FPS), f"clips, {name}: ")
    sets = jax.vmap(lambda theta2, tau1: lgmd.Parameters(**VALUES | {"theta2": theta2}, tau1=tau1))(
        jnp.array([0.5, 1.0, 2.0]), jnp.array([10.0, 30.0, 60.0])
    )
    together = jax.vmap(lambda parameters: lgmd.LGMD2(parameters, n_p=1)(FRAMES, FPS))(sets)
    return found | of_response(together, "sets: ")


def streamed(
    model: lgmd.AbstractNetwork, frames: np.ndarray, intervals: Iterable[float] | None, record: Any = None
) -> Outputs:
    """A clip, a frame at a time."""
    state, answers = model.init(frames[0]), []
    for frame, interval in zip(frames, intervals or [None] * len(frames), strict=True):
        if interval is None:
            state, now = model.step(state, frame, FPS, record=record)
        else:
            state, now = model.step(state, frame, interval=interval, record=record)
        answers.append(of_response(now))
    return {name: np.stack([it[name] for it in answers]) for name in answers[0]}


@case
def streams() -> Outputs:
    """Responses a frame at a time, by a steady clock and by one that jitters."""
    jittered = np.random.default_rng(3).uniform(15.0, 80.0, len(FRAMES)).tolist()
    models = {name: lgmd2_models()[name] for name in ("hard", "soft 1", "straight-through", "soft, exact, persistent")}
    models |= {f"Yue & Rind, {name}": yue_rind_models()[name] for name in ("hard", "soft 1")}
    found = {}
    for name, model in models.items():
        for clock, intervals in {"steady": None, "jittered": jittered}.items():
            found |= {f"{name}, {clock}: {key}": it for key, it in streamed(model, FRAMES, intervals).items()}
    recorded = streamed(lgmd2_models()["hard"], FRAMES[:8], None, layers_summed)
    return found | {f"recorded: {key}": it for key, it in recorded.items()}


@case
def hard_numpy() -> Outputs:
    """Responses of the NumPy model, to a clip and by a clock that jitters."""
    values = {name: float(getattr(PARAMETERS, name)) for name in lgmd.symbols()}
    jittered = np.random.default_rng(3).uniform(15.0, 80.0, len(FRAMES)).tolist()
    found = {}
    structures: list[dict[str, Any]] = [{}, {"n_p": 1, "low_pass": "exact", "N_ts": 7}, {"n_p": 2, "N_ts": 0}]
    for structure in structures:
        model = hard.HardLGMD2(values, FPS, **structure)
        answers = {"clip": model(FRAMES)}
        model.reset()
        steps = [model.step(frame, interval) for frame, interval in zip(FRAMES, jittered, strict=True)]
        answers["jittered"] = hard.Response.over_time(steps)
        for name, answer in answers.items():
            found |= {f"{structure}, {name}: {key}": np.asarray(it) for key, it in answer._asdict().items()}
    return found


# Derivatives


def scalar_of(response: lgmd.Response) -> jax.Array:
    """One number that every channel moves."""
    channels = jnp.stack([response.mp / 1000, response.ffi / 10, *(getattr(response, it) for it in CHANNELS[2:])])
    channel, time = np.indices(channels.shape)
    return jnp.sum(channels * np.cos(0.1 * time + channel))


DIFFERENTIATED = {
    "soft": lgmd.Soft(1.0),
    "straight-through": lgmd.StraightThrough(0.5),
}


@case
def gradients_by_parameters() -> Outputs:
    """Reverse derivatives of one number by all parameters, and by temperature and widths."""
    found = {}
    for name, thresholds in DIFFERENTIATED.items():
        for structure in ({}, {"n_p": 1, "low_pass": "exact"}):

            def value(parameters, structure=structure, thresholds=thresholds):
                return scalar_of(lgmd.LGMD2(parameters, thresholds, **structure)(FRAMES, FPS))

            number, gradient = jax.jit(jax.value_and_grad(value))(PARAMETERS)
            found[f"{name}, {structure}: value"] = np.asarray(number)
            found |= of_parameters(gradient, lgmd.Parameters, f"{name}, {structure}: ")

    def by_thresholds(temperature, widths):
        return scalar_of(lgmd.LGMD2(PARAMETERS, lgmd.Soft(temperature, widths))(FRAMES, FPS))

    temperature, widths = jax.jit(jax.grad(by_thresholds, argnums=(0, 1)))(jnp.asarray(0.7), lgmd.Widths())
    found["by temperature"] = np.asarray(temperature)
    names = [field.name for field in dataclasses.fields(lgmd.Widths)]
    return found | {f"by width {name}": np.asarray(getattr(widths, name)) for name in names}


@case
def gradients_by_frames() -> Outputs:
    """Reverse derivatives of one number by every pixel of every frame."""
    found, frames = {}, jnp.asarray(FRAMES[:16])
    for name, thresholds in DIFFERENTIATED.items():
        model = lgmd.LGMD2(PARAMETERS, thresholds)
        found[name] = np.asarray(jax.jit(jax.grad(lambda it, model=model: scalar_of(model(it, FPS))))(frames))
    model = lgmd.YueRindLGMD1(YUE_RIND, lgmd.Soft(1.0))
    found["Yue & Rind"] = np.asarray(jax.jit(jax.grad(lambda it: scalar_of(model(it, FPS))))(frames))
    return found


@case
def jacobians_by_parameters() -> Outputs:
    """Forward derivatives of the channels over time by all parameters, and by the contrast of what is shown."""
    found = {}
    for name, thresholds in DIFFERENTIATED.items():
        for structure in ({}, {"n_p": 1, "low_pass": "exact"}):

            def curves(parameters, structure=structure, thresholds=thresholds):
                response = lgmd.LGMD2(parameters, thresholds, **structure)(FRAMES, FPS)
                return response.mp, response.ffi, response.smp_adapted, response.spikes, response.collision

            jacobian = jax.jit(jax.jacfwd(curves))(PARAMETERS)
            for channel, rows in zip(("mp", "ffi", "smp_adapted", "spikes", "collision"), jacobian, strict=True):
                found |= of_parameters(rows, lgmd.Parameters, f"{name}, {structure}, {channel}: ")

    def shown(contrast):
        frames = stimuli.looming(SMALL, l_over_v=30.0, **LOOMS | {"contrast": contrast}).frames
        return lgmd.LGMD2(PARAMETERS, lgmd.Soft(1.0))(frames, SMALL.fps).smp_adapted

    found["by contrast"] = np.asarray(jax.jit(jax.jacfwd(shown))(jnp.asarray(-0.8)))
    return found


@case
def second_derivatives() -> Outputs:
    """Hessians of one number by three parameters."""

    def value(numbers):
        changes = dict(zip(("theta2", "tau1", "k"), numbers, strict=True))
        return scalar_of(lgmd.LGMD2(lgmd.Parameters(**VALUES | changes), lgmd.Soft(1.0), n_p=1)(FRAMES, FPS))

    place = jnp.array([1.3, 30.0, 5.0])
    return {"hessian": np.asarray(jax.jit(jax.hessian(value))(place))}


@case
def gradients_batched() -> Outputs:
    """Derivatives under `vmap`: of one set over clips, of several sets over one clip."""

    def value(parameters, frames):
        return scalar_of(lgmd.LGMD2(parameters, lgmd.Soft(1.0))(frames, FPS))

    clips = jnp.stack([FRAMES, 255 - FRAMES, FRAMES[:, ::-1]])
    over_clips = jax.jit(jax.vmap(jax.grad(value), in_axes=(None, 0)))(PARAMETERS, clips)
    sets = jax.vmap(lambda T_s: lgmd.Parameters(**VALUES | {"T_s": T_s}))(jnp.array([4.0, 8.0, 16.0]))
    over_sets = jax.jit(jax.vmap(jax.jacfwd(value), in_axes=(0, None)))(sets, jnp.asarray(FRAMES))
    found = of_parameters(over_clips, lgmd.Parameters, "clips: ")
    return found | of_parameters(over_sets, lgmd.Parameters, "sets: ")


@case
def gradients_yue_rind() -> Outputs:
    """Reverse and forward derivatives of the LGMD1 of Yue & Rind by all its parameters."""
    found = {}
    for name, thresholds in DIFFERENTIATED.items():

        def response(parameters, thresholds=thresholds):
            return lgmd.YueRindLGMD1(parameters, thresholds)(FRAMES, FPS)

        gradient = jax.jit(jax.grad(lambda it, response=response: scalar_of(response(it))))(YUE_RIND)
        jacobian = jax.jit(jax.jacfwd(lambda it, response=response: response(it).smp))(YUE_RIND)
        found |= of_parameters(gradient, lgmd.YueRindParameters, f"{name}, gradient: ")
        found |= of_parameters(jacobian, lgmd.YueRindParameters, f"{name}, jacobian: ")
    return found


# Stimuli and targets


def stimulus(family: str, **changes: Any) -> lgmd.Stimulus:
    """A stimulus of a family for the small eye."""
    own = {"grating": {"spatial_frequency": 0.03}}.get(family, {})
    return stimuli.FAMILIES[family](SMALL, **own | changes)


@case
def shown() -> Outputs:
    """Frames of every family, mean and weighted means, with times and courses."""
    weights = np.cos(np.arange(2 * SMALL.rows * SMALL.cols, dtype=float)).reshape(2, SMALL.rows, SMALL.cols)
    clips = {name: stimulus(name) for name in stimuli.FAMILIES}
    clips["textured"] = stimulus("looming", checks=4, shape="square", background=stimuli.Photograph("brick"))
    clips["filmed"] = stimuli.camera(clips["looming"], jax.random.key(4), flicker=0.05, blur=0.7)
    found = {}
    for name, it in clips.items():
        frames = np.asarray(it.frames)
        found[f"{name}: time"] = np.asarray(it.time)
        found[f"{name}: mean"] = frames.mean(axis=(1, 2))
        found[f"{name}: weighted"] = np.tensordot(frames, weights, axes=((1, 2), (1, 2))) / frames[0].size
        found |= {f"{name}: course {key}": np.asarray(course) for key, course in it.courses.items()}
        found |= {f"{name}: parameter {key}": np.asarray(number) for key, number in it.parameters.items()}
    return found


@case
def targets() -> Outputs:
    """What targets become on a stimulus, and the rate that an observation makes of a potential."""
    it = stimulus("looming", l_over_v=30.0, start_ms=-700.0, end_ms=300.0)
    generator = np.random.default_rng(5)
    trials = [[np.sort(generator.uniform(-600, 200, 30)) for _ in range(3)] for _ in range(2)]
    model = lgmd.LGMD2(PARAMETERS, lgmd.Soft(0.5))
    observation = lgmd.Observation(baseline=4.0, gain=90.0, latency=27.0, smoothing=25.0)
    law = lgmd.LoomingLaw(peak=0.3, alpha=4.0, delta=22.0, exponent=-0.1)
    recorded = lgmd.Target(
        "rate", np.arange(8.0), time=np.linspace(-300, 100, 8), sem=np.full(8, 0.5), interpolate=True
    )
    key = jax.random.key(3)
    kinds = {
        "law": law,
        "rest": lgmd.Rest(),
        "onset": lgmd.Onset(peak=0.2, decay_ms=100.0),
        "weighted": lgmd.Weighted(law, error=0.1, weight=2.0, from_ms=-300.0, until_ms=100.0, correlation_ms=40.0),
        "trains": lgmd.SpikeTrains(trials),
        "interpolated": recorded,
        "model": lgmd.ModelTarget(model=model, channel="rate", observation=observation, noise=0.5, key=key),
    }
    found = {"observed": np.asarray(observation(model(it.frames, it.fps).smp_adapted, it.time))}
    for name, target in kinds.items():
        on = target.on(it)
        found[f"{name}: correlation_ms"] = np.array(float(on.correlation_ms))
        for field in ("values", "sem", "error", "weight"):
            if getattr(on, field) is not None:
                found[f"{name}: {field}"] = np.asarray(getattr(on, field))
    return found


# What is done with a model


@case
def ablated() -> Outputs:
    """Responses of both networks without each of their mechanisms."""
    found = {}
    for name in lgmd.ABLATIONS:
        model = lgmd.ablate(lgmd.LGMD2(PARAMETERS), name)
        found |= of_parameters(model.parameters, lgmd.Parameters, f"{name}: ")
        found |= of_response(model(FRAMES, FPS), f"{name}: ")
    for name in ("ffi", "lateral"):
        model = lgmd.ablate(lgmd.YueRindLGMD1(YUE_RIND), name)
        found |= of_parameters(model.parameters, lgmd.YueRindParameters, f"Yue & Rind, {name}: ")
        found |= of_response(model(FRAMES, FPS), f"Yue & Rind, {name}: ")
    return found


@case
def other_frame_rates() -> Outputs:
    """Parameters, structure and responses of both networks at other frame rates than their own."""
    found = {}
    for fps in (50.0, 100.0):
        for n_p in (0, 1):
            model = lgmd.at_frame_rate(lgmd.LGMD2(PARAMETERS, n_p=n_p, eye=EYE), fps)
            found[f"{fps:g}, n_p {n_p}: N_ts"] = np.array(model.N_ts)
            found |= of_parameters(model.parameters, lgmd.Parameters, f"{fps:g}, n_p {n_p}: ")
            found |= of_response(model(FRAMES), f"{fps:g}, n_p {n_p}: ")
        model = lgmd.at_frame_rate(lgmd.YueRindLGMD1(YUE_RIND, eye=EYE), fps)
        found[f"Yue & Rind, {fps:g}: N_sp"] = np.array(model.N_sp)
        found |= of_parameters(model.parameters, lgmd.YueRindParameters, f"Yue & Rind, {fps:g}: ")
        found |= of_response(model(FRAMES), f"Yue & Rind, {fps:g}: ")
    return found


@case
def declared() -> Outputs:
    """What the parameters say of themselves, and the presets' values."""
    found = {}
    for kind in (lgmd.Parameters, lgmd.YueRindParameters):
        for name, symbol in lgmd.symbols(kind).items():
            found[f"{kind.__name__}.{name}"] = text(repr(dataclasses.astuple(symbol)[:6]))  # what was declared then
        found |= of_parameters(kind(), kind, f"{kind.__name__}, default: ")
    for name in lgmd.PRESETS:
        found |= of_parameters(lgmd.preset(name), lgmd.Parameters, f"preset {name}: ")
    for name, symbol in lgmd.observation_symbols().items():
        found[f"Observation.{name}"] = text(repr(dataclasses.astuple(symbol)[:6]))  # what was declared then
    return found


EXAMINED = lgmd.Eye(rows=8, cols=10, degrees_per_pixel=6.0, fps=20.0)


def of_exam(found: lgmd.Characterisation) -> Outputs:
    """All that an exam found: values, verdicts, summary, panels and the curves."""
    outputs = {
        "neuron": text(found.neuron),
        "reference": np.array([found.reference, found.reference_textured]),
        "verdicts": text("; ".join(f"{row.number} {row.name}: {row.verdict}" for row in found.rows)),
    }
    outputs |= {f"row {row.number}": np.array(row.values) for row in found.rows}
    outputs |= {f"selectivity {name}": np.array(it.value) for name, it in found.selectivity.items()}
    outputs |= {f"panel {name}": np.asarray(it) for name, it in found.panels.items()}
    for name, (time, r) in found.curves.items():
        outputs |= {f"time {name}": np.asarray(time), f"curve {name}": np.asarray(r)}
    return outputs


@case
def exam() -> Outputs:
    """All response properties of an LGMD2."""
    values = lgmd.preset("lgmd2", T_s=3.0, k=2.0, T_ffi=40.0, theta1=0.2)
    return of_exam(lgmd.characterise(lgmd.LGMD2(values, eye=EXAMINED)))


@case
def exam_yue_rind() -> Outputs:
    """All response properties of the LGMD1 of Yue & Rind."""
    return of_exam(lgmd.characterise(lgmd.YueRindLGMD1(lgmd.YueRindParameters(T_de=5.0, k=4.0), eye=EXAMINED)))


def of_dataset(dataset: Any) -> Outputs:
    """Variables and axes of labelled arrays, with their units."""
    found = {name: np.asarray(it.values) for name, it in dataset.variables.items()}
    found = {name: it if it.dtype.kind in "fib" else np.array(it.tolist(), str) for name, it in found.items()}
    units = {name: it.attrs.get("units", "") for name, it in dataset.variables.items()}
    sizes = {name: it.dims for name, it in dataset.variables.items()}
    return {str(name): it for name, it in found.items()} | {
        "units": text(repr(sorted(units.items()))),
        "dimensions": text(repr(sorted(sizes.items()))),
    }


@case
def sweeps() -> Outputs:
    """Sweeps in memory and through a store, with models and parameters as axes, and as plain arrays."""
    import xarray

    model = lgmd.LGMD2(PARAMETERS, eye=SMALL)
    grid: dict[str, Any] = {"contrast": [-0.9, -0.4, 0.2], "l_over_v": [10.0, 30.0]}
    swept = of_dataset(lgmd.sweep(model, stimuli.looming, SMALL, **grid))
    found = {f"memory: {name}": it for name, it in swept.items()}
    wider: dict[str, Any] = {"parameters": {"theta2": [0.5, 2.0]}, "channels": ("smp_adapted", "spikes")}
    models = {"dark": model, "balanced": dataclasses.replace(model, parameters=lgmd.preset("balanced", k=5.0))}
    with scratch() as folder:
        lgmd.sweep(models, stimuli.looming, SMALL, **wider, contrast=[-0.9, 0.2], store=folder / "s.zarr", block=3)
        with xarray.open_zarr(folder / "s.zarr", consolidated=False) as stored:
            found |= {f"store: {name}": it for name, it in of_dataset(stored.load()).items()}
    soft = lgmd.LGMD2(PARAMETERS, lgmd.Soft(0.5))
    surfaces = lgmd.surfaces(soft, stimuli.looming, SMALL, **grid)
    return found | {f"surfaces: {name}": np.asarray(it) for name, it in surfaces.items()}


# Fits

FITTED: dict[str, float] = {"T_s": 5.0, "T_sfa": 5e-4, "tau2": 300.0, "T_ffi": 12.0}
FREE = lgmd.Free(theta2=(1, 6), tau3=lgmd.Log(100, 1000), gain=(20, 300))
QUICK: dict[str, Any] = {"pixel_points": 4, "cell_points": 32, "descend": 2, "max_steps": 12}


def fit_stimuli() -> list[lgmd.Stimulus]:
    """Two approaches."""
    eye = lgmd.Eye(rows=10, cols=13, degrees_per_pixel=7.0, fps=60.0)
    return [dataclasses.replace(stimuli.looming(eye, l_over_v=it, **LOOMS), name=f"loom {it:g}") for it in (20.0, 40.0)]


def small_fit(thresholds: lgmd.Thresholds, temperatures: tuple[float, ...] | None) -> lgmd.Fit:
    """A fit of three parameters to two noisy conditions, a potential and a rate: noise leaves a loss to be compared."""
    looms = fit_stimuli()
    truth = lgmd.LGMD2(lgmd.Parameters(**FITTED, theta2=1.8, k=0.6, tau3=250.0), thresholds)
    rate = lgmd.ModelTarget(
        model=truth,
        channel="rate",
        observation=lgmd.Observation(baseline=5.0, gain=80.0, latency=30.0),
        noise=4.0,
        key=jax.random.key(1),
    )
    potential = lgmd.ModelTarget(model=truth, noise=0.02, key=jax.random.key(2))
    return lgmd.fit(
        lgmd.LGMD2(lgmd.Parameters(**FITTED, k=0.6), thresholds, eye=dataclasses.replace(SMALL, fps=60.0)),
        [(looms[0], potential), (looms[1], [rate, lgmd.Weighted(potential, weight=0.5)])],
        FREE,
        key=jax.random.key(0),
        observation=lgmd.Observation(baseline=5.0, latency=30.0),
        temperatures=temperatures,
        **QUICK,
    )


def of_fit(fit: lgmd.Fit) -> Outputs:
    """What a fit found, but for its curves."""
    u = fit.uncertainty
    found = {
        "z": np.asarray(fit.z),
        "values": np.array([fit.values[name] for name in fit.free.names]),
        "losses": np.array([fit.loss, fit.soft_loss]),
        "screened": np.array(fit.screened),
        "run losses": np.array([[it.start_loss, it.loss] for it in fit.runs]),
        "result": text("; ".join([fit.result, *(it.result for it in fit.runs)])),
        "errors": np.array([fit.errors[name] for name in sorted(fit.errors)]),
        "curved": text(" ".join(fit.nonlinear)),
        "summary": text(fit.summary()),
    }
    for field in dataclasses.fields(u):
        value = getattr(u, field.name)
        if field.name not in ("names", "reason", "gradient", "directions"):
            found[f"uncertainty: {field.name}"] = np.asarray(value)
    return found | of_parameters(fit.parameters, type(fit.parameters), "parameter ")


def of_curves(fit: lgmd.Fit) -> Outputs:
    """The curves of a fit."""
    return {
        f"curve {curve.condition}, {curve.channel}: {name}": np.asarray(getattr(curve, name))
        for curve in fit.curves
        for name in ("time", "target", "sem", "weight", "soft", "hard", "band")
    }


@case
def fit_hard() -> Outputs:
    """A fit with hard thresholds by two temperatures, its predictions, and the next stimulus that it asks for."""
    fit = small_fit(lgmd.Hard(), (0.5, 0.2))
    found = of_fit(fit) | of_curves(fit)
    new = stimuli.looming(fit.model.eye or SMALL, l_over_v=30.0, **LOOMS)
    found["predicted rate"] = np.asarray(fit.predict(new))
    found["predicted potential"] = np.asarray(fit.predict(new, "smp_adapted"))
    for it in fit.next_stimulus([dataclasses.replace(new, name="loom 30"), *fit_stimuli()]):
        found[f"next {it.name}"] = np.array([it.gain, *it.shrink.values()])
    return found


@case
def fit_soft_and_its_files() -> Outputs:
    """A fit with soft thresholds, and its result folder: what the files say, and what comes back."""
    fit = small_fit(lgmd.Soft(0.5), None)
    found = of_fit(fit) | of_curves(fit)
    with scratch() as folder:
        lgmd.save_fit(fit, folder / "fit", provenance={"recipe": "golden"}, notes={"digest": "abc"})
        found["files"] = text(" ".join(sorted(it.name for it in (folder / "fit").iterdir())))
        content = json.loads((folder / "fit" / "fit.json").read_text(encoding="utf-8"))
        del content["versions"], content["version"]
        found |= {
            name: it
            for name, it in plain(content, "fit.json")
            if not name.startswith(("fit.json/uncertainty/gradient", "fit.json/uncertainty/directions"))
        }
        found |= of_csv((folder / "fit" / "curves.csv").read_text(encoding="utf-8"), "curves.csv")
        found["report.txt"] = text((folder / "fit" / "report.txt").read_text(encoding="utf-8"))
        found |= of_model_file(folder / "fit" / "model.json", "model.json")
        again = of_fit(lgmd.load_fit(folder / "fit"))
    return found | {f"loaded: {name}": it for name, it in again.items()}


# Alarms


def labelled() -> list[alarms.LabelledClip]:
    """Approaches, in whose last second an alarm is wanted, and clips that must be silent."""
    eye = dataclasses.replace(SMALL, fps=30.0)
    window: dict[str, Any] = {"start_ms": -1500.0, "end_ms": 0.0}
    clips = []
    for number, (l_over_v, contrast) in enumerate(((30.0, -0.8), (60.0, -0.8), (40.0, -0.25))):
        frames = np.asarray(stimuli.looming(eye, l_over_v=l_over_v, contrast=contrast, **window).frames)
        last = len(frames) - 1
        clips.append(
            alarms.LabelledClip.of(
                f"loom {number}", frames, 30, windows=[(last - 15, last)], silent=[(5, last - 25)], contact=last + 2
            )
        )
    moving = {
        "translation": stimuli.translating(eye, speed=120.0, size=40.0, start=-60.0, stop=60.0),
        "light loom": stimuli.looming(eye, l_over_v=40.0, contrast=0.25, **window),
        "recession": stimuli.receding(eye, l_over_v=20.0, contrast=-0.8),
    }
    for name, it in moving.items():
        frames = np.round(np.asarray(it.frames)).astype(np.uint8)
        clips.append(alarms.LabelledClip.of(name, frames, 30, silent=[(5, len(frames) - 1)]))
    return clips


def of_watch(watched: alarms.Evaluation, prefix: str) -> Outputs:
    """Verdicts, evidence, scores and the operating curve of a model on clips."""
    found = {f"{prefix}score": np.array([*watched.score().hits, *watched.score().false_alarms])}
    for verdict, trace in zip(watched.verdicts(), watched.evidence, strict=True):
        found[f"{prefix}{verdict.clip}: evidence"] = np.asarray(trace)
        found[f"{prefix}{verdict.clip}: verdict"] = text(repr((verdict.alarms, verdict.hits, verdict.false_alarms)))
        found[f"{prefix}{verdict.clip}: warning and margin"] = np.array([verdict.warning_ms, verdict.margin])
    curve = watched.operating_curve(np.linspace(0.55, 0.95, 9))
    return found | {f"{prefix}operating curve": np.stack([np.asarray(it) for it in curve])}


@case
def alarms_watched() -> Outputs:
    """What models do on labelled clips, own ones and rendered ones."""
    model = lgmd.LGMD2(lgmd.preset("lgmd2", T_s=5.0, k=2.0, T_ffi=30.0, T_sp=0.7))
    rendered = list(alarms.Rendering(count=2, seed=5).clips(dataclasses.replace(SMALL, fps=30.0)))
    found = of_watch(alarms.evaluate(model, labelled()), "own: ") | of_watch(
        alarms.evaluate(model, rendered), "rendered: "
    )
    for it in rendered:
        found[f"labels of {it.name}"] = text(repr((it.windows, it.silent, it.contact)))
    potential = jnp.asarray(np.random.default_rng(2).uniform(0.5, 1.0, (3, 40)))
    found["evidence"] = np.asarray(alarms.evidence(potential, 0.1, N_sp=4, N_ts=3))
    return found


@case
def alarms_fitted() -> Outputs:
    """A small fit to labelled clips."""
    fit = alarms.fit(
        lgmd.LGMD2(lgmd.preset("lgmd2", N_sp=4.0, k=1.9, T_sp=0.9)),
        labelled(),
        lgmd.Free(T_s=lgmd.Log(2, 30), k=lgmd.Log(0.45, 4), T_ffi=(5, 60), T_sp=(0.51, 0.95)),
        key=jax.random.key(0),
        pixel_points=4,
        cell_points=32,
        generations=1,
        descend=1,
        max_steps=3,
    )
    found = of_watch(fit.evaluation, "watched ") | of_parameters(fit.model.parameters, lgmd.Parameters, "parameter ")
    found["z"] = np.asarray(fit.z)
    found["cost and margin"] = np.array([fit.cost, fit.margin])
    found["screened and right"] = np.array([fit.screened, fit.right])
    found["left out"] = text(repr(dict(fit.left_out)))
    found["descended"] = np.array([tuple(it) for it in fit.descended])
    found["summary"] = text(fit.summary())
    return found | {f"range {name}": np.array(it) for name, it in fit.ranges.items()}


# Files


def of_csv(content: str, prefix: str) -> Outputs:
    """The columns of a table by its header: numbers of nine digits, an empty cell being NaN, or text."""
    head, *rows = list(csv.reader(io.StringIO(content)))
    found = {f"{prefix}/header": text(",".join(head))}
    for name, column in zip(head, zip(*rows, strict=True), strict=True):
        try:
            found[f"{prefix}/{name} {NINE_DIGITS}"] = np.array([float(it) if it else np.nan for it in column])
        except ValueError:
            found[f"{prefix}/{name}"] = np.array(column)
    return found


def of_model_file(path: pathlib.Path, prefix: str) -> Outputs:
    """A hand-over file, but for its version and the program's."""
    content = json.loads(path.read_text(encoding="utf-8"))
    del content["version"], content["provenance"]["program"]
    return dict(plain(content, prefix))


def handed_over_model() -> lgmd.LGMD2:
    """The model of the hand-over file that is kept."""
    return lgmd.LGMD2(PARAMETERS, n_p=1, low_pass="exact", N_ts=5, eye=EYE)


@case
def model_files() -> Outputs:
    """Hand-over files of models with and without an eye."""
    found = {}
    with scratch() as folder:
        lgmd.save(handed_over_model(), folder / "a.json", provenance={"from": "golden", "count": 3})
        lgmd.save(lgmd.LGMD2(lgmd.preset("balanced"), lgmd.Soft(1.0)), folder / "b.json")
        found |= of_model_file(folder / "a.json", "with eye")
        found |= of_model_file(folder / "b.json", "without eye")
    return found


@case
def response_tables() -> Outputs:
    """What `lgmd2jax respond` writes for a folder of pictures, some of which repeat the one before."""
    with scratch() as folder:
        pictures = folder / "clip"
        pictures.mkdir()
        for number, frame in enumerate(np.round(FRAMES[:20]).astype(np.uint8).repeat(2, axis=1).repeat(2, axis=2)):
            for again in range(1 + (number % 5 == 3)):
                iio.imwrite(pictures / f"{number:03d}-{again}.png", frame)
        ways = {
            "plain": ["--fps", "30", "--set", "T_s=5", "--set", "k=3"],
            "without repeats": ["--fps", "25", "--resize", "20", "--crop", "2:,:36", "--drop-duplicates"],
            "Yue & Rind": ["--fps", "30", "--resize", "18", "--model", "preset:yue_rind"],
            "from a file": ["--fps", "30", "--model", str(MODEL_FILE)],
        }
        found = {}
        for name, options in ways.items():
            table, figure = folder / f"{name}.csv", folder / f"{name}.png"
            with contextlib.redirect_stdout(io.StringIO()):
                status = main(["respond", str(pictures), "--csv", str(table), "--figure", str(figure), *options])
            found[f"{name}: status"] = np.array(status)
            found |= of_csv(table.read_text(encoding="utf-8"), f"{name}.csv")
    return found


@case
def files_of_version_1() -> Outputs:
    """Responses of the models and the fit that are kept beside this file, as they load."""
    model = lgmd.load(MODEL_FILE)
    found = of_response(model(FRAMES), "model: ") | of_parameters(model.parameters, lgmd.Parameters, "model: ")
    found["model: structure"] = text(repr((model.n_p, model.low_pass, model.N_ts, dataclasses.astuple(EYE))))
    found |= {f"hard: {name}": np.asarray(it) for name, it in hard.load(MODEL_FILE)(FRAMES)._asdict().items()}
    fit = lgmd.load_fit(FIT_FOLDER)
    found |= {f"fit: {name}": it for name, it in (of_fit(fit) | of_curves(fit)).items()}
    loom = stimuli.looming(fit.model.eye or SMALL, l_over_v=30.0, **LOOMS)
    found["fit: predicted"] = np.asarray(fit.predict(loom))
    return found | of_response(fit.soft(loom.frames), "fit, soft: ")


def keep_files() -> list[pathlib.Path]:
    """Write the files that later versions must load, where there are none yet: once there, they are never renewed."""
    written = []
    if not MODEL_FILE.exists():
        lgmd.save(handed_over_model(), MODEL_FILE, provenance={"from": "golden outputs"})
        written.append(MODEL_FILE)
    if not FIT_FOLDER.exists():
        fit = small_fit(lgmd.Soft(0.5), None)
        with scratch() as folder:
            lgmd.save_fit(fit, folder / "fit")
            FIT_FOLDER.mkdir()
            for name in FIT_FILES:
                shutil.copy(folder / "fit" / name, FIT_FOLDER / name)
                written.append(FIT_FOLDER / name)
    return written
