# The public names. `__init__.py` loads each of them when it is first used.
from ._camera import EYE as EYE, Scene as Scene, render as render
from ._detectors import (
    AbstractDetector as AbstractDetector,
    FrameDifference as FrameDifference,
    NetworkDetector as NetworkDetector,
    NoDetector as NoDetector,
)
from ._drive import Pose as Pose, Trip as Trip, drive as drive
from ._layout import Layout as Layout, random_layout as random_layout
from ._run import Start as Start, run as run, trips as trips
from ._scores import Outcome as Outcome
from ._settings import detectors as detectors
from ._training import Budget as Budget, Range as Range, Space as Space, Training as Training, train as train
