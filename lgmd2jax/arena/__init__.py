"""The paper's arena: a robot that drives among obstacles, turns at an alarm, and runs into what it did not see coming.

`run(detector, seeds)` drives a robot in an arena for each seed; `Outcome.of` counts collisions and coverage;
`detectors()` are those that `lgmd2jax arena` compares.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
