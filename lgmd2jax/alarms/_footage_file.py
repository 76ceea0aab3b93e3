"""Labelled clips, read from a TOML file: recorded ones beside it, and rendered ones whose geometry is their label."""

import dataclasses
import math
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
from lgmd2jax._video.clip import Clip, open_clip, window_of
from lgmd2jax._video.recording import Recording
from lgmd2jax.alarms._decoded import decoded
from lgmd2jax.alarms._footage import Footage, check_stretches, footage
from lgmd2jax.stimuli import Encounter, encounters

_CLIP = ("name", "file", "fps", "resize", "crop", "drop_duplicates", "alarm", "silent", "contact", "before_ms")
_CLIP += ("grace_ms", "settle", "white", "until_damage")
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
        """All clips, recorded ones first. `progress` wraps the loop over them.

        All are opened and their labels checked before the first is decoded.

        **Raises:** `ValueError` that names all clips whose labels or files are wrong.
        """
        opened = self._opened()
        jobs: list[Callable[[], Iterator[Footage]]] = [lambda it=it: iter([_recorded(*it)]) for it in opened]
        if self.rendered is not None:
            jobs.append(lambda: rendered(self.eye, self.rendered))
        return tuple(clip for job in progress(jobs) for clip in job())

    def _opened(self) -> list[tuple[dict[str, Any], Path, Clip]]:
        opened, faults = [], []
        for table in self.clips:
            try:
                opened.append(_open(table, self))
            except (ValueError, OSError) as fault:
                faults.append(str(fault))
        if faults:
            raise ValueError("; ".join(faults))
        return opened


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
    # fps = 30, name = "crash", resize = 108, white = 4095, until_damage = true, grace_ms = 1000, settle = 10

    [rendered]                  # clips without end; their label is the time to contact by geometry
    count = 100
    seed = 0
    alarm_below_ms = 1000
    silent_above_ms = 2000
    ```

    **Raises:** `ValueError`, which names file, clip and key, for what is no such file; `FileNotFoundError`.
    """
    return read_named(source, "stimuli", _footage_file)


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


def _footage_file(path: Path, table: dict[str, Any]) -> FootageFile:
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


def _open(table: dict[str, Any], file: FootageFile) -> tuple[dict[str, Any], Path, Clip]:
    """A clip of the file, its labels checked as far as they can be before it is decoded."""
    place = file.folder / table["file"]
    crop = None if "crop" not in table else window_of(table["crop"])
    clip = open_clip(
        place,
        fps=table.get("fps"),
        crop=crop,
        resize=table.get("resize", file.eye.cols),
        white=table.get("white"),
        until_damage=bool(table.get("until_damage", False)),
    )
    _check_labels(table, _name(table), clip.count)
    return table, place, clip


def _name(table: dict[str, Any]) -> str:
    return table.get("name", Path(table["file"]).stem)


def _check_labels(table: dict[str, Any], name: str, count: int | None) -> None:
    """Labels are frames of the file, repeated ones included; `count` is their number where the file announces it."""
    contact, last = table.get("contact"), math.inf if count is None else count - 1
    if contact is not None and not (isinstance(contact, int) and 0 <= contact <= last):
        raise ValueError(f"{name}: contact is {contact!r}; give a frame of 0 to {last}")
    check_stretches(name, last, {kind: table.get(kind) or [] for kind in ("alarm", "silent")})
    if "before_ms" in table:
        before = table["before_ms"]
        if contact is None:
            raise ValueError(f"{name}: before_ms counts from contact, which is not given; give its frame")
        if not (isinstance(before, list) and len(before) == 2 and before[0] > before[1] >= 0):
            raise ValueError(f"{name}: before_ms is {before!r}; give two times before contact, as [1000, 0]")


def _recorded(table: dict[str, Any], place: Path, clip: Clip) -> Footage:
    """A clip of the file with its labels."""
    options = table.get("white"), table.get("until_damage")
    recording = decoded(clip, place, bool(table.get("drop_duplicates", False)), options)
    name, contact, last = _name(table), table.get("contact"), recording.count - 1
    _check_labels(table, name, recording.count)
    windows = table.get("alarm", [])
    if "before_ms" in table and contact is not None:
        windows = [_before(table["before_ms"], contact, recording)]
    silent = table.get("silent")
    if silent is None:
        grace = -1
        if contact is not None:
            grace = recording.frame_at(recording.time_of(contact) + table.get("grace_ms", _GRACE_MS))
        silent = _rest(windows, table.get("settle", _SETTLE), contact, grace, last)
    return footage(
        name,
        recording.frames,
        recording.fps,
        windows=windows,
        silent=silent,
        contact=contact,
        index=recording.index,
        time=recording.time,
        interval=recording.interval,
        count=recording.count,
    )


def _before(before: list, contact: int, recording: Recording) -> tuple[int, int]:
    first, last = (recording.frame_at(recording.time_of(contact) - ms) for ms in before)
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
