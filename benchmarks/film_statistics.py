"""Whether rendered films resemble real ones: both are measured in the same way, source by source.

python -m benchmarks.film_statistics LABELS...                 prints quantiles of real, of rendered and of older clips
python -m benchmarks.film_statistics LABELS... --figure FILE   draws them as well; stimuli/films.png is that

LABELS are files of labelled clips; each clip is a source. Without any, the two rendered worlds are compared alone:
`films`, on which `lgmd2jax fit video` is made, and `encounters`, single objects before a screen.
"""

import argparse
import dataclasses
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

import lgmd2jax as lgmd
from lgmd2jax._figures.style import BLUE, GREY, VERMILION, drawn
from lgmd2jax._files.atomic import replaced
from lgmd2jax.alarms import LabelledClip, Rendering, load_labels

EYE = lgmd.Eye(20, 36, 1.95, 30.0, "pinhole")
REAL, FILMS, ENCOUNTERS = "real", "films", "encounters"
SEED = 77  # which no fit uses
ALARM_MS, SILENT_MS = 850, 2000  # before contact, as the real clips were labelled
MOVES = 4.0  # grey levels, from which a pixel counts as changed
REPEATED = 0.02  # grey levels: a frame that changes by less repeats the one before
COARSE = 1 / 8  # cycles a pixel
QUANTILES = 0.1, 0.25, 0.5, 0.75, 0.9
FEWEST = 3  # frames of which a median is taken


@dataclasses.dataclass(frozen=True)
class Measured:
    """What is measured on the frames of a clip, each beside the one before it."""

    clip: LabelledClip

    @property
    def frames(self) -> Float[np.ndarray, "time row col"]:
        """Grey levels."""
        return self.clip.frames.astype(float)

    @property
    def steps(self) -> Float[np.ndarray, "step row col"]:
        """What changes from frame to frame."""
        return np.diff(self.frames, axis=0)

    @property
    def window(self) -> Bool[np.ndarray, " step"]:
        """Which of them lie in a window before a contact."""
        return self.clip.in_windows()[:, 1:].any(axis=0)

    @property
    def silence(self) -> Bool[np.ndarray, " step"]:
        """Which of them lie in silence."""
        return self.clip.in_silence()[1:]

    def change(self) -> Float[np.ndarray, " step"]:
        """The mean of abs(dI) over the field."""
        return np.abs(self.steps).mean(axis=(1, 2))

    def share_that_moves(self) -> Float[np.ndarray, " step"]:
        """Of the field."""
        return (np.abs(self.steps) > MOVES).mean(axis=(1, 2))

    def dark_share(self) -> Float[np.ndarray, " step"]:
        """How much of the change is darkening: one half where as much grows lighter."""
        return np.maximum(-self.steps, 0).sum(axis=(1, 2)) / np.maximum(np.abs(self.steps).sum(axis=(1, 2)), 1e-9)

    def coarse_share(self) -> Float[np.ndarray, " step"]:
        """How much of the power of the change has wavelengths of 8 pixels or more: the spectrum of the change."""
        power = np.abs(np.fft.fft2(self.steps)) ** 2
        down, across = (np.fft.fftfreq(size) for size in self.steps.shape[1:])
        coarse = np.hypot(down[:, None], across) <= COARSE
        return power[:, coarse].sum(axis=1) / np.maximum(power.sum(axis=(1, 2)), 1e-9)

    def own_motion(self) -> Float[np.ndarray, " step"]:
        """The one shift of the whole picture that explains most of a step, by least squares, in pixels a second."""
        down, across = (np.gradient(self.frames[:-1], axis=axis) for axis in (1, 2))
        slopes = np.stack([down.reshape(len(down), -1), across.reshape(len(across), -1)], axis=2)
        normal = np.swapaxes(slopes, 1, 2) @ slopes + 1e-3 * np.eye(2)
        shift = np.linalg.solve(normal, np.swapaxes(slopes, 1, 2) @ -self.steps.reshape(len(down), -1, 1))
        return np.hypot(*shift[..., 0].T) * self.clip.fps

    def flicker(self) -> Float[np.ndarray, " step"]:
        """By how much the mean of the picture changes, in grey levels."""
        return np.abs(self.steps.mean(axis=(1, 2)))


def _median(values: Float[np.ndarray, " step"], among: Bool[np.ndarray, " step"], q: float = 0.5) -> float:
    return float(np.quantile(values[among], q)) if among.sum() >= FEWEST else np.nan


FEATURES: Mapping[str, Callable[[Measured], float]] = {
    "mean abs(dI) in windows, median": lambda m: _median(m.change(), m.window),
    "mean abs(dI) in windows, upper tenth": lambda m: _median(m.change(), m.window, 0.9),
    "mean abs(dI) in silence, median": lambda m: _median(m.change(), m.silence),
    "mean abs(dI) in silence, upper tenth": lambda m: _median(m.change(), m.silence, 0.9),
    "share of the field that moves, windows": lambda m: _median(m.share_that_moves(), m.window),
    "share of the field that moves, silence": lambda m: _median(m.share_that_moves(), m.silence),
    "share of the field that moves, most in silence": lambda m: _median(m.share_that_moves(), m.silence, 1.0),
    "darkening, share of the change, windows": lambda m: _median(m.dark_share(), m.window),
    "coarse share of the change, windows": lambda m: _median(m.coarse_share(), m.window),
    "coarse share of the change, silence": lambda m: _median(m.coarse_share(), m.silence),
    "own motion in silence, pixels/s": lambda m: _median(m.own_motion(), m.silence),
    "flicker in silence, grey levels": lambda m: _median(m.flicker(), m.silence),
    "brightness, grey levels": lambda m: float(m.frames.mean()),
    "contrast, s.d. in grey levels": lambda m: float(m.frames.std(axis=(1, 2)).mean()),
    "repeated frames, share": lambda m: float((m.change() < REPEATED).mean()),
    "frames that differ, 1/s": lambda m: float(m.clip.fps * (m.change() >= REPEATED).mean()),
}
Table = dict[str, dict[str, Float[np.ndarray, " quantile"]]]


def quantiles(clips: Iterable[LabelledClip]) -> dict[str, Float[np.ndarray, " quantile"]]:
    """Of each feature over the clips that have it."""
    measured = [Measured(clip) for clip in clips]
    values = {name: np.array([feature(each) for each in measured]) for name, feature in FEATURES.items()}
    return {name: np.nanquantile(of_clips, QUANTILES) for name, of_clips in values.items()}


def agrees(rendered: Float[np.ndarray, " quantile"], real: Float[np.ndarray, " quantile"]) -> bool:
    """Whether the middle half of what is rendered lies within the spread of real sources, their 10 to 90 %."""
    slack = 1e-6 + 0.05 * (real[-1] - real[0])
    return bool(real[0] - slack <= rendered[1] and rendered[3] <= real[-1] + slack)


def main() -> None:
    """Measure, print, draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("labels", nargs="*", type=Path, metavar="LABELS", help="files of labelled real clips")
    parser.add_argument("--count", type=int, default=200, help="rendered clips of each world")
    parser.add_argument("--figure", type=Path, help="where the figure goes")
    options = parser.parse_args()
    table: Table = {}
    if options.labels:
        table[REAL] = quantiles(clip for file in options.labels for clip in load_labels(file).load())
    for world in (FILMS, ENCOUNTERS):
        rendering = Rendering(options.count, SEED, world=world, alarm_below_ms=ALARM_MS, silent_above_ms=SILENT_MS)
        table[world] = quantiles(rendering.clips(EYE))
    _print(table)
    if options.figure:
        with replaced(options.figure) as place:
            _draw(place, table)
        print(f"wrote {options.figure}")


def _print(table: Table) -> None:
    for name in FEATURES:
        print(name)
        for world, rows in table.items():
            verdict = ""
            if REAL in table and world != REAL:
                verdict = "  within" if agrees(rows[name], table[REAL][name]) else "  outside"
            print(f"  {world:10} " + " ".join(f"{value:8.3g}" for value in rows[name]) + verdict)
    if REAL in table:
        for world in (FILMS, ENCOUNTERS):
            halves = sum(agrees(table[world][name], table[REAL][name]) for name in FEATURES)
            medians = sum(table[REAL][name][0] <= table[world][name][2] <= table[REAL][name][-1] for name in FEATURES)
            print(
                f"{world}: within the 10 to 90 % of real sources lie the median of {medians}, "
                f"the middle half of {halves}, of {len(FEATURES)} features"
            )


def _draw(path: Path, table: Table) -> None:
    """Of each feature 10 to 90 % of the sources as a line, the middle half as a bar, the median as a mark."""
    colours = {REAL: GREY, FILMS: BLUE, ENCOUNTERS: VERMILION}
    with drawn(path, 9, 8.4) as figure:
        grid = figure.subplots(6, 3)
        for axes, name in zip(grid.flat, FEATURES, strict=False):
            for place, (world, rows) in enumerate(table.items()):
                low, first, middle, third, high = rows[name]
                axes.plot([low, high], [-place] * 2, color=colours[world], linewidth=1)
                axes.plot([first, third], [-place] * 2, color=colours[world], linewidth=6, alpha=0.5)
                axes.plot(middle, -place, "|", color="black", markersize=10)
            axes.set_title(name, fontsize=8)
            axes.set_yticks([-place for place in range(len(table))], list(table))
            axes.set_ylim(-len(table) + 0.4, 0.6)
        for axes in grid.flat[len(FEATURES) :]:
            axes.set_axis_off()


if __name__ == "__main__":
    main()
