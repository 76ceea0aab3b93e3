"""The test vector of a network that only JAX runs: a short clip and the response to it."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from lgmd2jax import hard
from lgmd2jax._compute.traced_once import traced_once
from lgmd2jax._handover.test_vector import FPS_WITHOUT_EYE, FRAMES, TOLERANCE, random_clip
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.parameter_set import declared
from lgmd2jax._words import warn

_CLIPS = 32
_NEAR, _FAR = 3e-5, 0.25  # by which share a parameter is moved


def response_vector(model: AbstractNetwork, fps: float | None) -> dict[str, Any]:
    """The test vector as it stands in the hand-over file. Equal models have equal ones.

    Of seeded clips that keep clear of thresholds, so that no parameter moved a little makes a spike or a jump, the one
    that shows most: on which most parameters, moved by a quarter, change the response. Where none is clear, a clip that
    stands still, and a warning.
    """
    fps = FPS_WITHOUT_EYE if fps is None else fps
    generator = np.random.default_rng(0)
    moved_little, moved_far = _moved(model, _NEAR), _moved(model, _FAR)
    candidates = []
    for _ in range(_CLIPS):
        frames = random_clip(generator)
        response = np.stack(_responses(model, model.parameters, frames, fps))
        near = np.stack(_responses(model, moved_little, frames, fps), axis=1)
        far = np.stack(_responses(model, moved_far, frames, fps), axis=1)
        scale = np.abs(response).max(axis=1)[:, None]
        jumps = np.abs(near - response) > 1e-2 * scale
        jumps[:, -2:] = near[:, -2:] != response[-2:]
        if not jumps.any():
            shows = int((np.abs(far - response) > 1e-3 * scale).any(axis=(1, 2)).sum())
            candidates.append((shows, frames, response))
    if candidates:
        _, frames, response = max(candidates, key=lambda candidate: candidate[0])
    else:
        warn(
            f"none of {_CLIPS} test clips stays clear of the thresholds of this {type(model).__name__}; its file has a "
            "still clip as its test vector, which checks little"
        )
        frames = np.repeat(random_clip(generator)[:1], FRAMES, axis=0)
        response = np.stack(_responses(model, model.parameters, frames, fps))
    channels = dict(zip(hard.CHANNELS, response.tolist(), strict=True))
    for name in ("mp", "ffi", "smp", "smp_adapted"):
        channels[name] = [float(f"{value:.9g}") for value in channels[name]]
    channels["spikes"] = [int(value) for value in channels["spikes"]]
    channels["collision"] = [value > 0 for value in channels["collision"]]
    return {"fps": fps, "tolerance": TOLERANCE, "frames": frames.astype(int).tolist(), "response": channels}


@traced_once
def _responses(model: AbstractNetwork, parameters, frames, fps):
    def one(parameters):
        response = dataclasses.replace(model, parameters=parameters)(frames, fps)
        return tuple(getattr(response, name) for name in hard.CHANNELS)

    batched = jnp.ndim(jax.tree.leaves(parameters)[0]) == 1
    return jax.vmap(one)(parameters) if batched else one(parameters)


def _moved(model: AbstractNetwork, share: float):
    """The parameters with each of them moved up and down by this share, as a batch."""
    names = list(declared(type(model.parameters)))
    values = {}
    for name in names:
        leaf = getattr(model.parameters, name)
        factors = np.ones(2 * len(names))
        factors[2 * names.index(name)], factors[2 * names.index(name) + 1] = 1 + share, 1 - share
        values[name] = leaf * jnp.asarray(factors, leaf.dtype)
    return eqx.tree_at(lambda p: [getattr(p, name) for name in names], model.parameters, list(values.values()))
