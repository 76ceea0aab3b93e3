"""`lgmd2jax respond CLIP`: the model on real video."""

import argparse
import contextlib
import csv
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import jax
import numpy as np
from tqdm import tqdm

from lgmd2jax._files.atomic import replaced
from lgmd2jax._handover.named import add_model, model_named, with_parameters
from lgmd2jax._network.abstract import Network
from lgmd2jax._video.clip import Clip, Frame, open_clip, window_of
from lgmd2jax._video.overlay import Overlay, video_writer
from lgmd2jax._video.repeats import RULE
from lgmd2jax._video.snapshots import Snapshots
from lgmd2jax._video.trace import Row, Trace

_EXAMPLES = """\
examples:
  lgmd2jax respond crash.mp4                              writes crash.csv and crash.png here
  lgmd2jax respond crash.mp4 --resize 108 --set T_sp=.65  as on the robot: small frames, a low spike threshold
  lgmd2jax respond dashcam.mp4 --drop-duplicates          a file whose frame rate was converted
  lgmd2jax respond film.mp4 --crop :,36:397               without the black bars left and right
  lgmd2jax respond crash.mp4 --model preset:yue_rind      the LGMD1 that the paper compares with
  lgmd2jax respond frames/ --fps 100                      a folder of images
  lgmd2jax respond crash.mp4 --overlay crash-lgmd2.mp4    the clip with trace and alarm drawn on it

Any video that ffmpeg reads will do. The clip is read frame by frame, so its length does not matter; --drop-duplicates
reads it twice. Parameters belong to a frame rate and a field of view: those of the presets are meant for 30 fps, and a
fitted model sees a clip as wide as the eye that it was fitted with.
"""


def add(commands) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "respond",
        help="run the model on a video or a folder of images",
        description="Run the model on a video or a folder of images: a CSV file, a figure and, if asked, a video.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("clip", metavar="CLIP", type=Path, help="a video file, or a folder of images in natural order")
    add_model(parser)
    parser.add_argument("--csv", type=Path, metavar="FILE", help="the numbers (default: CLIP's name with .csv, here)")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="the figure (default: CLIP's name with .png, here)")
    parser.add_argument("--overlay", type=Path, metavar="FILE", help="the clip with trace and alarm drawn on it")
    parser.add_argument("--fps", type=float, metavar="N", help="frames per second (default: the file's own clock)")
    parser.add_argument(
        "--resize",
        type=int,
        metavar="N",
        help="width in pixels that the model sees, after the crop (default: that of the model's eye, else the clip's)",
    )
    parser.add_argument(
        "--crop", metavar="TOP:BOTTOM,LEFT:RIGHT", help="rows and columns to use, from 0; ends may be left out"
    )
    parser.add_argument("--drop-duplicates", action="store_true", help="pass over frames that repeat the one before")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Run the model over the clip, write what was asked for, and say what was done."""
    from lgmd2jax._figures.response import response_figure
    from lgmd2jax._figures.style import check_figure_path

    place = options.clip.resolve()
    name = place.stem if place.is_file() else place.name
    table, figure = options.csv or Path(f"{name}.csv"), options.figure or Path(f"{name}.png")
    outputs = [path for path in (table, figure, options.overlay) if path is not None]
    _check_outputs(options.clip, outputs)
    check_figure_path(figure)
    model = with_parameters(model_named(options.model), options.set)
    crop = None if options.crop is None else window_of(options.crop)
    width = model.eye.cols if options.resize is None and model.eye is not None else options.resize
    clip = open_clip(options.clip, fps=options.fps, crop=crop, resize=width)
    if model.eye is not None and abs(clip.fps / model.eye.fps - 1) > 0.01:
        print(
            f"lgmd2jax: warning: the model belongs to {model.eye.fps:g} fps, the clip has {clip.fps:g}", file=sys.stderr
        )

    rows, snapshots, started = [], Snapshots(), time.perf_counter()
    with contextlib.ExitStack() as stack:
        files = {path: stack.enter_context(replaced(path)) for path in outputs}
        writer = csv.writer(stack.enter_context(open(files[table], "w", newline="", encoding="utf-8")))
        writer.writerow(Row._fields)
        film, overlay = None, Overlay(clip.size, model.parameters)
        if options.overlay:
            film = stack.enter_context(video_writer(files[options.overlay], clip.fps))
        if options.drop_duplicates:
            clip = clip.without_repeats(lambda frames: _progress(frames, "repeats", clip.count))
        for frame, row in responses(model, _progress(clip, "frames", clip.count)):
            if not frame.repeated:
                writer.writerow(f"{value:.9g}" for value in row)
                rows.append(row)
                snapshots.offer(frame.index, frame.time, bool(row.collision), frame.picture[clip.window])
            if film is not None:
                film.write(overlay.draw(frame, row), frame.time)
        trace = Trace.of(rows)
        seconds = time.perf_counter() - started
        title = f"{options.clip.name}: {_model_text(options)}, {clip.shape[0]} x {clip.shape[1]} pixels"
        response_figure(files[figure], trace, model.parameters, snapshots.chosen(), title)
    print("\n".join(_summary(options, clip, trace, seconds)))
    print("wrote     " + ", ".join(str(path) for path in outputs))


def responses(model: Network, frames: Iterable[Frame]) -> Iterator[tuple[Frame, Row]]:
    """The model frame by frame. A repeated frame does not reach it, and comes with the row before."""
    state, row = None, None
    for frame in frames:
        if row is None or not frame.repeated:
            state = model.init(frame.grey) if state is None else state
            state, now = model.step(state, frame.grey, interval=frame.interval)
            now = jax.device_get(now)
            row = Row(
                frame.index,
                frame.time,
                mp=float(now.mp),
                ffi=float(now.ffi),
                smp=float(now.smp),
                smp_adapted=float(now.smp_adapted),
                spikes=int(now.spikes),
                collision=int(now.collision),
            )
        yield frame, row


def _summary(options, clip: Clip, trace: Trace, seconds: float) -> Iterator[str]:
    total = len(trace.frame) if clip.repeats is None else len(clip.repeats)
    gaps = np.diff(trace.time_ms)
    yield f"clip      {options.clip}: {total} frames of {clip.size[0]} x {clip.size[1]} at {clip.fps:.5g} fps"
    if clip.repeats is not None:
        yield f"repeats   {clip.repeats.sum()} of {total} frames dropped, each {RULE}"
    if clip.regular or (clip.regular is None and np.ptp(gaps) < 1e-6):
        rate = clip.effective_fps
        yield f"clock     steady: a step of the model is {1000 / rate:.4g} ms ({rate:.4g} fps)"
    else:
        yield f"clock     the file's time stamps: a step of the model is {gaps.min():.4g} to {gaps.max():.4g} ms"
    yield f"model     {_model_text(options)}; it sees {clip.shape[0]} x {clip.shape[1]} pixels, grey by ITU-R 601"
    before, after = int(np.argmax(trace.smp)), int(np.argmax(trace.smp_adapted))
    yield (
        f"SMP       at most {trace.smp[before]:.3f} ({_moment(trace, before)}), "
        f"after adaptation {trace.smp_adapted[after]:.3f} ({_moment(trace, after)})"
    )
    yield f"spikes    {trace.spikes.sum()}"
    alarms = [
        f"frames {trace.frame[start]}-{trace.frame[end]}, {trace.time_ms[start]:.0f}-{trace.time_ms[end]:.0f} ms"
        for start, end in trace.alarms()
    ]
    yield "alarm     " + ("; ".join(alarms) or "none")
    yield f"speed     {total / seconds:.0f} frames per second"


def _moment(trace: Trace, row: int) -> str:
    return f"frame {trace.frame[row]}, {trace.time_ms[row]:.0f} ms"


def _model_text(options) -> str:
    return ", ".join([options.model, *options.set])


def _progress(frames: Iterable, what: str, count: int | None) -> tqdm:
    """A bar on standard error, where somebody is looking."""
    return tqdm(frames, what, count, unit=" frames", leave=False, disable=None)


def _check_outputs(clip: Path, outputs: list[Path]) -> None:
    places = [path.resolve() for path in (clip, *outputs)]
    for place in places:
        if places.count(place) > 1:
            raise ValueError(f"{place.name} is named twice; clip, table, figure and overlay need names of their own")
