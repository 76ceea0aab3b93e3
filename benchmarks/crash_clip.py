"""Write the clip that the README's commands use, stimuli/crash.mp4, and its labels.

python -m benchmarks.crash_clip

A dark disc approaches over a photograph and hits, filmed by a camera of the angle of `lgmd2jax fit video` at four times
its scale, at 24 frames a second; in the file of 30 every fourth frame comes twice, as in converted films.
"""

import argparse
from pathlib import Path

import jax
import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._video.writer import video_writer

FOLDER = Path(__file__).parents[1] / "stimuli"
SEEN = lgmd.Eye(rows=20, cols=36, degrees_per_pixel=1.95, fps=30)
FILM = lgmd.Eye(4 * SEEN.rows, 4 * SEEN.cols, SEEN.degrees_per_pixel / 4, 24)
START_MS, END_MS, ALARM_MS = -4000, 500, -1000
LABELS = """\
#:schema ../lgmd2jax/schemas/labels.json
# A rendered collision, for a first look: made by `python -m benchmarks.crash_clip`.
[eye]                       # what clips are resized to: here to the scale of the rendered ones
rows = 20
cols = 36
degrees_per_pixel = 1.95
fps = 30
[[clip]]
file = "crash.mp4"
alarm = [[{first}, {last}]]         # frames in which an alarm must be raised; without it the whole clip must be silent
contact = {contact}
drop_duplicates = true
"""


def film() -> lgmd.stimuli.Stimulus:
    """What the camera delivers; contact is at 0 ms."""
    scene = lgmd.stimuli.looming(
        FILM,
        l_over_v=100.0,
        level=30.0,
        background=lgmd.stimuli.Photograph("grass", level=150.0, contrast=0.5),
        stop_angle=100.0,
        start_ms=START_MS,
        end_ms=END_MS,
    )
    return lgmd.stimuli.camera(scene, jax.random.key(0), noise=1.0, blur=0.5)


def write(folder: Path) -> None:
    """Write the clip and its labels."""
    shown = film()
    sources = np.arange(len(shown.time) * SEEN.fps // FILM.fps) * FILM.fps // SEEN.fps
    time = np.asarray(shown.time)[sources]
    with video_writer(folder / "crash.mp4", SEEN.fps) as writer:
        for number, frame in enumerate(np.asarray(shown.frames)[sources].astype(np.uint8)):
            writer.write(np.repeat(frame[..., None], 3, axis=2), 1000 * number / SEEN.fps)
    first, contact = (int(np.argmax(time >= moment)) for moment in (ALARM_MS, 0))
    (folder / "crash.toml").write_text(LABELS.format(first=first, last=contact, contact=contact), encoding="utf-8")


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    write(FOLDER)
