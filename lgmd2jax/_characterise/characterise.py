"""The exam on a model; with mechanisms taken out, and on another raster."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._characterise.curves import curves_of
from lgmd2jax._characterise.exam import Exam, ExamSums, exam_of, sums_of
from lgmd2jax._characterise.measurements import Measurements, measure, result_of
from lgmd2jax._characterise.result import Characterisation, JudgedAs
from lgmd2jax._characterise.selectivity import Estimate, intervals
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.parameters import symbols
from lgmd2jax._network.variants import ablate
from lgmd2jax._types import Key, check_key
from lgmd2jax.fitting import Fit

_SLOWEST, _COARSEST, _NARROWEST = 10.0, 10.0, 40.0  # fps, degrees a pixel, degrees of field
_FINE = 1.0  # degrees a pixel


@checked
def characterise(model: AbstractNetwork | Fit, *, key: Key | None = None, progress: bool = False) -> Characterisation:
    """The 22 response properties of a looming-sensitive neuron, measured on a model with its own eye.

    The stimuli are rendered once for an eye and kept; another model of the same structure and eye compiles nothing.

    **Arguments:**

    - `model`: with an eye; or a fit, whose handed-over model is meant.
    - `key`: for 100 models drawn from a fit's covariance, which give the intervals of the summary; without it there are
      none.
    - `progress`: show a bar.

    **Raises:** `ValueError` for a model without an eye, for an eye that cannot be shown the stimuli, for a batch of
    models, and for a key without a fit.
    """
    fit = model if isinstance(model, Fit) else None
    if key is not None and fit is None:
        raise ValueError(
            "key is given, but model is no fit, whose covariance the intervals need; give lgmd.load_fit(...)"
        )
    if key is not None:
        check_key(key)
    model = model.model if isinstance(model, Fit) else model
    eye = _usable(model)
    result = _result(model, exam_of(eye), _neuron(model), progress)
    if fit is None or key is None or fit.uncertainty.reason:
        return result
    spans = intervals(fit, eye, key)
    estimates = {name: Estimate(estimate.value, *spans[name]) for name, estimate in result.selectivity.items()}
    return dataclasses.replace(result, selectivity=estimates)


@checked
def ablations(model: AbstractNetwork, *mechanisms: str, progress: bool = False) -> dict[str, Characterisation]:
    """The 22 properties of a model and of the same model without one mechanism at a time, judged as the same neuron.

    **Arguments:** `mechanisms`: which, as of `ablate`; by default all that the model has. What changes the structure,
    as taking size-coding inhibition out, compiles anew.

    **Returns:** by name the model as it is, `"intact"`, and the others, such as `"without ffi"`.

    **Raises:** `ValueError` as for `characterise`, and for a mechanism that the model does not have.
    """
    exam, neuron = exam_of(_usable(model)), _neuron(model)
    variants = {f"without {name}": ablate(model, name) for name in mechanisms or model.ablations}
    variants = {"intact": model} | variants
    return {name: _result(variant, exam, neuron, progress) for name, variant in variants.items()}


@checked
def rasters(
    model: AbstractNetwork, *, seeds: int = 0, finer: bool = True, progress: bool = False
) -> dict[str, Characterisation]:
    """The 22 properties again on other rasters and in other noise, which should not change a verdict.

    **Arguments:**

    - `seeds`: how many other draws of noise and texture to take, for the properties that have any.
    - `finer`: whether an eye of the same field with 1 degree a pixel is tried too, which takes as much longer as it has
      more pixels; where the model's own has 1 degree or less, it is not.

    **Returns:** by name `"as it is"`; `"shifted by half a pixel"`, where all objects are moved (gratings and changes of
    light fill the field and are not); `"noise and texture 1"` and so on, one for each seed; `"1 degree a pixel"`.

    **Raises:** `ValueError` as for `characterise`, and for a number of seeds that is none.
    """
    if not isinstance(seeds, int) or seeds < 0:
        raise ValueError(f"seeds is {seeds!r}; give a whole number, 0 or more")
    eye, neuron = _usable(model), _neuron(model)
    results = {"as it is": _result(model, exam_of(eye), neuron, progress)}
    results["shifted by half a pixel"] = _result(model, exam_of(eye, 0.5), neuron, progress)
    for seed in range(1, seeds + 1):
        results[f"noise and texture {seed}"] = _result(model, exam_of(eye, seed=seed), neuron, progress)
    pitch = 1 / eye.pixels_per_degree
    if finer and pitch > _FINE:
        rows, cols = (round(size * pitch / _FINE) for size in (eye.rows, eye.cols))
        fine = dataclasses.replace(eye, rows=rows, cols=cols, degrees_per_pixel=_FINE)
        model = dataclasses.replace(model, eye=fine)
        results["1 degree a pixel"] = _result(model, exam_of(fine), neuron, progress)
    return results


def differences(results: Mapping[str, Characterisation]) -> list[str]:
    """What depends on the raster, a sentence each: the shift of alpha, and the verdicts that change."""
    (_, first), *others = results.items()
    sentences = []
    for name, other in others:
        shift = other.selectivity["alpha"].value - first.selectivity["alpha"].value
        changes = [
            f"{a.number} {a.name} ({a.verdict} -> {b.verdict})"
            for a, b in zip(first.rows, other.rows, strict=True)
            if a.verdict != b.verdict
        ]
        sentences.append(f"{name}: alpha shifts by {shift:+.2f}; verdicts that change: {', '.join(changes) or 'none'}")
    return sentences


def _result(model: AbstractNetwork, exam: Exam, neuron: JudgedAs, progress: bool) -> Characterisation:
    return result_of(exam, neuron, _measure(exam, sums_of(exam, model, progress), model))


@traced_once
def _measure(exam: Exam, sums: ExamSums, model: AbstractNetwork) -> Measurements:
    return measure(curves_of(exam, sums, model))


def _neuron(model: AbstractNetwork) -> JudgedAs:
    """By the weights of the pathways: a circuit whose ON pathway counts is meant to answer light objects."""
    for name in symbols(type(model.parameters)):
        if shape := np.shape(getattr(model.parameters, name)):
            raise ValueError(f"{name} has shape {shape}; give one model, and loop over a batch")
    return model.neuron


def _usable(model: AbstractNetwork) -> Eye:
    eye = model.eye
    if eye is None:
        raise ValueError(
            "the model has no eye, so its field of view and frame rate are not known; give it one: "
            f"{type(model).__name__}(parameters, eye=Eye(...)); at_frame_rate(model, 100) then takes the parameters to "
            "another frame rate"
        )
    if eye.degrees_per_pixel is None:
        raise ValueError("the eye has no degrees_per_pixel, so that angles are not known; give it")
    if eye.fps < _SLOWEST:
        raise ValueError(f"fps is {eye.fps:g}; the stimuli need at least {_SLOWEST:g} frames per second")
    if eye.degrees_per_pixel >= _COARSEST or min(eye.field_of_view) < _NARROWEST:
        height, width = eye.field_of_view
        raise ValueError(
            f"the eye sees {height:.3g} x {width:.3g} degrees at {eye.degrees_per_pixel:g} degrees a pixel; "
            f"the stimuli need {_NARROWEST:g} degrees each way at less than {_COARSEST:g}"
        )
    return eye
