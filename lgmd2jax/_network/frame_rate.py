"""A parameter set at another frame rate than its own."""

import dataclasses
from typing import Any

import jax.numpy as jnp

from lgmd2jax._network.abstract import AnyNetwork
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.yue_rind import YueRindLGMD1


def at_frame_rate(model: AnyNetwork, fps: float | int) -> AnyNetwork:
    """The model for another frame rate, on an eye of that rate: what counts per frame is scaled.

    T_s, T_ffi, T_sfa and k go with the time that a frame lasts, sigma1 and a persistence over one frame are raised to
    its power, N_ts and N_sp count as many frames as fill the same time. It is an approximation: an edge that is faster
    than a pixel a frame changes fewer pixels instead, by as much. Persistence over more frames stays as it is.

    Of a `YueRindLGMD1` T_de, T_ffi, Delta_C and k go so. Its inhibition and its FFI come one frame late at any rate.

    **Arguments:** `fps`: frames per second.

    **Raises:** `ValueError` for a model without an eye, whose own rate is not known, and for a rate that is none.
    """
    if model.eye is None:
        raise ValueError("the model has no eye, so its own frame rate is not known; give it one: LGMD2(..., eye=Eye())")
    eye = dataclasses.replace(model.eye, fps=fps)
    share, p = model.eye.fps / fps, model.parameters
    changes, structure = _SCALED[type(model)](model, share)
    changes |= {name: share * getattr(p, name) for name in ("T_ffi", "k")}
    if model.n_p == 1:
        changes["u"] = jnp.log(jnp.expm1(share * jnp.log1p(jnp.exp(p.u))))  # a_1 = 1/(1 + exp(u)) to the power of share
    return dataclasses.replace(model, parameters=dataclasses.replace(p, **changes), eye=eye, **structure)


def _lgmd2(model: LGMD2, share: float) -> tuple[dict[str, Any], dict[str, int]]:
    p = model.parameters
    changes = {"T_s": share * p.T_s, "T_sfa": jnp.clip(share * p.T_sfa, -1, 1), "sigma1": p.sigma1**share}
    return changes | {"N_sp": p.N_sp / share}, {"N_ts": max(round((model.N_ts + 1) / share) - 1, 0)}


def _yue_rind(model: YueRindLGMD1, share: float) -> tuple[dict[str, Any], dict[str, int]]:
    p = model.parameters
    return {"T_de": share * p.T_de, "Delta_C": share * p.Delta_C}, {"N_sp": max(round(model.N_sp / share), 1)}


_SCALED = {LGMD2: _lgmd2, YueRindLGMD1: _yue_rind}
