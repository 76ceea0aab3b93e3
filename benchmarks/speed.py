"""How fast the model is, and how much memory it takes, beside other programs, all measured in one run.

python -m benchmarks.speed

Every subject is called once a round, one after the other, over several rounds. Times are medians, in microseconds a
frame a stimulus, with compilation apart; ratios are medians of the ratios of each round. A peer is checked against
`lgmd2jax.hard` before it is timed, and one that is not installed is left out. XLA compiles as for the command
`lgmd2jax`, unless `XLA_FLAGS` is set; with `XLA_FLAGS=` in front as it does by default.
"""

import argparse
import dataclasses
import functools
import itertools
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from tqdm import tqdm

import lgmd2jax as lgmd
from benchmarks import _accelerator, _gradient_memory, _kernels, _library, _peers, _profile, _roofline
from benchmarks._claims import Claim, claims
from benchmarks._task import FPS, LARGE, ROBOT, SMALL, VALUES, Size, film
from benchmarks._timing import Timing, time_together
from lgmd2jax._compute.xla import set_flags
from lgmd2jax._files.atomic import replaced

FRAMES, BATCH, SWEEP = 60, 64, 20
# The name for the fastest of several ways to do the same.
BEST = {
    "batch, best": ("batch, vmap", "batch, map", "batch, map on each device"),
    "PyTorch": ("PyTorch, one thread", "PyTorch, all threads"),
    "PyTorch gradient": ("PyTorch gradient, one thread", "PyTorch gradient, all threads"),
}


@dataclasses.dataclass(frozen=True)
class Subject:
    """A call to time, how many frames it works through, and whether it was compiled before, by the check of peers."""

    call: Callable[[], object]
    frames: int = FRAMES
    compiled: bool = False


@dataclasses.dataclass(frozen=True)
class Row:
    """What was measured of a subject."""

    timing: Timing
    frames: int
    compiled: bool

    @property
    def compile(self) -> float | None:
        """Seconds; None where it happened before."""
        return None if self.compiled else self.timing.compile

    @property
    def microseconds(self) -> float:
        return 1e6 * self.timing.median / self.frames

    def over(self, other: "Row") -> float:
        """How many times the other's time a frame."""
        return self.timing.over(other.timing) * other.frames / self.frames


@dataclasses.dataclass(frozen=True)
class Run:
    """All that one run of the benchmark measured."""

    rows: Mapping[Size, Mapping[str, Row]]
    memory: Mapping[tuple[str, int], _gradient_memory.GradientMemory]
    machine: _roofline.Machine | None
    profiles: Mapping[Size, Mapping[str, Mapping[str, _profile.Program]]]
    work: Mapping[Size, _kernels.Work]
    accelerator: _accelerator.Accelerator | None

    def ratio(self, subject: str, other: str, size: Size) -> float | None:
        """How many times the time of another a subject takes a frame; None where one of them is missing."""
        mine, its = self._find(subject, size), self._find(other, size)
        return None if mine is None or its is None else mine.over(its)

    def _find(self, name: str, size: Size) -> Row | None:
        rows = self.rows[size]
        found = [rows[each] for each in BEST.get(name, (name,)) if each in rows]
        return min(found, key=lambda row: row.microseconds, default=None)


def library_subjects(size: Size) -> dict[str, Subject]:
    """The library, with all mechanisms too, and plain differentiation of its scan."""
    frames = jnp.asarray(film(size, FRAMES))
    made = {
        "forward hard": _library.forward(lgmd.Hard()),
        "forward hard, habituation": _library.forward(lgmd.Hard(), ("habituation",)),
        "forward hard, mechanisms": _library.forward(lgmd.Hard(), _library.MECHANISMS),
        "forward soft": _library.forward(lgmd.Soft()),
        "forward soft, mechanisms": _library.forward(lgmd.Soft(), _library.MECHANISMS),
        "gradient": _library.gradient(),
        "jacobian": _library.jacobian(),
        "jacobian, habituation": _library.jacobian(mechanisms=("habituation",)),
        "jacobian, mechanisms": _library.jacobian(mechanisms=_library.MECHANISMS),
        "naive gradient": _library.naive_gradient(),
        "naive jacobian": _library.naive_jacobian(),
    }
    return {name: Subject(functools.partial(function, frames)) for name, function in made.items()}


def profiles(size: Size) -> dict[str, dict[str, _profile.Program]]:
    """By what is profiled, the programs that end with each of its parts."""
    return _profile.programs(size) | ({"sweep": _profile.sweep_programs()} if size == SMALL else {})


def _up_to(what: str, part: str) -> str:
    return f"{what}, up to {part}"


def batch_subjects() -> dict[str, Subject]:
    """A batch at the small size, and a sweep with its stimuli."""
    films = jnp.stack([jnp.asarray(film(SMALL, FRAMES, seed)) for seed in range(BATCH)])
    over_devices = _library.spread(films)
    made = {
        "batch, vmap": functools.partial(_library.vmapped(), films),
        "batch, map": functools.partial(_library.mapped(), films),
        "batch, map on each device": functools.partial(_library.sharded(), over_devices),
    }
    return {name: Subject(call, BATCH * FRAMES) for name, call in made.items()}


def peer_subjects(size: Size) -> dict[str, Subject]:
    """The peers that are installed and compute the same network."""
    frames = film(size, FRAMES)
    subjects = {}
    if loop := _peers.find("_numba_loop"):
        subjects["numba loop"] = Subject(lambda: loop.respond(frames, VALUES, FPS))
        if size == SMALL:
            films = np.stack([film(size, FRAMES, seed) for seed in range(BATCH)])
            subjects["numba loop, batch on all threads"] = Subject(
                lambda: loop.respond_batch(films, VALUES, FPS), BATCH * FRAMES
            )
    if opencv := _peers.find("_opencv"):
        subjects["OpenCV + NumPy"] = Subject(lambda: opencv.respond(frames, VALUES, FPS))
    if torch := _peers.find("_torch"):
        for threads, words in ((1, "one thread"), (None, "all threads")):
            subjects[f"PyTorch, {words}"] = Subject(lambda n=threads: torch.respond(frames, VALUES, FPS, n))
            subjects[f"PyTorch gradient, {words}"] = Subject(lambda n=threads: torch.gradient(frames, VALUES, FPS, n))
    return {name: dataclasses.replace(subject, compiled=True) for name, subject in subjects.items()}


def measure(quick: bool, profile_only: bool = False) -> Run:
    """Measure everything, or the profiles alone."""
    sweep = 4 if quick else SWEEP
    rows, profiled = {}, {}
    for size in tqdm((SMALL, ROBOT, LARGE), desc="speed", leave=False):
        profiled[size] = profiles(size)
        subjects = {
            _up_to(what, part): Subject(it.call, it.frames, compiled=True)
            for what, parts in profiled[size].items()
            for part, it in parts.items()
        }
        if not profile_only:
            subjects |= library_subjects(size) | peer_subjects(size)
        if size == SMALL and not profile_only:
            subjects |= batch_subjects()
            subjects["sweep, stimuli included"] = Subject(_library.sweep(sweep, sweep), sweep**2 * 100)
        timings = time_together({name: it.call for name, it in subjects.items()}, rounds=3 if quick else 11)
        rows[size] = {
            name: Row(timing, subjects[name].frames, subjects[name].compiled) for name, timing in timings.items()
        }
    machine = _peers.find("_numba_machine")
    roofline = machine and machine.measure(tuple(rows))
    if profile_only:
        return Run(rows, {}, roofline, profiled, {}, None)
    cases = [("exact", 60), ("exact", 600), ("exact", 6000), ("naive", 60), ("naive", 600)]
    if quick:
        cases = [("exact", 60), ("exact", 600), ("naive", 60)]
    memory = {case: _gradient_memory.measure(*case) for case in tqdm(cases, desc="memory", leave=False)}
    accelerator = None if jax.default_backend() == "cpu" else _accelerator.measure(rounds=3 if quick else 11)
    return Run(rows, memory, roofline, profiled, {size: _kernels.work_per_frame(size) for size in rows}, accelerator)


def table(run: Run) -> str:
    """The figures, as lines."""
    lines = ["size     subject                              us a frame  x forward hard  compile s  x roofline"]
    for size, rows in run.rows.items():
        for name, row in rows.items():
            over = row.over(rows["forward hard"])
            compiling = "-" if row.compile is None else f"{row.compile:.1f}"
            limit = f"{row.microseconds / 1e6 / run.machine.seconds(size):10.1f}" if run.machine else ""
            lines.append(f"{size!s:8} {name:36}{row.microseconds:11.1f}{over:16.2f}{compiling:>11}  {limit}")
    lines += ["", "memory of the gradient at 240x320, frames not counted"]
    for (rule, time), memory in run.memory.items():
        grown = "" if memory.grown is None else f"   the process grew by {memory.grown / 1e6:8.1f} MB"
        lines.append(f"{rule:6} {time:5} frames   temporary {memory.temporary / 1e6:8.1f} MB{grown}")
    if run.machine:
        cached = ", ".join(f"{value / 1e9:.0f} GB/s at {size}" for size, value in run.machine.cached.items())
        lines += [
            "",
            f"roofline of one core: {run.machine.memory / 1e9:.1f} GB/s from memory; {cached}; "
            f"{run.machine.peak / 1e9:.0f} Gflop/s",
            f"a frame in one pass: {_roofline.BYTES} bytes and {_roofline.FLOPS} flops a pixel, hence at best "
            + ", ".join(f"{1e6 * run.machine.seconds(size):.1f} us at {size}" for size in run.rows),
        ]
    lines += [""]
    for size, work in run.work.items():
        parts = ", ".join(f"{count} {kind}" for kind, count in work.kinds.items())
        kernels = "in one kernel for all frames" if work.whole else "each a kernel"
        lines.append(f"work a frame, forward hard, {size}: {sum(work.kinds.values())} ({parts}), {kernels}")
    lines += ["", *profile_lines(run), "", accelerator_line(run.accelerator)]
    return "\n".join(lines)


def profile_lines(run: Run) -> list[str]:
    """What each part adds, by the rounds that were disturbed least; at best, as fast as a cache gives its bytes."""
    lines = ["where the time goes, by what each part adds to a frame: us, its share, KB of maps, us for these at best"]

    def add(head: str, us: float, whole: float, count: int) -> None:
        best = f"{1e6 * count / run.machine.tile:9.1f}" if run.machine else ""
        lines.append(f"{head}{us:9.1f}{us / whole:6.0%}{count / 1e3:9.0f}{best}")

    for size, profiled in run.profiles.items():
        for what, parts in profiled.items():
            rows = {part: run.rows[size][_up_to(what, part)] for part in parts}
            until = [0.0, *(1e6 * row.timing.least / row.frames for row in rows.values())]
            bytes_until = [0, *(program.bytes for program in parts.values())]
            added = zip(parts, itertools.pairwise(until), itertools.pairwise(bytes_until), strict=True)
            for part, (before, after), (bytes_before, bytes_after) in added:
                add(f"{size!s:8} {what:14}{part:34}", after - before, until[-1], bytes_after - bytes_before)
            add(f"{size!s:8} {what:14}{'in all':34}", until[-1], until[-1], bytes_until[-1])
    return lines


def accelerator_line(found: _accelerator.Accelerator | None) -> str:
    """What was measured of an accelerator, or why nothing was."""
    if found is None:
        return "accelerator: left out, since JAX finds none here; with one this line tells its speed"
    return (
        f"accelerator {found.device}: {_accelerator.BATCH} films at {SMALL}, {found.microseconds:.2f} us a frame each; "
        f"{found.share:.0%} of {found.bandwidth / 1e9:.0f} GB/s, if maps were passed over once a frame"
    )


def claims_table(found: list[Claim]) -> str:
    """The claims, as lines."""
    lines = ["claim                                                    measured     bound  holds"]
    for claim in found:
        verdict = "yes" if claim.holds else "NO"
        lines.append(f"{claim.text:55}{claim.measured:10.2f}{claim.bound:10.2f}  {verdict}")
    return "\n".join(lines)


def as_json(run: Run, found: list[Claim]) -> str:
    """The same, for programs."""
    rows = [
        {"size": str(size), "subject": name, "us_per_frame": row.microseconds, "compile_s": row.compile}
        for size, rows in run.rows.items()
        for name, row in rows.items()
    ]
    memory = [{"rule": rule, "frames": time, **dataclasses.asdict(it)} for (rule, time), it in run.memory.items()]
    machine = run.machine and {
        "memory_bytes_per_s": run.machine.memory,
        "cached_bytes_per_s": {str(size): value for size, value in run.machine.cached.items()},
        "peak_flops_per_s": run.machine.peak,
    }
    work = {str(size): it._asdict() for size, it in run.work.items()}
    accelerator = run.accelerator and dataclasses.asdict(run.accelerator)
    verdicts = [{**dataclasses.asdict(claim), "holds": claim.holds} for claim in found]
    content = {"speed": rows, "memory": memory, "machine": machine, "work": work, "accelerator": accelerator}
    content["claims"] = verdicts
    return json.dumps(content, indent=1) + "\n"


def main() -> None:
    """Run the benchmark and print its tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="3 rounds instead of 11, a smaller sweep, less memory")
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the figures here too")
    parser.add_argument("--one-core", action="store_true", help="hold everything to one core, XLA's threads too")
    parser.add_argument("--profile", action="store_true", help="where the time goes, and nothing else")
    options = parser.parse_args()
    if options.one_core:
        os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])
    set_flags()
    print(f"XLA_FLAGS={os.environ['XLA_FLAGS']!r}")
    if options.profile:
        print(*profile_lines(measure(options.quick, profile_only=True)), sep="\n")
        return
    jax.config.update("jax_num_cpu_devices", 2)
    for module, package in _peers.PACKAGES.items():
        peer = _peers.find(module)
        if peer is None:
            print(f"{package} is missing and left out; to compare: pip install {package}")
        else:
            seconds = _peers.check(package, peer.respond)
            print(f"{package} computes the network of lgmd2jax.hard; first call {seconds:.1f} s")
    run = measure(options.quick)
    found = list(claims(run))
    print(table(run), claims_table(found), sep="\n\n")
    if options.json:
        with replaced(options.json) as temporary:
            temporary.write_text(as_json(run, found), encoding="utf-8")


if __name__ == "__main__":
    main()
