"""Whether random documents, pictures and clips are each read, or refused in one sentence, and never crash a command.

`python -m benchmarks.fuzz --documents 20000 --pictures 2000` says how many were taken and refused, and ends at the
first that hangs, changes another file, or raises what is not meant for a user.
"""

import argparse
import contextlib
import json
import os
import shutil
import signal
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import hypothesis
import hypothesis.strategies as st
import imageio.v3 as iio
import numpy as np

import lgmd2jax as lgmd
from benchmarks._fuzz_mutants import mutated, toml, torn
from lgmd2jax import hard
from lgmd2jax._compute.finished_work import FileMemory
from lgmd2jax._video.clip import open_clip
from lgmd2jax._words import is_refusal
from lgmd2jax.alarms import load_labels
from tests.videos import noise, write_folder, write_video

MOVING = (".gif", ".mkv", ".mp4", ".avi")
SECONDS = 60  # after which a document is taken to hang

EYE = {"rows": 6, "cols": 8, "degrees_per_pixel": 10, "fps": 50}
LOOM = {"family": "looming", "l_over_v": 20, "contrast": -0.9, "start_ms": -300, "end_ms": 60}
PROTOCOL = {
    "eye": EYE,
    "target": [{"law": "rest", "channel": "smp", "error": 0.1}],
    "condition": [
        LOOM | {"name": "{l_over_v} {eye[fps]}", "l_over_v": [20, 40], "camera": {"noise": 1.0, "seed": 3}},
        LOOM
        | {
            "name": "recorded",
            "background": {"kind": "uniform", "level": 150},
            "target": [
                {"file": "curve.csv", "channel": "rate", "column": "rate", "sem": "sem", "interpolate": True},
                {"spikes": "spikes.csv", "kernel_ms": 20, "where": {"animal": "A"}},
                {"law": "band", "low": [0.5, 0.5], "high": 0.9, "segments_ms": [[-300, -100], [-100, 60]]},
                {"model": "preset:balanced", "parameters": {"tau1": 20}, "noise": 0.1, "seed": 1, "weight": 2},
            ],
        },
        {"name": "grating", "family": "grating", "contrast": 0.5, "start_ms": -100, "end_ms": 100},
        LOOM | {"name": "rolling", "distance": {"kind": "tabulated", "time_ms": [[-300, 0]], "distance": [[9, 1]]}},
    ],
}
SMALL = {"eye": EYE, "condition": [LOOM | {"name": "loom"}], "target": [{"law": "rest"}]}
FIT = {
    "protocol": "small.toml",
    "kind": "fit",
    "preset": "lgmd2",
    "temperature": 1.0,
    "parameters": {"T_s": 5.0},
    "structure": {"n_p": 1, "mechanisms": ["size", "shunt"]},
    "observation": {"gain": 90},
    "free": {"k": {"low": 0.1, "high": 2, "scale": "log", "prior": [1, 0.3]}, "tau1": {}, "theta1": {"tie": "theta2"}},
    "solver": {"pixel_points": 4, "temperatures": [0.5, 0.2], "loss": "huber", "seed": 0},
    "uncertainty": {"profile": ["k"], "samples": 0, "absolute_errors": True},
    "validation": {"leave_one_out": False},
    "truth": {"k": 1.0},
}
LABELS = {
    "eye": EYE | {"projection": "pinhole"},
    "clip": [
        {"file": "clip.mkv", "alarm": [[5, 9]], "contact": 9, "crop": ":,2:20", "grace_ms": 100, "settle": 2},
        {"file": "frames", "fps": 30, "name": "folder", "drop_duplicates": True, "resize": 12, "silent": [[0, 3]]},
    ],
}
ALARMS = {
    "kind": "alarms",
    "protocol": "rendered.toml",
    "parameters": {"N_sp": 8},
    "structure": {"N_ts": 6},
    "free": {"tau1": {}, "T_sp": {"low": 0.51, "high": 0.97}},
    "weights": {"miss": 1, "false_alarm": 1},
    "solver": {"pixel_points": 4, "generations": 1, "descend": 0},
    "validation": {"count": 4, "seed": 19, "alarm_below_ms": 900},
}
SWEEP = {
    "kind": "sweep",
    "model": ["preset:lgmd2", "preset:balanced"],
    "family": "looming",
    "eye": EYE,
    "stimulus": {"contrast": [-0.9, -0.5], "l_over_v": {"from": 5, "to": 80, "count": 3, "spacing": "log"}},
    "parameters": {"T_ffi": 20},
    "channels": ["smp"],
}


class Kind(NamedTuple):
    """One kind of file: its name, how a mutant of it is drawn, and what reads it."""

    name: str
    file: str
    mutant: Callable[[st.DataObject], bytes]
    read: Callable[[Path], Any]


def document_kinds(folder: Path) -> list[Kind]:
    """The kinds of documents; whole ones stand in the folder."""
    _write_documents(folder)
    kinds = [
        Kind("protocol", "mutant.toml", _tables(PROTOCOL), lgmd.load_protocol),
        Kind(
            "protocol, rendered",
            "small.toml",
            _tables(SMALL),
            lambda path: lgmd.load_recipe(path.with_name("fit.toml")),
        ),
        Kind("recipe of a fit", "mutant.toml", _tables(FIT), lgmd.load_recipe),
        Kind("label file", "mutant.toml", _tables(LABELS), lambda path: load_labels(path).load()),
        Kind("recipe of alarms", "mutant.toml", _tables(ALARMS), lgmd.load_recipe),
        Kind("recipe of a sweep", "mutant.toml", _tables(SWEEP), lgmd.load_recipe),
    ]
    for reader, load in (("library", lgmd.load), ("robot", hard.load)):
        content = json.loads((folder / "fit" / "model.json").read_text())
        kinds.append(Kind(f"model.json, {reader}", "mutant.json", _json(content), load))
    content = json.loads((folder / "fit" / "fit.json").read_text())
    kinds.append(Kind("fit.json", "fit/fit.json", _json(content), lambda path: lgmd.load_fit(path.parent)))
    for name, file, read in [
        ("curves.csv", "fit/curves.csv", lambda path: lgmd.load_fit(path.parent)),
        ("TOML as bytes", "small.toml", lgmd.load_protocol),
        ("JSON as bytes", "fit/model.json", lgmd.load),
        ("fit.json as bytes", "fit/fit.json", lambda path: lgmd.load_fit(path.parent)),
        ("curve", "curve.csv", lambda path: lgmd.load_protocol(path.parent / "whole.toml")),
        ("spikes", "spikes.csv", lambda path: lgmd.load_protocol(path.parent / "whole.toml")),
        ("unfinished work", "starts.jsonl", lambda path: FileMemory(path, "abc", resume=True)),
    ]:
        kinds.append(Kind(name, file, _bytes((folder / file).read_bytes()), read))
    return kinds


def _tables(document: dict[str, Any]) -> Callable[[st.DataObject], bytes]:
    return lambda data: toml(mutated(data, document)).encode("utf-8", "replace")


def _json(document: dict[str, Any]) -> Callable[[st.DataObject], bytes]:
    return lambda data: json.dumps(mutated(data, document), default=str).encode()


def _bytes(content: bytes) -> Callable[[st.DataObject], bytes]:
    return lambda data: torn(data, content)


def _write_documents(folder: Path) -> None:
    write_video(folder / "clip.mkv", list(noise(12)))
    write_folder(folder / "frames", noise(6))
    (folder / "curve.csv").write_text("time_ms,rate,sem\n" + "".join(f"{t},{t % 7},1.5\n" for t in range(-300, 61, 20)))
    (folder / "spikes.csv").write_text("animal,trial,time_ms\nA,1,-20\nA,1,3\nA,2,\nB,1,10.5\n")
    (folder / "whole.toml").write_text(toml(PROTOCOL))
    (folder / "small.toml").write_text(toml(SMALL))
    (folder / "fit.toml").write_text(toml({"protocol": "small.toml", "free": {"k": {}}}))
    (folder / "rendered.toml").write_text(toml({"eye": EYE, "rendered": {"count": 3}}))
    (folder / "starts.jsonl").write_text('["digest", "abc"]\n["start 0", {"loss": 1.0}]\n["start 1", [1, 2]]\n')
    shutil.copytree(Path(__file__).parents[1] / "tests" / "golden" / "fit_v1", folder / "fit")


def picture_kinds(folder: Path) -> list[Kind]:
    """The kinds of pictures and clips, small ones of each format."""
    folder.mkdir(exist_ok=True)
    pictures, grey = noise(4, (10, 12)), np.arange(120, dtype=np.uint8).reshape(10, 12)
    for name, picture in [
        ("rgb.png", pictures[0]),
        ("deep.png", (257 * grey.astype(np.uint16))),
        ("grey.tif", grey),
        ("deep.tif", (257 * grey.astype(np.uint16))),
        ("rgb.tif", pictures[0]),
        ("grey.pgm", grey),
        ("rgb.jpg", pictures[0]),
        ("rgb.bmp", pictures[0]),
    ]:
        iio.imwrite(folder / name, picture)
    iio.imwrite(folder / "moving.gif", pictures, duration=50, loop=0)
    clip = list(noise(6, (16, 16)))
    write_video(folder / "lossless.mkv", clip)
    write_video(folder / "usual.mp4", clip, codec="mpeg4", pixels="yuv420p")
    write_video(folder / "usual.avi", clip, codec="mjpeg", pixels="yuvj420p")
    return [_picture_kind(path) for path in sorted(folder.iterdir()) if path.is_file()]


def _picture_kind(path: Path) -> Kind:
    """A clip, or a folder of two pictures of which the second one is the mutant."""
    content = path.read_bytes()
    if path.suffix in MOVING:
        return Kind(path.name, path.name, _bytes(content), _decoded)
    pictures = path.with_name(path.name.replace(".", "_"))
    pictures.mkdir()
    (pictures / f"1{path.suffix}").write_bytes(content)
    return Kind(path.name, f"{pictures.name}/2{path.suffix}", _bytes(content), lambda mutant: _decoded(mutant.parent))


def _decoded(path: Path) -> None:
    open_clip(path, fps=30.0, resize=8).record(True)


class FaultError(AssertionError):
    """What a mutant must not do."""


def attempt(kind: Kind, folder: Path, content: bytes) -> str:
    """Read a mutant: `"taken"` or `"refused"`. What was there before is put back.

    **Raises:** `FaultError`, with the mutant kept beside the folder, for anything else.
    """
    path = folder / kind.file
    path.parent.mkdir(exist_ok=True)
    whole = path.read_bytes() if path.is_file() else None
    path.write_bytes(content)
    before = _state(folder)
    try:
        with _time_limit(), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            kind.read(path)
        verdict, problem = "taken", ""
    except (ValueError, OSError) as error:
        verdict, problem = "refused", _problem_of_refusal(error, kind)
    except Exception as error:
        verdict, problem = "", f"{type(error).__name__}: {error}"
    if _state(folder) != before:
        problem = "a file was changed"
    if problem:
        (kept := folder.with_name("fault")).write_bytes(content)
        raise FaultError(f"{kind.name}: {problem}; the mutant is {kept}")
    if whole is None:
        path.unlink()
    else:
        path.write_bytes(whole)
    return verdict


def _problem_of_refusal(error: Exception, kind: Kind) -> str:
    message = str(error)
    if isinstance(error, ValueError) and not is_refusal(error):
        return f"a fault of the library, {type(error).__name__}: {message}"
    if kind.file.partition("/")[0] not in message:
        return f"the message does not name the file: {message}"
    return "" if len(message) < 2000 else f"the message has {len(message)} characters: {message:.200}"


def _state(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and "cache" not in path.parts}


@contextlib.contextmanager
def _time_limit() -> Iterator[None]:
    def stop(*_):
        raise RuntimeError(f"nothing came within {SECONDS} s")

    old = signal.signal(signal.SIGALRM, stop)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, old)


def fuzz(kinds: list[Kind], folder: Path, count: int, seed: int = 0) -> Counter[tuple[str, str]]:
    """How often which kind was taken and refused, of so many mutants.

    **Raises:** `FaultError` for the first that is neither.
    """
    outcomes: Counter[tuple[str, str]] = Counter()

    @hypothesis.seed(seed)
    @hypothesis.settings(
        max_examples=count,
        deadline=None,
        database=None,
        phases=[hypothesis.Phase.generate],
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(st.data())
    def each(data: st.DataObject) -> None:
        kind = data.draw(st.sampled_from(kinds))
        outcomes[kind.name, attempt(kind, folder, kind.mutant(data))] += 1

    each()
    return outcomes


def main() -> None:
    """Fuzz as many as asked for, and print what came out."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--documents", type=int, default=20_000, metavar="N")
    parser.add_argument("--pictures", type=int, default=2_000, metavar="N", help="pictures and clips")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        os.environ["XDG_CACHE_HOME"] = f"{place}/cache"
        for what, kinds_in, count in (
            ("documents", document_kinds, options.documents),
            ("pictures and clips", picture_kinds, options.pictures),
        ):
            if not count:
                continue
            folder = Path(place) / what.partition(" ")[0]
            folder.mkdir()
            start = time.monotonic()
            kinds = kinds_in(folder)
            outcomes = fuzz(kinds, folder, count, options.seed)
            for kind in kinds:
                print(
                    f"{kind.name:24} taken {outcomes[kind.name, 'taken']:6}, refused {outcomes[kind.name, 'refused']:6}"
                )
            print(f"{outcomes.total()} {what} in {time.monotonic() - start:.0f} s: no fault\n", flush=True)


if __name__ == "__main__":
    main()
