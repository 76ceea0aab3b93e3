"""Where results go: arrays in memory, or a Zarr store on disk that a killed sweep can be resumed from."""

import dataclasses
import os
import shutil
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from lgmd2jax._compute.cluster import need
from lgmd2jax._compute.fingerprint import fingerprint
from lgmd2jax._files.temporary import temporary_beside
from lgmd2jax._sweep.blocks import Plan, Region
from lgmd2jax._sweep.responses import SUMMARIES

if TYPE_CHECKING:
    import xarray

_DONE = "finished/blocks"  # in a group of its own, so that xarray does not show it


class Memory:
    """Results as arrays."""

    def __init__(self, plan: Plan):
        self._plan = plan
        self._arrays = {
            name: np.full((*plan.grid.shape, *shape), np.nan, dtype) for name, (shape, dtype) in plan.variables.items()
        }

    def missing(self) -> list[int]:
        """The blocks that are still to be computed."""
        return list(self._plan.numbers())

    def write(self, number: int, results: dict[str, np.ndarray]) -> None:
        """Keep the results of a block."""
        for name, values in results.items():
            self._arrays[name][self._plan.region(number)] = values

    def dataset(self) -> "xarray.Dataset":
        """All results, labelled."""
        empty = _labels(self._plan)
        return empty.assign(
            {
                name: (_dimensions(self._plan, name), array, _meaning(self._plan, name))
                for name, array in self._arrays.items()
            }
        )


class Store:
    """Results in a Zarr folder. A block is one chunk of every variable, and is marked once all of these are written.

    **Raises:** `ValueError` for a folder that holds something else, or the results of another sweep.
    """

    def __init__(self, plan: Plan, path: str | os.PathLike):
        need("zarr", extra="sweep")
        self._plan, self._path = plan, Path(path)
        if _is_vacant(self._path):
            self._create()
        try:
            digest = self._group("r").attrs.get("digest")
        except (FileNotFoundError, ValueError, TypeError):
            digest = None
        if digest is None:
            raise ValueError(f"{path} holds something else than a sweep; name another folder")
        if digest != _digest(plan):
            raise ValueError(
                f"{path} holds another sweep (or one of other versions); remove it, or name another folder"
            )

    def missing(self) -> list[int]:
        """The blocks that are still to be computed, those among them of which a chunk was lost."""
        group = self._group("r")
        done = group[_DONE][:]
        return [number for number in self._plan.numbers() if not done[number] or self._lost(group, number)]

    def _lost(self, group: Any, number: int) -> bool:
        """Whether a file of a marked block is gone or empty; what is read in its place would be NaN, or nothing."""
        place = np.unravel_index(number, self._plan.blocks) if self._plan.blocks else ()
        for name, (shape, _) in self._plan.variables.items():
            key = group[name].metadata.encode_chunk_key((*map(int, place), *(0 for _ in shape)))
            chunk = self._path / name / key
            if not (chunk.is_file() and chunk.stat().st_size):  # a crash of the machine leaves empty ones
                return True
        return False

    def write(self, number: int, results: dict[str, np.ndarray]) -> None:
        """Write the results of a block.

        **Raises:** `ValueError` where the disk refuses; what was stored stays.
        """
        try:
            _write(self._group("r+"), number, self._plan.region(number), results)
        except OSError as error:
            reason = error.strerror or str(error)
            raise ValueError(
                f"cannot write {self._path}: {reason}; what is stored stays: run again to continue"
            ) from error

    def dataset(self) -> "xarray.Dataset":
        """All results, labelled, and read from the disk where they are looked at."""
        import xarray

        return xarray.open_zarr(self._path, chunks=None, consolidated=False)[list(self._plan.variables)]

    def _group(self, mode: Literal["r", "r+"]) -> Any:
        import zarr

        return zarr.open_group(self._path, mode=mode, use_consolidated=False)

    def _create(self) -> None:
        """Write a store without results beside the place where it then appears, whole."""
        import zarr

        path = self._path.absolute()
        if not path.parent.is_dir():
            raise ValueError(f"the folder {path.parent} does not exist; make it first, or write elsewhere")
        temporary = temporary_beside(path)
        try:
            labels = _labels(self._plan).assign_attrs(digest=_digest(self._plan))
            labels.to_zarr(temporary, mode="w", zarr_format=3, consolidated=False)
            group = zarr.open_group(temporary, mode="r+", use_consolidated=False)
            for name, (shape, dtype) in self._plan.variables.items():
                group.create_array(
                    name,
                    shape=(*self._plan.grid.shape, *shape),
                    chunks=(*self._plan.chunk, *shape),
                    dtype=dtype,
                    fill_value=np.nan,
                    dimension_names=_dimensions(self._plan, name),
                    attributes={**_meaning(self._plan, name)},
                )
            count = len(self._plan.numbers())
            group.create_array(_DONE, shape=(count,), chunks=(1,), dtype=bool, fill_value=False)
            temporary.rename(path)
        except OSError as error:
            raise ValueError(f"cannot write {path}: {error.strerror or error}") from error
        finally:
            shutil.rmtree(temporary, ignore_errors=True)


def is_complete(plan: Plan, path: str | os.PathLike) -> bool:
    """Whether a folder holds all of this sweep, so that it is only read.

    **Raises:** `ValueError` as the class.
    """
    return not _is_vacant(Path(path)) and not Store(plan, path).missing()


def _is_vacant(path: Path) -> bool:
    return not path.exists() or (path.is_dir() and not any(path.iterdir()))


def _write(group: Any, number: int, region: Region, results: dict[str, np.ndarray]) -> None:
    """The mark comes last: what a kill leaves without one is computed again."""
    import zarr

    with zarr.config.set({"array.write_empty_chunks": True}):  # else a block of NaN leaves no file, and looks lost
        for name, values in results.items():
            group[name][region] = values
        group[_DONE][number] = True


def _dimensions(plan: Plan, name: str) -> list[str]:
    return [axis.name for axis in plan.grid.axes] + (["time"] if name in plan.channels else [])


def _meaning(plan: Plan, name: str) -> dict[str, str]:
    unit, meaning = SUMMARIES[name] if name in SUMMARIES else plan.grid.setup.model.channels[name][:2]
    return {"units": unit, "long_name": meaning}


def _labels(plan: Plan) -> "xarray.Dataset":
    """Coordinates and attributes alone."""
    import xarray

    coordinates: dict[str, Any] = {}
    for axis in plan.grid.axes:
        named = {"units": axis.unit, "long_name": axis.meaning}
        coordinates[axis.name] = (axis.name, axis.values, {key: text for key, text in named.items() if text})
    if plan.channels:
        coordinates["time"] = ("time", plan.time, {"units": "ms", "long_name": "time from the event"})
    shown = {name: value for name, value in plan.grid.setup.fixed.items() if isinstance(value, (int, float, str))}
    attributes = {
        "stimulus": getattr(plan.grid.setup.renderer, "__name__", "?"),
        "shown": ", ".join(f"{name} = {value}" for name, value in shown.items()),
        "eye": ", ".join(f"{name} = {value}" for name, value in dataclasses.asdict(plan.grid.setup.eye).items()),
        "made_by": f"lgmd2jax {version('lgmd2jax')}",
    }
    return xarray.Dataset(coords=coordinates, attrs=attributes)


def _digest(plan: Plan) -> str:
    """Of all that the numbers depend on, what the renderer captured included."""
    setup = plan.grid.setup
    values = [axis.values for axis in plan.grid.axes]
    versions = [version(name) for name in ("lgmd2jax", "jax")]
    stimulus = (setup.renderer, setup.eye, setup.kinds, setup.fixed, values)
    return fingerprint((setup.model, stimulus, plan.channels, plan.chunk, plan.variables, versions))
