"""A protocol: the conditions of an experiment, read from a TOML file, each a stimulus that can be rendered."""

import dataclasses
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import jax

from lgmd2jax._eye import Eye
from lgmd2jax._files.catalogue import read_named
from lgmd2jax._protocol.arguments import arguments, check_complete, check_keys, keywords
from lgmd2jax._protocol.placeholders import expand, fill
from lgmd2jax._protocol.target_table import target
from lgmd2jax._targets.target import AnyTarget
from lgmd2jax._words import nearest
from lgmd2jax.stimuli import FAMILIES, Stimulus, camera

_CONDITION_KEYS = ("name", "family", "eye", "camera", "target")


@dataclasses.dataclass(frozen=True)
class Condition:
    """One stimulus of a protocol.

    **Arguments:**

    - `name`: unique in its protocol.
    - `eye`: the sampling that it is rendered for.
    - `family`: the name of a renderer in `lgmd2jax.stimuli.FAMILIES`.
    - `parameters`: the renderer's keyword arguments; what is left out has the family's own default.
    - `camera`: what films the stimulus, as keyword arguments of `lgmd2jax.stimuli.camera` and a `seed`; None for none.
    - `targets`: the curves that a fit compares with: a `Target`, or what becomes one on the stimulus.

    **Raises:** `ValueError` for a family that there is not, and for a parameter that it does not take.
    """

    name: str
    eye: Eye
    family: str
    parameters: Mapping[str, Any]
    camera: Mapping[str, Any] | None = None
    targets: tuple[AnyTarget, ...] = ()

    def __post_init__(self):
        if self.family not in FAMILIES:
            raise ValueError(f"family is {self.family!r}; choose {nearest(self.family, FAMILIES)}")
        try:
            check_keys(self.parameters, keywords(FAMILIES[self.family]))
        except ValueError as error:
            raise ValueError(f"condition {self.name!r}: {error}") from error

    def render(self) -> Stimulus:
        """The stimulus, under the name of the condition.

        **Raises:** `ValueError` that names the condition, where its parameters do not make a stimulus.
        """
        try:
            stimulus = FAMILIES[self.family](self.eye, **self.parameters)
            if self.camera is not None:
                settings = dict(self.camera)
                stimulus = camera(stimulus, jax.random.key(settings.pop("seed", 0)), **settings)
        except ValueError as error:
            raise ValueError(f"condition {self.name!r}: {error}") from error
        return dataclasses.replace(stimulus, name=self.name)


@dataclasses.dataclass(frozen=True)
class Protocol:
    """The conditions of an experiment, in the order of their file, grids expanded."""

    name: str
    conditions: tuple[Condition, ...]


def load_protocol(source: str | Path) -> Protocol:
    """Read a protocol from a TOML file.

    ```toml
    [eye]                              # the fields of `Eye`, or preset = "paper" and what differs from it
    preset = "locust"
    fps = 100

    [[condition]]                      # as many as wanted
    name = "dark approach {l_over_v} ms"
    family = "looming"
    l_over_v = [20, 40, 80]            # a list is a grid; several lists make their product, in the order written
    contrast = -0.9
    ```

    A parameter that is itself a vector is written as a list within the list: `[[0, 1, 2]]`. Backgrounds and distances
    are tables with a `kind` (`{ kind = "photograph", image = ["brick", "gravel"] }`); a `camera` table films the
    stimulus, with the arguments of `lgmd2jax.stimuli.camera` and a `seed`; an `eye` table holds what differs from the
    common eye. Lists in these are axes too.

    Placeholders in names and targets are filled by the parameters and the fields of the eye, numbers with %g;
    `{background[image]}` reaches into a table. Targets are tables under `[[condition.target]]`, none or more, or under
    `[[target]]` for all conditions: a recorded curve or spike times in a `file` beside the protocol, a `law`, or what
    another `model` answers. `target` in lgmd2jax/_target_table.py shows all that they take.

    **Arguments:** `source`: a path, or the bare name of a shipped protocol: `"paper"`, `"looming"`, `"robot"`, ...

    **Raises:** `FileNotFoundError` for a file that is not there; `ValueError`, which names file, condition and key, for
    what is not a protocol.
    """
    return read_named(source, "stimuli", protocol_of)


def protocol_of(path: Path, document: dict[str, Any]) -> Protocol:
    """The protocol that a TOML file holds.

    **Raises:** `ValueError`, which names condition and key, for what is not a protocol.
    """
    if {"clip", "rendered"} & document.keys():
        raise ValueError("it holds labelled clips, for recipes of kind 'alarms': see lgmd2jax.alarms.load_labels")
    return Protocol(path.stem, _conditions(document, path.parent.resolve()))


def _conditions(document: dict[str, Any], folder: Path) -> tuple[Condition, ...]:
    check_keys(document, ("eye", "target", "condition"))
    eye, common, tables = _table(document, "eye"), _target_tables(document), document.get("condition")
    if not (isinstance(tables, list) and tables and all(isinstance(table, dict) for table in tables)):
        raise ValueError("no conditions; write each as a table under [[condition]]")
    conditions = []
    for number, table in enumerate(tables, start=1):
        try:
            conditions += [_condition(point, folder) for point in _points(table, eye, common)]
        except ValueError as error:
            raise ValueError(f"condition {number} ({table.get('name', 'without a name')}): {error}") from error
    for name, count in Counter(condition.name for condition in conditions).items():
        if count > 1:
            raise ValueError(f"{count} conditions are named {name!r}; tell them apart by placeholders, as {{contrast}}")
    return tuple(conditions)


def _points(table: dict[str, Any], eye: dict[str, Any], common: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """The grid points of one [[condition]], each with its whole eye and all its targets, which are no axes."""
    for key in ("name", "family"):
        if not isinstance(table.get(key), (str, list)):
            raise ValueError(f"{key} is missing; every condition has a name and a family, both text")
    targets = [*common, *_target_tables(table)]
    grid = {key: value for key, value in table.items() if key != "target"} | {"eye": eye | _table(table, "eye")}
    for point in expand(grid):
        yield point | {"target": targets}


def _condition(point: dict[str, Any], folder: Path) -> Condition:
    family = point["family"]
    if family not in FAMILIES:
        raise ValueError(f"family is {family!r}; choose {nearest(family, FAMILIES)}")
    known = keywords(FAMILIES[family])
    check_keys(point, [*known, *_CONDITION_KEYS])
    written = {key: value for key, value in point.items() if key in known}
    check_complete(written, FAMILIES[family])
    eye = eye_of(point["eye"], folder)
    values = {name: keyword.default for name, keyword in known.items()} | dataclasses.asdict(eye) | point
    return Condition(
        name=fill(point["name"], values),
        eye=eye,
        family=family,
        parameters=arguments(FAMILIES[family], written, folder),
        camera=_camera(_table(point, "camera"), folder) if "camera" in point else None,
        targets=_targets(point["target"], values, folder),
    )


def _target_tables(document: dict[str, Any]) -> list[dict[str, Any]]:
    tables = document.get("target", [])
    if not (isinstance(tables, list) and all(isinstance(table, dict) for table in tables)):
        raise ValueError("target is not a list of tables; write [[target]] or [[condition.target]]")
    return tables


def _targets(tables: list[dict[str, Any]], values: Mapping[str, Any], folder: Path) -> tuple[AnyTarget, ...]:
    targets = []
    for number, table in enumerate(tables, start=1):
        try:
            targets.append(target(fill(table, values), folder))
        except ValueError as error:
            raise ValueError(f"target {number}: {error}") from error
    return tuple(targets)


def eye_of(table: dict[str, Any], folder: Path) -> Eye:
    if not table:
        raise ValueError("no eye; give the protocol an [eye] table, such as preset = 'locust'")
    check_keys(table, ["preset", *keywords(Eye)])
    fields = arguments(Eye, {key: value for key, value in table.items() if key != "preset"}, folder)
    try:
        if "preset" in table:
            return dataclasses.replace(Eye.preset(table["preset"]), **fields)
        check_complete(fields, Eye)
        return Eye(**fields)
    except ValueError as error:
        raise ValueError(f"eye: {error}") from error


def _camera(table: dict[str, Any], folder: Path) -> dict[str, Any]:
    """What the camera does, with the seed of its noise."""
    check_keys(table, ["seed", *keywords(camera)])
    seed = table.get("seed", 0)
    if not isinstance(seed, int) or seed < 0:
        raise ValueError(f"camera: seed is {seed!r}; give a whole number, 0 or more")
    return {"seed": seed} | arguments(camera, {key: value for key, value in table.items() if key != "seed"}, folder)


def _table(document: dict[str, Any], key: str) -> dict[str, Any]:
    table = document.get(key, {})
    if not isinstance(table, dict):
        raise ValueError(f"{key} is {table!r}; write it as a table")
    return table
