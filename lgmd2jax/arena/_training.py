"""What each detector's thresholds are set to for this arena: one rule and one budget for all, on arenas kept for it."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from scipy.stats import qmc
from tqdm import tqdm

from lgmd2jax._handover.named import model_named
from lgmd2jax.arena._detectors import AbstractDetector, FrameDifference, NetworkDetector, NoDetector
from lgmd2jax.arena._layout import random_layout
from lgmd2jax.arena._run import Start, trips
from lgmd2jax.arena._scores import Outcome

FIRST_SEED = 1_000_000  # of the arenas for training; those judged count from 0
LEAST_COVERAGE = 0.75  # of that without a detector; a quarter of it may be lost, as what is asked for leaves 30 %


@dataclasses.dataclass(frozen=True)
class Range:
    """Where a setting is looked for, by factors where `log`. A `whole` number is rounded."""

    low: float | int
    high: float | int
    log: bool = False
    whole: bool = False

    def at(self, share: Float[np.ndarray, " candidate"]) -> Float[np.ndarray, " candidate"]:
        """The values at shares 0..1 of the range."""
        if self.whole:
            return np.floor(self.low + share * (self.high + 1 - self.low))
        return self.low * (self.high / self.low) ** share if self.log else self.low + share * (self.high - self.low)


@dataclasses.dataclass(frozen=True)
class Space:
    """A detector and what is set of it.

    `model`: the name of the one whose parameters are set; None for the threshold of a difference.
    """

    model: str | None
    ranges: Mapping[str, Range]

    def detector(self, settings: Mapping[str, float]) -> FrameDifference | NetworkDetector:
        """The detector with these settings."""
        values = [jnp.asarray(value, jnp.float32) for value in settings.values()]
        if self.model is None:
            return FrameDifference(*values)
        detector = NetworkDetector.of(model_named(self.model))

        def where(detector: NetworkDetector) -> list[Any]:
            return [getattr(detector.network.parameters, name) for name in settings]

        return eqx.tree_at(where, detector, values)


# Table I is searched within its own ranges.
SPACES: Mapping[str, Space] = {
    "table1": Space(
        "preset:lgmd2",
        {
            "theta2": Range(1, 6),
            "tau1": Range(5, 50),
            "tau2": Range(5, 100),
            "tau3": Range(400, 1000),
            "T_sp": Range(0.65, 0.78),
            "N_sp": Range(4, 8, whole=True),
        },
    ),
    "lgmd2": Space(
        "video",
        {
            "T_s": Range(6, 25, log=True),
            "k": Range(0.5, 3, log=True),
            "T_ffi": Range(8, 60, log=True),
            "T_sfa": Range(1e-5, 3e-3, log=True),
            "T_sp": Range(0.55, 0.8),
            "N_sp": Range(2, 6, whole=True),
        },
    ),
    "lgmd1": Space(
        "preset:yue_rind",
        {
            "W_I": Range(0.05, 1),
            "T_de": Range(6, 40, log=True),
            "k": Range(0.5, 6, log=True),
            "T_ffi": Range(4, 60, log=True),
            "alpha_ffi": Range(0, 0.5),
            "T_sp": Range(0.6, 0.95),
        },
    ),
    "difference": Space(None, {"threshold": Range(3, 12, log=True)}),
}


@dataclasses.dataclass(frozen=True)
class Training:
    """The settings that were chosen, and how each candidate did.

    - `settings`: of the one with the fewest collisions per metre among those whose coverage is at least
      `LEAST_COVERAGE` of that without a detector; of the one with the most coverage where none has so much.
    - `collisions_per_metre`, `coverage`: of each candidate; of the chosen one they are flattering.
    """

    settings: dict[str, float]
    chosen: int
    candidates: dict[str, np.ndarray]
    collisions_per_metre: np.ndarray
    coverage: np.ndarray
    coverage_without: float

    def plain(self) -> dict[str, Any]:
        """What is kept of it as JSON."""
        return {
            "settings": self.settings,
            "collisions_per_metre": round(float(self.collisions_per_metre[self.chosen]), 4),
            "coverage": round(float(self.coverage[self.chosen]), 4),
            "coverage_without": round(self.coverage_without, 4),
            "candidates": len(self.coverage),
        }


def train(space: Space, *, candidates: int = 32, arenas: int = 6, progress: bool = False) -> Training:
    """Drive robots with each of so many candidates, Sobol points of the space, and choose one."""
    seeds = range(FIRST_SEED, FIRST_SEED + arenas)
    layouts, starts = [random_layout(seed) for seed in seeds], Start.stacked(seeds)
    shares = qmc.Sobol(len(space.ranges), seed=0).random(candidates)  # pyright: ignore[reportCallIssue]
    values = {name: each.at(share) for (name, each), share in zip(space.ranges.items(), shares.T, strict=True)}

    def outcome(detector: AbstractDetector) -> Outcome:
        return Outcome.of(layouts, trips(detector, starts))

    outcomes = [
        outcome(space.detector({name: float(value[i]) for name, value in values.items()}))
        for i in tqdm(range(candidates), desc="candidates", disable=not progress, leave=False)
    ]
    without = outcome(NoDetector()).coverage.value
    collisions = np.array([each.collisions_per_metre.value for each in outcomes])
    coverage = np.array([each.coverage.value for each in outcomes])
    chosen = choose(collisions, coverage, LEAST_COVERAGE * without)
    settings = {name: float(f"{value[chosen]:.4g}") for name, value in values.items()}
    return Training(settings, chosen, values, collisions, coverage, without)


def choose(collisions: Sequence[float] | np.ndarray, coverage: Sequence[float] | np.ndarray, least: float) -> int:
    """The candidate with the fewest collisions among those of at least this coverage, else of the most coverage."""
    enough = np.asarray(coverage) >= least
    return int(np.argmin(np.where(enough, collisions, np.inf)) if enough.any() else np.argmax(coverage))
