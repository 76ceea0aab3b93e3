"""A camera, a stream or a pipe, read as it runs: the newest frame waits for whoever asks, older ones are dropped."""

import errno
import sys
import threading
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from lgmd2jax._pyav import open_container, pyav
from lgmd2jax._video.orientation import Orientation
from lgmd2jax._video.video_pixels import Scaler, VideoPixels

if TYPE_CHECKING:
    from av.error import FFmpegError

_PIPE = "-"
_DRIVERS = {"linux": "v4l2", "darwin": "avfoundation", "win32": "dshow"}  # of cameras, as ffmpeg names them
# What a stream holds is told by its first bytes, and the decoder keeps no frame back.
_WITHOUT_DELAY = {"flags": "low_delay", "probesize": "32768", "analyzeduration": "100000"}
_WAKE_S = 0.2  # a wait is no longer at a time: a Ctrl-C that another thread received is seen between two


class Arrival(NamedTuple):
    """A frame when it is taken.

    - `number`: how many frames came before it, dropped ones included.
    - `arrived`: when its bytes were there, by `time.monotonic`, in s.
    - `stamp`: when it was shot, by the clock of the source, in s; None where that states none.
    - `pixels`: to be converted on demand.
    """

    number: int
    arrived: float
    stamp: float | None
    pixels: VideoPixels


class LiveSource:
    """What a source shows, by `for arrival in source`, until it ends. A thread reads; only the newest frame waits.

    - `name`: as the user gave it.
    - `fps`: what the source states, or None.
    - `dropped`: how many frames were replaced by a newer one before they were taken.
    """

    def __init__(self, name: str, container: Any, timeout: float):
        self.name, self.dropped = name, 0
        self._container, self._timeout = container, timeout
        self._stream = container.streams.video[0]
        self._stream.thread_type = "SLICE"  # threads by frames would hold some back
        self.fps = float(self._stream.average_rate) if self._stream.average_rate else None
        self._aspect = float(self._stream.sample_aspect_ratio or 1)
        self._changed = threading.Condition()
        self._newest: Arrival | None = None
        self._ended, self._closed = False, False
        self._fault: FFmpegError | None = None
        self._thread = threading.Thread(target=self._read, name=f"frames of {name}", daemon=True)

    def __enter__(self) -> "LiveSource":
        self._thread.start()
        return self

    def __exit__(self, *_) -> None:
        """Let the thread go, which closes the source. One that waits for bytes of a pipe ends with the process."""
        self._closed = True
        self._thread.join(timeout=1.0)

    def __iter__(self) -> Iterator[Arrival]:
        """The newest frame each time, and never the same twice.

        **Raises:** `ValueError` for a source that stops without an end, and for bytes that cannot be decoded.
        """
        while (arrival := self._take()) is not None:
            yield arrival

    def _take(self) -> Arrival | None:
        latest = time.monotonic() + self._timeout
        with self._changed:
            while self._newest is None and not self._ended:
                if (left := latest - time.monotonic()) <= 0:
                    raise _silent(self.name, self._timeout)
                self._changed.wait(min(left, _WAKE_S))
            arrival, self._newest = self._newest, None
        if arrival is None and self._fault is not None:
            raise _refusal(self.name, self._fault, self._timeout)
        return arrival

    def _read(self) -> None:
        from av.error import FFmpegError

        scaler, number = Scaler(), 0
        try:
            for packet in self._container.demux(self._stream):
                arrived = time.monotonic()
                for frame in _frames(packet):
                    pixels = VideoPixels(frame, scaler, Orientation(), self._aspect, None)
                    self._put(Arrival(number, arrived, frame.time, pixels))
                    number += 1
                if self._closed:
                    return
        except FFmpegError as fault:  # told where the frames are asked for, since nobody listens to a thread
            self._fault = fault
        finally:
            with self._changed:
                self._ended = True
                self._changed.notify()
            self._container.close()

    def _put(self, arrival: Arrival) -> None:
        with self._changed:
            self.dropped += self._newest is not None
            self._newest = arrival
            self._changed.notify()


def _frames(packet: Any) -> list[Any]:
    """What a packet holds; nothing where bytes were lost on the way, or before the first key frame."""
    from av.error import InvalidDataError

    try:
        return packet.decode()
    except InvalidDataError:
        return []


def open_live(name: str, timeout: float = 5.0) -> LiveSource:
    """A source of frames, to be entered by `with`.

    **Arguments:**

    - `name`: the number of a camera or its path, `0` or `/dev/video0`; the URL of a stream, such as `udp://0.0.0.0:5000`
      or `tcp://robot:5000`; or `-` for a pipe on standard input.
    - `timeout`: after how many seconds without a frame it counts as stopped.

    **Raises:** `ValueError` for what is none of these, is not there, is in use, or is no video.
    """
    av = pyav("a camera or a stream needs", "live")
    place, driver = _place(name)
    try:
        container = open_container(av, place, format=driver, options={} if driver else _WITHOUT_DELAY, timeout=timeout)
    except av.error.FFmpegError as error:
        raise _refusal(name, error, timeout) from error
    if not container.streams.video:
        container.close()
        raise ValueError(f"{name} shows no video")
    return LiveSource(name, container, timeout)


def _place(name: str) -> tuple[str, str | None]:
    """What ffmpeg opens, and the driver where it is a camera."""
    driver = _DRIVERS.get(sys.platform)
    if name == _PIPE:
        return "pipe:0", None
    if name.isdecimal():
        return f"/dev/video{name}" if driver == "v4l2" else name, driver
    if name.startswith("/dev/"):
        return name, driver
    if "://" in name:
        return name, None
    raise ValueError(
        f"source is {name!r}; give a camera (0, /dev/video0), a stream (udp://, tcp://) or - for a pipe; "
        "for a file: lgmd2jax respond"
    )


def _refusal(name: str, error: "FFmpegError", timeout: float) -> ValueError:
    """What to tell the user of a source that ffmpeg refuses."""
    from av import error as errors

    if isinstance(error, (errors.ExitError, errors.TimeoutError)):
        return _silent(name, timeout)
    if isinstance(error, errors.FileNotFoundError):
        return ValueError(f"there is no camera {name}; see which there are: ls /dev/video*")
    if isinstance(error, errors.PermissionError):
        return ValueError(f"{name} may not be read by you; on Linux join the group 'video'")
    if isinstance(error, errors.ConnectionRefusedError):
        return ValueError(f"{name} does not answer: nothing listens there")
    if isinstance(error, errors.InvalidDataError):
        return ValueError(f"{name} sends no video that ffmpeg can read")
    if error.errno == errno.EBUSY:
        return ValueError(f"{name} is busy: another program uses it")
    return ValueError(f"{name} cannot be read: {error.strerror}")


def _silent(name: str, timeout: float) -> ValueError:
    return ValueError(
        f"{name} is silent: no frame for {timeout:g} s; give it longer by --timeout, or see to the source"
    )
