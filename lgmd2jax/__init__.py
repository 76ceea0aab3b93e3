"""The LGMD2 collision detector of juvenile locusts, differentiable in JAX: `import lgmd2jax as lgmd`."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
