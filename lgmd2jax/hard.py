"""The hard-threshold LGMD2 in NumPy alone: one file to copy to a robot, beside the hand-over file model.json.

```python
import hard

model = hard.load("model.json")
while True:
    now = model.step(camera.read())  # grey levels 0..255, any size from 3 x 3
    if now.collision:
        robot.turn()
```

`load` proves itself: the file carries a short clip with the response to it, which must come out.
`model.step(frame, interval=ms)` takes the time since the last frame where the camera's clock is known, and
`model(frames)` gives the response to a whole clip. The equations are those of Fu, Hu & Yue (arXiv 1801.06452), with the
mechanisms that the file names: inhibition that codes size, a graded shunt, a lag, a membrane, change per
time, a lamina, habituation.

It runs on Python 3.8 and NumPy 1.17 or later.
"""

from __future__ import annotations

import json
import math
import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

FORMAT = "lgmd2jax-model"
VERSION = 2
NETWORK = "LGMD2"
DOMAINS = {
    "theta1": "[0, inf)",
    "theta2": "[0, inf)",
    "theta3": "[0, inf)",
    "tau1": "(0, inf)",
    "tau2": "(0, inf)",
    "tau3": "(0, inf)",
    "w_bias": "[0, inf)",
    "sigma1": "[0, 1)",
    "T_s": "[0, inf)",
    "T_ffi": "(0, inf)",
    "T_sfa": "[-1, 1]",
    "T_sp": "(0.5, 1)",
    "sigma_sp": "[0, inf)",
    "k": "(0, inf)",
    "u": "(-inf, inf)",
    "N_sp": "(0, inf)",
}
MECHANISMS = {
    "size": {"T_p": "(0, inf)", "tau_hold": "(0, inf)", "A_ffi": "(0, inf)"},
    "shunt": {"m": "(0, inf)", "gamma": "(0, inf)"},
    "lag": {"lag": "[0, 80]"},
    "membrane": {"tau_cell": "[0, inf)"},
    "rate": {},
    "lamina": {"tau_lamina": "(0, inf)"},
    "habituation": {"tau_hab": "(0, inf)", "S_hab": "(0, inf)"},
}
EYE = ("rows", "cols", "degrees_per_pixel", "fps", "projection")
MOST_FRAMES = 10000  # of persistence or of a window; more would only fill the memory
BRIGHTEST = 300  # above it are frames of more than 8 bits; noise reaches a little beyond 255
SECONDS = 1e-4, 0.2  # between them an interval is hardly one in ms; below is none at all
REFERENCE_MS = 1000 / 30  # of change per time: MP and F are those of a frame that lasts so long
TEST_VECTOR = ("fps", "tolerance", "frames", "response")
CHANNELS = ("mp", "ffi", "smp", "smp_adapted", "spikes", "collision")
EVIDENCE = ("smp_adapted", "level", "rise", "inhibition")  # of which urgency is a logistic function
URGENCY = ("within_ms", "tau_ms", "intercept", *EVIDENCE)
CALIBRATION = ("predicted", "observed")  # a table, rising: what that function says, and how often contact followed


class Response(NamedTuple):
    """What the cell does in a frame, or an array over the frames of a clip.

    `mp` in grey levels; `ffi` likewise, with size-coding inhibition the share of the field that changed recently;
    `smp` before and `smp_adapted` after adaptation, in [.5, 1); `spikes` 0, 1 or 2; `collision` the alarm, 0 or 1.
    `mp_sides` and `f_sides`: the shares of the left, centre and right third of the columns in MP, and in F, which `ffi`
    follows; they tell where to turn. `urgency`: the probability of contact within the time that the hand-over file
    names, NaN where that has no calibration. The test vector of a hand-over file states none of these last three.
    """

    mp: Any
    ffi: Any
    smp: Any
    smp_adapted: Any
    spikes: Any
    collision: Any
    mp_sides: Any = None
    f_sides: Any = None
    urgency: Any = math.nan

    @classmethod
    def over_time(cls, frames: Iterable[Response]) -> Response:
        """The response to a clip, from those to its frames."""
        return cls(*(np.array(channel) for channel in zip(*frames)))


class HardLGMD2:
    """The network with hard thresholds, a frame at a time.

    **Arguments:**

    - `parameters`: a value for each of `DOMAINS`, by the paper's symbols, in its domain.
    - `fps`: frames per second that the parameters belong to; None if every step is given its interval.
    - `n_p`, `low_pass`, `N_ts`: structure, as in the hand-over file.
    - `mechanisms`: the names of those that the model has; `parameters` then holds theirs too (`MECHANISMS`).
    - `urgency`: how to tell the probability of contact: a number for each of `URGENCY`, and perhaps the table
      `CALIBRATION`, between whose rows it is interpolated; None for not at all.

    **Raises:** `ValueError` for parameters that are missing, unknown or out of their domain, and for unknown structure.
    """

    def __init__(
        self,
        parameters: Mapping[str, float],
        fps: float | None = None,
        *,
        n_p: int = 0,
        low_pass: str = "backward_euler",
        N_ts: int = 4,
        mechanisms: Sequence[str] = (),
        urgency: Mapping[str, Any] | None = None,
    ):
        _check_names(mechanisms)
        domains = dict(DOMAINS)
        for name in mechanisms:
            domains.update(MECHANISMS[name])
        _check_parameters(parameters, domains)
        _check_structure({"n_p": n_p, "low_pass": low_pass, "N_ts": N_ts})
        _check_rate(fps)
        _check_urgency(urgency)
        self.urgency = None if urgency is None else dict(urgency)
        self.parameters = {name: float(parameters[name]) for name in domains}
        self.mechanisms = tuple(mechanisms)
        self.fps, self.n_p, self.low_pass, self.N_ts = fps, n_p, low_pass, N_ts
        u = self.parameters["u"]
        self._persistence = [1 / (1 + math.exp(min(u * i, 700))) for i in range(1, n_p + 1)]
        if n_p and "lamina" in mechanisms:
            raise ValueError(f"n_p is {n_p}; a lamina stands in the place of persistence: give n_p=0")
        if sum(self._persistence) >= 1:
            raise ValueError(f"u is {u:g} with n_p = {n_p}: the persistence is not stable; raise u or lower n_p")
        self.reset()

    def reset(self) -> None:
        """Forget all frames; the next one sets what was seen before it."""
        self._luminance = None

    def __call__(self, frames: Iterable[np.ndarray], fps: float | None = None) -> Response:
        """The response to a clip, from rest: an array over time in each field.

        **Arguments:** `frames` of (time, row, col) or any iterable of (row, col); `fps` by default the model's.
        """
        _check_rate(fps)
        if fps and self.fps and abs(fps / self.fps - 1) > 0.01:
            warnings.warn(f"the parameters belong to {self.fps:g} frames per second, not {fps:g}", stacklevel=2)
        self.reset()
        now = [self.step(frame, fps and 1000 / fps) for frame in frames]
        if not now:
            raise ValueError("frames is empty; give at least one frame")
        return Response.over_time(now)

    def step(self, frame: np.ndarray, interval: float | None = None) -> Response:
        """The response to one frame.

        **Arguments:** `frame` of (row, col) in grey levels 0..255; `interval` in ms since the last frame, by default
        1000/fps.

        **Raises:** `ValueError` for a frame of the wrong shape or not finite, and for an interval that is not positive;
        the state stays as it was.
        """
        if isinstance(frame, np.ma.MaskedArray):
            raise ValueError("frame is masked; fill what is masked with a grey level first: frame.filled(128)")
        try:
            given = np.asarray(frame)
            # Before any difference, since uint8 3 - 5 is 254; a copy, since buffers are refilled; in one order of
            # pixels, since sums round by it.
            frame = np.array(given if given.dtype.kind in "biufO" else None, dtype=float, order="C")
        except (TypeError, ValueError, OverflowError):
            raise ValueError(f"frame is a {type(frame).__name__}; give an array of grey levels (row, col)") from None
        self._check_frame(frame)
        _warn_of_levels(frame)
        if interval is None:
            if self.fps is None:
                raise ValueError("the model has no frame rate; give the interval since the last frame in ms")
            interval = 1000 / self.fps
        if not _is_positive(interval):
            raise ValueError(f"interval is {interval!r}; give a positive number of ms")
        if SECONDS[0] < interval < SECONDS[1]:
            warnings.warn(
                f"interval is {interval:.4g} ms; was {1000 * interval:.4g} ms meant, given in s?", stacklevel=2
            )
        if self._luminance is None:
            self._start(frame)
        s, f = self._pixels(frame, interval)
        return self._cell(self._potential(s), f, frame.size, interval)

    def _start(self, frame):
        self._luminance = frame
        self._history = [np.zeros_like(frame)] * (1 if "lamina" in self.mechanisms else self.n_p)
        self._on = self._off = self._d_on = self._d_off = self._held = self._fatigue = np.zeros_like(frame)
        self._ffi, self._smp, self._smp_adapted, self._excitation = 0.0, 0.5, 0.5, 0.0
        self._past = []  # ms ago, MP, F; the newest first
        self._spikes = [0] * self.N_ts
        self._level = 0.5

    def _pixels(self, frame, interval):
        """Eqs 1-8 and habituation: the S layer. By thirds eq. 13, or how many pixels changed of late: F in sum."""
        v = self.parameters
        p = frame - self._luminance
        shares = self._persistence
        if "lamina" in self.mechanisms:  # dP/dt = dL/dt - P/tau, exact where luminance changes evenly in a frame
            frames = interval / v["tau_lamina"]
            p = -math.expm1(-frames) / frames * p
            shares = [math.exp(-frames)]
        for share, past in zip(shares, self._history):
            p = p + share * past
        self._luminance, self._history = frame, [p, *self._history][: len(shares)]
        self._on = np.maximum(p, 0) + v["sigma1"] * self._on
        self._off = np.maximum(-p, 0) + v["sigma1"] * self._off
        a = self._coefficient(v["tau1"], interval)
        self._d_on = self._d_on + a * (self._on - self._d_on)
        self._d_off = self._d_off + a * (self._off - self._d_off)
        s_on = self._on - v["w_bias"] * _lateral(self._d_on)
        s_off = _lateral(self._d_off) - v["w_bias"] * self._off
        s = v["theta1"] * s_on + v["theta2"] * s_off + v["theta3"] * s_on * s_off
        s = self._habituated(s, interval) if "habituation" in self.mechanisms else s
        if "size" not in self.mechanisms:
            return s, _thirds(np.abs(p))
        height = v["T_p"] if "lamina" in self.mechanisms else a * v["T_p"]
        changed = self._d_on + self._d_off > height
        self._held = np.where(changed, 1.0, math.exp(-interval / v["tau_hold"]) * self._held)
        return s, _thirds(self._held)

    def _habituated(self, s, interval):
        """A pixel excites the cell the less the more it did so until the frame before."""
        left = s / (1 + self._fatigue / self.parameters["S_hab"])
        a = self._coefficient(self.parameters["tau_hab"], interval)
        self._fatigue = self._fatigue + a * (np.maximum(left, 0) - self._fatigue)
        return left

    def _potential(self, s):
        """Eqs 9-11: MP, by thirds. The mean of eq. 10 keeps the sum."""
        return _thirds(np.where(s >= self.parameters["T_s"], s, 0.0))

    def _cell(self, mp_sides, f_sides, pixels, interval):
        """Eqs 12 and 14-17."""
        v = self.parameters
        mp, f = sum(mp_sides), sum(f_sides) / pixels
        f_sides = tuple(side / pixels for side in f_sides)
        late, f = self._per_time(mp, f, interval) if "rate" in self.mechanisms else (mp, f)
        late, f = self._delayed(late, f, interval) if "lag" in self.mechanisms else (late, f)
        self._ffi += self._coefficient(v["tau2"], interval) * (f - self._ffi)
        smp = self._potential_behind_inhibition(abs(late) / (pixels * v["k"]), interval)
        c = v["tau3"] / (v["tau3"] + interval)
        rise = smp - self._smp
        adapted = c * (self._smp_adapted + rise) if rise <= v["T_sfa"] else c * smp
        self._smp, self._smp_adapted = smp, max(adapted, 0.5)
        spikes = int(self._smp_adapted >= v["T_sp"]) + int(self._smp_adapted > v["T_sp"] + v["sigma_sp"])
        window = [*self._spikes, spikes]
        self._spikes = window[1:]
        alarm = sum(window) >= v["N_sp"]
        urgency = self._contact(smp, interval)
        return Response(mp, self._ffi, smp, self._smp_adapted, spikes, alarm, mp_sides, f_sides, urgency)

    def _contact(self, smp, interval):
        """The probability of contact: logistic in U', in U of late and its rise over that, and in the inhibition."""
        if self.urgency is None:
            return math.nan
        self._level += -math.expm1(-interval / self.urgency["tau_ms"]) * (smp - self._level)
        inhibition = self._ffi / (self._ffi + self._inhibited_from())
        evidence = (self._smp_adapted - 0.5, self._level - 0.5, smp - self._level, inhibition)
        weighted = (self.urgency[name] * value for name, value in zip(EVIDENCE, evidence))
        predicted = _sigmoid(self.urgency["intercept"] + sum(weighted))
        if not self.urgency.get("predicted"):
            return predicted
        return float(np.interp(predicted, self.urgency["predicted"], self.urgency["observed"]))

    def _inhibited_from(self):
        return self.parameters["A_ffi" if "size" in self.mechanisms else "T_ffi"]

    def _per_time(self, mp, f, interval):
        """MP and F as they would be of a frame of the reference's length. A share of the field is not a change."""
        scale = REFERENCE_MS / interval
        return scale * mp, f if "size" in self.mechanisms else scale * f

    def _delayed(self, mp, f, interval):
        """MP and F of `lag` ms ago, linear between frames, 0 before the first one."""
        lag = self.parameters["lag"]
        self._past = [(0.0, mp, f)] + [(age + interval, *sums) for age, *sums in self._past]
        ages = [age for age, _, _ in self._past]
        newer = sum(age < lag for age in ages)  # frames after that moment
        if newer == len(ages):
            return 0.0, 0.0
        self._past = self._past[: newer + 1]
        return tuple(float(np.interp(lag, ages[: newer + 1], channel)) for channel in list(zip(*self._past))[1:])

    def _potential_behind_inhibition(self, drive, interval):
        """Eq. 12 behind the gate, or the graded shunt with its membrane."""
        v = self.parameters
        threshold = self._inhibited_from()
        if "shunt" not in self.mechanisms:
            return _sigmoid(drive) if self._ffi <= threshold else 0.5
        inhibition = _sigmoid(v["m"] * (math.log(threshold) - math.log(self._ffi + 1e-12)))
        excitation = ((drive + 1e-3) ** v["gamma"] - 1e-3 ** v["gamma"]) * inhibition
        if "membrane" in self.mechanisms:
            excitation = self._excitation + self._coefficient(v["tau_cell"], interval) * (excitation - self._excitation)
            self._excitation = excitation
        return _sigmoid(excitation)

    def _coefficient(self, tau, interval):
        if tau == 0:
            return 1.0
        return -math.expm1(-interval / tau) if self.low_pass == "exact" else interval / (interval + tau)

    def _check_frame(self, frame):
        if frame.ndim != 2 or min(frame.shape) < 3:
            raise ValueError(f"frame has shape {frame.shape}; give grey levels of (row, col), at least 3 x 3")
        if self._luminance is not None and frame.shape != self._luminance.shape:
            raise ValueError(f"frame has shape {frame.shape}, those before {self._luminance.shape}; call reset() first")
        if not np.isfinite(frame).all():
            raise ValueError("frame holds values that are not finite; mask or fill them")


def first_difference(response: Response, expected: Response, tolerance: float) -> tuple[int, str] | None:
    """The first frame, and in it the first channel, in which a response is not the expected one; None if it is.

    **Arguments:** `tolerance` is the share of a channel's largest expected value by which it may be off. Spikes and
    alarm may not.
    """
    wanted = np.array(expected[: len(CHANNELS)], float)
    limits = tolerance * np.abs(wanted).max(axis=1)
    limits[-2:] = 0
    return first_beyond(zip(*response[: len(CHANNELS)]), wanted.T.tolist(), limits.tolist())


def first_beyond(frames: Iterable, wanted: Iterable, limits: Sequence[float]) -> tuple[int, str] | None:
    """The first frame, and in it the first channel, that is off what is wanted by more than the channel's limit.

    **Arguments:** `frames` and `wanted` hold the channels of frame after frame; of `frames` none is asked for after the
    first that is off.
    """
    for t, (values, due) in enumerate(zip(frames, wanted)):
        for name, value, expects, limit in zip(CHANNELS, values, due, limits):
            if not abs(value - expects) <= limit:
                return t, name
    return None


def load(path) -> HardLGMD2:
    """The model of a hand-over file, once its test vector has come out.

    **Raises:** `ValueError` that says what is wrong with the file, `OSError` where it cannot be read.
    """
    content = read(path)
    return _model(content, content["eye"]["fps"] if content["eye"] else None)


def read(path) -> dict:
    """The content of a hand-over file, as `checked` returns it.

    **Raises:** as `load`.
    """
    if os.path.isdir(path):
        raise IsADirectoryError(f"{path} is a folder; give a file")
    try:
        with open(path, encoding="utf-8") as file:
            content = json.load(file)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not a hand-over file: no JSON ({error})") from None
    try:
        return checked(content)
    except ValueError as error:
        raise ValueError(f"{path} is not a hand-over file that can be used: {error}") from None


def checked(content) -> dict:
    """The content of a hand-over file, which is whole, and whose test vector this program computes.

    What version 1 did not have is as version 2 says it: the network is the LGMD2, without mechanisms.

    **Raises:** `ValueError` that says what is wrong with it.
    """
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ValueError(f"its format is not {FORMAT!r}")
    version = content.get("version")
    if type(version) is not int or version not in (1, VERSION):
        raise ValueError(f"its version is {version!r}, this program reads 1 and {VERSION}; update it")
    later = ("mechanisms", "calibration") if version > 1 else ()
    names = (("network",) if version > 1 else ()) + ("parameters", "structure", "eye", "provenance", "test_vector")
    for name in names:
        if name not in content:
            raise ValueError(f"{name} is missing")
    for name in content:
        if name not in ("format", "version", *names, *later):
            raise ValueError(f"{name!r} is unknown; there are {', '.join(('format', 'version', *names, *later))}")
    content = {"network": NETWORK, "mechanisms": {}, "calibration": {}, **content}
    for name in ("parameters", "mechanisms", "structure", "provenance", "calibration"):
        if not isinstance(content[name], dict):
            raise ValueError(f"{name} is {content[name]!r}; give values by name")
    _check_eye(content["eye"])
    check_test_vector(content["test_vector"], content["eye"])
    if content["network"] != NETWORK:
        raise ValueError(f"its network is {content['network']!r}; this program runs only the {NETWORK}")
    _check_parameters(content["parameters"], DOMAINS)
    for name in content["parameters"]:
        if name not in DOMAINS:
            raise ValueError(f"parameter {name} belongs to a mechanism; give it there")
    _check_tables(content["mechanisms"])
    _check_structure(content["structure"])
    _check_urgency(content["calibration"].get("urgency"))
    vector = content["test_vector"]
    with np.errstate(all="ignore"):
        prove(_model(content, vector["fps"])(np.array(vector["frames"])), vector)
    return content


def _model(content, fps):
    parameters = dict(content["parameters"])
    for values in content["mechanisms"].values():
        parameters.update(values)
    return HardLGMD2(
        parameters,
        fps,
        mechanisms=tuple(content["mechanisms"]),
        urgency=content["calibration"].get("urgency"),
        **content["structure"],
    )


def prove(response: Response, vector: Mapping) -> None:
    """Raise `ValueError` where a response is not the one that a test vector states."""
    expected = Response(**vector["response"])
    difference = first_difference(response, expected, vector["tolerance"])
    if difference is not None:
        t, name = difference
        value, wanted = float(getattr(response, name)[t]), getattr(expected, name)[t]
        raise ValueError(
            f"the response to its test vector differs: {name} of frame {t} is {value:.9g}, not {wanted:.9g}; "
            "copy the file again, or write it with lgmd2jax.save"
        )


def _sigmoid(x):
    return 1 / (1 + math.exp(-x)) if x > -700 else 0.0


def _thirds(layer):
    """The sums of the left, centre and right third of the columns; a mirror image swaps the outer ones."""
    columns, outer = layer.sum(axis=0), (layer.shape[1] + 1) // 3
    return tuple(float(part.sum()) for part in (columns[:outer], columns[outer:-outer], columns[-outer:]))


def _lateral(d):
    """The four nearest neighbours at .25, the four diagonal ones at .125, the edge repeated beyond the border."""
    tall = np.concatenate((d[:1], d, d[-1:]))
    rows = tall[:-2] + 2 * d + tall[2:]
    wide = np.concatenate((rows[:, :1], rows, rows[:, -1:]), axis=1)
    return (wide[:, :-2] + 2 * rows + wide[:, 2:]) / 8 - d / 2


def _check_parameters(parameters, domains):
    """Whether each has a value in its domain. What belongs to an absent mechanism may be there, and is not used."""
    if not isinstance(parameters, Mapping):
        raise ValueError(f"parameters is {parameters!r}; give a value for each of {', '.join(domains)}")
    for name in parameters:
        if name not in DOMAINS and not any(name in table for table in MECHANISMS.values()):
            raise ValueError(f"parameter {name!r} is unknown; there are {', '.join(domains)}")
    _check_values(parameters, domains)


def _check_names(mechanisms):
    for name in mechanisms:
        if name not in MECHANISMS:
            raise ValueError(f"mechanism {name!r} is unknown; there are {', '.join(MECHANISMS)}")
    if "membrane" in mechanisms and "shunt" not in mechanisms:
        raise ValueError("mechanisms has a membrane, which needs the shunt; add the shunt")
    if "lamina" in mechanisms and "rate" in mechanisms:
        raise ValueError("mechanisms has a lamina, whose changes do not depend on the frame rate; remove rate")


def _check_tables(mechanisms):
    if not isinstance(mechanisms, Mapping):
        raise ValueError(f"mechanisms is {mechanisms!r}; give a table for each, of {', '.join(MECHANISMS)}")
    _check_names(mechanisms)
    for name, values in mechanisms.items():
        if not isinstance(values, Mapping) or set(values) != set(MECHANISMS[name]):
            raise ValueError(f"mechanism {name} is {values!r}; give {', '.join(MECHANISMS[name])}")
        _check_values(values, MECHANISMS[name])


def _check_values(values, domains):
    for name, domain in domains.items():
        if name not in values:
            raise ValueError(f"parameter {name} is missing")
        value, (low, high) = values[name], map(float, domain[1:-1].split(","))
        inside = _is_finite(value) and low <= value <= high
        if not inside or (value == low and domain[0] == "(") or (value == high and domain[-1] == ")"):
            raise ValueError(f"parameter {name} is {value!r}; it must lie in {domain}")


def _check_structure(structure):
    if not isinstance(structure, dict) or set(structure) != {"n_p", "low_pass", "N_ts"}:
        raise ValueError(f"structure is {structure!r}; give n_p, low_pass and N_ts")
    for name in ("n_p", "N_ts"):
        if type(structure[name]) is not int or not 0 <= structure[name] <= MOST_FRAMES:
            raise ValueError(f"{name} is {structure[name]!r}; give a whole number of frames, 0 to {MOST_FRAMES}")
    if structure["low_pass"] not in ("backward_euler", "exact"):
        raise ValueError(f"low_pass is {structure['low_pass']!r}; give 'backward_euler' or 'exact'")


def _check_urgency(urgency):
    if urgency is None:
        return
    if not isinstance(urgency, Mapping) or set(urgency) - set(CALIBRATION) != set(URGENCY):
        raise ValueError(f"urgency is {urgency!r}; give {', '.join(URGENCY)}")
    for name in URGENCY:
        value = urgency[name]
        if not _is_finite(value) or (name.endswith("_ms") and value <= 0):
            raise ValueError(f"{name} of urgency is {value!r}; give a finite number, of ms a positive one")
    given = [urgency.get(name, []) for name in CALIBRATION]
    columns = [_array(list(column) if isinstance(column, tuple) else column, (int, float)) for column in given]
    for name, column in zip(CALIBRATION, columns):
        is_row = column.ndim == 1 and column.dtype.kind in "fi" and column.shape == columns[0].shape
        if not (is_row and (np.diff(column) >= 0).all() and ((column >= 0) & (column <= 1)).all()):
            raise ValueError(f"{name} of urgency is {urgency.get(name)!r}; give rising numbers 0..1, as many in both")


def _check_eye(eye):
    if eye is None:
        return
    if not isinstance(eye, dict) or set(eye) != set(EYE):
        raise ValueError(f"eye is {eye!r}; give {', '.join(EYE)}")
    for name in ("rows", "cols"):
        if type(eye[name]) is not int or eye[name] < 3:
            raise ValueError(f"{name} is {eye[name]!r}; an eye has a whole number of at least 3 {name}")
    for name in ("degrees_per_pixel", "fps"):
        if not (_is_positive(eye[name]) or (eye[name] is None and name == "degrees_per_pixel")):
            raise ValueError(f"{name} is {eye[name]!r}; give a positive number")
    if eye["projection"] not in ("equidistant", "pinhole"):
        raise ValueError(f"projection is {eye['projection']!r}; give 'equidistant' or 'pinhole'")


def check_test_vector(vector, eye):
    """Raise `ValueError` for a test vector without a value for each frame, and at another rate than the eye's."""
    if not isinstance(vector, dict) or set(vector) != set(TEST_VECTOR):
        raise ValueError(f"test_vector does not hold {', '.join(TEST_VECTOR)}")
    if not _is_positive(vector["fps"]) or (eye and eye["fps"] != vector["fps"]):
        raise ValueError(f"the fps of test_vector is {vector['fps']!r}; it must be positive, and that of the eye")
    if not (_is_positive(vector["tolerance"]) and vector["tolerance"] <= 1e-3):
        raise ValueError(f"the tolerance of test_vector is {vector['tolerance']!r}; it must lie in (0, 0.001]")
    frames, response = _array(vector["frames"], (int,)), vector["response"]
    if not (frames.dtype.kind == "i" and frames.ndim == 3 and min(frames.shape) >= 3) or (frames & ~255).any():
        raise ValueError("the frames of test_vector are not whole grey levels 0..255 of (time, row, col)")
    if not isinstance(response, dict) or set(response) != set(CHANNELS):
        raise ValueError(f"the response of test_vector does not hold {', '.join(CHANNELS)}")
    for name in CHANNELS:
        types = {"spikes": (int,), "collision": (bool,)}.get(name, (int, float))
        channel = _array(response[name], types)
        if channel.dtype.kind not in "fib" or channel.shape != frames.shape[:1] or not np.isfinite(channel).all():
            raise ValueError(f"{name} in the response of test_vector is not a finite value for each frame")


def _array(nested, types):
    """Nested lists of values of these types as an array; where they hold anything else, one of the kind "O"."""
    try:
        array = np.array(nested)
    except ValueError:  # lists of unequal lengths
        return np.array(None)
    return array if all(type(value) in types for value in _flat(nested)) else np.array(None)


def _flat(nested):
    if not isinstance(nested, list):
        yield nested
        return
    for part in nested:
        yield from _flat(part)


def _check_rate(fps):
    if fps is not None and not _is_positive(fps):
        raise ValueError(f"fps is {fps!r}; give a positive number of frames per second")
    if fps is not None and fps < 1:
        warnings.warn(f"fps is {fps:.4g}; were {1 / fps:.4g} meant, given as an interval in s?", stacklevel=3)


def _warn_of_levels(frame):
    lowest, highest = frame.min(), frame.max()
    if highest > BRIGHTEST:
        warnings.warn(
            f"a frame reaches {highest:g}; grey levels lie in 0..255: multiply by 255 over what is white", stacklevel=3
        )
    elif -1 <= lowest < highest <= 1:
        span = "0..1" if lowest >= 0 else "-1..1"
        warnings.warn(
            f"a frame lies in {span}; were grey levels in 0..255 meant? Give black as 0 and white as 255", stacklevel=3
        )


def _is_positive(value):
    return _is_finite(value) and value > 0


def _is_finite(value):
    try:
        return not isinstance(value, (bool, str)) and math.isfinite(value)
    except (TypeError, OverflowError):
        return False
