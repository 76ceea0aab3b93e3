"""Claims 15 to 20: what the paper recorded, by photographs, a camera model, and repeats in noise and clock phase."""

import numpy as np

from notebooks.paper_claims._claim import Finding, claim, falls, listed, rises, shares, spread
from notebooks.paper_claims._shown import REST, Seen, shown

T_FFI = 10
SCENES = ("camera", "gravel")
REPEATS, FEWER = 10, 5  # as in the paper
WINDOW = {"start_ms": -1500, "end_ms": 300}  # of an approach, ms: before it nothing happens
ANGLES, SPEEDS, TURNS = (0, 3, 6, 12), (30, 60, 120), (30, 90)


def at_the_end(channel: np.ndarray, moving: np.ndarray) -> np.ndarray:
    """A channel in the last frame in which the scene changes, a value a repeat."""
    return channel[moving & ~np.roll(moving, -1, axis=1)]


@claim(
    15, "Fig. 10a", "An approach ends in high-frequency spikes, is then cut by FFI; SFA attenuates it only slightly."
)
def approach() -> Finding:
    """Two backgrounds, five repeats each."""
    runs = [shown("LGMD2", "cluttered", f"approach over {scene}", FEWER, **WINDOW) for scene in SCENES]
    last = [at_the_end(it.smp, it.moving) for it in runs]
    cut = [float((it.moving & (it.ffi > T_FFI)).sum(axis=1).mean() * 1000 / 30) for it in runs]
    loss = [it.peak("smp") - it.peak() for it in runs]
    return Finding(
        f"two spikes a frame at the peak of {listed(it.peak() for it in runs)}, {-runs[0].peak_time:.0f} ms before the "
        f"end; cut for the last {listed(cut, 0)} ms, by an FFI of up to {listed((it.peak('ffi') for it in runs), 1)}; "
        f"SFA takes {listed(loss)} off the peak",
        {
            "spikes": min(it.peak("spikes") for it in runs) == 2,
            "cut": max(it.max() for it in last) <= REST,
            "slightly": max(loss) < 0.1,
        },
    )


@claim(16, "Fig. 10b", "A recession leaves it quiet from the start.")
def recession() -> Finding:
    """The whole clip."""
    smp = max(
        shown("LGMD2", "cluttered", f"recession over {it}", FEWER, end_ms=1500).smp_adapted.max() for it in SCENES
    )
    return Finding(f"SMP at most {smp:.3f} in the whole clips", {"quiet": smp <= REST})


def approaches(
    name: str = "LGMD2", angles: tuple = ANGLES, fps: float | None = None, repeats: int = REPEATS
) -> dict[str, Seen]:
    """A run an angle."""
    base = f"approach at an angle of {ANGLES[0]} deg"
    return {
        f"{it:g} deg": shown(name, "cluttered", base, repeats, fps=fps, deviation=float(it), **WINDOW) for it in angles
    }


@claim(
    17,
    "Fig. 11",
    "With a growing angle of approach the peak comes later, SMP and FFI peak lower, and spikes are fewer.",
    choices={
        "angles 0, .5, 1 deg": {"angles": (0, 0.5, 1), "repeats": FEWER},
        "60 fps, thresholds as they are": {"fps": 60.0, "repeats": FEWER},
        "n_p = 1": {"name": "LGMD2, n_p 1", "repeats": FEWER},
        "fitted parameters": {"name": "fitted", "repeats": FEWER},
    },
)
def angles(name: str = "LGMD2", angles: tuple = ANGLES, fps: float | None = None, repeats: int = REPEATS) -> Finding:
    """What passes by leaves the field of 72 degrees before it is nearest."""
    runs = list(approaches(name, angles, fps, repeats).values())
    times = [it.peak_time for it in runs]
    smp, ffi = [it.peak() for it in runs], [it.peak("ffi") for it in runs]
    counts = [it.spike_counts for it in runs]
    return Finding(
        f"at {', '.join(f'{angle:g}' for angle in angles)} deg: peaks at {listed(times, 0)} ms, SMP {listed(smp)}, FFI "
        f"{listed(ffi, 1)}, spikes {spread(((n.mean(), n.std()) for n in counts), 1)}",
        {
            "later": rises(times),
            "SMP falls": falls(smp),
            "FFI falls": falls(ffi),
            "spikes fall": falls([n.mean() for n in counts if n.any()]) and counts[-1].mean() < counts[0].mean(),
        },
    )


def translations() -> dict[str, Seen]:
    """Five repeats a speed."""
    return {f"{it} deg/s": shown("LGMD2", "cluttered", f"translation at {it} deg/s", FEWER) for it in SPEEDS}


@claim(18, "Fig. 12", "Translation over clutter stays below approach.")
def translation() -> Finding:
    """The peaks of both."""
    peaks = [it.peak() for it in translations().values()]
    loom = shown("LGMD2", "cluttered", "approach over camera", FEWER, **WINDOW).peak()
    return Finding(
        f"peaks {listed(peaks)} at {', '.join(map(str, SPEEDS))} deg/s, {loom:.3f} for the approach; alarms in "
        f"{shares(it.alarms for it in translations().values())} of repeats: a difference in peaks, not in alarms",
        {"below": max(peaks) < loom},
    )


@claim(19, "Fig. 12", "Its peak grows with the angular speed.")
def translation_by_speed() -> Finding:
    """With its spread over repeats."""
    runs = list(translations().values())
    peaks = [it.peak() for it in runs]
    measured = spread((it.peak(), it.spread()) for it in runs)
    return Finding(f"peaks {measured} at {', '.join(map(str, SPEEDS))} deg/s", {"grows": rises(peaks)})


@claim(20, "Fig. 13", "A turning scene suppresses it throughout, with the FFI above its threshold to the end.")
def turning() -> Finding:
    """Two speeds, both ways, five repeats each."""
    runs = [
        shown("LGMD2", "cluttered", f"turning {way} at {s} deg/s", FEWER) for s in TURNS for way in ("left", "right")
    ]
    smp = max(float(it.during("smp_adapted").max()) for it in runs)
    later = max(float(np.where(np.cumsum(it.moving, axis=1) > 1, it.during("smp_adapted"), 0).max()) for it in runs)
    last = min(float(at_the_end(it.ffi, it.moving).min()) for it in runs)
    share = min(float((it.ffi[it.moving] > T_FFI).mean()) for it in runs)
    return Finding(
        f"no spike; SMP at most {smp:.3f} in the first frame, where the scene has hardly moved, {later:.3f} in all "
        f"others; FFI above {T_FFI} in {share:.0%} of the turn, {last:.0f} at its end; a burst of up to "
        f"{max(it.burst for it in runs):.3f} as it stops",
        {
            "suppressed": sum(it.spike_counts.sum() for it in runs) == 0 and later <= REST,
            "FFI to the end": last > T_FFI,
        },
    )
