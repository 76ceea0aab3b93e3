"""A protocol, read from a TOML file: grids expanded, placeholders filled, targets read."""

import dataclasses
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._files.catalogue import read_named
from lgmd2jax._protocol.arguments import arguments
from lgmd2jax._protocol.condition import Condition, Protocol
from lgmd2jax._protocol.placeholders import expand, fill
from lgmd2jax._protocol.target_table import target
from lgmd2jax._schemas.check import check, check_kind
from lgmd2jax._schemas.protocol import PROTOCOL
from lgmd2jax._words import within
from lgmd2jax.stimuli import FAMILIES, camera
from lgmd2jax.stimuli._keywords import check_keywords, keywords

_CONDITION_KEYS = ("name", "family", "eye", "camera", "target")


@checked
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
    another `model` answers. `target` in lgmd2jax/_protocol/target_table.py shows all that they take.

    **Arguments:** `source`: a path, or the bare name of a shipped protocol: `"paper"`, `"looming"`, `"robot"`, ...

    **Raises:** `FileNotFoundError` for a file that is not there; `ValueError`, which names file, condition and key, for
    what is not a protocol.
    """
    return read_named(source, "stimuli", protocol_of)


def protocol_of(path: Path, document: dict[str, Any]) -> Protocol:
    """The protocol that a TOML file holds.

    **Raises:** `ValueError`, which names condition and key, for what is not a protocol.
    """
    check_kind(document, "protocol")
    check(PROTOCOL, document)
    return Protocol(path.stem, _conditions(document, path.parent.resolve()))


def _conditions(document: dict[str, Any], folder: Path) -> tuple[Condition, ...]:
    common = list(_placed("target", document))
    conditions = []
    for number, table in enumerate(document["condition"]):
        place = f"condition[{number}]"
        targets = [*common, *_placed(f"{place}.target", table)]
        grid = {key: value for key, value in table.items() if key != "target"}
        grid["eye"] = document["eye"] | table.get("eye", {})
        conditions += [_condition(place, point, targets, folder) for point in expand(grid)]
    for name, count in Counter(condition.name for condition in conditions).items():
        if count > 1:
            raise ValueError(f"{count} conditions are named {name!r}; tell them apart by placeholders, as {{contrast}}")
    return tuple(conditions)


def _placed(place: str, table: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The targets of a table, with the place at which each stands."""
    for number, target_table in enumerate(table.get("target", [])):
        yield f"{place}[{number}]", target_table


def _condition(
    place: str, point: dict[str, Any], targets: Sequence[tuple[str, dict[str, Any]]], folder: Path
) -> Condition:
    """One grid point, with the targets that its values fill in."""
    family = point["family"]
    known = keywords(FAMILIES[family])
    with within(place):
        check_keywords(FAMILIES[family], point, *_CONDITION_KEYS)  # of several families, one takes what others do not
        written = {key: value for key, value in point.items() if key in known}
        eye = eye_of(point["eye"])
        values = {name: keyword.default for name, keyword in known.items()} | dataclasses.asdict(eye) | point
        name = fill(point["name"], values)
        parameters = arguments(FAMILIES[family], written, folder)
        film = _camera(point["camera"], folder) if "camera" in point else None
    filled = []
    for target_place, table in targets:
        with within(target_place):
            filled.append(target(fill(table, values), folder))
    return Condition(name, eye, family, parameters, film, tuple(filled))


def eye_of(table: Mapping[str, Any]) -> Eye:
    """The eye of a table whose form is checked.

    **Raises:** `ValueError` for a table that leaves fields open.
    """
    fields: dict[str, Any] = {
        key: float(value) if key in ("degrees_per_pixel", "fps") else value for key, value in table.items()
    }
    if "preset" in fields:
        return dataclasses.replace(Eye.preset(fields.pop("preset")), **fields)
    for name in ("rows", "cols", "degrees_per_pixel", "fps"):
        if name not in fields:
            raise ValueError(f"eye.{name} is missing; add it, or start from one: preset = 'locust'")
    return Eye(**fields)


def _camera(table: dict[str, Any], folder: Path) -> dict[str, Any]:
    """What the camera does, with the seed of its noise."""
    settings = {key: value for key, value in table.items() if key != "seed"}
    return {"seed": table.get("seed", 0)} | arguments(camera, settings, folder)
