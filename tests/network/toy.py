"""A network of one's own, as a user would write it: a pixel that dims by a step counts, the cell adds up leakily."""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._eye import Eye
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.maps import pool
from lgmd2jax._network.parameter_set import ParameterSet, declares, scalar
from lgmd2jax._network.stages import AbstractCell, AbstractPixels, Levels, Response, Sums
from lgmd2jax._network.structure import counts, one_of
from lgmd2jax._network.thresholds import Hard, Thresholds
from lgmd2jax._types import Map, Scalar


class DimmingParameters(ParameterSet):
    """What a dimming detector is free to have."""

    T_dim: Float[Array, ""] = eqx.field(
        default=6.0,
        converter=scalar,
        metadata=declares(
            "fall of luminance in a frame that counts", "grey level", "[0, inf)", (1.0, 30.0), "a guess", "log",
            stage="pixels", per_frame="change",
        ),
    )  # fmt: skip
    tau: Float[Array, ""] = eqx.field(
        default=60.0,
        converter=scalar,
        metadata=declares("time constant of the cell", "ms", "(0, inf)", (10.0, 300.0), "a guess", scale="log"),
    )
    k: Float[Array, ""] = eqx.field(
        default=1.5,
        converter=scalar,
        metadata=declares(
            "mean fall that maps to sigma(1)", "grey level", "(0, inf)", (0.1, 10.0), "a guess", "log",
            per_frame="change",
        ),
    )  # fmt: skip
    T_sp: Float[Array, ""] = eqx.field(
        default=0.7,
        converter=scalar,
        metadata=declares("potential from which there is a spike", "1", "(0.5, 1)", (0.55, 0.95), "a guess"),
    )


class DimmingPixels(AbstractPixels):
    parameters: DimmingParameters
    thresholds: Thresholds
    border: str = eqx.field(static=True)

    def rest(self, frame: Map) -> Map:
        return frame

    def step(self, state: Map, frame: Map, interval: Scalar) -> tuple[Map, Sums, Map]:
        fall = jnp.maximum(state - frame, 0)
        counted = fall * self.thresholds.s(fall, self.parameters.T_dim)
        if self.border == "left out":
            counted = counted[1:-1, 1:-1]
        return frame, Sums(pool(counted), pool(jnp.abs(frame - state), 1 / frame.size)), counted


class DimmingCell(AbstractCell):
    parameters: DimmingParameters
    thresholds: Thresholds
    N_alarm: int = eqx.field(static=True)

    def rest(self) -> tuple[Scalar, Float[Array, " N_alarm"]]:
        dtype = self.parameters.dtype
        return jnp.zeros((), dtype), jnp.zeros(self.N_alarm - 1, dtype)

    def step(self, state: Any, sums: Sums, interval: Scalar, pixels: int) -> tuple[Any, Response]:
        v, (excitation, past) = self.parameters, state
        excitation += interval / (interval + v.tau) * (sums.mp / (pixels * v.k) - excitation)
        u = 1 / (1 + jnp.exp(-excitation))
        spikes = self.thresholds.spikes(u, v.T_sp, jnp.ones_like(u))
        window = jnp.append(past, spikes)
        alarm = self.thresholds.collision(window.sum(), jnp.full_like(u, self.N_alarm))
        return (excitation, window[1:]), Response(sums.mp, sums.f, u, u, spikes, alarm)


class Dimming(AbstractNetwork):
    """A dimming detector; it alarms after N_alarm spikes in a row."""

    parameters: DimmingParameters = eqx.field(default_factory=DimmingParameters)
    thresholds: Thresholds = eqx.field(default_factory=Hard)
    N_alarm: int = counts(3, "spikes", least=1, at_interval=lambda spikes, ratio: max(round(spikes / ratio), 1))
    border: str = one_of("counted", ("counted", "left out"))
    eye: Eye | None = eqx.field(default=None, static=True)

    @property
    def pixels(self) -> DimmingPixels:
        return DimmingPixels(self.parameters, self.thresholds, self.border)

    @property
    def cell(self) -> DimmingCell:
        return DimmingCell(self.parameters, self.thresholds, self.N_alarm)

    @property
    def levels(self) -> Levels:
        return Levels((float(self.parameters.T_sp),), float("inf"))

    @property
    def ablations(self):
        return {"threshold": {"T_dim": 0.0}, "border": {"border": "left out"}}
