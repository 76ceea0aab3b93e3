"""Everything that is shown to a locust: renderers in JAX, pure functions of array parameters.

Each family is called as `family(eye, *, ...)` and returns a `Stimulus`. Numbers may be traced, so that a family jits,
vmaps and differentiates; what shapes the result (window, names, number of checks) is plain Python.

`encounters(eye, key, count)` draws clips by chance from these families, as a camera delivers them: collisions of dark
objects with the time to contact, and as many clips without one.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
