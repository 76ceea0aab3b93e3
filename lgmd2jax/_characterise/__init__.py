"""What a neuron does: the 22 response properties of the field, measured on any model.

Trials (stimuli with their times) make up an exam; the pixels turn each into MP and F, the cell turns these into curves,
and rows read their values from the curves. All from MP and F on is pure JAX and maps over models.
"""

from lgmd2jax._characterise.characterise import (
    ablations as ablations,
    characterise as characterise,
    differences as differences,
    rasters as rasters,
)
from lgmd2jax._characterise.result import Characterisation as Characterisation, Finding as Finding
