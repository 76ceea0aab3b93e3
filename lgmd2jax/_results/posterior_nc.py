"""Posterior draws as a NetCDF file in the layout that ArviZ reads (the extra `bayes`)."""

import os
from collections.abc import Mapping
from importlib.metadata import version

import numpy as np
from jaxtyping import Float

from lgmd2jax._compute.cluster import need
from lgmd2jax._files.atomic import replaced


def check_packages() -> None:
    """Raise `ValueError` where the packages that draws need are not installed: before the fit, not after it."""
    need("blackjax", "h5netcdf", "h5py", "xarray", extra="bayes")


def write_posterior(
    path: str | os.PathLike,
    draws: Mapping[str, Float[np.ndarray, "chain draw"]],
    units: Mapping[str, str],
    statistics: Mapping[str, np.ndarray],
) -> None:
    """Write the groups `posterior` and `sample_stats`: `arviz.from_netcdf(path)`.

    **Arguments:** `draws` of each parameter in its own unit; `units` of them; `statistics` of each draw, named as ArviZ
    does: `energy`, `diverging`, `acceptance_rate`, `tree_depth`.

    **Raises:** `ValueError` without these packages, and when `path` cannot become a file.
    """
    check_packages()
    import xarray

    def group(arrays: Mapping[str, np.ndarray]) -> xarray.Dataset:
        count, length = next(iter(arrays.values())).shape
        coordinates = {"chain": np.arange(count), "draw": np.arange(length)}
        attributes = {"inference_library": "blackjax", "inference_library_version": version("blackjax")}
        return xarray.Dataset(
            {name: (("chain", "draw"), array) for name, array in arrays.items()}, coordinates, attributes
        )

    posterior = group(draws)
    for name, unit in units.items():
        posterior[name].attrs["units"] = unit
    with replaced(path) as temporary:
        posterior.to_netcdf(temporary, mode="w", group="posterior", engine="h5netcdf")
        group(statistics).to_netcdf(temporary, mode="a", group="sample_stats", engine="h5netcdf")
