"""`lgmd2jax stimuli PROTOCOL`: see what a protocol shows, and hand it to other software."""

import argparse
import contextlib
from pathlib import Path

from tqdm import tqdm

from lgmd2jax._catalogue import results_folder
from lgmd2jax._clips import FORMS, clips_folder, write_clip
from lgmd2jax._contact_sheet import Card
from lgmd2jax._files import replaced
from lgmd2jax._protocol import load_protocol

_EXAMPLES = """\
examples:
  lgmd2jax stimuli looming                        the shipped protocol looming: writes looming.png here
  lgmd2jax stimuli mine.toml                      one of your own: writes mine.png beside mine.toml
  lgmd2jax stimuli paper -o sheets                several pages: sheets/paper-1.png, sheets/paper-2.png, ...
  lgmd2jax stimuli robot --clips mp4              also one film for each condition, in robot-clips/
  lgmd2jax stimuli robot --clips png -o screen    also folders of PNG, 8 bit and lossless, in screen/robot-clips/
  lgmd2jax stimuli robot --clips npz              also arrays: frames (uint8), time_ms, fps, name

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
    from lgmd2jax._figures_stimuli import PAGE, contact_sheet

    protocol = load_protocol(options.protocol)
    folder = results_folder(options.protocol, options.output)
    folder.mkdir(parents=True, exist_ok=True)
    conditions, cards = protocol.conditions, []
    starts = range(0, len(conditions), PAGE)
    sheets = [
        folder / f"{protocol.name}{f'-{page}' if len(starts) > 1 else ''}.png" for page in range(1, len(starts) + 1)
    ]
    clips = folder / f"{protocol.name}-clips"
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(replaced(sheet)) for sheet in sheets]
        place = stack.enter_context(clips_folder(clips)) if options.clips else None
        for number, condition in enumerate(tqdm(conditions, "stimuli", leave=False, disable=None), start=1):
            stimulus = condition.render()
            cards.append(Card.of(stimulus))
            if place is not None:
                write_clip(stimulus, options.clips, place, number)
        for page, (file, start) in enumerate(zip(files, starts, strict=True), start=1):
            title = f"{protocol.name}: {len(conditions)} conditions" + (f", page {page}" if len(starts) > 1 else "")
            contact_sheet(file, cards[start : start + PAGE], title)
    print("\n".join(f"wrote {sheet}" for sheet in sheets))
    if options.clips:
        print(f"wrote {clips} ({len(conditions)} clips)")
