"""Draws from the posterior of the free parameters, by the no-U-turn sampler of blackjax (the extra `bayes`)."""

import dataclasses
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Key
from tqdm import tqdm

from lgmd2jax._compute.fingerprint import fingerprint
from lgmd2jax._compute.finished_work import Memory

# A start is moved so far into the unit box, and moved about by so much on the unbounded scale.
_EDGE, _SCATTER = 1e-2, 0.1
_PIECES = 20  # of the draws of a chain at most, after each of which the bar moves

Residuals = Callable[[Float[Array, " free"]], Float[Array, " n"]]


@dataclasses.dataclass(frozen=True)
class Posterior:
    """Draws, and what tells whether they can be trusted.

    - `z`: the draws, in the unit box.
    - `energy`, `diverging`, `acceptance_rate`, `tree_depth`: of each draw, as in ArviZ' `sample_stats`.
    - `r_hat`, `effective`: of each parameter; 1 where the chains agree, above 1.01 they have not met; and how many
      independent draws there are.
    """

    z: Float[np.ndarray, "chain draw free"]
    energy: Float[np.ndarray, "chain draw"]
    diverging: Bool[np.ndarray, "chain draw"]
    acceptance_rate: Float[np.ndarray, "chain draw"]
    tree_depth: Int[np.ndarray, "chain draw"]
    r_hat: Float[np.ndarray, " free"]
    effective: Float[np.ndarray, " free"]


def draw_posterior(
    residuals: Residuals,
    z: Float[np.ndarray, " free"],
    *,
    key: Key[Array, ""],
    variance: float = 1.0,
    chains: int = 4,
    draws: int = 1000,
    warmup: int = 1000,
    memory: Memory | None = None,
    progress: bool = False,
) -> Posterior:
    """Sample exp(-chi2 / (2 variance)) over the unit box.

    Between its bounds every value is as likely beforehand as every other (on a logarithmic scale: every factor); what
    else is known enters as penalties among the residuals. Step size and mass matrix are adapted during the warm-up.
    Gradients are taken in forward mode, in which the model is fast.

    **Arguments:** `residuals` by a point of the unit box, correlated ones already counted as fractions, as for
    `profile`; `z` the point near which the chains start; `variance` of a residual; `memory` keeps finished chains, so
    that draws which were stopped go on.

    **Raises:** `ValueError` without blackjax, and for fewer than two chains or four draws.
    """
    if chains < 2 or draws < 4:
        raise ValueError(f"{chains} chains of {draws} draws are too few; give at least 2 chains and 4 draws")
    try:
        import blackjax
    except ImportError:
        raise ValueError("posterior samples need blackjax: pip install 'lgmd2jax[bayes]'") from None

    place = jnp.clip(jnp.asarray(z), _EDGE, 1 - _EDGE)
    scatter, sampling = jax.random.split(key)
    starts = jnp.log(place / (1 - place))[None, :] + _SCATTER * jax.random.normal(scatter, (chains, len(z)))
    keys, settings = jax.random.split(sampling, chains), (jnp.asarray(variance), draws, warmup)
    digest = "" if memory is None else f" of {fingerprint((residuals, starts, keys, settings))}"
    memory, names = {} if memory is None else memory, [f"chain {number}{digest}" for number in range(chains)]
    with tqdm(total=chains * (warmup + draws), unit="step", leave=False, disable=not progress) as bar:
        for name, start, own_key in zip(names, starts, keys, strict=True):
            if name in memory:
                bar.update(warmup + draws)
            else:
                memory[name] = _chain(residuals, start, own_key, *settings, bar)
    finished = zip(*(memory[name] for name in names), strict=True)
    x, energy, diverging, rate, depth = (np.array(array) for array in finished)
    x = np.asarray(jax.nn.sigmoid(x))
    return Posterior(
        z=x,
        energy=energy,
        diverging=diverging,
        acceptance_rate=rate,
        tree_depth=depth,
        r_hat=np.asarray(blackjax.diagnostics.potential_scale_reduction(x)),
        effective=np.asarray(blackjax.diagnostics.effective_sample_size(x)),
    )


def _chain(
    residuals: Residuals,
    start: Float[Array, " free"],
    key: Array,
    variance: Float[Array, ""],
    draws: int,
    warmup: int,
    bar: tqdm,
) -> list[Any]:
    """One chain as plain data. Side by side with others it would take the steps of the longest trajectory."""
    adapting, sampling = jax.random.split(key)
    state, tuned = _adapted(residuals, start, adapting, variance, warmup)
    bar.update(warmup)
    keys, pieces = jax.random.split(sampling, draws), []
    piece = draws // next(count for count in range(_PIECES, 0, -1) if draws % count == 0)  # of one length: one program
    for begin in range(0, draws, piece):
        state, drawn = _drawn(residuals, state, tuned, keys[begin : begin + piece], variance)
        pieces.append([np.asarray(array) for array in drawn])  # waits until they are there
        bar.update(len(pieces[-1][0]))
    return [np.concatenate(arrays).tolist() for arrays in zip(*pieces, strict=True)]


@eqx.filter_jit
def _adapted(residuals, start, key, variance, warmup: int):
    """Where a chain stands after its warm-up, and the step size and mass matrix that suit it."""
    import blackjax

    adaptation: Any = blackjax.window_adaptation(blackjax.nuts, _log_density(residuals, variance))
    (state, tuned), _ = adaptation.run(key, start, warmup)
    return state, tuned


@eqx.filter_jit
def _drawn(residuals, state, tuned, keys, variance):
    """The next draws of a chain, a key each."""
    import blackjax

    sampler: Any = blackjax.nuts(_log_density(residuals, variance), **tuned)

    def draw(state, key):
        state, info = sampler.step(key, state)
        depth = info.num_trajectory_expansions
        return state, (state.position, info.energy, info.is_divergent, info.acceptance_rate, depth)

    return jax.lax.scan(draw, state, keys)


def _log_density(residuals: Residuals, variance: Float[Array, ""]) -> Callable[[Float[Array, " free"]], Any]:
    def log_density(x):
        def exactly(x):
            # d z / d x = z (1 - z) keeps the density that of z.
            density = -0.5 * jnp.sum(jnp.square(residuals(jax.nn.sigmoid(x)))) / variance
            density += jnp.sum(jax.nn.log_sigmoid(x) + jax.nn.log_sigmoid(-x))
            return density, density

        at = jax.lax.stop_gradient(x)
        slope, value = jax.jacfwd(exactly, has_aux=True)(at)
        return value + slope @ (x - at)  # the value and the gradient there, computed forward

    return log_density
