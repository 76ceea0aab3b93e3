"""What a camera's noise alone does to a network: the inhibition at rest."""

import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._network.abstract import AbstractNetwork

_SECONDS, _PIXELS, _MEAN = 5.0, (24, 32), 128.0  # longer than a changed pixel counts; grey levels


@checked
def inhibition_in_noise(model: AbstractNetwork, noise: float | int = 2.0, fps: float | int | None = None) -> float:
    """The inhibition that a camera's noise alone brings about, as a share of the one that inhibits the cell.

    With size-coding inhibition every frame is another chance for a pixel to count as changed, and it counts for
    tau_hold, so noise fills more of the field as the frame rate rises; behind a lamina about as much at any rate. From
    about a half on it takes part of every response away: T_p must rise (without size-coding inhibition T_ffi).

    **Arguments:**

    - `noise`: standard deviation in grey levels, independent for pixels and frames, as of `stimuli.camera`.
    - `fps`: frames per second, by default the eye's.

    **Raises:** `ValueError` without a frame rate, and as a call of the model.
    """
    if fps is None:
        if model.eye is None:
            raise ValueError("fps is missing; give it, or a model with an eye")
        fps = model.eye.fps
    count = max(round(_SECONDS * fps), 2)
    frames = _MEAN + noise * np.random.default_rng(0).standard_normal((count, *_PIXELS))
    response = model(frames, fps)
    return float(response.ffi[-count // 5 :].mean()) / model.levels.ffi
