"""Where the time of the forward goes: its loop over frames with one part of the equations after another.

XLA makes a loop over the map of every result, ten of them in a frame, where the loop in numba makes one of all.
"""

from collections.abc import Callable

import jax
import jax.numpy as jnp

import lgmd2jax as lgmd
from benchmarks import _library
from benchmarks._task import FPS
from lgmd2jax._network import medulla, retina
from lgmd2jax._network.low_pass import coefficient, low_pass
from lgmd2jax._network.maps import inside, pool
from lgmd2jax._network.tiles import change, over_tiles

PARTS = ("P with its border", "ON and OFF", "their delays", "F", "spread, S and gate", "MP")


def up_to(last: str) -> Callable:
    """The jitted loop over a film that ends with this part."""
    kept = PARTS[: PARTS.index(last) + 1]

    def loop(v: lgmd.Parameters, frames):
        v = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), v)
        a = coefficient(v.tau1, jnp.float32(1000 / FPS), "backward_euler")

        def of_tile(first, height):
            def step(maps, t):
                p, on, off, d_on, d_off, s = maps
                p, f, mp = change(frames, t, first, onto=p), None, None
                if "ON and OFF" in kept:
                    flows = zip(retina.half_wave(p), (on, off), strict=True)
                    on, off = (retina.residual(flow, trace, v.sigma1) for flow, trace in flows)
                if "their delays" in kept:
                    d_on, d_off = low_pass(d_on, on, a), low_pass(d_off, off, a)
                if "F" in kept:
                    f = retina.mean_change(inside(p))
                if "spread, S and gate" in kept:
                    spreads = medulla.lateral(d_on), medulla.lateral(d_off)
                    s = medulla.s_layer(*medulla.local_sums(inside(on), inside(off), *spreads, v.w_bias), v)
                    s = medulla.gate(s, v.T_s, lgmd.Hard())
                if "MP" in kept:
                    mp = pool(s)
                return (p, on, off, d_on, d_off, s), (f, mp)

            zero = jnp.zeros((height + 2, frames.shape[2] + 2), jnp.float32)
            return jax.lax.scan(step, (*(zero,) * 5, inside(zero)), jnp.arange(len(frames)))

        return over_tiles(of_tile, frames)

    jitted, given = jax.jit(loop), _library.parameters()
    return lambda frames: jax.block_until_ready(jitted(given, frames))
