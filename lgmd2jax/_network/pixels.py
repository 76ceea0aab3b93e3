"""The pixel stage of the LGMD2: eqs 1-11 and 13."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp

from lgmd2jax._network import medulla, retina
from lgmd2jax._network.low_pass import LowPass, coefficient, low_pass
from lgmd2jax._network.maps import Bordered, bordered, inside, pool
from lgmd2jax._network.parameters import Parameters
from lgmd2jax._network.parts import PixelParts, Signals, Traces, signals_of
from lgmd2jax._network.sensitivity import exact_sums
from lgmd2jax._network.stages import Interval, Record, Sums
from lgmd2jax._network.thresholds import Thresholds
from lgmd2jax._types import Map, Scalar


class PixelState(eqx.Module):
    """What the pixels keep from one frame to the next."""

    luminance: Map
    traces: Traces


class Layers(eqx.Module):
    """The maps of one frame, in grey levels, for `record` to choose from.

    ```python
    response = model(frames, fps, record=lambda layers: layers.s)
    response.recorded                                           # S of every frame: (time, row, col)
    ```

    - `p`: P, the change of luminance with its persistence (eq. 1) or with what the lamina keeps of it.
    - `on`, `off`: the two pathways (eqs 2, 3); `d_on`, `d_off`: the same, delayed (eq. 4).
    - `s_on`, `s_off`: the local sums of each pathway (eq. 7). `s`: S, both together (eq. 8), or what habituation leaves
      of it.
    - `s_gated`: S', what passes T_s (eq. 9). `g`: its 3x3 mean (eq. 10).
    - `f`: the map whose mean is F: abs(P) (eq. 13), or with size-coding inhibition M, from 0 to 1, how much a pixel
      changed of late.
    """

    p: Map
    on: Map
    off: Map
    d_on: Map
    d_off: Map
    s_on: Map
    s_off: Map
    s: Map
    s_gated: Map
    g: Map
    f: Map

    @property
    def mp(self) -> Map:
        """The map whose sum is MP: the mean of eq. 10 keeps the sum of S'."""
        return self.s_gated


class Pixels(PixelParts):
    """From frames to MP and F. Parameters and frames come in one dtype."""

    parameters: Parameters
    thresholds: Thresholds
    n_p: int = eqx.field(static=True)
    low_pass: LowPass = eqx.field(static=True)
    codes_size: bool = eqx.field(static=True)
    has_lamina: bool = eqx.field(static=True)
    habituates: bool = eqx.field(static=True)

    @property
    def _kept(self) -> int:
        """How many frames' P is remembered."""
        return 1 if self.has_lamina else self.n_p

    def rest(self, frame: Map) -> PixelState:
        return PixelState(frame, self.traces_at_rest(frame))

    def traces_at_rest(self, frame: Map) -> Traces:
        zero = jnp.zeros((frame.shape[0] + 2, frame.shape[1] + 2), frame.dtype)
        held = jnp.zeros_like(frame) if self.codes_size else None
        fatigue = jnp.zeros_like(frame) if self.habituates else None
        return Traces(jnp.zeros((self._kept, *zero.shape), zero.dtype), zero, zero, zero, zero, held, fatigue)

    def over(self, frames, interval: Interval, record: Record | None = None):
        if record is None:
            return exact_sums(self, frames, interval), None
        return self.plain(frames, interval, record)

    def step(self, state: PixelState, frame: Map, interval: Scalar) -> tuple[PixelState, Sums, Layers]:
        traces, f, p = self.remember(state.traces, bordered(frame - state.luminance), interval)
        signals = signals_of(traces)
        s = self.add_flows(signals)
        layers = self._layers(traces, p, signals, s)
        return PixelState(frame, self.tire(traces, s, interval)), Sums(self.gate_and_pool(s), f), layers

    def _layers(self, traces: Traces, p: Bordered, signals: Signals, s: Map) -> Layers:
        s_gated = medulla.gate(s, self.parameters.T_s, self.thresholds)
        return Layers(
            inside(p),
            signals.on,
            signals.off,
            inside(traces.d_on),
            inside(traces.d_off),
            *self._local_sums(signals),
            s,
            s_gated,
            medulla.g_layer(bordered(s_gated)),
            retina.magnitude(inside(p)) if traces.held is None else traces.held,
        )

    def remember(self, traces: Traces, change: Bordered, interval: Scalar) -> tuple[Traces, Scalar, Bordered]:
        """Eqs 1-4, and F: eq. 13 or the share of the field that changed recently."""
        a = coefficient(self.parameters.tau1, interval, self.low_pass)
        p = retina.photoreceptors(change, traces.p, *self._of_changes(interval))
        on, off = retina.half_wave(p)
        on = retina.residual(on, traces.on, self.parameters.sigma1)
        off = retina.residual(off, traces.off, self.parameters.sigma1)
        d_on = low_pass(traces.d_on, on, a)
        d_off = low_pass(traces.d_off, off, a)
        history = jnp.concatenate([p[None], traces.p])[: self._kept]
        if traces.held is None:
            new = Traces(history, on, off, d_on, d_off, None, traces.fatigue)
            return new, retina.mean_change(inside(p)), p
        # What lasts for a frame alone reaches that share of its height when delayed; of a lamina P lasts longer.
        height = self.parameters.T_p if self.has_lamina else a * self.parameters.T_p
        changed = self.thresholds.change(inside(d_on + d_off), height)
        held = medulla.hold(traces.held, changed, self.parameters.tau_hold, interval)
        return Traces(history, on, off, d_on, d_off, held, traces.fatigue), pool(held, 1 / held.size), p

    def tire(self, traces: Traces, s: Map, interval: Scalar) -> Traces:
        """B(t) of habituation: a low-pass of S where it excites."""
        if traces.fatigue is None:
            return traces
        a = coefficient(self.parameters.tau_hab, interval, self.low_pass)
        return dataclasses.replace(traces, fatigue=low_pass(traces.fatigue, jnp.maximum(s, 0), a))

    def _of_changes(self, interval: Scalar):
        """What is left of each P before, and the share of a change that there is at its end."""
        if self.has_lamina:
            return retina.lamina(self.parameters.tau_lamina, interval)
        return retina.persistence(self.parameters.u, self.n_p), 1.0

    def add_flows(self, signals: Signals) -> Map:
        """Eqs 7 and 8, and habituation."""
        s = medulla.s_layer(*self._local_sums(signals), self.parameters)
        return s if signals.fatigue is None else medulla.habituated(s, signals.fatigue, self.parameters.S_hab)

    def _local_sums(self, signals: Signals) -> tuple[Map, Map]:
        """Eq. 7."""
        return medulla.local_sums(
            signals.on, signals.off, signals.spread_on, signals.spread_off, self.parameters.w_bias
        )

    def gate(self, s: Map) -> Map:
        """Eq. 9."""
        return medulla.gate(s, self.parameters.T_s, self.thresholds)
