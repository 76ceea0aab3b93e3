"""The pixel stage of the LGMD2 in four parts, by what a derivative needs of each (`sensitivity`)."""

import abc
from typing import NamedTuple

import equinox as eqx
import jax
from jaxtyping import Array, Float

from lgmd2jax._network.maps import Bordered, folded, inside, pool
from lgmd2jax._network.medulla import lateral
from lgmd2jax._network.stages import AbstractPixels
from lgmd2jax._types import Map, Scalar


class Traces(eqx.Module):
    """What the pixels remember of changes, with the border. It is pointwise: neighbours only feed forward.

    `held`: M, how much of late a pixel changed; for size-coding inhibition alone. `fatigue`: B, how much of late it
    excited the cell; for habituation alone.
    """

    p: Float[Array, "n_p row_and_border col_and_border"]
    on: Bordered
    off: Bordered
    d_on: Bordered
    d_off: Bordered
    held: Map | None = None
    fatigue: Map | None = None


class Signals(NamedTuple):
    """What S is made of: ON, OFF, the lateral spread of their delayed ones, and the fatigue until then, B(t-1)."""

    on: Map
    off: Map
    spread_on: Map
    spread_off: Map
    fatigue: Map | None = None


def signals_of(traces: Traces) -> Signals:
    """Eqs 5 and 6: the flows of a frame, and the fatigue before it. Of sensitivities too, of which some are None."""
    on, off = jax.tree.map(inside, (traces.on, traces.off))
    spread_on, spread_off = jax.tree.map(lateral, (traces.d_on, traces.d_off))
    return Signals(on, off, spread_on, spread_off, traces.fatigue)


def mp_of(s_gated: Map) -> Scalar:
    """Eqs 10 and 11: MP, the sum of S', which the mean of eq. 10 keeps."""
    return pool(folded(s_gated))


class PixelParts(AbstractPixels):
    """What pixels remember, how flows add up to S, what that tires, and the gate with the sum over the field."""

    @abc.abstractmethod
    def traces_at_rest(self, frame: Map) -> Traces:
        """The traces of pixels that saw no change."""

    @abc.abstractmethod
    def remember(self, traces: Traces, change: Bordered, interval: Scalar) -> tuple[Traces, Scalar, Bordered]:
        """All that has a memory, each pixel by itself: the next traces, F, and P. The fatigue is still that before."""

    @abc.abstractmethod
    def add_flows(self, signals: Signals) -> Map:
        """S."""

    @abc.abstractmethod
    def tire(self, traces: Traces, s: Map, interval: Scalar) -> Traces:
        """The traces with the fatigue by S of this frame, where pixels habituate."""

    @abc.abstractmethod
    def gate(self, s: Map) -> Map:
        """S', whose sum is MP."""

    def gate_and_pool(self, s: Map) -> Scalar:
        """MP."""
        return mp_of(self.gate(s))
