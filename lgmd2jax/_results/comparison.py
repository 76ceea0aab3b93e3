"""Fits, as objects or as folders of results, side by side; and that as files."""

import csv
import dataclasses
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm
from typing_extensions import TypeAliasType

from lgmd2jax._arguments.checked import checked
from lgmd2jax._characterise import characterise
from lgmd2jax._files import atomic
from lgmd2jax._results.fit_folder import fit_folder, load_validated_fit
from lgmd2jax._results.fit_json import plain
from lgmd2jax.fitting import Comparison, Fit
from lgmd2jax.fitting._comparison import Estimate, Held, compared

AnyFit = TypeAliasType("AnyFit", Fit | str | Path)


@checked
def compare(
    fits: Sequence[AnyFit] | Mapping[str, AnyFit], *, properties: bool = False, progress: bool = False
) -> Comparison:
    """Fits to the same stimuli and targets side by side: chi2, R2, parameters, what was left out, AIC and BIC.

    ```python
    lgmd.compare({"plain": "results/plain", "with size": fit})
    ```

    **Arguments:**

    - `fits`: a `Fit`, the folder of its results or the fit.json in it, or the name of a shipped one, each; by the names
      that they are to have, or in a row, where a folder gives its own name, or its path where two share that. What a
      fit says of conditions that were left out stands in its folder alone.
    - `properties`: also count which of the 22 response properties each model holds, which takes a minute.
    - `progress`: show a bar over models while these are counted.

    **Raises:** `ValueError` for fewer than two fits, for two of one name, for what is no fit, and for fits to different
    data, with what the difference is; `FileNotFoundError` for a folder that is not there.
    """
    by_name = fits if isinstance(fits, Mapping) else _named(fits)
    loaded = {name: (fit, {}) if isinstance(fit, Fit) else load_validated_fit(fit) for name, fit in by_name.items()}
    models = {name: fit for name, (fit, _) in loaded.items()}
    comparison = compared(models, {name: r2 for name, (_, r2) in loaded.items()})
    if not properties:
        return comparison
    bar = tqdm(models.values(), unit="model", leave=False, disable=not progress)
    results = [characterise(fit.model) for fit in bar]
    held = tuple(Held(result.passed, result.judged) for result in results)
    return dataclasses.replace(comparison, properties=held)


def _named(fits: Sequence[AnyFit]) -> dict[str, AnyFit]:
    if isinstance(fits, str | Path | Fit):
        raise ValueError(f"fits is {str(fits)!r:.60}; give a list of two or more")
    names = [f"fit {i}" if isinstance(fit, Fit) else fit_folder(fit).name for i, fit in enumerate(fits, start=1)]
    names = [name if names.count(name) == 1 else str(fit) for name, fit in zip(names, fits, strict=True)]
    for name, count in Counter(names).items():
        if count > 1:
            raise ValueError(f"{name} is given {count} times; give each fit once")
    return dict(zip(names, fits, strict=True))


def write_json(path: Path, comparison: Comparison) -> None:
    """All of it, by fit; None for a number that there is not."""
    content = {
        "samples": comparison.samples,
        "without_criteria": comparison.without_criteria,
        "alike": comparison.alike,
        "fits": {name: _content(comparison, i) for i, name in enumerate(comparison.names)},
    }
    atomic.write_json(path, plain(content))


def _content(comparison: Comparison, i: int) -> dict[str, Any]:
    """What is known of one fit."""
    return {
        "free_parameters": int(comparison.free[i]),
        "chi2": comparison.chi2_in_all[i],
        "r2": comparison.r2_in_all[i],
        "left_out_r2": comparison.left_out_in_mean[i],
        "aic": comparison.aic[i],
        "bic": comparison.bic[i],
        "properties": comparison.properties and comparison.properties[i]._asdict(),
        "curves": [
            {"condition": condition, "channel": channel, "chi2": comparison.chi2[i, j], "r2": comparison.r2[i, j]}
            for j, (condition, channel) in enumerate(comparison.curves)
        ],
        "left_out": {name: r2[i] for name, r2 in comparison.left_out.items()},
        "parameters": {
            name: {"unit": comparison.units[name]} | estimate._asdict()
            for name, estimates in comparison.parameters.items()
            if (estimate := estimates[i]) is not None
        },
    }


def write_csv(path: Path, comparison: Comparison) -> None:
    """A line for each number that fits have, a column for each fit; an empty cell for a number that there is not."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["quantity", "of", "unit", *comparison.names])
        for *labels, numbers in _lines(comparison):
            cells = ("" if math.isnan(number) else f"{float(number):.9g}" for number in numbers)
            writer.writerow([*labels, *cells])


def _lines(comparison: Comparison) -> Iterator[tuple[str, str, str, Iterable[float]]]:
    """The quantity, of what, its unit, and a number for each fit."""
    yield "free parameters", "", "", comparison.free
    yield "chi2", "", "", comparison.chi2_in_all
    yield "R2", "", "", comparison.r2_in_all
    yield "R2 left out", "", "", comparison.left_out_in_mean
    yield "AIC", "", "", comparison.aic
    yield "BIC", "", "", comparison.bic
    if comparison.properties is not None:
        yield "response properties", "", "", [held.passed for held in comparison.properties]
    for quantity, numbers in (("chi2", comparison.chi2), ("R2", comparison.r2)):
        for (condition, channel), row in zip(comparison.curves, numbers.T, strict=True):
            yield quantity, f"{condition}, {channel}", "", row
    for condition, row in comparison.left_out.items():
        yield "R2 left out", condition, "", row
    for name, estimates in comparison.parameters.items():
        known = [estimate or Estimate(math.nan, math.nan) for estimate in estimates]
        yield "parameter", name, comparison.units[name], [estimate.value for estimate in known]
        yield "standard error", name, comparison.units[name], [estimate.standard_error for estimate in known]
