"""A video file through ffmpeg (PyAV): its frames in order, each with its time stamp."""

import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lgmd2jax._pyav import open_container, pyav
from lgmd2jax._video.orientation import Orientation
from lgmd2jax._video.remarks import warn
from lgmd2jax._video.video_pixels import Scaler, VideoPixels

_NO_TIME_STAMPS = 0x80  # AVFMT_NOTIMESTAMPS: what ffmpeg says of such a file's rate is its own default of 25
_COVER = 0x400  # AV_DISPOSITION_ATTACHED_PIC: the picture of a sound file
_HDR: dict[int | None, str] = {16: "PQ", 18: "HLG"}  # by ffmpeg's numbers of transfer curves (AVCOL_TRC)
_PEEK = 300  # packets by which the usual interval is known


class VideoFile:
    """The first video of a file.

    - `fps`: the frame rate that the time stamps keep, else the one that the file states, or None.
    - `count`: the number of frames that it announces, or None.
    - `remarks`: what a user should know.

    Iteration gives the pixels of each frame, with its time stamp in ms after the first, or None.
    """

    def __init__(self, path: Path, white: float | int | None = None, until_damage: bool = False):
        self.path = path
        self._white = white
        self._until_damage = until_damage
        with self._opened() as container:
            streams = [stream for stream in container.streams.video if not stream.disposition.value & _COVER]
            stream = (streams or container.streams.video)[0]
            self._number = stream.index
            self._has_stamps = not container.format.flags & _NO_TIME_STAMPS
            # Matroska counts its duration from 0, wherever the first frame stands.
            self._from_zero = "matroska" in container.format.name
            self._is_avi = container.format.name == "avi"
            self._aspect = float(stream.sample_aspect_ratio or 1)
            self._seconds = _announced_seconds(container, stream)
            self.count = stream.frames or None
            self.remarks = (f"it holds {len(streams)} videos; the first is used",) if len(streams) > 1 else ()
            if (curve := _HDR.get(getattr(stream.codec_context, "color_trc", None))) is not None:
                self.remarks += (
                    f"its levels are coded for HDR ({curve}), in which contrasts are others than in usual video; "
                    "convert it to that first (tone mapping)",
                )
            self.fps = self._rate(container, stream)

    def __iter__(self) -> Iterator[tuple[VideoPixels, float | None]]:
        from av.error import FFmpegError

        scaler, count, first, last, end = Scaler(), 0, 0.0, 0.0, 0.0
        with self._opened() as container:
            stream = next(stream for stream in container.streams.video if stream.index == self._number)
            stream.thread_type = "AUTO"
            try:
                for frame in container.decode(stream):
                    if frame.is_corrupt and count == 0:
                        continue  # a recording that was cut between two key frames
                    if frame.is_corrupt:
                        self._damaged(f"frame {count} is incomplete")
                        return
                    stamp = None
                    if self._has_stamps and frame.time is not None:
                        first = frame.time if count == 0 else first
                        last = frame.time - first
                        end = last + float((frame.duration or 0) * (frame.time_base or 0))
                        stamp = 1000 * last
                    count += 1
                    yield VideoPixels(frame, scaler, self._orientation(frame), self._aspect, self._white), stamp
            except FFmpegError as error:
                self._damaged(error.strerror or "it cannot be decoded further")
                return
        self._check_end(count, first, last, end)

    def packets(self) -> int:
        """How many packets the video has, which are read and not decoded: no fewer than its frames."""
        with self._opened() as container:
            stream = next(stream for stream in container.streams.video if stream.index == self._number)
            return sum(packet.size > 0 for packet in container.demux(stream))

    def _check_end(self, count: int, first: float, last: float, end: float) -> None:
        """Whether the file ended where it announces its end; times in seconds."""
        if not (self._seconds and self._has_stamps and self.fps and count):
            return
        announced = self._seconds - (max(first, 0.0) if self._from_zero else 0.0)
        # An announced number of frames is exact, a duration is not.
        margin = 1.5 / self.fps if self.count else 0.02 * announced + 3 / self.fps
        if max(end, last + 1 / self.fps) < announced - margin:
            self._damaged(f"it announces {announced:.3g} s and ends after {end:.3g} s")
        elif self._is_avi and self.count and count < self.count - 1:
            # Other containers announce also the frames that a trimmed file does not show.
            warn(f"{self.path}: it announces {self.count} frames and holds {count}; their time stamps are used")

    def _damaged(self, how: str) -> None:
        if not self._until_damage:
            cure = "to use the frames before that: --until-damage (until_damage = true)"
            raise ValueError(f"{self.path} is damaged or truncated: {how}; {cure}")
        warn(f"{self.path}: it is damaged or truncated: {how}; the frames before that are used")

    def _orientation(self, frame) -> Orientation:
        """By the display matrix, for a camera that was held upright or that mirrors."""
        matrix = frame.side_data.get("DISPLAYMATRIX")
        try:
            return Orientation() if matrix is None else Orientation.of_matrix(np.frombuffer(matrix, np.int32).tolist())
        except ValueError as error:
            raise ValueError(f"{self.path} {error}") from None

    def _rate(self, container, stream) -> float | None:
        """Frames per second by the usual interval: one frame that is held for long makes the average of no use."""
        if not self._has_stamps or container.format.name.endswith("_pipe"):
            rate = stream.codec_context.framerate  # where the coded stream itself states it
            return float(rate) if rate else None
        stated = [float(rate) for rate in (stream.average_rate, stream.guessed_rate) if rate]
        usual = _usual_rate(container, stream)
        if usual is None:
            return stated[0] if stated else None
        return next((rate for rate in stated if abs(usual / rate - 1) < 0.02), usual)

    def _opened(self):
        av = pyav("reading video needs")
        try:
            # The prefix keeps ffmpeg from taking a colon in the name for a protocol.
            container = open_container(av, f"file:{self.path}")
        except PermissionError as error:
            raise ValueError(f"cannot read {self.path}: {error.strerror}") from error
        except av.error.FFmpegError as error:
            raise ValueError(f"{self.path} is not a video, or is truncated: {error.strerror}") from error
        # ffmpeg draws plain text as the screen of a terminal ("tty").
        if not container.streams.video or container.format.name == "tty":
            container.close()
            raise ValueError(f"{self.path} holds no video; give a video file or a folder of images")
        return container


def _announced_seconds(container, stream) -> float | None:
    """What the header promises. The duration of the file is that of the video where there is nothing else in it.

    A trimmed file keeps the whole stream, of which it shows less: the lesser of both counts.
    """
    promises = [stream.duration and float(stream.duration * stream.time_base)]
    if len(container.streams) == 1 or promises[0]:
        promises.append(container.duration and container.duration / 1e6)
    return min((promise for promise in promises if promise), default=None)


def _usual_rate(container, stream) -> float | None:
    """Frames per second by the usual interval between the first time stamps of a container that was just opened."""
    from av.error import FFmpegError

    stamps: set[int] = set()
    try:
        packets = itertools.islice(container.demux(stream), _PEEK)
        stamps.update(packet.pts for packet in packets if packet.pts is not None)
    except FFmpegError:
        pass  # decoding will say so
    intervals = np.diff(sorted(stamps)) * float(stream.time_base)
    if len(intervals) < 2:
        return None
    usual = np.sort(intervals)[(len(intervals) - 1) // 2]  # one that there is: none may lie near a mean of two
    # Containers round to a millisecond.
    return 1 / float(intervals[abs(intervals - usual) <= max(0.001, 0.02 * usual)].mean())
