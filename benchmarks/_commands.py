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

from tests.documents import CLIPS_EYE, FREE_K_AND_TAU3, SIX_CLIPS, TWO_LOOMS

FIT = f"""{FREE_K_AND_TAU3}
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


OPTIONS = {"csv": "csv", "json": "json", "png": "figure", "mp4": "overlay"}  # by which a file is asked for


@dataclasses.dataclass(frozen=True)
class Command:
    """A command whose results go to OUT, and the one that continues it.

    `earlier`: what fills OUT with other results of the same kind, None where these would be refused. `stdin`: a file
    for its standard input. `adds_to`: a folder whose model and fit lie in OUT/results before.
    """

    name: str
    arguments: tuple[str, ...]
    resume: tuple[str, ...] = ()
    earlier: tuple[str, ...] | None = None
    stdin: Path | None = None
    adds_to: Path | None = None

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
    for name, text in {"looms": TWO_LOOMS, "clips": SIX_CLIPS, "sweep": SWEEP}.items():
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


def further_commands(place: Path, runner: "Runner", log: Path) -> tuple[Command, ...]:
    """All others that write files. The fits that some of them need are made first, after those of `commands`."""
    write_clip(place / "loom.mkv", frames=120, size=(160, 120))
    (place / "own.toml").write_text(CLIPS_EYE + '[[clip]]\nfile = "loom.mkv"\n', encoding="utf-8")
    rows = "".join(
        f"A,{trial},{speed},{-4 * speed - 20 + 3 * spike + trial}\n"
        for speed in (20, 40, 80)
        for trial in range(3)
        for spike in range(-12, 12)
    )
    (place / "trials.csv").write_text("animal,trial,l_over_v_ms,spike_ms\n" + rows, encoding="utf-8")
    for recipe in ("1/fit", "2/fit", "1/alarms"):
        status, _ = runner.run(("fit", str(place / f"{recipe}.toml")), log)
        if status:
            raise RuntimeError(f"{recipe} ended with {status}: {log.read_text()[-500:]}")
    fits, model = (str(place / "1/fit"), str(place / "2/fit")), str(place / "1/fit/model.json")

    def files(name: str, *suffixes: str) -> list[str]:
        return [word for suffix in suffixes for word in (f"--{OPTIONS[suffix]}", f"OUT/{name}.{suffix}")]

    recipe, out = str(place / "1/alarms.toml"), ("-o", "OUT/results")
    return (
        Command("clips of one's own", ("fit", recipe, "--clips", str(place / "own.toml"), *out)),
        Command("calibrate", ("calibrate", recipe, *out), adds_to=place / "1/alarms"),
        Command("watch", ("watch", str(place / "clips.toml"), "--baselines", *files("w", "csv", "json", "png"))),
        Command("predict", ("predict", fits[0], str(place / "looms.toml"), "-o", "OUT/p.csv")),
        Command("characterise", ("characterise", model, *files("c", "json", "png"))),
        Command("compare", ("compare", *fits, *files("c", "json", "csv", "png"))),
        Command("looming", ("looming", str(place / "trials.csv"), *files("l", "json", "png"))),
        Command("import", ("import", str(place / "trials.csv"), *out)),
        Command("arena", ("arena", "--seeds", "1", "--seconds", "1", *files("a", "json", "png"))),
        Command("live", ("live", "-", *files("v", "csv", "mp4")), stdin=place / "loom.mkv"),
        Command("stimuli", ("stimuli", str(place / "looms.toml"), "--clips", "npz", *out)),
        Command("export --c", ("export", model, "--c", "OUT/results")),
        Command("export --ros", ("export", model, "--ros", "OUT/results")),
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

    def start(self, arguments: Sequence[str], log: Path, stdin: Path | None = None):
        """The process, begun. `log`: for what it prints; it is there as soon as the command has begun."""
        log.unlink(missing_ok=True)
        process = self._context.Process(target=_run, args=(tuple(arguments), log, stdin))
        process.start()
        return process

    def run(self, arguments: Sequence[str], log: Path, stdin: Path | None = None) -> tuple[int, float]:
        """The exit status and the seconds that it took."""
        began, process = time.monotonic(), self.start(arguments, log, stdin)
        process.join()
        return int(process.exitcode or 0), time.monotonic() - began


def _run(arguments: tuple[str, ...], log: Path, stdin: Path | None) -> None:
    from lgmd2jax.cli import main

    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a job in the background ignores otherwise
    sys.argv = ["lgmd2jax", *arguments]
    with open(log, "wb", buffering=0) as file, open(stdin or os.devnull, "rb", buffering=0) as fed:
        os.dup2(fed.fileno(), 0)
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    sys.exit(main())
