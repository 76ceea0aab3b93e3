"""Labelled clips, read from a TOML file: recorded ones beside it, and rendered ones whose geometry is their label."""

import dataclasses
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import jax
import numpy as np

from lgmd2jax._eye import Eye
from lgmd2jax._files.catalogue import read_named
from lgmd2jax._protocol.arguments import check_keys, section
from lgmd2jax._protocol.protocol import eye_of
from lgmd2jax._signals import stretches
from lgmd2jax._video.clip import open_clip, window_of
from lgmd2jax.alarms._decoded import Decoded, decoded
from lgmd2jax.alarms._footage import Footage, check_stretches, footage
from lgmd2jax.stimuli import Encounter, encounters

_CLIP = ("name", "file", "fps", "resize", "crop", "drop_duplicates", "alarm", "silent", "contact", "before_ms")
_CLIP += ("grace_ms", "settle")
_SETTLE = 10  # frames at the beginning of a clip that are not judged: the network comes to rest
_GRACE_MS = 1000.0  # after contact nothing is judged: the camera jolts


@dataclasses.dataclass(frozen=True)
class Rendered:
    """Which clips to render: how many, from which seed, and how time to contact becomes a label.

    - `alarm_below_ms`: an alarm is wanted while contact is nearer than that, on a collision course of a dark object.
    - `silent_above_ms`: silence is wanted while it is further away than that; between the two nothing is judged.
    """

    count: int
    seed: int = 0
    duration_ms: float | int = 3000.0
    alarm_below_ms: float | int = 1000.0
    silent_above_ms: float | int = 2000.0

    def __post_init__(self):
        if not (isinstance(self.count, int) and self.count >= 1):
            raise ValueError(f"count is {self.count!r}; give a whole number of clips, 1 or more")
        if not 0 < self.alarm_below_ms <= self.silent_above_ms:
            raise ValueError(
                f"alarm_below_ms is {self.alarm_below_ms:g} and silent_above_ms {self.silent_above_ms:g}; "
                "let both be positive and the first not the larger"
            )


@dataclasses.dataclass(frozen=True)
class FootageFile:
    """What a file of labelled clips holds: the eye that they are seen with, recorded clips, and what to render."""

    name: str
    eye: Eye
    clips: tuple[dict[str, Any], ...]
    rendered: Rendered | None
    folder: Path

    def load(self, progress: Callable[[Iterable], Iterable] = iter) -> tuple[Footage, ...]:
        """All clips, recorded ones first. `progress` wraps the loop over them."""
        jobs: list[Callable[[], Iterator[Footage]]] = [lambda it=it: iter([_recorded(it, self)]) for it in self.clips]
        if self.rendered is not None:
            jobs.append(lambda: rendered(self.eye, self.rendered))
        return tuple(clip for job in progress(jobs) for clip in job())


def load_footage(source: str | Path) -> FootageFile:
    """Read a file of labelled clips, or a shipped one by its bare name.

    ```toml
    [eye]                       # what the clips are resized to, and what the model then belongs to
    rows = 60
    cols = 108
    degrees_per_pixel = 0.65
    fps = 30
    projection = "pinhole"

    [[clip]]                    # as many as wanted; frames are counted from 0, as in the file
    file = "crash.mp4"          # beside this file; any video that ffmpeg reads, or a folder of images
    alarm = [[149, 175]]        # in each of these an alarm must be raised; leave it out where all must be silent
    silent = [[10, 120]]        # by default all else but the first 10 frames and a grace time after contact
    contact = 174               # the frame in which something is hit
    drop_duplicates = true      # for a file whose frame rate was converted
    crop = ":,36:397"           # rows and columns to use
    # before_ms = [1000, 0]     # instead of alarm: from so long before contact to so long before it
    # fps = 30, name = "crash", resize = 108, grace_ms = 1000, settle = 10

    [rendered]                  # clips without end; their label is the time to contact by geometry
    count = 100
    seed = 0
    alarm_below_ms = 1000
    silent_above_ms = 2000
    ```

    **Raises:** `ValueError`, which names file, clip and key, for what is no such file; `FileNotFoundError`.
    """
    return read_named(source, "stimuli", footage_file)


def rendered(eye: Eye, wanted: Rendered | None) -> Iterator[Footage]:
    """Rendered clips with their labels."""
    if wanted is None:
        return
    clips = encounters(eye, jax.random.key(wanted.seed), wanted.count, duration_ms=wanted.duration_ms)
    for number, encounter in enumerate(clips):
        yield labelled(f"{number:03d} {encounter.kind}", encounter, wanted)


def labelled(name: str, encounter: Encounter, how: Rendered) -> Footage:
    """A rendered clip with the labels that its time to contact gives."""
    left = np.asarray(encounter.time_to_contact_ms)
    count = len(left)
    judged = np.arange(count) >= _SETTLE
    frames = np.asarray(encounter.stimulus.frames).astype(np.uint8)
    windows = stretches(judged & (left <= how.alarm_below_ms))
    silent = stretches(judged & (left > how.silent_above_ms))
    contact = None
    if np.isfinite(left[-1]):
        contact = count - 1 + round(float(left[-1]) * encounter.stimulus.fps / 1000)
    return footage(name, frames, encounter.stimulus.fps, windows=windows, silent=silent, contact=contact)


def footage_file(path: Path, table: dict[str, Any]) -> FootageFile:
    """What a TOML file of labelled clips holds.

    **Raises:** `ValueError`, which names clip and key, for what is no such file.
    """
    check_keys(table, ("eye", "clip", "rendered"))
    folder = path.parent.resolve()
    eye, clips = eye_of(section(table, "eye"), folder), table.get("clip", [])
    if not (isinstance(clips, list) and all(isinstance(it, dict) for it in clips)):
        raise ValueError("clip is not a list of tables; write each under [[clip]]")
    names = [field.name for field in dataclasses.fields(Rendered)]
    wanted = section(table, "rendered", names)
    if not clips and not wanted:
        raise ValueError("no clips; write each under [[clip]], or ask for some under [rendered]")
    for number, clip in enumerate(clips, start=1):
        check_keys(clip, _CLIP)
        if not isinstance(clip.get("file"), str):
            raise ValueError(f"clip {number}: file is missing")
        if not (place := folder / clip["file"]).exists():
            raise ValueError(f"clip {number}: there is no {place}; labels need their clip")
        if {"alarm", "before_ms"} <= clip.keys():
            raise ValueError(f"clip {number}: alarm and before_ms are both given; give one")
    return FootageFile(path.stem, eye, tuple(clips), Rendered(**wanted) if wanted else None, folder)


def _recorded(table: dict[str, Any], file: FootageFile) -> Footage:
    """A clip of the file with its labels."""
    place = file.folder / table["file"]
    name = table.get("name", place.stem)
    crop = None if "crop" not in table else window_of(table["crop"])
    clip = open_clip(place, fps=table.get("fps"), crop=crop, resize=table.get("resize", file.eye.cols))
    seen = decoded(clip, place, bool(table.get("drop_duplicates", False)))
    last = int(seen.index[-1])
    contact = table.get("contact")
    if contact is not None and not (isinstance(contact, int) and 0 <= contact <= last):
        raise ValueError(f"{name}: contact is {contact!r}; give a frame of 0 to {last}")
    windows = table.get("alarm", [])
    if "before_ms" in table:
        windows = [_before(name, table["before_ms"], contact, seen)]
    silent = table.get("silent")
    if silent is None:
        check_stretches(name, last, {"alarm": windows})
        grace = seen.frame_at(seen.time_of(contact) + table.get("grace_ms", _GRACE_MS)) if contact is not None else -1
        silent = _rest(windows, table.get("settle", _SETTLE), contact, grace, last)
    return footage(
        name, seen.frames, seen.fps, windows=windows, silent=silent, contact=contact, index=seen.index, time=seen.time
    )


def _before(name: str, before: Any, contact: int | None, seen: Decoded) -> tuple[int, int]:
    if contact is None:
        raise ValueError(f"{name}: before_ms counts from contact, which is not given; give its frame")
    if not (isinstance(before, list) and len(before) == 2 and before[0] > before[1] >= 0):
        raise ValueError(f"{name}: before_ms is {before!r}; give two times before contact, as [1000, 0]")
    first, last = (seen.frame_at(seen.time_of(contact) - it) for it in before)
    return first, last


def _rest(
    windows: list[list[int]] | list[tuple[int, int]], settle: int, contact: int | None, grace: int, last: int
) -> list[tuple[int, int]]:
    """All frames from `settle` on but those in windows and those in the grace time."""
    judged = np.arange(last + 1) >= settle
    for first, end in windows:
        judged[first : end + 1] = False
    if contact is not None:
        judged[contact : grace + 1] = False
    return stretches(judged)
