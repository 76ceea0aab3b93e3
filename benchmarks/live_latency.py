"""How soon the alarm of `lgmd2jax live` follows a frame, on one core, over minutes.

python -m benchmarks.live_latency                10 minutes
python -m benchmarks.live_latency --minutes 1

Another process sends frames of 72x99 at 30 a second over TCP on loopback, JPEG in NUT, each when it is due. Here the
loop of `lgmd2jax live` receives, decodes and answers them, shows its lines and writes its CSV file, held to one core.
Latencies count to the answer, from the moment when the sender hands a frame over, and from when its bytes are there.
Memory is the resident set of this process. The load of the machine is told, since it makes the longest latencies.
"""

import argparse
import contextlib
import csv
import io
import multiprocessing
import os
import socket
import time
from fractions import Fraction
from pathlib import Path

import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._handover.model_file import as_hard
from lgmd2jax._video.live_source import open_live
from lgmd2jax.cli.live import moments
from lgmd2jax.cli.live_tally import COLUMNS, Tally
from lgmd2jax.cli.live_view import Lines

ROWS, COLS, FPS = 72, 99, 30
_WHOLE = (slice(None), slice(None))


def film() -> np.ndarray:
    """Four seconds: a dark disc approaches, stays, and is gone."""
    y, x = np.mgrid[:ROWS, :COLS]
    radius = np.append(60 / np.maximum(90 - np.arange(100), 2), np.zeros(20))
    discs = np.hypot(y - ROWS / 2, x - COLS / 2) <= radius[:, None, None]
    return np.repeat(np.where(discs, 20, 220).astype(np.uint8)[..., None], 3, -1)


def send(server: socket.socket, count: int, times) -> None:
    """Send so many frames to whoever connects first, and note in `times` when each was handed over."""
    import av

    pictures = film()
    line, _ = server.accept()
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    file = line.makefile("wb", buffering=0)
    with line, file, av.open(file, "w", format="nut", options={"flush_packets": "1"}) as container:
        stream = container.add_stream("mjpeg", rate=FPS)
        stream.height, stream.width, stream.pix_fmt = ROWS, COLS, "yuvj420p"
        start = time.monotonic()
        for number in range(count):
            time.sleep(max(0.0, start + number / FPS - time.monotonic()))
            frame = av.VideoFrame.from_ndarray(pictures[number % len(pictures)], format="rgb24")
            frame.pts, frame.time_base = number, Fraction(1, FPS)
            times[number] = time.monotonic()
            container.mux(stream.encode(frame))


def resident() -> float:
    """MB of this process."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def latencies(name: str, values: np.ndarray) -> str:
    """A line with their distribution."""
    median, most_of, longest = np.percentile(values, [50, 99, 100])
    within = np.mean(values <= 1000 / FPS)
    return (
        f"{name:13} median {median:6.2f} ms, 99 % {most_of:6.2f}, longest {longest:6.1f}; "
        f"{within:.3%} within a frame's interval, {np.sum(values > 1000 / FPS)} beyond"
    )


def main() -> None:
    """Run the benchmark and print its lines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    count = round(parser.parse_args().minutes * 60 * FPS)
    context = multiprocessing.get_context("spawn")
    server, times = socket.create_server(("127.0.0.1", 0)), context.Array("d", count, lock=False)
    load_before = os.getloadavg()[0]
    program, tally, lines = as_hard(lgmd.LGMD2()), Tally(), Lines()
    answered, arrival, memory = np.full(count, np.nan), np.full(count, np.nan), []
    sender = context.Process(target=send, args=(server, count, times), daemon=True)
    sender.start()
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, [core])
    with (
        open(os.devnull, "w", newline="", encoding="utf-8") as file,
        contextlib.redirect_stdout(io.StringIO()) as said,
        open_live(f"tcp://127.0.0.1:{server.getsockname()[1]}", timeout=60.0) as source,
    ):
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for frame, moment in moments(program, source, "stream", _WHOLE, COLS, 1000 / FPS):
            answered[frame.index] = time.monotonic()
            arrival[frame.index] = moment.latency_ms
            tally.add(moment)
            lines.show(moment, tally, source.dropped)
            table.writerow(f"{value:.9g}" for value in moment.cells())
            if frame.index % FPS == 0:
                memory.append(resident())
                said.seek(0)
                said.truncate()
    sender.join()
    seen = np.isfinite(answered)
    minute = min(60, max(1, len(memory) // 2))
    first, last = np.median(memory[:minute]), np.median(memory[-minute:])
    print(f"{ROWS}x{COLS} at {FPS} fps for {count / FPS / 60:g} minutes on core {core}, of {os.cpu_count()}")
    print(f"load of the machine {load_before:.1f} before, {os.getloadavg()[0]:.1f} after")
    print(f"frames        {count} sent, {tally.frames} seen, {source.dropped} dropped, {tally.alarms} alarms")
    print(latencies("from sending", 1000 * (answered - np.array(times))[seen]))
    print(latencies("from arrival", arrival[seen]))
    print(f"memory        {first:.1f} MB in the first minute, {last:.1f} in the last: {last - first:+.2f}")


if __name__ == "__main__":
    main()
