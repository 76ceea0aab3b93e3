"""How a command is told its model: by file, by shipped name or by preset, with single parameters set."""

from collections.abc import Iterable
from pathlib import Path

import equinox as eqx

from lgmd2jax._catalogue import locate
from lgmd2jax._export import load
from lgmd2jax._model import LGMD2
from lgmd2jax._parameters import nearest, preset, symbols

_PRESET = "preset:"
MODEL_HELP = "a hand-over file model.json, the name of a shipped fit, or preset:NAME (default: %(default)s)"


def model_named(name: str) -> LGMD2:
    """The model of a path, of a shipped fit's bare name, or of `preset:NAME`.

    **Raises:** `ValueError` for a preset or a file that is none, `FileNotFoundError` for a file that is not there.
    """
    path = model_file(name)
    return LGMD2(preset(name.removeprefix(_PRESET))) if path is None else load(path)


def model_file(name: str) -> Path | None:
    """The hand-over file that is meant, None for a preset.

    **Raises:** `FileNotFoundError` for a file that is not there.
    """
    return None if name.startswith(_PRESET) else locate(name, "fits", "/model.json")


def with_parameters(model: LGMD2, settings: Iterable[str]) -> LGMD2:
    """The model with single parameters set, each written as `NAME=VALUE`.

    **Raises:** `ValueError` for what is not written so, for unknown names, and for values out of their domain.
    """
    for setting in settings:
        name, _, text = setting.partition("=")
        if name not in symbols():
            raise ValueError(f"parameter is {name!r}; choose {nearest(name, symbols())}")
        try:
            value = float(text)
        except ValueError:
            raise ValueError(f"{setting!r} gives no number; write {name}=VALUE") from None
        parameters = {known: getattr(model.parameters, known) for known in symbols()} | {name: value}
        model = eqx.tree_at(lambda model: model.parameters, model, type(model.parameters)(**parameters))
    return model
