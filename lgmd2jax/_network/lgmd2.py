"""The LGMD2: its two stages, pixels and cell, put together as a network."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import equinox as eqx

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import RESPONSE, Description
from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import AbstractNetwork, Neuron
from lgmd2jax._network.lobula import Cell
from lgmd2jax._network.low_pass import LOW_PASS_FORMS, LowPass
from lgmd2jax._network.parameter_set import declared
from lgmd2jax._network.parameters import Parameters
from lgmd2jax._network.pixels import Pixels
from lgmd2jax._network.retina import unstable_persistence
from lgmd2jax._network.stages import Levels
from lgmd2jax._network.structure import counts, one_of, some_of, structure_fields
from lgmd2jax._network.thresholds import Hard, Thresholds

_SHORTEST_INTERVAL = 2.0  # ms; by a faster clock than this a lag wants an eye that says so
_SHARE_OF_FIELD = Description(
    "1", "share of the field that changed recently, delayed (eq. 14)", "FFI, share of the field"
)
_PER_TIME = Description("grey level", "delayed feed-forward inhibition in 1/30 s (eq. 14)", "FFI in 1/30 s")
MECHANISMS = ("size", "shunt", "lag", "membrane", "rate", "lamina", "habituation")
"""What the paper's circuit does not have, by the names that `LGMD2(mechanisms=...)` takes."""
ABLATIONS: Mapping[str, Mapping[str, float]] = {
    "ffi": {"T_ffi": 1e9},
    "sfa": {"T_sfa": -1.0, "tau3": 1e9},
    "lateral": {"w_bias": 0.0},
    "on": {"theta1": 0.0, "theta3": 0.0},
    "off": {"theta2": 0.0, "theta3": 0.0},
}
"""The mechanisms of the paper's circuit, with the values of parameters by which `ablate` takes each out."""


@checked
class LGMD2(AbstractNetwork):
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
    - `mechanisms`: what the paper's circuit does not have, some of `"size"` (inhibition codes size: F is the share
      of the field that changed of late, and A_ffi its threshold), `"shunt"` (inhibition divides, and the excitation
      has an exponent), `"lag"` (the cell sees the pixels late), `"membrane"` (the excitation is low-passed, which
      needs the shunt), `"rate"` (the cell sees change per time instead of per frame: MP and F are scaled to a frame
      of 1/30 s by the interval that each frame had, so that k and T_ffi are right at any frame rate), `"lamina"`
      (a change of luminance fades with tau_lamina instead of after a frame, so that T_s, T_ffi and k are right at any
      frame rate; without persistence and without `"rate"`) and `"habituation"` (a pixel excites the cell the less the
      more it did so of late, so that what moves on and on is answered less than what is new).
    - `eye`: the sampling that the parameters belong to; where it is given, `fps` may be left out of a call.

    **Raises:** `ValueError` for structure that does not exist and for persistence that is not stable.
    """

    parameters: Parameters = eqx.field(default_factory=Parameters)
    thresholds: Thresholds = eqx.field(default_factory=Hard)
    n_p: int = counts(0, "frames", least=0)
    low_pass: LowPass = one_of("backward_euler", LOW_PASS_FORMS)
    N_ts: int = counts(4, "frames", least=0, at_interval=lambda frames, ratio: max(round((frames + 1) / ratio) - 1, 0))
    mechanisms: tuple[str, ...] = some_of(MECHANISMS)
    eye: Eye | None = eqx.field(default=None, static=True)

    def __check_init__(self):
        structure_fields(LGMD2)["mechanisms"].check("mechanisms", self.mechanisms)
        if "membrane" in self.mechanisms and "shunt" not in self.mechanisms:
            raise ValueError(f"mechanisms is {self.mechanisms}; a membrane needs the shunt: add 'shunt'")
        if {"lamina", "rate"} <= set(self.mechanisms):
            raise ValueError(
                f"mechanisms is {self.mechanisms}; with a lamina changes do not depend on the frame rate: remove 'rate'"
            )
        if "lamina" in self.mechanisms and self.n_p:
            raise ValueError(f"n_p is {self.n_p}; a lamina stands in the place of persistence: give n_p=0")

    @property
    def pixels(self) -> Pixels:
        return Pixels(
            self.parameters,
            self.thresholds,
            self.n_p,
            self.low_pass,
            codes_size="size" in self.mechanisms,
            has_lamina="lamina" in self.mechanisms,
            habituates="habituation" in self.mechanisms,
        )

    @property
    def cell(self) -> Cell:
        shortest = _SHORTEST_INTERVAL if self.eye is None else min(_SHORTEST_INTERVAL, 1000 / self.eye.fps)
        return Cell(self.parameters, self.thresholds, self.low_pass, self.N_ts, self.mechanisms, shortest)

    @property
    def ablations(self) -> Mapping[str, Mapping[str, Any]]:
        """`ABLATIONS`, and each optional mechanism that the model has; without the shunt there is no membrane."""
        changes: dict[str, Mapping[str, Any]] = dict(ABLATIONS)
        if "size" in self.mechanisms:
            changes["ffi"] = {"A_ffi": 1e9}
        for name in self.mechanisms:
            gone = {name, "membrane"} if name == "shunt" else {name}
            changes[name] = {"mechanisms": tuple(other for other in self.mechanisms if other not in gone)}
        return changes

    @property
    def unused(self) -> frozenset[str]:
        """Parameters of mechanisms that the model does not have; T_ffi where inhibition codes size; u without n_p."""
        unused = {
            name for name, known in declared(Parameters).items() if known.mechanism not in (None, *self.mechanisms)
        }
        return frozenset(unused | ({"T_ffi"} if "size" in self.mechanisms else set()) | (set() if self.n_p else {"u"}))

    @property
    def levels(self) -> Levels:
        v = self.parameters
        inhibited_from = "A_ffi" if "size" in self.mechanisms else "T_ffi"
        return Levels((float(v.T_sp), float(v.T_sp + v.sigma_sp)), float(getattr(v, inhibited_from)), inhibited_from)

    @property
    def channels(self) -> Mapping[str, Description]:
        if "size" in self.mechanisms:
            return {**RESPONSE, "ffi": _SHARE_OF_FIELD}
        return {**RESPONSE, "ffi": _PER_TIME} if "rate" in self.mechanisms else RESPONSE

    @property
    def neuron(self) -> Neuron:
        """A circuit whose ON pathway counts is meant to answer light objects."""
        return "LGMD1" if float(self.parameters.theta1) >= float(self.parameters.theta2) / 2 else "LGMD2"

    def at_interval(self, ratio: float):
        """As of any network, but that persistence over more than one frame stays as it is; k and T_ffi too, where they
        are compared with change per time, and with T_s and S_hab where a lamina sees changes.
        """
        other = super().at_interval(ratio)
        kept = () if self.n_p == 1 else ("u",)
        if {"rate", "lamina"} & set(self.mechanisms):
            kept += "k", "T_ffi"
        if "lamina" in self.mechanisms:
            kept += "T_s", "S_hab"
        values = {name: getattr(self.parameters, name) for name in kept}
        return dataclasses.replace(other, parameters=dataclasses.replace(other.parameters, **values))

    def conflicts(self):
        return unstable_persistence(self.parameters.u, self.n_p)
