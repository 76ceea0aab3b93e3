"""A model by name: a file, a shipped fit or a preset, with single parameters set."""

import dataclasses
from collections.abc import Iterable
from pathlib import Path

from lgmd2jax._files.atomic import read_json
from lgmd2jax._files.catalogue import locate
from lgmd2jax._handover.model_file import load
from lgmd2jax._network.abstract import AbstractNetwork, AnyNetwork
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameters import PRESETS, preset, symbols
from lgmd2jax._network.yue_rind import YueRindLGMD1
from lgmd2jax._words import nearest, warn_unfinished

_PRESET, _YUE_RIND = "preset:", "yue_rind"


def model_named(name: str) -> AbstractNetwork:
    """The model of a path, of a shipped fit's bare name, or of `preset:NAME`; `preset:yue_rind` is the LGMD1.

    An `UnfinishedWarning` says where a fit's search was stopped.

    **Raises:** `ValueError` for a preset or a file that is none, `FileNotFoundError` for a file that is not there.
    """
    path = model_file(name)
    if path is not None:
        model = load(path)
        if (part := read_json(path)["provenance"].get("unfinished")) is not None:
            warn_unfinished(f"{path} is of an unfinished fit: {part} was stopped")
        return model
    name = name.removeprefix(_PRESET)
    if name not in (known := (*PRESETS, _YUE_RIND)):
        raise ValueError(f"preset is {name!r}; choose {nearest(name, known)}")
    return YueRindLGMD1() if name == _YUE_RIND else LGMD2(preset(name))


def model_file(name: str) -> Path | None:
    """The hand-over file that is meant, None for a preset.

    **Raises:** `FileNotFoundError` for a file that is not there.
    """
    return None if name.startswith(_PRESET) else locate(name, "fits", "/model.json")


def with_parameters(model: AnyNetwork, settings: Iterable[str]) -> AnyNetwork:
    """The model with single parameters set, each written as `NAME=VALUE`.

    **Raises:** `ValueError` for what is not written so, for unknown names, and for values out of their domain.
    """
    known = symbols(type(model.parameters))
    values: dict[str, float] = {}
    for setting in settings:
        name, _, text = setting.partition("=")
        if name not in known:
            raise ValueError(f"parameter is {name!r}; choose {nearest(name, known)}")
        try:
            values[name] = float(text)
        except ValueError:
            raise ValueError(f"{setting!r} gives no number; write {name}=VALUE") from None
    return dataclasses.replace(model, parameters=dataclasses.replace(model.parameters, **values))
