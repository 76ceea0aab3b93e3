"""Streams that a test serves itself on loopback, as MPEG-TS: over TCP, over UDP, through a pipe."""

import contextlib
import socket
import threading
import time
from fractions import Fraction

import numpy as np
import pytest

av = pytest.importorskip("av", reason="streams need the extra 'live'")


def mux(file, pictures, fps=30.0, paced=True):
    """Write the pictures as they are due. `file` has `write`."""
    with av.open(file, "w", format="mpegts", options={"flush_packets": "1"}, buffer_size=1316) as container:
        stream = container.add_stream("mpeg2video", rate=round(fps))
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt, stream.gop_size, stream.max_b_frames = "yuv420p", 5, 0
        start = time.monotonic()
        for number, picture in enumerate(pictures):
            if paced:
                time.sleep(max(0.0, start + number / fps - time.monotonic()))
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            frame.pts, frame.time_base = number, Fraction(1, round(fps))
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


class Datagrams:
    """A file whose bytes go to a port of this machine."""

    def __init__(self, port):
        self._socket, self._port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), port

    def close(self):
        self._socket.close()

    def write(self, content):
        for start in range(0, len(content), 1316):
            self._socket.sendto(bytes(content[start : start + 1316]), ("127.0.0.1", self._port))
        return len(content)


@contextlib.contextmanager
def over_tcp(pictures, then=None, **options):
    """The URL of a stream that begins when somebody connects. `then`: an event until which the line stays open."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            line, _ = server.accept()
            with line, contextlib.suppress(OSError, av.FFmpegError), line.makefile("wb", buffering=0) as file:
                mux(file, pictures, **options)
                if then is not None:
                    then.wait(20)

        with _running(serve):
            yield f"tcp://127.0.0.1:{server.getsockname()[1]}"


@contextlib.contextmanager
def over_udp(pictures, **options):
    """The URL of a stream that runs, whoever listens."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with contextlib.closing(Datagrams(port)) as file, _running(lambda: mux(file, pictures, **options)):
        yield f"udp://127.0.0.1:{port}"


@contextlib.contextmanager
def _running(task):
    thread = threading.Thread(target=task, daemon=True)
    thread.start()
    yield
    thread.join(20)
