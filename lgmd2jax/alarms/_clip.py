"""A clip with its labels: when an alarm is right, and when it must not be raised."""

import dataclasses
import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Bool, Float, Int, Real

from lgmd2jax._arguments.checked import checked
from lgmd2jax._video.recording import time_of

Stretch = tuple[int, int]  # first and last frame, as they are counted in the file


@dataclasses.dataclass(frozen=True)
class ClipLabels:
    """The stretches of a clip in which an alarm is wanted, or silence. Frames that lie in neither are not judged.

    - `name`: of the clip.
    - `fps`: frames per second, after repeated frames were dropped.
    - `index`, `time`: where each frame stands in the file, and when, in ms.
    - `interval`: ms since the frame before, for the model's time constants.
    - `windows`: stretches in each of which an alarm must be raised.
    - `silent`: stretches in which none may be.
    - `contact`: the frame of the file in which something is hit, perhaps one after its end; None where nothing is.
    - `source`: where the clip comes from. Clips of one source are alike, so that they are left out together; None for
      a rendered clip, which is never left out.
    - `weight`: how much an error on this clip counts in a fit.
    """

    name: str
    fps: float
    index: Int[np.ndarray, " time"]
    time: Float[np.ndarray, " time"]
    interval: Float[np.ndarray, " time"]
    windows: tuple[Stretch, ...] = ()
    silent: tuple[Stretch, ...] = ()
    contact: int | None = None
    source: str | None = None
    weight: float = 1.0

    def in_windows(self) -> Bool[np.ndarray, "window time"]:
        """Which frames lie in each window."""
        return np.array([self._within(window) for window in self.windows], bool).reshape(
            len(self.windows), len(self.index)
        )

    def in_silence(self) -> Bool[np.ndarray, " time"]:
        """Which frames must be silent."""
        return np.any([np.zeros(len(self.index), bool), *(self._within(stretch) for stretch in self.silent)], axis=0)

    @property
    def contact_ms(self) -> float | None:
        """When something is hit, in ms, perhaps after the clip's end."""
        return None if self.contact is None else time_of(self.contact, self.index, self.time)

    @property
    def silent_minutes(self) -> float:
        """How long the clip must be silent."""
        return float(self.interval[self.in_silence()].sum()) / 60_000

    def _within(self, stretch: Stretch) -> Bool[np.ndarray, " time"]:
        return (self.index >= stretch[0]) & (self.index <= stretch[1])


@checked
@dataclasses.dataclass(frozen=True)
class LabelledClip(ClipLabels):
    """A clip with its labels, whose fields are those of `ClipLabels`, and

    - `frames`: grey levels 0..255; 8-bit integers where they are whole.
    """

    frames: Real[np.ndarray, "time row col"] = dataclasses.field(kw_only=True)

    @classmethod
    @checked
    def of(
        cls,
        name: str,
        frames: Real[np.ndarray, "time row col"],
        fps: float | int,
        *,
        windows: Sequence[Sequence[int]] = (),
        silent: Sequence[Sequence[int]] = (),
        contact: int | None = None,
        index: Int[np.ndarray, " time"] | None = None,
        time: Float[np.ndarray, " time"] | None = None,
        interval: Float[np.ndarray, " time"] | None = None,
        count: int | None = None,
        source: str | None = None,
        weight: float | int = 1.0,
    ) -> "LabelledClip":
        """A clip of your own with its labels.

        ```python
        LabelledClip.of("crash", frames, 30.0, windows=[(149, 175)], silent=[(10, 120)], contact=174)
        ```

        **Arguments:** as the fields; stretches are pairs of first and last frame, counted from 0. Without `index` and
        `time` the frames are taken to be all of the file's. Without `interval` it follows from the times. Without
        `source` the name is the source.

        - `count`: how many frames the file holds, where the last ones were dropped as repeats.

        **Raises:** `ValueError` for stretches that are reversed, overlap or lie outside of the clip, for frames with
        NaN or with a mask, and for a weight that is not positive.
        """
        if not (np.isfinite(weight) and weight > 0):
            raise ValueError(f"{name}: weight is {weight!r}; give a positive number")
        if np.ma.isMaskedArray(frames) or not np.isfinite(frames).all():
            raise ValueError(f"{name}: frames holds NaN, infinite or masked pixels; fill them first")
        index = np.arange(len(frames)) if index is None else index
        if interval is None:
            usual = 1000.0 / fps
            interval = np.full(len(index), usual) if time is None else np.diff(time, prepend=time[0] - usual)
        time = index * (1000.0 / fps) if time is None else time
        count = int(index[-1]) + 1 if count is None else count
        labels = labels_of(name, fps, index, time, interval, count, windows=windows, silent=silent, contact=contact)
        labels = dataclasses.replace(labels, source=name if source is None else source, weight=float(weight))
        return cls(**vars(labels), frames=frames)


def labels_of(
    name: str,
    fps: float | int,
    index: Int[np.ndarray, " time"],
    time: Float[np.ndarray, " time"],
    interval: Float[np.ndarray, " time"],
    count: int,
    *,
    windows: Sequence[Sequence[int]] = (),
    silent: Sequence[Sequence[int]] = (),
    contact: int | None = None,
) -> ClipLabels:
    """The labels of a clip, checked.

    **Arguments:** as the fields of `ClipLabels`; stretches are pairs of first and last frame. `count`: how many frames
    the file holds, repeated ones included.

    **Raises:** `ValueError` for stretches that are reversed, overlap, lie outside of the clip or hold repeats alone.
    """
    check_stretches(name, count - 1, {"alarm": windows, "silent": silent}, contact)
    labels = ClipLabels(name, float(fps), index, time, interval, _pairs(windows), _pairs(silent), contact)
    for window, inside in zip(labels.windows, labels.in_windows(), strict=True):
        if not inside.any():
            raise ValueError(f"{name}: alarm {window[0]} to {window[1]} holds only repeated frames; widen it")
    return labels


def _pairs(stretches: Sequence[Sequence[int]]) -> tuple[Stretch, ...]:
    return tuple((int(first), int(last)) for first, last in stretches)


def check_stretches(
    name: str, last: float | int, kinds: Mapping[str, Sequence[Sequence[int]]], contact: int | None
) -> None:
    """Raise `ValueError` for a stretch that is reversed, lies outside of frames 0 to `last`, or meets another one.

    Also for a contact before the first window in which an alarm is wanted.
    """
    labels = []
    for kind, pairs in kinds.items():
        for pair in pairs:
            if np.shape(pair) != (2,) or not all(isinstance(frame, (int, np.integer)) for frame in pair):
                raise ValueError(f"{name}: {kind} holds {pair!r}; write pairs of frames, as [[149, 175]]")
            first, end = pair
            if first > end:
                raise ValueError(f"{name}: {kind} {first} to {end} is reversed; write the first frame first")
            if first < 0 or end > last:
                raise ValueError(
                    f"{name}: {kind} {first} to {end} lies outside of the clip, whose frames are 0 to {last}"
                )
            labels.append((first, end, kind))
    labels.sort()
    alarm = min((first for first, _, kind in labels if kind == "alarm"), default=None)
    if contact is not None and alarm is not None and contact < alarm:
        raise ValueError(f"{name}: contact is frame {contact}, before an alarm is wanted, from {alarm} on; correct one")
    for (_, end, kind), (first, _, other) in itertools.pairwise(labels):
        if first <= end:
            raise ValueError(f"{name}: {kind} up to {end} and {other} from {first} overlap; shorten one of them")
