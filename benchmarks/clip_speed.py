"""How many frames a second are decoded and shrunk, and how much memory a long clip takes.

python -m benchmarks.clip_speed [--minutes 60]

Renders clips of moving texture in 1080p and 4K (H.264), and one of 72 x 99 pixels that is as long as asked, reads each
as `respond --resize 108` does, and prints frames per second of wall clock and of processor time.
"""

import argparse
import itertools
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np

from lgmd2jax._video.clip import Clip, open_clip


def main() -> None:
    """Render, read and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=6.0, help="length of the long clip (default: %(default)s)")
    minutes = parser.parse_args().minutes
    with tempfile.TemporaryDirectory() as folder:
        for share in (0.1, 1.0):
            count = round(share * minutes * 60 * 30)
            report(f"{share * minutes:g} minutes", open_clip(render(Path(folder) / f"{count}.mp4", 72, 99, count)))
        for name, rows, cols, count in (("1080p", 1080, 1920, 300), ("4K", 2160, 3840, 90)):
            report(name, open_clip(render(Path(folder) / f"{name}.mp4", rows, cols, count), resize=108))


def report(name: str, clip: Clip) -> None:
    """Read the clip and print a line."""
    wall, processor = time.perf_counter(), time.process_time()
    count = sum(1 for _ in clip)
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{name:12} {count:7} frames of {clip.size[0]} x {clip.size[1]}: {count / wall:6.0f} frames a second, "
        f"{1000 * processor / count:.2f} ms of processor time a frame, peak memory {peak:.0f} MiB",
        flush=True,
    )


def render(path: Path, rows: int, cols: int, count: int) -> Path:
    """A clip of texture that moves by a pixel and a half a frame."""
    even = rows + rows % 2, cols + cols % 2
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"preset": "veryfast", "crf": "23"})
        (stream.height, stream.width), stream.pix_fmt = even, "yuv420p"
        for frame in itertools.islice(texture(*even), count):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="gray").reformat(format="yuv420p")))
        container.mux(stream.encode(None))
    return path


def texture(rows: int, cols: int) -> Iterator[np.ndarray]:
    """Frames without end: a window that moves over blocks of random grey."""
    coarse = np.random.default_rng(0).integers(0, 256, (rows // 8 + 40, cols // 8 + 40), dtype=np.uint8)
    whole = np.kron(coarse, np.ones((8, 8), np.uint8))
    for i in itertools.count():
        left = 3 * i // 2 % 300
        yield np.ascontiguousarray(whole[left // 2 : left // 2 + rows, left : left + cols])


if __name__ == "__main__":
    main()
