"""Sweeps: the response over grids of stimuli, parameters and models, as labelled arrays.

`_axes` reads what is swept, `_responses` computes it in JAX, `_blocks` cuts it into pieces of bounded size, `_store`
keeps them on disk, and `_sweep` brings these together, here or on the workers of a Dask cluster (`_cluster`).
"""

from lgmd2jax._sweep.responses import surfaces as surfaces
from lgmd2jax._sweep.sweep import sweep as sweep
