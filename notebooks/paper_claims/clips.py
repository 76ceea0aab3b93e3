"""Claims 15, 16, 18 and 20 on filmed clips: the LGMD2 of Table I on what dash cameras and a hand-held camera saw.

The clips are not in this project: their folder is named by LGMD2JAX_DATA, else it is ../shared/data beside it. Each is
seen as by `lgmd2jax respond CLIP --resize 108 --drop-duplicates`, at its own frame rate less the repeats.
"""

import dataclasses
import functools
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

import lgmd2jax as lgmd
from lgmd2jax._video.clip import open_clip
from lgmd2jax.alarms._decoding import decode
from notebooks.paper_claims._claim import Finding, listed
from notebooks.paper_claims._shown import REST

WIDTH = 108  # pixels
FOLDER = Path(os.environ.get("LGMD2JAX_DATA", Path(__file__).parents[3] / "shared" / "data")) / "clips"
# First and last frame of what happens, judged by eye.
CRASH, COLLISION = ("c29", 126, 174), 174  # into a dark car
RECEDING = {"car": ("nc03", 91, 150), "bottle": ("cup", 111, 152)}
COMING = ("cup", 163, 205)  # the same bottle, slowly
PASSING = {"road": ("c29", 0, 125), "hedge": ("nc03", 0, 64), "bottle to and fro": ("cup", 41, 110)}


@dataclasses.dataclass(frozen=True)
class Part:
    """The channels while something happens; `frame` is the clip's own count, repeats left out."""

    frame: Int[np.ndarray, " time"]
    ffi: Float[np.ndarray, " time"]
    smp: Float[np.ndarray, " time"]
    smp_adapted: Float[np.ndarray, " time"]
    spikes: Float[np.ndarray, " time"]
    collision: Float[np.ndarray, " time"]

    @property
    def peak(self) -> float:
        """The highest U'."""
        return float(self.smp_adapted.max())

    @property
    def alarms(self) -> Int[np.ndarray, " alarm"]:
        """The frames with an alarm."""
        return self.frame[self.collision > 0.5]


@functools.cache
def _response(name: str) -> tuple[np.ndarray, lgmd.Response]:
    """A clip's frames by number, and what the whole clip is answered."""
    path = FOLDER / f"{name}.mp4"
    seen = decode(open_clip(path, resize=WIDTH), path, drop_duplicates=True)
    return seen.index, lgmd.LGMD2()(seen.frames, seen.fps)


def part(name: str, first: int, last: int) -> Part:
    """What happens from one frame to another, after all that came before."""
    number, response = _response(name)
    inside = (number >= first) & (number <= last)
    channels = {it.name: np.asarray(getattr(response, it.name))[inside] for it in dataclasses.fields(Part)[1:]}
    return Part(number[inside], **channels)


def approach() -> Finding:
    """Claim 15 on the crash: what is left of it at the collision, and what SFA took."""
    it = part(*CRASH)
    loss = float(it.smp.max()) - it.peak
    return Finding(
        f"crash into a dark car: {it.spikes.max():g} spikes a frame at the peak of {it.peak:.3f} in frame "
        f"{it.frame[it.smp_adapted.argmax()]}, first alarm in {it.alarms[0]}, collision in {COLLISION}; FFI up to "
        f"{it.ffi.max():.1f}, SMP before SFA {it.smp[-1]:.3f} at the collision; SFA takes {loss:.3f} off the peak",
        {"spikes": it.spikes.max() == 2, "cut": it.smp[-1] <= REST, "slightly": loss < 0.1},
    )


def recession() -> Finding:
    """Claim 16 on a car that draws away and a bottle that is moved away."""
    runs = {name: part(*where) for name, where in RECEDING.items()}
    peaks, spikes = [it.peak for it in runs.values()], [it.spikes.sum() for it in runs.values()]
    return Finding(
        f"{' and '.join(runs)} that recede: SMP up to {listed(peaks)}, the bottle as it comes again "
        f"{part(*COMING).peak:.3f}; spikes {listed(spikes, 0)}; the first clip is filmed while driving, the second has "
        "a hand in it",
        {
            "no spike": not any(spikes),
            "quiet": max(peaks) <= REST,
        },
    )


def translation() -> Finding:
    """Claim 18 on what passes by, against the crash."""
    runs = {name: part(*where) for name, where in PASSING.items()}
    crash = part(*CRASH).peak
    return Finding(
        f"{', '.join(runs)}: peaks {listed(it.peak for it in runs.values())}, crash {crash:.3f}; alarms in "
        f"{listed((len(it.alarms) for it in runs.values()), 0)} frames",
        {"below": max(it.peak for it in runs.values()) < crash},
    )


def turning() -> Finding:
    """Claim 20: nothing at hand shows it."""
    return Finding("not measured: in none of the clips does the camera turn", {})


ON_CLIPS: dict[int, Callable[[], Finding]] = {15: approach, 16: recession, 18: translation, 20: turning}


def on_clips(number: int) -> Finding:
    """A claim on the clips, or why it is not measured."""
    if not FOLDER.is_dir():
        return Finding("not measured: the clips are not here; LGMD2JAX_DATA names the folder that holds clips/", {})
    return ON_CLIPS[number]()
