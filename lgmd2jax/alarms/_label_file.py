"""Labelled clips, read from a TOML file: recorded ones beside it, and rendered ones whose geometry is their label."""

import dataclasses
import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Literal, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from lgmd2jax._arguments.checked import checked
from lgmd2jax._eye import Eye
from lgmd2jax._files.catalogue import read_named
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._protocol.protocol import eye_of
from lgmd2jax._schemas.check import check, check_kind
from lgmd2jax._schemas.labels import LABELS
from lgmd2jax._signals import stretches
from lgmd2jax._video.clip import Clip, open_clip, window_of
from lgmd2jax._video.field import field_remark
from lgmd2jax._video.recording import Timeline
from lgmd2jax._video.remarks import warn
from lgmd2jax._words import is_refusal, within
from lgmd2jax.alarms._clip import ClipLabels, LabelledClip, check_stretches, labels_of
from lgmd2jax.alarms._decoding import decode
from lgmd2jax.alarms._evaluation import Evaluation, evaluate
from lgmd2jax.alarms._reasons import Drive
from lgmd2jax.alarms._streaming import streamed_evidence
from lgmd2jax.stimuli import Encounter, encounters, films

_SETTLE = 10  # frames at the beginning of a recorded clip that are not judged: the network comes to rest
_SETTLE_MS = 333.0  # the same of a rendered one, whatever its frame rate
_GRACE_MS = 1000.0  # after contact nothing is judged: the camera jolts


@checked
@dataclasses.dataclass(frozen=True)
class Rendering:
    """Which clips to render: how many, from which seed and world, and how time to contact becomes a label.

    - `world`: `"encounters"`, single objects before a screen, or `"films"`, which have the statistics of real ones.
    - `duration_ms`: of a clip; by default 3,000 of an encounter and 5,600 of a film.
    - `alarm_below_ms`: an alarm is wanted while contact is nearer than that, on a collision course of a dark object.
    - `silent_above_ms`: silence is wanted while it is further away than that; between the two nothing is judged.
    """

    count: int
    seed: int = 0
    world: Literal["encounters", "films"] = "encounters"
    duration_ms: float | int | None = None
    alarm_below_ms: float | int = 1000.0
    silent_above_ms: float | int = 2000.0

    def __post_init__(self):
        if not (isinstance(self.count, int) and self.count >= 1):
            raise ValueError(f"count is {self.count!r}; give a whole number of clips, 1 or more")
        if not 0 < self.alarm_below_ms <= self.silent_above_ms:
            raise ValueError(
                f"alarm_below_ms is {self.alarm_below_ms:g} and silent_above_ms {self.silent_above_ms:g}; "
                "give positive times, the first at most as long as the second"
            )

    @checked
    def clips(self, eye: Eye) -> Iterator[LabelledClip]:
        """Render the clips for an eye, one by one, with their labels."""
        world = {"encounters": encounters, "films": films}[self.world]
        lasts = {} if self.duration_ms is None else {"duration_ms": self.duration_ms}
        shown = world(eye, jax.random.key(self.seed), self.count, **lasts)
        for number, encounter in enumerate(shown):
            yield self.labelled(f"{number:03d} {encounter.kind}", encounter)

    def labelled(self, name: str, encounter: Encounter) -> LabelledClip:
        """A rendered clip with its labels."""
        left = np.asarray(encounter.time_to_contact_ms)
        count = len(left)
        judged = np.asarray(encounter.stimulus.time) >= _SETTLE_MS
        contact = None
        if np.isfinite(left[-1]):
            contact = count - 1 + round(float(left[-1]) * encounter.stimulus.fps / 1000)
        clip = LabelledClip.of(
            name,
            np.asarray(encounter.stimulus.frames).astype(np.uint8),
            encounter.stimulus.fps,
            windows=stretches(judged & (left <= self.alarm_below_ms)),
            silent=stretches(judged & (left > self.silent_above_ms)),
            contact=contact,
        )
        return dataclasses.replace(clip, source=None)


@dataclasses.dataclass(frozen=True)
class LabelFile:
    """The content of a file of labelled clips: the eye that they are sampled with, recorded clips, what to render."""

    name: str
    eye: Eye
    clips: tuple[dict[str, Any], ...]
    rendered: Rendering | None
    folder: Path

    @checked
    def load(self, progress: Callable[[Iterable], Iterable] = iter) -> tuple[LabelledClip, ...]:
        """All clips, recorded ones first. `progress` wraps the loop over them; what is rendered counts as one.

        All recorded clips are opened and their labels checked before the first is decoded, as many at a time as there
        are cores.

        **Raises:** `ValueError` that names all clips whose files or labels are wrong.
        """
        pool = ThreadPoolExecutor(os.cpu_count())
        try:
            with within(f"{self.folder / self.name}.toml"):
                sources = [
                    *(pool.submit(opened.labelled) for opened in self._opened()),
                    *([] if self.rendered is None else [self.rendered]),
                ]
                return tuple(clip for source in progress(sources) for clip in self._clips_of(source))
        finally:
            pool.shutdown(cancel_futures=True)

    @checked
    def evaluate(self, model: LGMD2) -> Evaluation:
        """Run a model over all clips, recorded ones first, as `evaluate(model, file.load())` does.

        Recorded clips are decoded while they are judged, so that memory does not grow with their length. The
        evaluation holds their labels, and no frames.

        **Raises:** `ValueError` that names all clips whose files or labels are wrong.
        """
        with within(f"{self.folder / self.name}.toml"):
            streamed = [clip.judged(model) for clip in self._opened()]
            rendered = () if self.rendered is None else tuple(self.rendered.clips(self.eye))
        clips, traces, drives = zip(*streamed, strict=True) if streamed else ((), (), ())
        if not rendered:
            return Evaluation(clips, traces, float(model.parameters.T_sp), drives)
        others = evaluate(model, rendered)
        return Evaluation((*clips, *others.clips), (*traces, *others.evidence), others.T_sp, (*drives, *others.drives))

    def _clips_of(self, source: "Future[LabelledClip] | Rendering") -> Iterator[LabelledClip]:
        if isinstance(source, Rendering):
            yield from source.clips(self.eye)
        else:
            yield source.result()

    def _opened(self) -> list["_Opened"]:
        opened, faults = [], []
        for table in self.clips:
            try:
                opened.append(_Opened.of(table, self))
            except (ValueError, OSError) as fault:
                if not isinstance(fault, OSError) and not is_refusal(fault):
                    raise
                faults.append(str(fault))
        if faults:
            raise ValueError("; ".join(faults))
        for remark, names in _by_remark(opened, self.eye).items():
            warn(f"{', '.join(names)}: {remark}")
        return opened


@checked
def load_labels(source: str | Path) -> LabelFile:
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
    contact = 174               # the frame in which something is hit, perhaps one after the clip's end
    source = "dashcam of May"   # clips of one source are left out together; by default each is a source of its own
    weight = 1                  # how much an error on this clip counts in a fit
    drop_duplicates = true      # for a file whose frame rate was converted
    crop = ":,36:397"           # rows and columns to use
    # before_ms = [1000, 0]     # instead of alarm: from so long before contact to so long before it
    # fps = 30, name = "crash", resize = 108, white = 4095, until_damage = true, grace_ms = 1000, settle = 10

    [rendered]                  # clips to render; their label is the time to contact by geometry
    count = 100
    seed = 0
    world = "films"             # with the statistics of real films; "encounters" are objects before a screen
    alarm_below_ms = 1000
    silent_above_ms = 2000
    ```

    **Raises:** `ValueError`, which names file, clip and key, for what is no such file; `FileNotFoundError`.
    """
    return read_named(source, "stimuli", label_file)


def label_file(path: Path, table: dict[str, Any]) -> LabelFile:
    """The labelled clips that a TOML file describes.

    **Raises:** `ValueError`, which names clip and key, for what is no such file.
    """
    check_kind(table, "labels")
    check(LABELS, table)
    clips, rendering = table.get("clip", []), table.get("rendered")
    if not (clips or rendering):
        raise ValueError("there are no clips; list recorded ones under [[clip]], or ask for [rendered] ones")
    folder = path.parent.resolve()
    for number, clip in enumerate(clips):
        if not clip["file"].strip():
            raise ValueError(f"clip[{number}].file is {clip['file']!r}; give a video, or a folder of pictures")
        if not (place := folder / clip["file"]).exists():
            raise ValueError(f"clip[{number}].file: there is no {place}; give a path from the folder of this file")
        if {"alarm", "before_ms"} <= clip.keys():
            raise ValueError(f"clip[{number}]: alarm and before_ms are both given; give one")
    return LabelFile(
        path.stem, eye_of(table["eye"]), tuple(clips), Rendering(**rendering) if rendering else None, folder
    )


class _Opened(NamedTuple):
    """A recorded clip that is not decoded yet, with its table of the file."""

    table: dict[str, Any]
    place: Path
    clip: Clip

    @classmethod
    def of(cls, table: dict[str, Any], file: LabelFile) -> "_Opened":
        """Open a clip of the file; its labels are checked as far as they can be before it is decoded."""
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
        opened = cls(table, place, clip)
        opened.check_labels(clip.most)
        return opened

    @property
    def name(self) -> str:
        """As the file says, else the clip's."""
        return self.table.get("name", self.place.stem)

    def check_labels(self, count: int | None) -> None:
        """Raise `ValueError` for what is no label: labels are frames of the file, repeated ones included.

        `count`: how many frames there are, or are at most, where that is known.
        """
        name, table = self.name, self.table
        contact, last = table.get("contact"), math.inf if count is None else count - 1
        check_stretches(name, last, {kind: table.get(kind) or [] for kind in ("alarm", "silent")}, contact)
        if (before := table.get("before_ms")) is not None:
            if contact is None:
                raise ValueError(f"{name}: before_ms counts back from contact, which is missing; give its frame")
            if not before[0] > before[1]:
                raise ValueError(f"{name}: before_ms is {before!r}; give two times before contact, as [1000, 0]")

    @property
    def drops_duplicates(self) -> bool:
        """Whether repeated frames are left out."""
        return bool(self.table.get("drop_duplicates", False))

    def labelled(self) -> LabelledClip:
        """The clip with its labels, decoded."""
        options = self.table.get("white"), self.table.get("until_damage")
        film = decode(self.clip, self.place, self.drops_duplicates, options)
        return LabelledClip(**vars(self._labels(film)), frames=film.frames)

    def judged(self, model: LGMD2) -> tuple[ClipLabels, Float[np.ndarray, " time"], Drive]:
        """The labels of the clip, the evidence and what acts on the cell in its frames, which are freed one by one."""
        clip = self.clip.without_repeats() if self.drops_duplicates else self.clip
        film, trace, drive = streamed_evidence(model, clip)
        return self._labels(film), trace, drive

    def _labels(self, film: Timeline) -> ClipLabels:
        table = self.table
        self.check_labels(film.count)
        contact, windows, silent = table.get("contact"), table.get("alarm", []), table.get("silent")
        if contact is not None and "before_ms" in table:
            windows = [self._before(table["before_ms"], film.time_of(contact), film)]
        if silent is None:
            grace = -1
            if contact is not None:
                grace = film.frame_at(film.time_of(contact) + table.get("grace_ms", _GRACE_MS))
            silent = _rest(windows, table.get("settle", _SETTLE), contact, grace, film.count - 1)
        clock = film.fps, film.index, film.time, film.interval, film.count
        labels = labels_of(self.name, *clock, windows=windows, silent=silent, contact=contact)
        source, weight = table.get("source", self.name), float(table.get("weight", 1))
        return dataclasses.replace(labels, source=source, weight=weight)

    def _before(self, before: list, contact_ms: float, film: Timeline) -> tuple[int, int]:
        if (missing := contact_ms - before[0] - film.time[-1]) > 0:
            raise ValueError(
                f"{self.name}: before_ms is {before!r}, but the clip ends {before[0] + missing:.0f} ms before contact; "
                "give a longer time, or an earlier contact"
            )
        first, last = (film.frame_at(contact_ms - lead) for lead in before)
        return first, last


def _by_remark(clips: Sequence[_Opened], eye: Eye) -> dict[str, list[str]]:
    """What is to be said of the fields of clips, with the names of those of which it is."""
    names: dict[str, list[str]] = {}
    for clip in clips:
        if remark := field_remark(clip.clip.size, clip.clip.window, clip.clip.shape, eye):
            names.setdefault(remark, []).append(clip.name)
    return names


def _rest(
    windows: Sequence[Sequence[int]], settle: int, contact: int | None, grace: int, last: int
) -> list[tuple[int, int]]:
    """All frames from `settle` on but those in windows and those in the grace time."""
    judged = np.arange(last + 1) >= settle
    for first, end in windows:
        judged[first : end + 1] = False
    if contact is not None:
        judged[contact : grace + 1] = False
    return stretches(judged)
