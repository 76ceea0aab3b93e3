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
from lgmd2jax._protocol.condition import Protocol
from lgmd2jax._protocol.protocol import protocol_of
from lgmd2jax._video.clip_files import clips_folder, write_clip
from lgmd2jax._words import within
from lgmd2jax.alarms import LabelFile, LabelledClip
from lgmd2jax.alarms._label_file import label_file
from lgmd2jax.stimuli import Stimulus

_RENDERED = 24  # of the clips that a file of labelled ones renders: a dozen collisions, two of each other kind


def run(options: argparse.Namespace) -> None:
    """Render every condition once, write the sheet and the clips, and name them."""
    from lgmd2jax._figures.stimuli import PAGE, contact_sheet

    name, content, renderers = _renderers(options.protocol)
    folder = results_folder(options.protocol, options.output)
    folder.mkdir(parents=True, exist_ok=True)
    cards, starts = [], range(0, len(renderers), PAGE)
    sheets = [folder / f"{name}{f'-{page}' if len(starts) > 1 else ''}.png" for page in range(1, len(starts) + 1)]
    clips = folder / f"{name}-clips"
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(replaced(sheet)) for sheet in sheets]
        place = stack.enter_context(clips_folder(clips)) if options.clips else None
        for number, render in enumerate(tqdm(renderers, "stimuli", leave=False, disable=None), start=1):
            with within(options.protocol):
                stimulus = render()
            cards.append(Card.of(stimulus))
            if place is not None:
                write_clip(stimulus, options.clips, place, number)
        for page, (file, start) in enumerate(zip(files, starts, strict=True), start=1):
            title = f"{name}: {content}" + (f", page {page}" if len(starts) > 1 else "")
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


def _protocol_or_clips(path: Path, document: dict[str, Any]) -> Protocol | LabelFile:
    is_of_clips = {"clip", "rendered"} & document.keys()
    return label_file(path, document) if is_of_clips else protocol_of(path, document)


def _labelled(clip: LabelledClip) -> Stimulus:
    """A clip over the course of its label: 1 where an alarm is wanted, 0 where none may be raised, else nothing."""
    label = np.where(clip.in_windows().any(axis=0), 1.0, np.where(clip.in_silence(), 0.0, np.nan))
    courses = {"alarm_wanted": jnp.asarray(label)}
    return Stimulus(jnp.asarray(clip.frames, float), clip.fps, jnp.asarray(clip.time), clip.name, courses=courses)
