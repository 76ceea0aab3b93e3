"""A recipe of a fit to labelled clips, read from a TOML file."""

import dataclasses
import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np

from lgmd2jax._arguments.checked import checked
from lgmd2jax._files.catalogue import beside, read_named
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._schemas.check import check
from lgmd2jax._schemas.recipes import RECIPE
from lgmd2jax.alarms._clip import LabelledClip
from lgmd2jax.alarms._fit import fit
from lgmd2jax.alarms._label_file import LabelFile, Rendering, load_labels
from lgmd2jax.alarms._result import AlarmFit
from lgmd2jax.fitting import Free
from lgmd2jax.fitting._sections import free_of, model_of


@dataclasses.dataclass(frozen=True)
class AlarmRecipe:
    """A fit of alarms to be made, as `load_recipe` reads it: the model, what is free, the file of labelled clips.

    ```python
    recipe = lgmd.load_recipe("video")
    fit = recipe.run(recipe.file.load(), progress=True)
    ```

    - `weights`: the cost of a missed window and of a false alarm; what recorded clips weigh together.
    - `validation`: which clips to render, with a seed that the fit does not use, for the score of the report.
    - `table`: the file's content.
    """

    name: str
    model: LGMD2
    free: Free
    file: LabelFile
    weights: Mapping[str, float | int]
    solver: Mapping[str, Any]
    validation: Rendering | None
    table: Mapping[str, Any]

    @property
    def seed(self) -> int:
        """The seed of the search's random points."""
        return self.solver.get("seed", 0)

    @property
    def within_ms(self) -> float | int | None:
        """Within which time contact follows, for the probability of contact; None where none is asked for."""
        return self.table.get("urgency", {}).get("within_ms")

    @checked
    def run(self, clips: Sequence[LabelledClip], progress: bool = False, memory=None) -> AlarmFit:
        """Make the fit to clips, such as those of `file.load()`.

        **Arguments:** `progress`, `memory`: as of `alarms.fit`. **Raises:** as `alarms.fit`.
        """
        settings = {name: value for name, value in self.solver.items() if name != "seed"}
        key = jax.random.key(self.seed)
        return fit(self.model, clips, self.free, key=key, progress=progress, memory=memory, **self.weights, **settings)

    def weighing(self, recorded: float | int) -> "AlarmRecipe":
        """The recipe with recorded clips that together weigh so many times what the rendered ones do."""
        weights = {**self.weights, "recorded": recorded}
        return dataclasses.replace(self, weights=weights, table={**self.table, "weights": weights})

    def held_out(self) -> tuple[LabelledClip, ...]:
        """The clips that the fit does not see."""
        return () if self.validation is None else tuple(self.validation.clips(self.file.eye))

    def digest(self, clips: Sequence[LabelledClip]) -> str:
        """A digest of all that the fit sees: recipe, clips and labels. The urgency comes after it."""
        seen = {name: value for name, value in self.table.items() if name != "urgency"}
        digest = hashlib.sha256(json.dumps(seen, sort_keys=True).encode())
        for clip in clips:
            labels = clip.fps, clip.windows, clip.silent, clip.contact, clip.source, clip.weight
            digest.update(repr(labels).encode())
            digest.update(np.ascontiguousarray(clip.frames).tobytes() + clip.index.tobytes() + clip.interval.tobytes())
        return digest.hexdigest()


@checked
def load_recipe(source: str | Path) -> AlarmRecipe:
    """Read a recipe of kind `"alarms"` from a TOML file, or a shipped one by its bare name.

    **Raises:** `ValueError`, which names the file and the key, for what is not such a recipe; `FileNotFoundError`.
    """
    return read_named(source, "fits", _checked_recipe)


def alarm_recipe(path: Path, table: dict[str, Any]) -> AlarmRecipe:
    """The recipe of a fit to labelled clips that a TOML file, whose form is checked, holds.

    **Raises:** `ValueError`, which names the key, for what is not such a recipe; `FileNotFoundError`.
    """
    file = load_labels(beside(path, table["protocol"]))
    held_out = Rendering(**table["validation"]) if "validation" in table else None
    if held_out is not None and file.rendered is not None and held_out.seed == file.rendered.seed:
        raise ValueError(f"validation.seed = {held_out.seed}: the fitted clips have this seed too; give another one")
    if "urgency" in table and held_out is None:
        raise ValueError("[urgency] needs [validation], whose clips show whether it holds; add it")
    return AlarmRecipe(
        name=path.stem,
        model=model_of(table, file.eye),
        free=free_of(table),
        file=file,
        weights=table.get("weights", {}),
        solver=table.get("solver", {}),
        validation=held_out,
        table=table,
    )


def _checked_recipe(path: Path, table: dict[str, Any]) -> AlarmRecipe:
    if table.get("kind") != "alarms":
        raise ValueError(f"kind is {table.get('kind', 'missing')!r}; a fit to labelled clips has kind 'alarms'")
    check(RECIPE, table)
    return alarm_recipe(path, table)
