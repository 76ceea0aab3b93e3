"""Whether what README.md and docs/figures.md state of the arena is still of these detectors and of this world.

Where a test here fails, run `lgmd2jax arena --seeds 100 --figure fits/arena/trajectories.png`, write its figures into
both and into the notebook arena, and then what the tests compare with.
"""

import hashlib

import numpy as np

from lgmd2jax._network.structure import structure_of
from lgmd2jax.arena import FrameDifference, NetworkDetector, detectors, run

# Of the settings with which the figures were measured.
MEASURED = {
    "table1": "ca59ad9a58eb",
    "lgmd2": "d8e0e9919e7c",
    "lgmd1": "fe434d664dbd",
    "difference": "b00b443ce811",
}
FRAMES_OF_ALARMS = [6, 60, 95, 141, 170, 200]


def digest(detector):
    """Of all that decides what a detector does, in six digits."""
    if isinstance(detector, FrameDifference):
        known = {"threshold": detector.threshold}
    else:
        assert isinstance(detector, NetworkDetector)
        network = detector.network
        acting = {name: value for name, value in vars(network.parameters).items() if name not in network.unused}
        known = acting | structure_of(network) | {"eye": str(network.eye)}
    numbers = {name: f"{float(value):.6g}" for name, value in known.items() if hasattr(value, "dtype")}
    text = [f"{name} {value}" for name, value in sorted((known | numbers).items())]
    return hashlib.sha256("\n".join(text).encode()).hexdigest()[:12]


def test_the_detectors_are_those_that_were_measured():
    assert {name: digest(it) for name, it in detectors().items() if name != "none"} == MEASURED


def test_the_first_alarms_of_a_robot_come_when_they_came():
    """In one arena: the world, the camera and the network are those that were measured."""
    _, trips = run(detectors()["lgmd2"], [0], seconds=8.0)
    np.testing.assert_allclose(np.flatnonzero(trips.alarm[0]), FRAMES_OF_ALARMS, atol=1)
