"""Small commands of lgmd2jax, each in a process of its own, for studies of what kills and full disks leave."""

import dataclasses
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

PROTOCOL = """
[eye]
rows = 10
cols = 12
degrees_per_pixel = 8
fps = 50
[[target]]
model = "preset:lgmd2"
parameters = { k = 0.4, T_ffi = 12, T_s = 5, tau3 = 250 }
[[condition]]
name = "loom {l_over_v}"
family = "looming"
l_over_v = [20, 40]
contrast = -0.9
start_ms = -500
end_ms = 200
"""
FIT = """
protocol = "protocol.toml"
[parameters]
T_ffi = 12
T_s = 5
[free]
k = { low = 0.1, high = 2, scale = "log" }
tau3 = { low = 100, high = 1000 }
[solver]
pixel_points = 8
cell_points = 64
descend = 2
temperatures = [0.5, 0.1]
seed = SEED
[uncertainty]
profile = ["k"]
samples = 20
[validation]
leave_one_out = true
"""
CLIPS = """
[eye]
rows = 12
cols = 18
degrees_per_pixel = 4
fps = 30
projection = "pinhole"
[rendered]
count = 6
seed = 2
"""
ALARMS = """
protocol = "clips.toml"
kind = "alarms"
[free]
k = { low = 0.1, high = 2 }
T_ffi = { low = 2, high = 60 }
[solver]
pixel_points = 2
cell_points = 64
generations = 2
descend = 1
max_steps = 3
seed = SEED
[validation]
count = 4
seed = 9
"""
SWEEP = """
kind = "sweep"
family = "looming"
[eye]
rows = 24
cols = 32
degrees_per_pixel = 3
fps = 100
[stimulus]
contrast = { from = -0.9, to = -0.1, count = 20 }
l_over_v = { from = 10, to = 80, count = 20 }
[figure]
value = "peak"
"""


@dataclasses.dataclass(frozen=True)
class Command:
    """A command whose results go to OUT, and the one that goes on with it.

    `earlier`: what fills OUT with other results of the same kind, None where these would be refused.
    """

    name: str
    arguments: tuple[str, ...]
    resume: tuple[str, ...] = ()
    earlier: tuple[str, ...] | None = None

    def at(self, out: Path) -> tuple[str, ...]:
        """The arguments with results in this folder."""
        return _placed(self.arguments, out)

    def resumed_at(self, out: Path) -> tuple[str, ...]:
        """The same, going on."""
        return _placed((*self.arguments, *self.resume), out)

    def earlier_at(self, out: Path) -> tuple[str, ...] | None:
        """The arguments for other results in this folder."""
        return None if self.earlier is None else _placed(self.earlier, out)


def _placed(arguments: Sequence[str], out: Path) -> tuple[str, ...]:
    return tuple(argument.replace("OUT", str(out)) for argument in arguments)


def commands(place: Path) -> tuple[Command, ...]:
    """Those that write for longer than a moment; their recipes and a clip are written into a folder."""
    for name, text in {"protocol": PROTOCOL, "clips": CLIPS, "sweep": SWEEP}.items():
        (place / f"{name}.toml").write_text(text, encoding="utf-8")
    for seed in (1, 2):
        (place / str(seed)).mkdir(exist_ok=True)
        for name, text in {"fit": FIT, "alarms": ALARMS}.items():
            text = text.replace("SEED", str(seed)).replace('protocol = "', 'protocol = "../')
            (place / str(seed) / f"{name}.toml").write_text(text, encoding="utf-8")
    write_clip(place / "clip.mp4", frames=120, size=(160, 120))
    clip, write = str(place / "clip.mp4"), ("--csv", "OUT/r.csv", "--figure", "OUT/r.png", "--overlay", "OUT/r.mp4")

    def fit(name: str, seed: int) -> tuple[str, ...]:
        return "fit", str(place / str(seed) / f"{name}.toml"), "-o", "OUT/results"

    return (
        Command("fit", fit("fit", 1), ("--resume",), fit("fit", 2)),
        Command("alarms", fit("alarms", 1), ("--resume",), fit("alarms", 2)),
        Command("sweep", ("sweep", str(place / "sweep.toml"), "-o", "OUT/results")),
        Command("respond", ("respond", clip, *write), (), ("respond", clip, "--set", "T_sp=.65", *write)),
        Command(
            "export",
            ("export", "preset:lgmd2", "--python", "OUT/results"),
            (),
            ("export", "preset:balanced", "--python", "OUT/results"),
        ),
    )


def write_clip(path: Path, frames: int, size: tuple[int, int]) -> None:
    """A moving test picture of ffmpeg, as a video of this many frames at 30 a second. `size`: columns, rows."""
    import av
    from av.filter import Graph

    graph = Graph()
    source = graph.add("testsrc2", f"size={size[0]}x{size[1]}:rate=30")
    sink = graph.add("buffersink")
    source.link_to(sink)
    graph.configure()
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"preset": "ultrafast", "g": "300"})
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        for _ in range(frames):
            frame: Any = graph.pull()
            container.mux(stream.encode(frame.reformat(format="yuv420p")))
        container.mux(stream.encode(None))


class Runner:
    """Runs commands in processes that are forked from one in which all is imported and nothing has begun."""

    def __init__(self):
        self._context = multiprocessing.get_context("forkserver")
        names = ("fit", "fit_alarms", "sweep", "respond", "watch", "predict", "characterise", "stimuli", "export")
        self._context.set_forkserver_preload(["benchmarks._commands", *(f"lgmd2jax.cli.{name}" for name in names)])

    def start(self, arguments: Sequence[str], log: Path):
        """The process, begun. `log`: for what it prints."""
        process = self._context.Process(target=_run, args=(tuple(arguments), log))
        process.start()
        return process

    def run(self, arguments: Sequence[str], log: Path) -> tuple[int, float]:
        """The exit status and the seconds that it took."""
        began, process = time.monotonic(), self.start(arguments, log)
        process.join()
        return int(process.exitcode or 0), time.monotonic() - began


def _run(arguments: tuple[str, ...], log: Path) -> None:
    with open(log, "wb", buffering=0) as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    from lgmd2jax.cli import main

    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a job in the background ignores otherwise
    sys.argv = ["lgmd2jax", *arguments]
    sys.exit(main())
