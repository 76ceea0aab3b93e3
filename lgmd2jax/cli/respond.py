"""`lgmd2jax respond CLIP`: the model on real video."""

import argparse
import contextlib
import csv
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import jax
import numpy as np
from tqdm import tqdm

from lgmd2jax._files.atomic import all_replaced
from lgmd2jax._handover.named import model_named, with_parameters
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax._video.clip import Clip, Frame, open_clip, window_of
from lgmd2jax._video.field import field_remark
from lgmd2jax._video.overlay import Overlay
from lgmd2jax._video.repeats import RULE
from lgmd2jax._video.snapshots import Snapshots
from lgmd2jax._video.trace import Row, Rows, Trace
from lgmd2jax._video.writer import video_writer
from lgmd2jax.cli.warning import warn


def run(options: argparse.Namespace) -> None:
    """Run the model over the clip, write what was asked for, and say what was done."""
    from lgmd2jax._figures.response import response_figure
    from lgmd2jax._figures.style import check_figure_path

    place = options.clip.resolve()
    name = place.stem if place.is_file() else place.name
    table, figure = options.csv or Path(f"{name}.csv"), options.figure or Path(f"{name}.png")
    outputs = [path for path in (table, figure, options.overlay) if path is not None]
    check_figure_path(figure)
    model = with_parameters(model_named(options.model), options.set)
    crop = None if options.crop is None else window_of(options.crop)
    width = model.eye.cols if options.resize is None and model.eye is not None else options.resize
    clip = open_clip(
        options.clip,
        fps=options.fps,
        crop=crop,
        resize=width,
        white=options.white,
        until_damage=options.until_damage,
    )
    for misfit in _misfits(clip, model):
        warn(misfit)

    rows, snapshots, start = Rows(), Snapshots(), 0.0
    with contextlib.ExitStack() as stack:
        files = stack.enter_context(all_replaced(outputs, (options.clip, options.model)))
        writer = csv.writer(stack.enter_context(open(files[table], "w", newline="", encoding="utf-8")))
        writer.writerow(Row._fields)
        film, overlay = None, Overlay(clip.size, model)
        if options.overlay:
            film = stack.enter_context(video_writer(files[options.overlay], clip.fps))
        if options.drop_duplicates:
            clip = clip.without_repeats(lambda frames: _progress(frames, "repeats", clip.count))
        for frame, row in responses(model, _progress(clip, "frames", clip.count)):
            if not frame.repeated:
                writer.writerow(f"{value:.9g}" for value in row)
                rows.append(row)
                snapshots.offer(
                    frame.index, frame.time, bool(row.collision), lambda shown=frame: shown.picture[clip.window]
                )
            if film is not None:
                film.write(overlay.draw(frame, row), frame.time)
            start = start or time.perf_counter()  # the first frame compiles the model
        trace = rows.trace()
        seconds = time.perf_counter() - start
        title = f"{options.clip.name}: {_model_text(options)}, {clip.shape[0]} x {clip.shape[1]} pixels"
        response_figure(files[figure], trace, model, snapshots.chosen(), title)
    print("\n".join(_summary(options, clip, trace, seconds)))
    print("wrote     " + ", ".join(str(path) for path in outputs))


def responses(model: AbstractNetwork, frames: Iterable[Frame]) -> Iterator[tuple[Frame, Row]]:
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


def _misfits(clip: Clip, model: AbstractNetwork) -> Iterator[str]:
    """Where the clip is not what the model's parameters belong to."""
    if model.eye is None:
        return
    if abs(clip.fps / model.eye.fps - 1) > 0.01:
        yield f"the model belongs to {model.eye.fps:g} fps, the clip has {clip.fps:g}"
    if remark := field_remark(clip.size, clip.window, clip.shape, model.eye):
        yield remark
    if clip.shape[1] > 2 * model.eye.cols:
        yield (
            f"the model's eye has {model.eye.rows} x {model.eye.cols} pixels, and it sees {clip.shape[0]} x "
            f"{clip.shape[1]}; without --resize the clip is made as wide as the eye"
        )


def _summary(options, clip: Clip, trace: Trace, seconds: float) -> Iterator[str]:
    total = len(trace.frame) if clip.repeats is None else len(clip.repeats)
    gaps = np.diff(trace.time_ms)
    size, seen = (f"{rows} rows x {columns} columns" for rows, columns in (clip.size, clip.shape))
    yield f"clip      {options.clip}: {total} frames of {size} at {clip.fps:.5g} fps"
    if clip.repeats is not None:
        yield f"repeats   {clip.repeats.sum()} of {total} frames dropped, each {RULE}"
    if clip.regular or np.ptp(gaps) < 1e-6:
        step = 1000 / clip.effective_fps if clip.regular else float(gaps.mean())
        yield f"clock     steady: a step of the model is {step:.4g} ms ({1000 / step:.4g} fps)"
    else:
        yield f"clock     the file's time stamps: a step of the model is {gaps.min():.4g} to {gaps.max():.4g} ms"
    yield f"model     {_model_text(options)}; it sees {seen}, grey by ITU-R 601"
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
    yield f"speed     {(total - 1) / seconds:.0f} frames per second, without compilation"


def _moment(trace: Trace, row: int) -> str:
    return f"frame {trace.frame[row]}, {trace.time_ms[row]:.0f} ms"


def _model_text(options) -> str:
    return ", ".join([options.model, *options.set])


def _progress(frames: Iterable, what: str, count: int | None) -> tqdm:
    """A bar on standard error, where somebody is looking."""
    return tqdm(frames, what, count, unit=" frames", leave=False, disable=None)
