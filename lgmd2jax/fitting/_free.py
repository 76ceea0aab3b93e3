"""Which parameters a fit may change, and within which bounds."""

from collections.abc import Mapping

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lgmd2jax._parameters import Parameters, nearest, symbols


class Free:
    """The free parameters with their bounds; None takes the bounds that are declared with the parameter.

    ```python
    Free(theta2=(1, 6), T_sp=None)
    ```

    **Raises:** `ValueError` for unknown parameters, for none at all, and for bounds that are empty or leave the domain.
    """

    def __init__(self, **bounds: tuple[float | int, float | int] | None):
        if not bounds:
            raise ValueError("free is empty; name at least one parameter")
        self.bounds: Mapping[str, tuple[float, float]] = {}
        for name, pair in bounds.items():
            if name not in symbols():
                raise ValueError(f"free parameter is {name!r}; choose {nearest(name, symbols())}")
            low, high = symbols()[name].bounds if pair is None else map(float, pair)
            if not low < high:
                raise ValueError(f"{name} is free in ({low:g}, {high:g}); the first bound must be below the second")
            for bound in (low, high):
                if not symbols()[name].contains(bound):
                    raise ValueError(f"{name} has the bound {bound:g}; it must lie in {symbols()[name].domain}")
            self.bounds[name] = low, high

    def insert(self, parameters: Parameters, raw: Float[Array, " free"]) -> Parameters:
        """The parameters with free ones at low + (high - low) sigma(raw), so that any `raw` lies within the bounds."""
        values = [
            low + (high - low) / (1 + jnp.exp(-x)) for x, (low, high) in zip(raw, self.bounds.values(), strict=True)
        ]
        return eqx.tree_at(lambda p: [getattr(p, name) for name in self.bounds], parameters, values)
