"""A parameter set at another frame rate than its own."""

import dataclasses

import jax.numpy as jnp

from lgmd2jax._model import LGMD2


def at_frame_rate(model: LGMD2, fps: float | int) -> LGMD2:
    """The model for another frame rate, on an eye of that rate: what counts per frame is scaled.

    T_s, T_ffi, T_sfa and k go with the time that a frame lasts, sigma1 and a persistence over one frame are raised to
    its power, N_ts and N_sp count as many frames as fill the same time. It is an approximation: an edge that is faster
    than a pixel a frame changes fewer pixels instead, by as much. Persistence over more frames stays as it is.

    **Arguments:** `fps`: frames per second.

    **Raises:** `ValueError` for a model without an eye, whose own rate is not known, and for a rate that is none.
    """
    if model.eye is None:
        raise ValueError("the model has no eye, so its own frame rate is not known; give it one: LGMD2(..., eye=Eye())")
    eye = dataclasses.replace(model.eye, fps=fps)
    share, p = model.eye.fps / fps, model.parameters
    changes = {name: share * getattr(p, name) for name in ("T_s", "T_ffi", "k")}
    changes |= {"T_sfa": jnp.clip(share * p.T_sfa, -1, 1), "sigma1": p.sigma1**share, "N_sp": p.N_sp / share}
    if model.n_p == 1:
        changes["u"] = jnp.log(jnp.expm1(share * jnp.log1p(jnp.exp(p.u))))  # a_1 = 1/(1 + exp(u)) to the power of share
    N_ts = max(round((model.N_ts + 1) / share) - 1, 0)
    return dataclasses.replace(model, parameters=dataclasses.replace(p, **changes), N_ts=N_ts, eye=eye)
