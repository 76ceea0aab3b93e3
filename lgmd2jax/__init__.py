"""The LGMD2 collision detector of juvenile locusts, differentiable in JAX: `import lgmd2jax as lgmd`."""

import lazy_loader

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str):
    """A public name, loaded when first used; an old one with a warning; `__version__`, which pyproject.toml states."""
    if name == "__version__":
        from importlib.metadata import version

        return version(__name__)
    if name == "Network":
        from lgmd2jax._words import warn_renamed

        warn_renamed("lgmd2jax.Network", "lgmd2jax.AbstractNetwork")
        return _load("AbstractNetwork")
    return _load(name)
