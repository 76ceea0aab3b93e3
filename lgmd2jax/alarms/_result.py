"""The result of a fit of alarms."""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._reports.section import Section, as_text, unfinished_section
from lgmd2jax._words import warn_renamed
from lgmd2jax.alarms import _report
from lgmd2jax.alarms._comparison import Comparison
from lgmd2jax.alarms._evaluation import Evaluation, HeldOutScores
from lgmd2jax.alarms._starts import AlarmDescent
from lgmd2jax.fitting import Free


@dataclasses.dataclass(frozen=True)
class AlarmFit:
    """A model that was fitted to labelled clips.

    - `model`: what is handed over, with hard thresholds.
    - `free`: what was free. `z`: the model's point in the unit box, 0 to 1 for each parameter between its bounds.
    - `cost`: the weight of what the model gets wrong; 0 where it is right on all clips.
    - `margin`: how far T_sp may move, up or down, before a verdict changes, in units of U'.
    - `evaluation`: what the model does on the clips.
    - `screened`, `right`: how many parameter sets were drawn within the bounds, and how many of them were
      right on all clips.
    - `ranges`: between which values each parameter lay in those that were right.
    - `descended`: the best starts, and what the descent brought.
    - `without`: for each source of recorded clips, what a model that was searched and chosen without that source does
      on all clips; empty for a single source and for very many.
    - `stopped`: whether it was stopped by hand.
    """

    model: LGMD2
    free: Free
    z: Float[np.ndarray, " free"]
    cost: float
    margin: float
    evaluation: Evaluation
    screened: int
    right: int
    ranges: Mapping[str, tuple[float, float]]
    descended: tuple[AlarmDescent, ...]
    without: Mapping[str, Evaluation]
    stopped: bool

    @property
    def left_out(self) -> dict[str, int]:
        """For each recorded clip, how much a model gets wrong on it that was searched and chosen without its source.

        Each missed window counts, and a silence with false alarms once. Clips in which nothing is judged are left out.
        """
        wrong = {}
        for source, evaluation in self.without.items():
            for clip, verdict in zip(evaluation.clips, evaluation.verdicts(), strict=True):
                if clip.source == source and (clip.windows or clip.in_silence().any()):
                    wrong[verdict.clip] = verdict.hits.count(False) + (verdict.false_alarms > 0)
        return wrong

    @property
    def watch(self) -> Evaluation:
        """The old name of `evaluation`."""
        warn_renamed("AlarmFit.watch", "AlarmFit.evaluation")
        return self.evaluation

    @checked
    def sections(
        self,
        held_out: HeldOutScores | None = None,
        unfinished: Sequence[str] = (),
        comparisons: Mapping[str, Comparison] | None = None,
    ) -> list[Section]:
        """The report's sections.

        **Arguments:** `held_out`: what models do on held-out clips. `unfinished`: what is still to come, each in a few
        words. `comparisons`: with plain detectors, each on the clips that its title names.
        """
        return [
            *unfinished_section(unfinished),
            _report.clip_section(self.evaluation, self.left_out, "Fitted clips"),
            *([] if held_out is None or comparisons else [_report.held_out_section(held_out)]),
            *(_report.comparison_section(title, each) for title, each in (comparisons or {}).items()),
            _report.search_section(self.screened, self.right, self.descended, self.left_out, self.stopped),
            _report.parameter_section(self.free, self.model.parameters, self.ranges),
        ]

    @checked
    def summary(
        self, held_out: HeldOutScores | None = None, comparisons: Mapping[str, Comparison] | None = None
    ) -> str:
        """The report as text, at most 110 columns wide. Arguments: as of `sections`."""
        return as_text(self.sections(held_out, comparisons=comparisons))
