"""What the library is meant to keep to in speed and memory, and whether this run bears it out."""

import dataclasses
from collections.abc import Iterator

from benchmarks._task import LARGE, ROBOT, SMALL


@dataclasses.dataclass(frozen=True)
class Claim:
    """Something measured that may be at most `bound`."""

    text: str
    measured: float
    bound: float

    @property
    def holds(self) -> bool:
        return self.measured <= self.bound


def claims(run) -> Iterator[Claim]:
    """All claims for which what they compare was measured. `run` has `ratio(a, b, size)` and `memory`."""
    wanted = [
        *[("jacobian", "forward soft", size, 3.2) for size in (LARGE, SMALL)],
        *[("gradient", "forward soft", size, 3.5) for size in (LARGE, SMALL)],
        *[(f"forward {kind}, mechanisms", f"forward {kind}", SMALL, 1.35) for kind in ("hard", "soft")],
        ("jacobian, mechanisms", "forward soft", SMALL, 4.5),
        ("forward hard, habituation", "forward hard", SMALL, 1.35),
        ("jacobian, habituation", "forward soft", SMALL, 4.5),
        *[("forward hard", "numba loop", size, 0.8) for size in (LARGE, ROBOT, SMALL)],
        ("batch, best", "numba loop", SMALL, 1.0),
        *[("forward hard", "PyTorch", size, 1 / 3) for size in (LARGE, ROBOT, SMALL)],
        *[("gradient", "PyTorch gradient", size, 1 / 3) for size in (LARGE, ROBOT, SMALL)],
        *[("forward hard", "OpenCV + NumPy", size, 1 / 2) for size in (LARGE, ROBOT, SMALL)],
        ("batch, best", "forward hard", SMALL, 1.2),
        # What the docstring of LGMD2 tells users to write, whether or not it is the best way.
        ("batch, vmap", "forward hard", SMALL, 1.2),
        ("sweep, stimuli included", "forward hard", SMALL, 1.15),
    ]
    for subject, other, size, bound in wanted:
        measured = run.ratio(subject, other, size)
        if measured is not None:
            yield Claim(f"{subject} : {other}, {size}", measured, bound)
    long, short = run.memory.get(("exact", 6000)), run.memory.get(("exact", 60))
    if long and short:
        yield Claim("memory of the gradient, 6,000 : 60 frames of 240x320", long.temporary / short.temporary, 1.2)
