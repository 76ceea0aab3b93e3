"""`lgmd2jax stimuli PROTOCOL`: see what a protocol shows, and hand it to other software."""

import argparse
import contextlib
import dataclasses
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from tqdm import tqdm

from lgmd2jax._figures.contact_sheet import Card
from lgmd2jax._files.atomic import replaced
from lgmd2jax._files.catalogue import read_named, results_folder
from lgmd2jax._protocol.protocol import Protocol, protocol_of
from lgmd2jax._video.clip_files import FORMS, clips_folder, write_clip
from lgmd2jax.alarms import Footage, FootageFile
from lgmd2jax.alarms._footage_file import footage_file
from lgmd2jax.stimuli import Stimulus

_RENDERED = 24  # of the clips that a file of labelled ones renders: a dozen collisions, two of each other kind

_EXAMPLES = """\
examples:
  lgmd2jax stimuli looming                        the shipped protocol looming: writes looming.png here
  lgmd2jax stimuli mine.toml                      one of your own: writes mine.png beside mine.toml
  lgmd2jax stimuli paper -o sheets                several pages: sheets/paper-1.png, sheets/paper-2.png, ...
  lgmd2jax stimuli robot --clips mp4              also one film for each condition, in robot-clips/
  lgmd2jax stimuli robot --clips png -o screen    also folders of PNG, 8 bit and lossless, in screen/robot-clips/
  lgmd2jax stimuli robot --clips npz              also arrays: frames (uint8), time_ms, fps, name
  lgmd2jax stimuli video                          labelled clips with their labels; the first of those rendered

A protocol is a TOML file: an eye, and a list of conditions.
  [eye]
  preset = "locust"
  [[condition]]
  name = "dark approach {l_over_v} ms"
  family = "looming"
  l_over_v = [20, 40, 80]
  contrast = -0.9
"""


def add(commands) -> None:
    """Add the command to argparse's sub-commands."""
    parser = commands.add_parser(
        "stimuli",
        help="draw what a protocol shows, and write its clips",
        description="Draw a contact sheet of a protocol: some frames of each condition and what it does over time.",
        epilog=_EXAMPLES,
    )
    parser.add_argument("protocol", metavar="PROTOCOL", help="a TOML file, or the name of a shipped protocol")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER", help="default: beside the file; for a shipped one, here"
    )
    parser.add_argument("--clips", choices=FORMS, help="also write every condition as a clip")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Render every condition once, write the sheet and the clips, and name them."""
    from lgmd2jax._figures.stimuli import PAGE, contact_sheet

    name, told, renderers = _renderers(options.protocol)
    folder = results_folder(options.protocol, options.output)
    folder.mkdir(parents=True, exist_ok=True)
    cards, starts = [], range(0, len(renderers), PAGE)
    sheets = [folder / f"{name}{f'-{page}' if len(starts) > 1 else ''}.png" for page in range(1, len(starts) + 1)]
    clips = folder / f"{name}-clips"
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(replaced(sheet)) for sheet in sheets]
        place = stack.enter_context(clips_folder(clips)) if options.clips else None
        for number, render in enumerate(tqdm(renderers, "stimuli", leave=False, disable=None), start=1):
            stimulus = render()
            cards.append(Card.of(stimulus))
            if place is not None:
                write_clip(stimulus, options.clips, place, number)
        for page, (file, start) in enumerate(zip(files, starts, strict=True), start=1):
            title = f"{name}: {told}" + (f", page {page}" if len(starts) > 1 else "")
            contact_sheet(file, cards[start : start + PAGE], title)
    print("\n".join(f"wrote {sheet}" for sheet in sheets))
    if options.clips:
        print(f"wrote {clips} ({len(renderers)} clips)")


def _renderers(source: str) -> tuple[str, str, Sequence[Callable[[], Stimulus]]]:
    """The name of a protocol, or of a file of labelled clips, what it holds, and what renders each of its stimuli."""
    file = read_named(source, "stimuli", _protocol_or_clips)
    if isinstance(file, Protocol):
        renderers = [condition.render for condition in file.conditions]
        return file.name, f"{len(renderers)} conditions", renderers
    if file.rendered is not None:
        few = dataclasses.replace(file.rendered, count=min(file.rendered.count, _RENDERED))
        file = dataclasses.replace(file, rendered=few)
    clips = sorted(file.load(), key=lambda clip: clip.name.lstrip("0123456789 "))  # by kind
    return file.name, f"{len(clips)} labelled clips", [partial(_labelled, clip) for clip in clips]


def _protocol_or_clips(path: Path, document: dict[str, Any]) -> Protocol | FootageFile:
    is_of_clips = {"clip", "rendered"} & document.keys()
    return footage_file(path, document) if is_of_clips else protocol_of(path, document)


def _labelled(clip: Footage) -> Stimulus:
    """A clip over the course of its label: 1 where an alarm is wanted, 0 where none may be raised, else nothing."""
    label = np.where(clip.in_windows().any(axis=0), 1.0, np.where(clip.in_silence(), 0.0, np.nan))
    courses = {"alarm_wanted": jnp.asarray(label)}
    return Stimulus(jnp.asarray(clip.frames, float), clip.fps, jnp.asarray(clip.time), clip.name, courses=courses)
