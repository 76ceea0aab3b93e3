"""The medulla: lateral spread, local sums, the S layer, its gate and the G layer (eqs 5-11).

Pure functions of one frame; the delay of eq. 4 is `low_pass.low_pass`.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._network.maps import Bordered, inside
from lgmd2jax._network.parameters import Parameters
from lgmd2jax._network.thresholds import Thresholds
from lgmd2jax._types import Map, Scalar


def lateral(d: Bordered) -> Map:
    """Eqs 5, 6: W * D with W = 0 at the centre, .25 for the nearest and .125 for the diagonal neighbours."""
    nearest, diagonal = _neighbours(d)
    return nearest / 4 + diagonal / 8


def local_sums(on: Map, off: Map, spread_on: Map, spread_off: Map, w_bias: Float[Array, ""]) -> tuple[Map, Map]:
    """Eq. 7: S_on = ON - w_bias W*D_on, S_off = W*D_off - w_bias OFF.

    The two pathways delay opposite flows: the inhibition in ON, the excitation in OFF.
    """
    return on - w_bias * spread_on, spread_off - w_bias * off


def s_layer(s_on: Map, s_off: Map, parameters: Parameters) -> Map:
    """Eq. 8: S = theta1 S_on + theta2 S_off + theta3 S_on S_off."""
    return parameters.theta1 * s_on + parameters.theta2 * s_off + parameters.theta3 * s_on * s_off


def habituated(s: Map, fatigue: Map, S_hab: Scalar) -> Map:
    """Habituation: S/(1 + B/S_hab). The `fatigue` B is a low-pass of what it left of max(S, 0) in the frames before."""
    return s * S_hab / (S_hab + fatigue)


def gate(s: Map, T_s: Float[Array, ""], thresholds: Thresholds) -> Map:
    """Eq. 9: S' = S where S >= T_s, else 0."""
    return s * thresholds.s(s, T_s)


def hold(held: Map, changed: Map, tau_hold: Scalar, interval: Scalar) -> Map:
    """Size-coding inhibition: M = a + (1 - a) lambda M, lambda = exp(-ti/tau_hold), where `changed` is a in [0, 1]."""
    return changed + (1 - changed) * jnp.exp(-interval / tau_hold) * held


def g_layer(s_gated: Bordered) -> Map:
    """Eq. 10: the 3x3 mean of S'. With repeated edges it keeps the sum, so the potential does not need it."""
    nearest, diagonal = _neighbours(s_gated)
    return (inside(s_gated) + nearest + diagonal) / 9


def _neighbours(x: Bordered) -> tuple[Map, Map]:
    """The sums over the four nearest and the four diagonal neighbours of each pixel."""
    above_below, left_right = x[:-2] + x[2:], x[1:-1, :-2] + x[1:-1, 2:]
    return above_below[:, 1:-1] + left_right, above_below[:, :-2] + above_below[:, 2:]
