"""The stimuli and targets of a fit: held by its folder, or named there and rendered anew when they are needed."""

import dataclasses
import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from lgmd2jax._files.catalogue import folder as shipped_folder
from lgmd2jax._protocol.protocol import load_protocol
from lgmd2jax._words import within
from lgmd2jax.fitting import Fit
from lgmd2jax.fitting._animals import conditions_by_animal
from lgmd2jax.fitting._comparison import difference_of_data
from lgmd2jax.fitting._conditions import AnyCondition, Rendered, render
from lgmd2jax.fitting._curve import curve_of, rest_of
from lgmd2jax.fitting._fit import digest_of
from lgmd2jax.fitting._problem import Batch, Place, Problem, Slot, problem_of

DATA = "data.npz"
_MOST = 2**28  # bytes of frames that a folder holds; of more it only knows what they were
_CURE = "give them to load_fit(folder, conditions=...)"

Arrays = Mapping[str, np.ndarray]


def holds(problem: Problem | None) -> bool:
    """Whether a folder can hold these stimuli and targets."""
    return problem is not None and sum(batch.frames.nbytes for batch in problem.batches) <= _MOST


def write_data(path: Path, problem: Problem) -> None:
    """Write stimuli and targets as they were compared, so that all that follows is the same to the bit."""
    np.savez_compressed(path, **_arrays(problem))  # pyright: ignore[reportArgumentType]


def entry_of(problem: Problem) -> dict[str, str]:
    """What fit.json says of the data that its folder holds."""
    return {"file": DATA, "digest": _digest(_arrays(problem))}


def entry_naming(protocol: Path, folder: Path, animal: str = "") -> dict[str, str]:
    """What fit.json says of a protocol: the bare name of a shipped one, else its place as seen from the folder.

    **Arguments:** `animal`: whose trials alone are the data; empty for all.
    """
    own = {"animal": animal} if animal else {}
    if protocol.resolve().parent == shipped_folder("stimuli").resolve():
        return {"protocol": protocol.stem} | own
    return {"protocol": Path(os.path.relpath(protocol.resolve(), folder.resolve())).as_posix()} | own


def source_of_data(
    folder: Path, content: Mapping[str, Any], conditions: Sequence[AnyCondition] | None
) -> Callable[[Fit], Problem]:
    """What gives a loaded fit its data.

    **Arguments:** `content`: of fit.json. `conditions`: in place of what the folder holds or names.
    """

    def data(fit: Fit) -> Problem:
        entry = content.get("data") or {}
        if conditions is None and "file" in entry:
            return _held(folder / entry["file"], entry["digest"], fit)
        pairs = render(_named_conditions(folder, content) if conditions is None else conditions)
        problem = problem_of(fit.model, fit.observation, fit.free, pairs, fit.stats["loss"])
        if difference := difference_of_data("the fit", fit, "what is there now", _compared(fit, pairs)):
            cure = "" if jax.config.read("jax_enable_x64") else "; or switch double precision on: jax_enable_x64"
            raise ValueError(f"the data of {folder} have changed since the fit was made: {difference}{cure}")
        return problem

    return data


def _compared(fit: Fit, pairs: Sequence[Rendered]) -> Fit:
    """A fit to these data, as far as data are compared."""
    curves = [
        curve_of(
            stimulus, target, target.values, target.values, target.values, rest_of(target.channel, fit.observation)
        )
        for stimulus, targets in pairs
        for target in targets
    ]
    stimuli = {stimulus.name: digest_of(stimulus) for stimulus, _ in pairs}
    return dataclasses.replace(fit, curves=tuple(curves), stats={**fit.stats, "stimuli": stimuli})


def _named_conditions(folder: Path, content: Mapping[str, Any]) -> Sequence[AnyCondition]:
    named = (content.get("data") or content.get("recipe") or {}).get("protocol")
    if named is None:
        raise ValueError(f"{folder} neither holds nor names its stimuli and targets; {_CURE}")
    # An earlier version wrote the recipe alone, beside which the folder of its results lies as a rule.
    places = [folder / named, folder.parent / named]
    shipped = shipped_folder("stimuli") / f"{Path(named).stem}.toml"
    found = next((place for place in (*places, shipped) if place.is_file()), None)
    if found is None:
        raise ValueError(f"the protocol of {folder}, {named}, is gone; put it back, or {_CURE}")
    with within(f"the data of {folder} cannot be read"):
        conditions = load_protocol(found).conditions
        if not (animal := content.get("data", {}).get("animal")):
            return conditions
        return [pair for _, pair in conditions_by_animal(conditions).get(animal, ())]


def _held(path: Path, digest: str, fit: Fit) -> Problem:
    if not path.is_file():
        raise ValueError(f"{path}, with the stimuli and targets of the fit, is gone; put it back, or {_CURE}")
    try:
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError) as error:
        raise ValueError(f"{path} cannot be read: {error}; put back the one that was written, or {_CURE}") from error
    if _digest(arrays) != digest:
        raise ValueError(f"{path} is not the one that was written with the fit; put that back, or {_CURE}")
    return _problem(arrays, fit)


def _arrays(problem: Problem) -> dict[str, np.ndarray]:
    """All arrays by their place, and as JSON what is no array."""
    arrays: dict[str, np.ndarray] = {}
    for number, batch in enumerate(problem.batches):
        for name in ("frames", "interval", "time"):
            arrays[f"{number}/{name}"] = np.asarray(getattr(batch, name))
        for place, slot in enumerate(batch.slots):
            for name in _SLOT_ARRAYS:
                arrays[f"{number}/{place}/{name}"] = np.asarray(getattr(slot, name))
    slots = [[{name: getattr(slot, name) for name in _SLOT_WORDS} for slot in batch.slots] for batch in problem.batches]
    arrays["structure"] = np.array(json.dumps({"slots": slots, "places": problem.places}))
    return arrays


_SLOT_WORDS = [field.name for field in dataclasses.fields(Slot) if field.metadata.get("static")]
_SLOT_ARRAYS = [field.name for field in dataclasses.fields(Slot) if field.name not in _SLOT_WORDS]


def _problem(arrays: Arrays, fit: Fit) -> Problem:
    structure = json.loads(str(arrays["structure"]))

    def batch(number: int, words: Sequence[Mapping[str, Any]]) -> Batch:
        slots = []
        for place, word in enumerate(words):
            values: dict[str, Any] = {name: jnp.asarray(arrays[f"{number}/{place}/{name}"]) for name in _SLOT_ARRAYS}
            values["thinning"] = values["thinning"].reshape(
                len(values["scale"]), -1
            )  # once a number for each condition
            slots.append(Slot(**word, **values))
        own = {name: jnp.asarray(arrays[f"{number}/{name}"]) for name in ("frames", "interval", "time")}
        return Batch(**own, slots=tuple(slots))

    batches = tuple(batch(number, words) for number, words in enumerate(structure["slots"]))
    places = tuple(tuple(Place(*place) for place in row) for row in structure["places"])
    return Problem(fit.model, fit.observation, fit.free, batches, places, fit.stats["loss"])


def _digest(arrays: Arrays) -> str:
    whole = hashlib.sha256()
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        whole.update(f"{name} {array.dtype} {array.shape} ".encode() + array.tobytes())
    return whole.hexdigest()[:32]
