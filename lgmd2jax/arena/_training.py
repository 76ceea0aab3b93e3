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

from lgmd2jax._arguments.checked import checked
from lgmd2jax._handover.named import model_named
from lgmd2jax._network.parameters import symbols
from lgmd2jax._words import nearest
from lgmd2jax.arena._detectors import AbstractDetector, FrameDifference, NetworkDetector, NoDetector
from lgmd2jax.arena._layout import Layout
from lgmd2jax.arena._run import Start, run, trips
from lgmd2jax.arena._scores import Outcome
from lgmd2jax.fitting._bounds import between, check_bounds

FIRST_SEED = 1_000_000  # of the arenas for training; those judged count from 0
LEAST_COVERAGE = 0.75  # of that without a detector; a quarter of it may be lost, as what is asked for leaves 30 %


@checked
@dataclasses.dataclass(frozen=True)
class Budget:
    """How much each detector may try: so many `candidates` in each of the `arenas`, the best `finalists` in others.

    **Raises:** `ValueError` for a number below 1, and for more finalists than candidates.
    """

    candidates: int = 32
    arenas: int = 6
    finalists: int = 6
    final_arenas: int = 18

    def __post_init__(self):
        for name, count in dataclasses.asdict(self).items():
            if count < 1:
                raise ValueError(f"{name} is {count}; give 1 or more")
        if self.finalists > self.candidates:
            raise ValueError(f"finalists is {self.finalists}; give no more than the {self.candidates} candidates")


BUDGET = Budget()


@checked
@dataclasses.dataclass(frozen=True)
class Range:
    """Between which values a setting is searched: `log` by factors, `whole` in whole numbers.

    **Raises:** `ValueError` for a lower bound that is not below the upper one, and for one on a logarithmic scale that
    is not positive.
    """

    low: float | int
    high: float | int
    log: bool = False
    whole: bool = False

    def __post_init__(self):
        check_bounds("range", self.low, self.high, "log" if self.log else "linear")

    @checked
    def at(self, share: Float[np.ndarray, " candidate"]) -> Float[np.ndarray, " candidate"]:
        """The values at shares 0..1 of the range."""
        if self.whole:
            return np.floor(self.low + share * (self.high + 1 - self.low))
        return between(self.low, self.high, "log" if self.log else "linear", share)


@checked
@dataclasses.dataclass(frozen=True)
class Space:
    """A detector, and which of its settings are searched.

    ```python
    space = Space("preset:lgmd2", {"T_sp": Range(0.65, 0.78), "N_sp": Range(4, 8, whole=True)})
    print(train(space).settings)
    ```

    - `model`: a result folder, a shipped fit or a preset, whose parameters are set; None for a `FrameDifference`.
    - `ranges`: of these parameters by name, or of `threshold`.
    """

    model: str | None
    ranges: Mapping[str, Range]

    @checked
    def detector(self, settings: Mapping[str, float]) -> FrameDifference | NetworkDetector:
        """The detector with these settings, by name.

        **Raises:** `ValueError` for a model, and for a setting, that there is not.
        """
        model = None if self.model is None else model_named(self.model)
        known = ("threshold",) if model is None else tuple(symbols(type(model.parameters)))
        for name in settings:
            if name not in known:
                raise ValueError(f"ranges has {name!r}; choose {nearest(name, known)}")
        values = [jnp.asarray(value, jnp.float32) for value in settings.values()]
        if model is None:
            return FrameDifference(*values)
        detector = NetworkDetector.of(model)

        def where(detector: NetworkDetector) -> list[Any]:
            return [getattr(detector.network.parameters, name) for name in settings]

        return eqx.tree_at(where, detector, values)


# Table I is searched within its own ranges. The fitted LGMD2 keeps its other values, which came with a fit to clips, as
# its own hand-over file has them: that fit may be made anew.
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
        "arena",
        {
            "T_s": Range(8, 30, log=True),
            "k": Range(0.5, 3, log=True),
            "tau1": Range(5, 50),
            "w_bias": Range(0.05, 1),
            "T_ffi": Range(10, 60, log=True),
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
    """The settings that were chosen, and what robots did with them in the last arenas.

    - `outcome`: with these settings. `without`: in the same arenas, by robots without a detector.
    """

    settings: dict[str, float]
    outcome: Outcome
    without: Outcome

    def plain(self) -> dict[str, Any]:
        """As plain data for JSON."""
        return {
            "settings": self.settings,
            "collisions_per_metre": round(self.outcome.collisions_per_metre.value, 4),
            "coverage": round(self.outcome.coverage.value, 4),
            "coverage_without": round(self.without.coverage.value, 4),
        }


@checked
def train(space: Space, budget: Budget = BUDGET, *, progress: bool = False) -> Training:
    """Choose the settings of a detector: robots drive by all candidates in a few arenas, and by the best in others.

    Candidates are Sobol points of the space. Of those that cover at least three quarters of the floor that a robot
    without a detector covers, the one with the fewest collisions a metre wins. The arenas have seeds from 1,000,000 on,
    so that none is one of an evaluation.

    **Arguments:** `space`: what is searched. `budget`: how many candidates and arenas. `progress`: show a bar.

    **Raises:** `ValueError` for a model, and for a setting, that there is not.
    """
    shares = qmc.Sobol(len(space.ranges), rng=np.random.default_rng(0)).random(budget.candidates)
    values = {name: each.at(share) for (name, each), share in zip(space.ranges.items(), shares.T, strict=True)}
    candidates = [
        {name: float(f"{value[number]:.4g}") for name, value in values.items()} for number in range(budget.candidates)
    ]
    first = Arenas.of(range(FIRST_SEED, FIRST_SEED + budget.arenas))
    final = Arenas.of(range(FIRST_SEED + budget.arenas, FIRST_SEED + budget.arenas + budget.final_arenas))
    with tqdm(total=budget.candidates + budget.finalists, desc="candidates", disable=not progress) as bar:

        def ranked(candidates: list[dict[str, float]], arenas: Arenas) -> list[tuple[dict[str, float], Outcome]]:
            outcomes = []
            for settings in candidates:
                outcomes.append(arenas.outcome(space.detector(settings)))
                bar.update()
            least = LEAST_COVERAGE * arenas.without.coverage.value
            return [(candidates[number], outcomes[number]) for number in ranking(outcomes, least)]

        finalists = [settings for settings, _ in ranked(candidates, first)[: budget.finalists]]
        settings, outcome = ranked(finalists, final)[0]
    return Training(settings, outcome, final.without)


def ranking(outcomes: Sequence[Outcome], least: float) -> list[int]:
    """Numbers of outcomes, the best first: those of at least this coverage by their collisions, then the others.

    The others stand in the order of their coverage, the most first.
    """

    def place(number: int) -> tuple[bool, float]:
        coverage, collisions = outcomes[number].coverage.value, outcomes[number].collisions_per_metre.value
        return (False, collisions) if coverage >= least else (True, -coverage)

    return sorted(range(len(outcomes)), key=place)


@dataclasses.dataclass(frozen=True)
class Arenas:
    """Arenas with robots at their starts, and what robots without a detector do there."""

    layouts: list[Layout]
    starts: Start
    without: Outcome

    @classmethod
    def of(cls, seeds: Sequence[int]) -> "Arenas":
        """Those of these seeds."""
        layouts, blind = run(NoDetector(), seeds)
        return cls(layouts, Start.stacked(seeds), Outcome.of(layouts, blind))

    def outcome(self, detector: AbstractDetector) -> Outcome:
        """What robots with this detector do."""
        return Outcome.of(self.layouts, trips(detector, self.starts))
