"""The retina: photoreceptors, and the split into ON and OFF (eqs 1-3). Pure functions of one frame."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lgmd2jax._network.maps import folded, pool
from lgmd2jax._types import Map, Scalar, is_concrete


def persistence(u: Float[Array, ""], n_p: int) -> Float[Array, " n_p"]:
    """Eq. 1: a_i = 1/(1 + exp(u i)) for i = 1..n_p, the share that is left of the change i frames ago."""
    i = jnp.arange(1, n_p + 1, dtype=u.dtype)
    return 1 / (1 + jnp.exp(u * i))


def unstable_persistence(u: Float[Array, "*batch"], n_p: int) -> dict[str, Bool[Array, "*batch"]]:
    """Where the persistence is not sure to be stable, with the sentence that says so: where sum(a_i) >= 1."""
    if n_p == 0:
        return {}
    total = jnp.vectorize(lambda u: persistence(u, n_p).sum())(u)
    known = f"u is {u} with n_p = {n_p}: " if is_concrete(u) else ""
    return {f"{known}the persistence sums to 1 or more and is stable only below 1; raise u or lower n_p": total >= 1}


def lamina(tau: Float[Array, ""], interval: Scalar) -> tuple[Float[Array, " 1"], Scalar]:
    """The a and g of P(t) = g (L(t) - L(t-1)) + a P(t-1), which solves dP/dt = dL/dt - P/tau.

    a = exp(-ti/tau) and g = (1 - a) tau/ti are exact where luminance changes evenly between two frames, so that P is
    the same at one moment however many frames came before it.

    **Arguments:** `tau` and `interval` (ti) in ms.
    """
    frames = interval / tau
    return jnp.exp(-frames)[None], -jnp.expm1(-frames) * (tau / interval)


def photoreceptors(
    change: Map, history: Float[Array, "kept row col"], a: Float[Array, " kept"], gain: float | Scalar = 1.0
) -> Map:
    """Eq. 1: P(t) = g (L(t) - L(t-1)) + sum_i a_i P(t-i), in grey levels; g is 1 without a lamina.

    **Arguments:** `change` is L(t) - L(t-1); `history` holds P(t-1), P(t-2) ..
    """
    p = gain * change
    for i in range(len(history)):
        p = p + a[i] * history[i]
    return p


def half_wave(p: Map) -> tuple[Map, Map]:
    """Eq. 2: on = max(P, 0), off = max(-P, 0). `jnp.maximum` has slope 1/2 at 0, the central difference."""
    return jnp.maximum(p, 0), jnp.maximum(-p, 0)


def residual(y: Map, previous: Map, sigma1: Float[Array, ""]) -> Map:
    """Eq. 3: Y(t) = y(t) + sigma1 Y(t-1), for ON and OFF alike."""
    return y + sigma1 * previous


@jax.custom_jvp
def magnitude(x: Float[Array, " *map"]) -> Float[Array, " *map"]:
    """abs(x) with slope 0 at 0. `jnp.abs` has slope 1 there, which makes every pixel at rest wrong."""
    return jnp.abs(x)


@magnitude.defjvp
def _magnitude_jvp(primals, tangents):
    (x,), (along,) = primals, tangents
    return magnitude(x), jnp.sign(x) * along


def mean_change(p: Map) -> Scalar:
    """Eq. 13: F, the mean of abs(P)."""
    return pool(folded(magnitude(p)), 1 / p.size)
