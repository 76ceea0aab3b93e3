"""`lgmd2jax export MODEL --c DIR`: the model in C99 for one eye, and how far it is from the other models."""

import argparse
import dataclasses
import functools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from tqdm import tqdm

from lgmd2jax._c.gap import Film, Gap, gaps
from lgmd2jax._c.host import compiled, compiler
from lgmd2jax._c.memory import Memory, memory
from lgmd2jax._c.source import file_names, sources
from lgmd2jax._eye import Eye
from lgmd2jax._files.atomic import read_json
from lgmd2jax._files.folder import check_folder, replaced_folder
from lgmd2jax._handover.model_file import as_lgmd2, calibration_of, save
from lgmd2jax._handover.named import model_file, model_named
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameter_set import declared
from lgmd2jax._network.variants import at_eye
from lgmd2jax._protocol.protocol import Condition, load_protocol
from lgmd2jax._video.clip import Clip, open_clip
from lgmd2jax.fitting._search.search import TEMPERATURES

_MARKER = "lgmd2.h"
_TEMPERATURE = TEMPERATURES[-1]  # at which fits end
_MOST_PIXELS = 2**24  # which single precision can count


def export_c(options: argparse.Namespace) -> None:
    """Check what was given, write the folder, and say what it holds and how far soft model and C are from the hard one.

    **Raises:** `ValueError` for a size without a field, for what does not fit, and for a folder of something else.
    """
    folder = options.c
    _check_place(folder)
    own = as_lgmd2(model_named(options.model))
    eye = _eye(own.eye, options)
    model = dataclasses.replace(own, eye=eye) if own.eye is None else at_eye(own, eye)
    path = model_file(options.model)
    calibration = {} if path is None else calibration_of(path)
    urgency = calibration.get("urgency") if model is own else None
    needs = _check_memory(memory(model, eye.rows, eye.cols, urgency is not None), options.ram)
    conditions = load_protocol(options.protocol or "lgmd2").conditions
    clips = [open_clip(path, resize=eye.cols) for path in options.clip or ()]
    optional = options.protocol is None
    films = list(_progress(_films(conditions, eye, clips, optional), "stimuli", len(conditions) + len(clips)))
    files = _write(folder, model, path if model is own else None, _provenance(path))

    size = f"{eye.rows} x {eye.cols} pixels of {eye.degrees_per_pixel:g} degrees at {eye.fps:g} fps"
    print(f"wrote {folder}: C99 for {size}; there: make test, make robot, make emulation")
    print(f"RAM: {needs.state + needs.frame:,} bytes, of the state {needs.state:,}, of the frame {needs.frame:,}")
    print(_changes(own, model))
    if "urgency" in calibration and urgency is None:
        print("the urgency was calibrated for the model's own eye, and is left out")
    programs = None
    if compiler() is None:
        print("there is no C compiler here (cc, or CC): how far the C is from the hard model is not known")
    else:
        programs = functools.cache(lambda rows, cols: compiled(files, rows, cols))
    print(_table(gaps(model, _progress(films, "gap", len(films)), _TEMPERATURE, programs), films))


def _check_place(folder: Path) -> None:
    """A parent that does not exist is made when all else is known to be right."""
    if folder.exists() or folder.absolute().parent.is_dir():
        check_folder(folder, _MARKER)


def _eye(own: Eye | None, options: argparse.Namespace) -> Eye:
    """What was asked for, else the model's own."""
    field = {"rows": options.rows, "cols": options.cols, "degrees_per_pixel": options.degrees_per_pixel}
    missing = [f"--{name.replace('_', '-')}" for name, value in field.items() if value is None]
    if 0 < len(missing) < len(field) or (missing and own is None):
        raise ValueError(
            f"the field of view is not known, and k and the threshold of the inhibition go with it; give "
            f"{' and '.join(missing)} too"
        )
    if own is None:
        if options.fps is None:
            raise ValueError("the model has no eye, so its frame rate is not known; give --fps")
        return Eye(**field, fps=options.fps)
    rate = {} if options.fps is None else {"fps": options.fps}
    return dataclasses.replace(own, **({} if missing else field), **rate)


def _check_memory(needs: Memory, ram: int | None) -> Memory:
    if needs.frame > _MOST_PIXELS:
        raise ValueError(
            f"a frame has {needs.frame:,} pixels and may have {_MOST_PIXELS:,}; give fewer --rows and --cols"
        )
    total = needs.state + needs.frame
    if ram is not None and total > ram:
        raise ValueError(
            f"the state takes {needs.state:,} bytes and the frame {needs.frame:,}, together {total:,}, "
            f"and --ram allows {ram:,}; choose fewer --rows and --cols, or a model with fewer mechanisms"
        )
    return needs


def _films(conditions: Iterable[Condition], eye: Eye, clips: Iterable[Clip], optional: bool) -> Iterator[Film]:
    """In whole grey levels, as a camera gives them; stimuli rendered for the eye.

    **Arguments:** `optional`: leave out what this eye cannot show, such as stripes finer than its pixels.
    """
    for condition in conditions:
        try:
            frames = np.asarray(dataclasses.replace(condition, eye=eye).render().frames)
        except ValueError as error:
            if not optional:
                raise
            tqdm.write(f"left out of the comparison: {error}")
            continue
        yield Film(condition.name, _whole(frames), np.full(len(frames), 1000 / eye.fps))
    for clip in clips:
        recording = clip.record()
        yield Film(clip.name, _whole(recording.frames), np.asarray(recording.interval, float))


def _whole(frames: np.ndarray) -> np.ndarray:
    return np.clip(np.round(frames), 0, 255).astype(np.uint8)


def _provenance(path: Path | None) -> dict:
    """What the hand-over file says of its origin; nothing for a preset."""
    if path is None:
        return {}
    known = read_json(path)["provenance"]
    return {key: value for key, value in known.items() if key != "program"}


def _write(folder: Path, model: LGMD2, original: Path | None, provenance: Mapping) -> dict[str, str]:
    """The folder, whole or not at all, with the hand-over file as it is where the model is.

    **Returns:** the text of each file.
    """
    content = None if original is None else original.read_bytes()
    own_files = {"model.json", *(name.partition("/")[0] for name in file_names())}
    folder.absolute().parent.mkdir(parents=True, exist_ok=True)
    with replaced_folder(folder, _MARKER, own_files) as new:
        handover = new / "model.json"
        if content is None:
            save(model, handover, provenance)
        else:
            handover.write_bytes(content)
        written = read_json(handover)
        files = sources(model, written["test_vector"], written.get("calibration", {}).get("urgency"))
        for name, text in files.items():
            (new / name).parent.mkdir(exist_ok=True)
            (new / name).write_text(text, encoding="utf-8")
    return files


def _changes(own: LGMD2, model: LGMD2) -> str:
    """Which parameters the eye has changed."""
    if own.eye is None:
        return "the model has no eye: its parameters are taken to belong to this one, and stay as they are"
    values = {
        name: (float(getattr(own.parameters, name)), float(getattr(model.parameters, name)))
        for name in declared(type(own.parameters))
        if name not in own.unused
    }
    changes = [f"{name} {before:.4g} -> {after:.4g}" for name, (before, after) in values.items() if before != after]
    if own.N_ts != model.N_ts:
        changes.append(f"N_ts {own.N_ts} -> {model.N_ts}")
    return (
        f"changed for this eye: {', '.join(changes)}"
        if changes
        else "all parameters as they are: they belong to this eye"
    )


def _table(by_name: Mapping[str, Gap], films: Sequence[Film]) -> str:
    words = {"soft": f"soft, temperature {_TEMPERATURE:g}", "C": "C"}
    frames = sum(len(film.frames) for film in films)
    heading = "largest difference of U'  frames with other spikes  alarms that move  where that difference is"
    lines = [f"gap to the hard model over {len(films)} stimuli and clips, {frames:,} frames:", f"  {'':22}  {heading}"]
    for name, gap in by_name.items():
        numbers = f"{gap.difference:24.2g}{gap.other_counts:26}{gap.moved_alarms:18}"
        lines.append(f"  {words[name]:22}  {numbers}  {gap.film}")
    return "\n".join(lines)


def _progress(items: Iterable, what: str, count: int) -> Iterable:
    return tqdm(items, desc=what, total=count, leave=False)
