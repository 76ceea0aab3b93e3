"""All trials of an experiment."""

import dataclasses
from collections.abc import Iterator
from typing import Any

from lgmd2jax._arguments.checked import checked
from lgmd2jax._arguments.units import Duration
from lgmd2jax._targets.spike_trains import Likelihood, SpikeTrains
from lgmd2jax._trials.peak_line import LoomingEstimate, estimate
from lgmd2jax._trials.trial import Condition, Trial, natural, told
from lgmd2jax._words import nearest


@checked
@dataclasses.dataclass(frozen=True, repr=False)
class Trials:
    """All trials of an experiment, sorted by animal, condition, session and name.

    ```python
    trials = lgmd.load_trials("spikes.csv")           # columns animal, trial, l_over_v_ms, spike_ms
    print(trials.looming_law())                       # alpha and delta, with intervals
    trials.where(l_over_v=20).spike_trains()          # a target for the loom of 20 ms
    ```

    **Arguments:** `trials`: one or more. `remarks`: what was noticed while they were read.

    **Raises:** `ValueError` for no trials, and for two of the same animal, session, name and condition.
    """

    trials: tuple[Trial, ...]
    remarks: tuple[str, ...] = dataclasses.field(default=(), compare=False)

    def __post_init__(self):
        if not self.trials:
            raise ValueError("there are no trials; give at least one")
        object.__setattr__(self, "trials", tuple(sorted(self.trials, key=_order)))
        labels = [trial.label for trial in self.trials]
        for before, trial, last in zip(labels, self.trials[1:], labels[1:], strict=False):
            if before == last:
                raise ValueError(f"{trial} is given twice; leave one out, or number the trials on")

    def __repr__(self):
        held = "; ".join(told(condition) for condition in self.conditions)
        return f"{len(self)} trials of {', '.join(self.animals)}: {held or 'one condition'}"

    def __len__(self) -> int:
        return len(self.trials)

    def __iter__(self) -> Iterator[Trial]:
        return iter(self.trials)

    @property
    def animals(self) -> tuple[str, ...]:
        """The names of the animals."""
        return tuple(dict.fromkeys(trial.animal for trial in self.trials))

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """The different conditions, sorted."""
        ordered = sorted(self.trials, key=lambda trial: _condition_order(trial.condition))
        return tuple(dict(items) for items in dict.fromkeys(tuple(sorted(t.condition.items())) for t in ordered))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of what differs between conditions, such as `l_over_v`."""
        return tuple(dict.fromkeys(name for trial in self.trials for name in trial.condition))

    @checked
    def where(self, animal: str | None = None, **condition: float | int | str) -> "Trials":
        """The trials of an animal, and of conditions that have these values.

        **Raises:** `ValueError` where none is left, and for a name that no condition has.
        """
        for name in condition:
            if name not in self.names:
                raise ValueError(f"no condition has {name!r}; choose {nearest(name, self.names)}")
        left = tuple(
            trial
            for trial in self.trials
            if animal in (None, trial.animal)
            and all(name in trial.condition and trial.condition[name] == value for name, value in condition.items())
        )
        if not left:
            asked = ", ".join(f"{name} = {value!r}" for name, value in {"animal": animal, **condition}.items())
            raise ValueError(f"no trial has {asked}; animals are {', '.join(self.animals)}")
        return Trials(left, self.remarks)

    @checked
    def spike_trains(self, kernel_ms: Duration = 20.0, likelihood: Likelihood = "normal") -> SpikeTrains:
        """These trials as a target of a fit, by animal; choose one condition by `where` before."""
        by_animal = {animal: [] for animal in self.animals}
        for trial in self.trials:
            by_animal[trial.animal].append(trial.spikes_ms)
        return SpikeTrains(list(by_animal.values()), kernel_ms, likelihood, self.animals)

    @checked
    def looming_law(
        self, kernel_ms: float | int | None = None, *, resamples: int = 1000, seed: int = 0
    ) -> LoomingEstimate:
        """The line t_c - t_peak = alpha l/|v| - delta of peak times, for each animal and for all, with quality control.

        **Arguments:**

        - `kernel_ms`: standard deviation of the Gaussian that makes a rate of the spikes. By default a kernel of sixth
          order, as wide as l/|v| asks, which does not move the peak of an asymmetric rate (`peak_rule` of the result).
        - `resamples`: bootstrap samples of the trials, from which the 95 % intervals come; `seed`: of these draws.

        **Raises:** `ValueError` for trials without `l_over_v`, and where no animal is left that has two l/|v|.

        Source: Gabbiani, Krapp & Laurent 1999.
        """
        return estimate(self.trials, None if kernel_ms is None else float(kernel_ms), resamples, seed)


def _order(trial: Trial) -> tuple[Any, ...]:
    return natural(trial.animal), _condition_order(trial.condition), natural(trial.session), natural(trial.name)


def _condition_order(condition: Condition) -> tuple[Any, ...]:
    """Numbers by their value, before texts."""
    return tuple(
        (name, isinstance(value, str), value if isinstance(value, float) else 0.0, natural(str(value)))
        for name, value in sorted(condition.items())
    )
