"""Variants of a model: without a mechanism, at another frame rate, and for another eye."""

import dataclasses

import jax.numpy as jnp

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import AnyNetwork
from lgmd2jax._network.parameter_set import declared
from lgmd2jax._words import nearest


@checked
def ablate(model: AnyNetwork, *mechanisms: str) -> AnyNetwork:
    """The model without the named mechanisms, as a pharmacologist would take them out.

    - `"ffi"`: feed-forward inhibition never silences the cell.
    - `"sfa"`: no spike-frequency adaptation; `smp_adapted` is `smp`.
    - `"lateral"`: no inhibition in the local sums (eq. 7).
    - `"on"`, `"off"`: the pathway, and its product with the other, carries no weight (eq. 8).
    - `"size"`, `"shunt"`, `"lag"`, `"membrane"`, `"rate"`, `"lamina"`, `"habituation"`: the mechanism that the paper's
      circuit does not have, where the model has it; without the shunt there is no membrane either.

    **Raises:** `ValueError` for another name, and for what the model does not have: a `YueRindLGMD1` has
    FFI and lateral inhibition alone.
    """
    for mechanism in mechanisms:
        if mechanism not in tuple(model.ablations):
            raise ValueError(f"mechanism is {mechanism!r}; choose {nearest(mechanism, model.ablations)}")
    for mechanism in mechanisms:
        changes = model.ablations.get(mechanism, {})  # none where it left with another one
        values = {
            name: jnp.full_like(getattr(model.parameters, name), value)
            for name, value in changes.items()
            if name in declared(type(model.parameters))
        }
        fields = {name: value for name, value in changes.items() if name not in values}
        parameters = dataclasses.replace(model.parameters, **values)
        model = dataclasses.replace(model, parameters=parameters, **fields)
    return model


@checked
def at_frame_rate(model: AnyNetwork, fps: float | int) -> AnyNetwork:
    """The model for another frame rate, on an eye of that rate: what counts per frame is scaled.

    What is compared with a change in a frame goes with the time that a frame lasts, as T_s, S_hab, T_ffi, T_sfa and k;
    a share that is left after a frame is raised to its power, as sigma1; N_ts and N_sp count as many frames as fill the
    same time (`Symbol.per_frame` of each parameter). It is an approximation: an edge that is faster than a pixel a
    frame changes fewer pixels instead, by as much. Persistence over more than one frame stays as it is, and so do T_ffi
    and k of a model that sees change per time (`"rate"` of its mechanisms), and T_s, S_hab, T_ffi and k of one with a
    `"lamina"`, whose P is a change in a time of its own.

    **Arguments:** `fps`: frames per second.

    **Raises:** `ValueError` for a model without an eye, whose own rate is not known, and for a rate that is none.
    """
    if model.eye is None:
        raise ValueError("the model has no eye, so its own frame rate is not known; give it one: LGMD2(..., eye=Eye())")
    eye = dataclasses.replace(model.eye, fps=fps)
    return dataclasses.replace(model.at_interval(model.eye.fps / fps), eye=eye)


@checked
def at_eye(model: AnyNetwork, eye: Eye) -> AnyNetwork:
    """The model for another eye: at its frame rate, and in its field of view.

    The rate is changed as `at_frame_rate` does. What is compared with a mean over the field goes as 1/(field area), as
    k, T_ffi and A_ffi (`Symbol.of_field` of each parameter): an object of the same angular size then means the same.
    A finer or coarser raster of one field changes nothing. It is an approximation where contrast is low, since on a
    finer raster T_s bites earlier.

    **Raises:** `ValueError` for a model without an eye, and where one of the two fields is not known in degrees.
    """
    if model.eye is None:
        raise ValueError("the model has no eye, so its field of view is not known; give it one: LGMD2(..., eye=Eye())")
    for name, own in (("the model's eye", model.eye), ("eye", eye)):
        if own.degrees_per_pixel is None:
            raise ValueError(f"{name} has no degrees_per_pixel, so its field of view is not known; give it")
    if model.eye == eye:
        return model
    ratio = eye.field_area / model.eye.field_area
    return dataclasses.replace(at_frame_rate(model, eye.fps).in_field(ratio), eye=eye)
