"""Whether the response peaks at one angle of the disc for all contrasts and speeds: 1,000 looms for each circuit.

python -m benchmarks.threshold_angle                                  prints the figures, a minute on two cores
python -m benchmarks.threshold_angle --figure fits/lgmd2/surface.png  draws the surfaces as well

Dark discs approach from 2 to 80 degrees, at 20 contrasts and 50 l/|v|: Table I, the fit `lgmd2`, and the same without
size-coding inhibition. The threshold angle is the full angle of the disc 25 ms and a frame before the peak of the
response, as in the 22 response properties: so much is allowed for the delay of the cell. R = 1 is the peak of the
intact circuit at Weber -.9 and 40 ms.
"""

import argparse
import dataclasses
from pathlib import Path

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

import lgmd2jax as lgmd
from benchmarks._surface_figure import Surfaces, surface_figure
from lgmd2jax._characterise.curves import Stack, peak, rise_and_fall
from lgmd2jax._characterise.trials import LARGE, SMALL
from lgmd2jax._compute import xla
from lgmd2jax._files.atomic import replaced

CONTRASTS = -np.linspace(0.05, 1, 20)  # Weber
L_OVER_V = np.geomspace(10, 80, 50)  # ms
STRONG = CONTRASTS <= -0.299  # where the angle is asked to be one
EARLY = 20.0  # degrees; below, inhibition is not yet significant (Gabbiani, Cohen & Laurent 2005)
ALLOWANCE = 25.0  # ms; a frame comes on top
REST_MS = 200.0

TABLE_I, FIT, WITHOUT_SIZE = "Table I", "fit lgmd2", "fit lgmd2 without size"


def looms(model: lgmd.LGMD2, eye: lgmd.Eye):
    """The responses above rest to all looms, by one sweep."""
    responses = lgmd.sweep(
        model,
        lgmd.stimuli.looming,
        eye,
        contrast=CONTRASTS,
        l_over_v=L_OVER_V,
        background=200.0,
        start_angle=SMALL,
        stop_angle=LARGE,
        channels=("smp_adapted",),
        progress=True,
    ).smp_adapted
    rest = responses.isel(time=responses.time < float(responses.time[0]) + REST_MS)
    return responses - rest.mean("time")


def reference_of(responses) -> float:
    """The peak at Weber -.9 and the l/|v| next to 40 ms."""
    return float(responses.sel(contrast=-0.9, l_over_v=40.0, method="nearest").max())


def surfaces_of(responses, reference: float) -> Surfaces:
    """The surfaces of responses above rest, in units of a reference."""
    curves, time = responses.values / reference, responses.time.values
    frame, shape, l_over_v = float(time[1] - time[0]), curves.shape[:2], np.tile(L_OVER_V, len(CONTRASTS))
    begin, end = (-l_over_v / np.tan(np.radians(angle / 2)) for angle in (SMALL, LARGE))
    flat = jnp.asarray(curves.reshape(-1, len(time)))
    stack = Stack(flat, np.broadcast_to(time, flat.shape), begin, end, (len(time),) * len(flat), frame)
    top, moment = (np.asarray(each) for each in peak(stack))
    angle = full_angle(l_over_v, moment - ALLOWANCE - frame)
    fall = np.asarray(rise_and_fall(stack)[1])
    return Surfaces(curves, time, *(each.reshape(shape) for each in (angle, top, fall)))


def full_angle(l_over_v, time):
    """The angle that a disc subtends at a time in ms before the collision, in degrees."""
    return 2 * np.degrees(np.arctan2(l_over_v, -time))


def early_until(frame: float) -> Float[np.ndarray, " l_over_v"]:
    """Up to when, in ms, the cell answers what it saw of a disc of less than 20 degrees."""
    return ALLOWANCE + frame - L_OVER_V / np.tan(np.radians(EARLY / 2))


def angle_lines(surfaces: dict[str, Surfaces]) -> list[str]:
    """How far the threshold angle is one, over contrasts of -.3 to -1 and 10 to 80 ms."""
    lines = [
        "threshold angle, deg, Weber -.3 to -1, l/|v| 10 to 80 ms",
        f"{'':24}   mean  s.d.   from     to   most over contrasts   most over l/|v|   within 5 deg",
    ]
    for name, each in surfaces.items():
        angle = each.angle[STRONG]
        over_contrasts, over_speeds = (np.ptp(angle, axis=axis).max() for axis in (0, 1))
        lines.append(
            f"{name:24} {angle.mean():6.1f} {angle.std():5.1f} {angle.min():6.1f} {angle.max():6.1f} "
            f"{over_contrasts:21.1f} {over_speeds:17.1f} {most_within(angle, 5.0):13.0%}"
        )
    return lines


def most_within(angle: Float[np.ndarray, "..."], width: float) -> float:
    """The largest share of the angles that lies within a window of this width."""
    ordered = np.sort(angle, axis=None)
    beyond = np.searchsorted(ordered, ordered + width, side="right")
    return float((beyond - np.arange(ordered.size)).max() / ordered.size)


def picrotoxin_lines(intact: Surfaces, without: Surfaces) -> list[str]:
    """What the response is without the inhibition, beside the intact one."""
    early = intact.time < early_until(intact.time[1] - intact.time[0])[:, None]
    apart = np.abs(without.curves - intact.curves)[STRONG][:, early].max()
    falls = [surfaces.fall[STRONG] for surfaces in (intact, without)]
    longer, higher = falls[1] / falls[0], without.peak[STRONG] / intact.peak[STRONG]
    return [
        "without size-coding inhibition, the same looms",
        f"R up to {EARLY:g} degrees: changes by at most {apart:.4f}",
        f"from the peak to its half: {longer.min():.1f} to {longer.max():.1f} times as long, in the median "
        f"{np.median(falls[1]):.0f} ms instead of {np.median(falls[0]):.0f}",
        f"peak: {higher.min():.2f} to {higher.max():.2f} times as high",
    ]


def main() -> None:
    """Make the sweeps, print the figures, and draw the surfaces where a name is given."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", default="fits/lgmd2/model.json", help="hand-over file (default: %(default)s)")
    parser.add_argument("--figure", type=Path, help="draw the surfaces here")
    options = parser.parse_args()
    xla.set_flags()
    fit = lgmd.load(options.model)
    table = lgmd.at_frame_rate(lgmd.LGMD2(eye=dataclasses.replace(fit.eye, fps=30.0)), fit.eye.fps)
    circuits = {TABLE_I: table, FIT: fit, WITHOUT_SIZE: lgmd.ablate(fit, "size")}
    responses = {name: looms(model, fit.eye) for name, model in circuits.items()}
    references = {name: reference_of(each) for name, each in responses.items()}
    references[WITHOUT_SIZE] = references[FIT]
    surfaces = {name: surfaces_of(each, references[name]) for name, each in responses.items()}
    print("\n".join([*angle_lines(surfaces), "", *picrotoxin_lines(surfaces[FIT], surfaces[WITHOUT_SIZE])]))
    if options.figure:
        with replaced(options.figure) as temporary:
            surface_figure(temporary, surfaces, CONTRASTS, L_OVER_V, early_until(1000 / fit.eye.fps))
        print(f"wrote {options.figure}")


if __name__ == "__main__":
    main()
