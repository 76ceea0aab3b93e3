"""The LGMD2: its two stages, pixels and cell, put together as a `Network`."""

from typing import ClassVar

import equinox as eqx

from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import Network
from lgmd2jax._network.lobula import CellState, cell_step
from lgmd2jax._network.low_pass import LOW_PASS_FORMS, LowPass
from lgmd2jax._network.parameters import Parameters
from lgmd2jax._network.pixels import PixelState, Traces, pixel_step
from lgmd2jax._network.sensitivity import potentials
from lgmd2jax._network.thresholds import Hard, Thresholds
from lgmd2jax._words import nearest


class LGMD2(Network):
    """The collision-selective network of Fu, Hu & Yue, differentiable and streaming.

    ```python
    model = LGMD2()                                    # Table I, hard thresholds
    response = model(frames, fps)                      # a clip
    state = model.init(frame)                          # the same numbers, a frame at a time
    state, now = model.step(state, frame, fps)
    jax.vmap(model, in_axes=(0, None))(clips, fps)     # a batch
    ```

    **Arguments:**

    - `parameters`: the paper's parameters; they belong to a frame rate and a field of view.
    - `thresholds`: `Hard()`, `Soft(temperature)` or `StraightThrough(temperature)`.
    - `n_p`: number of frames that a change of luminance persists (eq. 1).
    - `low_pass`: how the delays are discretised, `"backward_euler"` or `"exact"` (eqs 4, 14).
    - `N_ts`: number of past frames in which spikes are counted for an alarm (eq. 17).
    - `eye`: the sampling that the parameters belong to; where it is given, `fps` may be left out of a call.

    **Raises:** `ValueError` for structure that does not exist and for persistence that is not stable.
    """

    pixel_parameters: ClassVar = ("theta1", "theta2", "theta3", "tau1", "w_bias", "sigma1", "T_s", "u")
    parameters: Parameters = eqx.field(default_factory=Parameters)
    thresholds: Thresholds = eqx.field(default_factory=Hard)
    n_p: int = eqx.field(default=0, static=True)
    low_pass: LowPass = eqx.field(default="backward_euler", static=True)
    N_ts: int = eqx.field(default=4, static=True)
    eye: Eye | None = eqx.field(default=None, static=True)

    def __check_init__(self):
        for name in ("n_p", "N_ts"):
            if not isinstance(getattr(self, name), int) or getattr(self, name) < 0:
                raise ValueError(f"{name} is {getattr(self, name)!r}; give a whole number of frames, 0 or more")
        if self.low_pass not in LOW_PASS_FORMS:
            raise ValueError(f"low_pass is {self.low_pass!r}; choose {nearest(self.low_pass, LOW_PASS_FORMS)}")

    def _pixels_at_rest(self, frame):
        return PixelState(frame, Traces.rest(frame, self.n_p))

    def _pixel_step(self, state, frame, interval):
        return pixel_step(self, state, frame, interval)

    def _potentials(self, frames, interval, record):
        return potentials(self, frames, interval, record)

    def _cell_at_rest(self, dtype):
        return CellState.rest(self.N_ts, dtype)

    def _cell_step(self, state, mp, f, parameters, interval, pixels):
        return cell_step(state, mp, f, parameters, self.thresholds, interval, pixels, self.low_pass)
