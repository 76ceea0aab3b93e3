"""`lgmd2jax live SOURCE`: the model on a camera or a stream, while it runs."""

import argparse
import contextlib
import csv
import math
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from lgmd2jax import hard
from lgmd2jax._eye import Eye
from lgmd2jax._files.atomic import all_replaced
from lgmd2jax._handover.model_file import as_hard, as_lgmd2
from lgmd2jax._handover.named import model_file, model_named, with_parameters
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._video.clip import Frame, nearly_square, shape_after, window_of
from lgmd2jax._video.field import field_remark
from lgmd2jax._video.live_source import Arrival, open_live
from lgmd2jax._video.orientation import Window
from lgmd2jax._video.overlay import Overlay
from lgmd2jax._video.trace import Row
from lgmd2jax._video.writer import video_writer
from lgmd2jax.cli.live_tally import COLUMNS, Moment, Tally
from lgmd2jax.cli.live_view import view
from lgmd2jax.cli.warning import warn

_COLS = 99  # of the paper's robot, for a model that belongs to no size
_FPS = 30.0  # likewise, where neither source nor model states one
_SHARES = {"median": 0.5, "99 %": 0.99, "most": 1.0}  # of the frames, of which the latency is told


def run(options: argparse.Namespace) -> None:
    """Run the model until the source ends, Ctrl-C, or an error; what came until then is written in each case."""
    outputs = [path for path in (options.csv, options.overlay) if path is not None]
    if not (math.isfinite(options.timeout) and options.timeout > 0):
        raise ValueError(f"timeout is {options.timeout:g}; give a positive number of seconds")
    if options.resize is not None and options.resize < 3:
        raise ValueError(f"resize is {options.resize}; give a width of at least 3 pixels")
    model, program = _model(options)
    crop = (slice(None), slice(None)) if options.crop is None else window_of(options.crop)
    cols = options.resize or (_COLS if model.eye is None else model.eye.cols)
    tally, failure = Tally(), None
    with contextlib.ExitStack() as stack:
        files = stack.enter_context(all_replaced(outputs, (options.source, options.model)))
        source = stack.enter_context(open_live(options.source, options.timeout))
        fps = source.fps or (_FPS if model.eye is None else model.eye.fps)
        if model.eye is not None and abs(fps / model.eye.fps - 1) > 0.01:
            warn(f"the model belongs to {model.eye.fps:g} fps, {options.source} states {fps:g}")
        rows = film = overlay = None
        if options.csv:
            rows = csv.writer(stack.enter_context(open(files[options.csv], "w", newline="", encoding="utf-8")))
            rows.writerow(COLUMNS)
        if options.overlay:
            film = stack.enter_context(video_writer(files[options.overlay], fps))
        screen = stack.enter_context(view(model.levels.spikes))
        try:
            for frame, moment in moments(program, source, options.source, crop, cols, 1000 / fps, model.eye):
                tally.add(moment)
                screen.show(moment, tally, source.dropped)
                if rows is not None:
                    rows.writerow(f"{value:.9g}" for value in moment.cells())
                if film is not None:
                    overlay = overlay or Overlay(frame.pixels.size, model)
                    film.write(overlay.draw(frame, moment.row), frame.time)
        except KeyboardInterrupt:  # the usual end of a camera
            if not tally.frames:
                raise
        except ValueError as error:
            failure = error  # told once the files are whole
        if not tally.frames:  # the files of an earlier run stay
            raise failure or ValueError(f"{options.source} sent no frame; nothing was written")
    print("\n".join(_summary(options.source, tally, source.dropped)))
    if outputs:
        print("wrote    " + ", ".join(str(path) for path in outputs))
    if failure is not None:
        raise failure


def moments(
    program: hard.HardLGMD2,
    arrivals: Iterable[Arrival],
    name: str,
    crop: Window,
    cols: int,
    usual_ms: float,
    eye: Eye | None = None,
) -> Iterator[tuple[Frame, Moment]]:
    """Each frame that is not dropped, and the answer to it.

    **Arguments:** `name`: of the source. `cols`: of what the model sees. `usual_ms`: what the first frame lasts.
    `eye`: of the model.

    **Raises:** `ValueError` for frames that change their size, and as the source does.
    """
    size, shape, before, now_ms = None, None, None, 0.0
    for arrival in arrivals:
        pixels = arrival.pixels
        if size is None or shape is None:
            size = pixels.size
            shape = shape_after(name, size, crop, cols, nearly_square(pixels.aspect))
            if remark := field_remark(size, crop, shape, eye):
                warn(remark)
        if pixels.size != size:
            new, old = (f"{rows} x {cols}" for rows, cols in (pixels.size, size))
            raise ValueError(f"{name}: frame {arrival.number} has {new} pixels, those before {old}; start again")
        interval = usual_ms if before is None else _interval(before, arrival)
        now_ms, before = now_ms + (0.0 if before is None else interval), arrival
        grey = pixels.grey(crop, shape)
        now = program.step(grey, interval)
        latency = 1000 * (time.monotonic() - arrival.arrived)
        row = Row(arrival.number, now_ms, now.mp, now.ffi, now.smp, now.smp_adapted, now.spikes, int(now.collision))
        frame = Frame(arrival.number, now_ms, interval, pixels, grey, False)
        yield frame, Moment(row, interval, latency, now.mp_sides, now.urgency)


def _interval(before: Arrival, now: Arrival) -> float:
    """Ms between two frames by the clock of the source; by their arrival where that clock fails or jumps back."""
    if before.stamp is not None and now.stamp is not None and now.stamp > before.stamp:
        return 1000 * (now.stamp - before.stamp)
    return max(1000 * (now.arrived - before.arrived), 1.0)


def _model(options: argparse.Namespace) -> tuple[LGMD2, hard.HardLGMD2]:
    """The model as the library has it, and as the robot's program, which answers soonest: it wakes no other thread."""
    model = as_lgmd2(with_parameters(model_named(options.model), options.set))
    path: Path | None = model_file(options.model)
    if path is None:
        return model, as_hard(model)
    program = hard.load(path)
    if not options.set:
        return model, program
    if program.urgency is not None:
        warn("the urgency was calibrated without --set, and is left out")
    return model, as_hard(model)


def _summary(source: str, tally: Tally, dropped: int) -> Iterator[str]:
    yield f"source   {source}: {tally.frames} frames, {dropped} dropped, {tally.fps:.1f} fps at the end"
    latencies = ", ".join(f"{name} {tally.latency(share):.1f}" for name, share in _SHARES.items())
    yield f"latency  {latencies} ms, from a frame's arrival to the answer"
    yield f"alarms   {tally.alarms}"
    if dropped > tally.frames:
        yield "note     frames came faster than they were answered; a file is for lgmd2jax respond, which drops none"
