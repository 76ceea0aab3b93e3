"""The result of a fit to curves, and what can be asked of it."""

import dataclasses
import functools
import importlib
import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Literal

import jax
import numpy as np
from jaxtyping import Array, Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._channels import Channel
from lgmd2jax._compute.finished_work import Memory
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._network.parameters import ParameterSet, symbols
from lgmd2jax._network.thresholds import Hard
from lgmd2jax._protocol.condition import Condition
from lgmd2jax._reports.section import Section, as_html, as_text, unfinished_section
from lgmd2jax._targets.observation import Observation, observation_symbols
from lgmd2jax._targets.target import Target
from lgmd2jax._types import check_key, strong
from lgmd2jax._words import warn_renamed
from lgmd2jax.fitting import _remarks, _report, _supplement
from lgmd2jax.fitting._bounds import Linear
from lgmd2jax.fitting._curve import Curve, predict
from lgmd2jax.fitting._free import Free
from lgmd2jax.fitting._problem import Problem, chi2_residuals, problem_of
from lgmd2jax.fitting._run import Run
from lgmd2jax.fitting._search.space import soften
from lgmd2jax.fitting._supplement import Supplement
from lgmd2jax.fitting._uncertainty.covariance import Uncertainty, sentences
from lgmd2jax.fitting._uncertainty.jacobian import sensitivity_at
from lgmd2jax.fitting._uncertainty.next_stimulus import Candidate, rank
from lgmd2jax.fitting._uncertainty.posterior import Posterior, draw_posterior
from lgmd2jax.fitting._uncertainty.profile import Profile, first_step, profile_likelihood, rise_limit
from lgmd2jax.fitting._uncertainty.score import Score, score_test
from lgmd2jax.stimuli import Stimulus

_SAME_LOSS = 0.01  # relative; runs so close to the best count as being at the same optimum


@dataclasses.dataclass(frozen=True)
class Fit:
    """A fitted model with all that is known of how well it is determined.

    ```python
    fit = lgmd.load_fit("dcmd")
    print(fit)                                 # the report
    fit.values, fit.uncertainty.intervals      # the free parameters
    lgmd.save(fit.model, "model.json")         # for a robot
    ```

    - `model`: the best model, with the thresholds of the one that was given: hard ones, to be handed over.
    - `observation`: how a rate arises from the potential, fitted where its parameters were free.
    - `free`: what was free. `z`: the best point in the unit box, 0 to 1 for each free parameter between its bounds.
    - `start`: the values from which the search set out, by name.
    - `loss`: half the sum of squares of `model`; `soft_loss`: of the same parameters at the last temperature.
    - `temperatures`: how soft the thresholds were in each descent; the last is that of `soft` and the uncertainty.
    - `uncertainty`: errors, intervals, correlations, information criteria, all by linearisation; of counts
      of spikes the intervals by profile likelihood.
    - `nonlinear`: the parameters within whose intervals the curves are nonlinear, so that a `profile` is needed.
    - `curves`: target, soft and hard model for every target of every condition.
    - `runs`: the starts that were descended, the best first. `screened`: losses of all points of the search, sorted.
    - `errors`: by channel, the standard error that one frame would have if its neighbours told nothing of it.
    - `result`: `"converged"`, or why the best descent stopped. `stats`: counts of what was done, settings, and
      how samples were counted and errors arose.
    - `problem`: the stimuli and targets of the fit. Of a fit that was loaded it is None; `data` then gives them when
      they are first needed, or refuses where they are gone or have changed.
    """

    model: AbstractNetwork
    observation: Observation
    free: Free
    z: Float[np.ndarray, " free"]
    start: dict[str, float]
    loss: float
    soft_loss: float
    temperatures: tuple[float, ...]
    uncertainty: Uncertainty
    nonlinear: tuple[str, ...]
    curves: tuple[Curve, ...]
    runs: tuple[Run, ...]
    screened: tuple[float, ...]
    errors: dict[str, float]
    result: str
    stats: dict[str, Any]
    problem: Problem | None = None
    data: Callable[["Fit"], Problem] | None = dataclasses.field(default=None, repr=False)

    @property
    def parameters(self) -> Any:
        """The parameters of `model`."""
        return self.model.parameters

    @property
    def values(self) -> dict[str, float]:
        """The free parameters by name, of model and observation."""
        return {name: float(getattr(self._owner(name), name)) for name in self.free.names}

    @property
    def covariance(self) -> Float[np.ndarray, "free free"]:
        """The covariance of the free parameters, in their own units and in the order of `free.names`."""
        return self.uncertainty.covariance

    @property
    def soft(self) -> AbstractNetwork:
        """The fitted model with soft thresholds, at the last temperature."""
        thresholds = soften(self.model.thresholds, strong(self.temperatures[-1]))
        return dataclasses.replace(self.model, thresholds=thresholds)

    @property
    def hard(self) -> AbstractNetwork:
        """The fitted model with hard thresholds."""
        return dataclasses.replace(self.model, thresholds=Hard())

    @property
    def kind(self) -> Literal["soft", "hard"]:
        """Which of the curves are those of `model`: `"hard"` or `"soft"`."""
        return "hard" if isinstance(self.model.thresholds, Hard) else "soft"

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The channels that had targets, the rate first."""
        return tuple(sorted({curve.channel for curve in self.curves}, key=lambda name: (name != "rate", name)))

    @checked
    def predict(self, condition: Condition | Stimulus, channel: Channel | None = None) -> Float[np.ndarray, " time"]:
        """What `model` answers to any stimulus: the fitted channel, a value a frame.

        **Arguments:** `channel`: by default the rate, where one was fitted, else the first of `channels`.

        **Raises:** `ValueError` for a condition whose parameters do not make a stimulus.
        """
        stimulus = condition if isinstance(condition, Stimulus) else condition.render()
        return predict(self.model, self.observation, stimulus, channel or self.channels[0])

    @checked
    def profile(self, name: str, confidence: float = 0.95) -> Profile:
        """The interval of a free parameter by its profile likelihood: all others are fitted anew as it is moved.

        Where the curves are nonlinear within an interval (`nonlinear`), it is the one to trust.

        **Arguments:** `confidence`: the probability with which the interval should hold the true value.

        **Raises:** `ValueError` for a parameter that is not free, and for a loaded fit whose data are gone.
        """
        if name not in self.free.names:
            raise ValueError(f"{name!r} is not free in this fit; choose {', '.join(self.free.names)}")
        residuals, u, index = self._residuals("profile"), self.uncertainty, self.free.names.index(name)
        return profile_likelihood(
            residuals,
            self.z,
            index,
            variance=u.variance,
            limit=rise_limit(u, confidence),
            step=first_step(u, index),
            value=lambda z: float(self.free.parameters[index].value(z)),
        )

    @checked
    def sample(
        self,
        key: Array,
        draws: int = 1000,
        chains: int = 4,
        memory: Memory | None = None,
        *,
        warmup: int = 1000,
        progress: bool = True,
    ) -> Posterior:
        """Draws from the posterior of the free parameters, under a prior that is uniform within the bounds.

        The draws lie in the unit box; `values_of` maps them to the parameters' own units. Needs the extra `bayes`.

        **Arguments:** `key`: of the draws. `draws`: how many of each of the `chains`. `warmup`: steps before them, that
        adapt the sampler. `memory`: a mapping, such as a dict, that keeps finished chains; given again, the draws go on
        from there. `progress`: show a bar.

        **Raises:** `ValueError` for a loaded fit whose data are gone, and without the extra.
        """
        check_key(key)
        residuals = self._residuals("sample")
        return draw_posterior(
            residuals,
            self.z,
            key=key,
            variance=self.uncertainty.variance,
            draws=draws,
            chains=chains,
            warmup=warmup,
            memory=memory,
            progress=progress,
        )

    @checked
    def values_of(self, draws: Posterior) -> dict[str, Float[np.ndarray, "chain draw"]]:
        """The draws by parameter, in its own unit."""
        return {each.name: np.asarray(each.value(draws.z[..., i])) for i, each in enumerate(self.free.parameters)}

    def score_test(self) -> list[Score]:
        """What freeing each fixed parameter would promise, to first order: the one that lowers chi2 most stands first.

        Left out are parameters that act on nothing here, that are tied, and that the free ones can replace.

        **Raises:** `ValueError` for a loaded fit whose data are gone.
        """
        problem, fixed = self._problem("score_test"), dict(self._fixed())
        if self.uncertainty.reason or not fixed:
            return []
        values = np.array([float(getattr(self._owner(name), name)) for name in fixed])
        return score_test(problem, self.z, strong(self.temperatures[-1]), self.uncertainty, fixed, values)

    def _fixed(self) -> Iterator[tuple[str, Linear]]:
        """What acts on the curves and is not free, within its declared bounds, or up to a value beyond them."""
        observed = observation_symbols() if "rate" in self.channels else {}
        for name, symbol in (symbols(type(self.parameters)) | observed).items():
            if name not in (*self.free.names, *self.free.ties, *self.model.unused):
                value = float(getattr(self._owner(name), name))
                yield name, Linear(min(symbol.bounds[0], value), max(symbol.bounds[1], value))

    @checked
    def next_stimulus(self, candidates: Sequence[Condition | Stimulus]) -> list[Candidate]:
        """Which stimulus to record next: the candidates, the one that narrows the intervals most first.

        Each is taken to be recorded with the errors that the targets of this fit have, in the same channels.
        """
        temperature = strong(self.temperatures[-1])
        stimuli = [candidate if isinstance(candidate, Stimulus) else candidate.render() for candidate in candidates]
        jacobians = []
        for stimulus in stimuli:
            nothing = np.zeros(len(stimulus.time))
            targets = [Target(channel, nothing, error=self.errors[channel]) for channel in self.channels]
            pair = stimulus, [target.on(stimulus) for target in targets]
            problem = problem_of(self.model, self.observation, self.free, [pair], "squares")
            jacobian = sensitivity_at(problem, jax.device_put(self.z), temperature).jacobian
            jacobians.append(np.asarray(jacobian)[: len(targets) * len(nothing)])
        return rank(self.uncertainty, jacobians, [stimulus.name for stimulus in stimuli])

    @checked
    def plot(self, path: str | os.PathLike | None = None) -> Any:
        """Draw target, soft and hard model of every condition, a panel each.

        **Arguments:** `path`: of a file to write, whose suffix says its format, such as .png, .pdf or .svg.

        **Returns:** the first panel, a matplotlib `Axes`; its `figure` holds all of them, and `figure.axes` lists them.

        **Raises:** `ValueError` for a suffix that is no format.
        """
        return _figures().plot_curves(self, path)

    @checked
    def plot_residuals(self, path: str | os.PathLike | None = None) -> Any:
        """Draw the residuals of `model` over time, and beside them their autocorrelation.

        **Arguments**, **Returns**, **Raises:** as `plot`.
        """
        return _figures().plot_residuals(self, path)

    @checked
    def plot_profile(
        self, name: str, profile: Profile | None = None, *, path: str | os.PathLike | None = None, ax: Any = None
    ) -> Any:
        """Draw how chi2 rises as a parameter is moved, with its interval and the parabola of its standard error.

        **Arguments:** `profile`: of this parameter, where it was computed before. `path`: as for `plot`. `ax`: the
        matplotlib `Axes` to draw on.

        **Returns:** the `Axes`. **Raises:** `ValueError` as `profile` and `plot`.
        """
        return _figures().plot_profile(self, name, profile or self.profile(name), path, ax)

    def remarks(self) -> list[str]:
        """What a reader must know before trusting the numbers, a sentence each."""
        return [
            *_remarks.on_search(self.result, self.stats),
            *_remarks.on_bounds(self.values, self.uncertainty),
            *_remarks.on_misfit(self.uncertainty),
            *_remarks.on_missed_targets(self.curves, self.stats, self.best_count, len(self.runs)),
            *_remarks.on_hard_and_soft(self.curves),
            *_remarks.on_noise(self.stats, self.model.levels.inhibited_from),
            *_remarks.on_nonlinear(self.nonlinear),
            *sentences(self.uncertainty),
        ]

    @property
    def best_count(self) -> int:
        """How many of `runs` ended at the best loss."""
        best = self.runs[0].loss
        return sum(run.loss <= best * (1 + _SAME_LOSS) + 1e-9 for run in self.runs)

    @property
    def found(self) -> int:
        """The old name of `best_count`."""
        warn_renamed("Fit.found", "Fit.best_count")
        return self.best_count

    @property
    def curved(self) -> tuple[str, ...]:
        """The old name of `nonlinear`."""
        warn_renamed("Fit.curved", "Fit.nonlinear")
        return self.nonlinear

    @property
    def status(self) -> tuple[str, ...]:
        """The verdict in a few words each, the first of which says whether the fit is valid."""
        return _report.status(self.result, self.loss, self.uncertainty, self.curves)

    @checked
    def sections(self, supplement: Supplement | None = None) -> list[Section]:
        """The report's sections that have a content."""
        more, u, free, values = supplement or Supplement(), self.uncertainty, self.free, self.values
        head, *sections = (
            Section(f"Fit: {' | '.join(self.status)}", sentences=_report.warning(self.status)),
            _report.free_section(free, values, self.start, u, self.nonlinear),
            _report.given_section(free, self.parameters, self.observation, self.channels),
            _report.statistics_section(
                u, self.curves, self.stats.get("rules", {})
            ),  # an earlier version wrote no rules
            _report.curve_section(self.curves),
            _report.band_section(self.curves),
            _report.residual_section(self.curves, self.kind),
            _report.search_section(
                self.runs, self.best_count, len(self.screened), self.temperatures, self.loss, self.soft_loss
            ),
            _report.correlation_section(u),
            _supplement.profile_section(more.profiles, free, u),
            _supplement.score_section(more.scores, self.parameters),
            _supplement.left_out_section(more.left_out),
            _supplement.law_section(more.looming_law, self.curves, more.left_out),
            _supplement.truth_section(more.truth, free, values, u),
            Section("Remarks", sentences=tuple(self.remarks())),
        )
        return [
            *unfinished_section(more.unfinished),
            head,
            *(section for section in sections if section.rows or section.sentences),
        ]

    @checked
    def summary(self, supplement: Supplement | None = None) -> str:
        """The report as text."""
        return as_text(self.sections(supplement))

    def __repr__(self):
        return self.summary()

    def _repr_html_(self) -> str:
        return as_html(self.sections())

    def _owner(self, name: str) -> ParameterSet | Observation:
        return self.observation if name in observation_symbols() else self.model.parameters

    def _residuals(self, purpose: str) -> Callable[[Float[Array, " free"]], Float[Array, " n"]]:
        return chi2_residuals(self._problem(purpose), self.temperatures[-1], self.uncertainty.variance)

    def _problem(self, purpose: str) -> Problem:
        if self.problem is not None:
            return self.problem
        if self.data is None:
            raise ValueError(f"{purpose} needs the stimuli and targets, which this fit does not hold; fit again")
        return self._loaded_problem

    @functools.cached_property
    def _loaded_problem(self) -> Problem:
        return self.data(self)  # pyright: ignore[reportOptionalCall]


def _figures() -> Any:
    """The functions that draw a fit. They stand above it and know it, so that it finds them by name, when asked."""
    return importlib.import_module("lgmd2jax._figures.after_fit")
