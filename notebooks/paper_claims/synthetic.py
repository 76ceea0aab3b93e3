"""Claims 1 to 14: synthetic stimuli without noise, LGMD2 and LGMD1 beside each other.

Peaks are up to the end of motion.
"""

import numpy as np

from notebooks.paper_claims._claim import Finding, claim, falls, listed
from notebooks.paper_claims._shown import REST, T_SP, Seen, shown

DEPTH = [f"{shade} {motion}" for shade in ("dark", "light") for motion in ("approach", "recession")]
TRANSLATIONS = [f"{shade} translation {direction} deg" for shade in ("dark", "light") for direction in (0, 180)]
CONTRASTS, EDGE_SPEEDS = (0.2, 0.4, 0.6, 0.8, 1.0), (30, 60, 120, 240)
BRIEF_MS, WEAK = 400, 0.82  # this project's reading: above .55 for less, and no higher than just past T_sp


def both(condition: str, **changes) -> tuple[Seen, Seen]:
    """LGMD2 and LGMD1."""
    return shown("LGMD2", "paper", condition, **changes), shown("LGMD1", "paper", condition, **changes)


@claim(1, "Fig. 5a", "A dark approach raises the SMP steeply, in both LGMDs.")
def dark_approach() -> Finding:
    """To what, and in what time."""
    two, one = both("dark approach")
    times = []
    for it in (two, one):
        smp = it.during("smp_adapted")[0]
        first = {level: np.argmax(smp >= level) for level in (0.6, 0.9)}
        times.append(float(it.time[first[0.9]] - it.time[first[0.6]]))
    return Finding(
        f"LGMD2 peaks at {two.peak():.3f} {-two.peak_time:.0f} ms before the end, LGMD1 at {one.peak():.3f}; "
        f".6 to .9 in {times[0]:.0f} and {times[1]:.0f} ms",
        {"LGMD2": two.peak() > 0.9 and times[0] < 200, "LGMD1": one.peak() > 0.9 and times[1] < 200},
    )


@claim(2, "Fig. 5a", "A dark recession inhibits the LGMD2 throughout.")
def dark_recession() -> Finding:
    """The highest SMP of the whole clip."""
    smp = shown("LGMD2", "paper", "dark recession").smp_adapted.max()
    return Finding(f"SMP at most {smp:.3f} in the whole clip", {"LGMD2 at rest": smp <= REST})


@claim(3, "Fig. 5b", "A light approach gives no response of the LGMD2.")
def light_approach() -> Finding:
    """The highest SMP of the whole clip."""
    smp = shown("LGMD2", "paper", "light approach").smp_adapted.max()
    return Finding(f"SMP at most {smp:.3f} in the whole clip", {"LGMD2 at rest": smp <= REST})


@claim(4, "Fig. 5b", "A light recession excites the LGMD2 briefly; it adapts fast.")
def light_recession() -> Finding:
    """How long, with and without adaptation."""
    two, without = (shown(name, "paper", "light recession") for name in ("LGMD2", "LGMD2 without SFA"))
    return Finding(
        f"peak {two.peak():.3f}; above .55 for {two.above(0.55):.0f} ms, {without.above(0.55):.0f} ms without SFA",
        {
            "excited": two.peak() > 0.9,
            "brief": two.above(0.55) < BRIEF_MS,
            "adapts": two.above(0.55) < without.above(0.55),
        },
    )


@claim(5, "Fig. 5", "The LGMD1 has a high potential in all four movements in depth.")
def lgmd1_in_depth() -> Finding:
    """Its peaks, and how long they stay."""
    four = [shown("LGMD1", "paper", name) for name in DEPTH]
    shares = [float((it.smp[it.moving] > T_SP).mean()) for it in four]
    return Finding(
        f"LGMD1 peaks {listed(it.peak() for it in four)}; above {T_SP:g} in {min(shares):.0%} of the movement or more",
        {"peaks": min(it.peak() for it in four) > 0.9, "stays": min(shares) > 0.5},
    )


def peaks_by_contrast_and_speed() -> np.ndarray:
    """Peak SMP of the LGMD2, a row a contrast, a column a speed of the edge."""
    names = [[f"contrast -{c:g}, edge {speed} px/s" for speed in EDGE_SPEEDS] for c in CONTRASTS]
    return np.array([[shown("LGMD2", "paper", name).peak() for name in row] for row in names])


@claim(6, "Fig. 6", "The peak grows with contrast, most where the edge is slow.")
def peak_by_contrast() -> Finding:
    """At the slowest and the fastest edge."""
    peaks = peaks_by_contrast_and_speed()
    gains = peaks[-1] - peaks[0]
    return Finding(
        f"from contrast .2 to 1: {listed(peaks[:, 0])} at {EDGE_SPEEDS[0]} px/s, {listed(peaks[:, -1])} at "
        f"{EDGE_SPEEDS[-1]} px/s",
        {"grows": bool(np.all(np.diff(peaks, axis=0) > -1e-3)), "most when slow": gains.argmax() == 0},
    )


@claim(7, "Fig. 6", "The influence of contrast shrinks as the speed grows.")
def contrast_by_speed() -> Finding:
    """The range of peaks over contrasts."""
    ranges = np.ptp(peaks_by_contrast_and_speed(), axis=0)
    speeds = ", ".join(map(str, EDGE_SPEEDS))
    return Finding(f"range over contrasts {listed(ranges)} at {speeds} px/s", {"shrinks": falls(list(ranges))})


@claim(8, "Fig. 7a, b", "Translation, dark or light, either way, is answered weakly and briefly, at its beginning.")
def translation() -> Finding:
    """Peak, when, for how long; spikes."""
    runs = [shown("LGMD2", "paper", name) for name in TRANSLATIONS]
    peaks = [it.peak() for it in runs]
    return Finding(
        f"peaks {listed(peaks)} (approach .937) by {max(it.peak_time for it in runs):.0f} ms, above .55 for "
        f"{max(it.above(0.55) for it in runs):.0f} of {runs[0].moving.sum() * 1000 / 30:.0f} ms; "
        f"{runs[0].spike_counts[0]:.0f} spikes, no alarm",
        {
            "weak": max(peaks) < WEAK and not any(it.alarms for it in runs),
            "brief": max(it.above(0.55) for it in runs) < BRIEF_MS,
            "at the beginning": max(it.peak_time for it in runs) < BRIEF_MS / 2,
        },
    )


@claim(9, "Fig. 7a, b", "There is no difference between directions, in either LGMD.")
def directions() -> Finding:
    """The largest difference of the SMP at any time."""
    apart = {}
    for name in ("LGMD2", "LGMD1"):
        runs = [shown(name, "paper", condition).smp_adapted for condition in TRANSLATIONS]
        apart[name] = max(np.abs(runs[0] - runs[1]).max(), np.abs(runs[2] - runs[3]).max())
    measured = ", ".join(f"{name} {value:.3f}" for name, value in apart.items())
    return Finding(f"SMP differs by at most: {measured}", {name: value < 1e-3 for name, value in apart.items()})


@claim(10, "Fig. 7a, b", "The LGMD1 stays high to the end of a translation.")
def lgmd1_in_translation() -> Finding:
    """Its lowest SMP while the object moves."""
    lowest = [float(it.smp[it.moving].min()) for it in (shown("LGMD1", "paper", name) for name in TRANSLATIONS)]
    return Finding(f"LGMD1 at least {min(lowest):.3f} throughout", {"high": min(lowest) > T_SP})


EDGES = [f"{shade} {motion}" for shade in ("dark", "light") for motion in ("elongating", "shortening")]


@claim(11, "Fig. 7c, d", "The LGMD2 answers, briefly, only dark elongation and light shortening.")
def single_edge() -> Finding:
    """Peaks of all four."""
    runs = {name: shown("LGMD2", "paper", name) for name in EDGES}
    darken = [runs["dark elongating"], runs["light shortening"]]
    lighten = [runs["dark shortening"], runs["light elongating"]]
    return Finding(
        "; ".join(f"{name} {it.peak():.3f}" for name, it in runs.items())
        + f"; above .55 for {max(it.above(0.55) for it in darken):.0f} of {darken[0].moving.sum() * 1000 / 30:.0f} ms",
        {
            "answers": min(it.peak() for it in darken) > 0.75,
            "briefly": max(it.above(0.55) for it in darken) < BRIEF_MS,
            "only these": max(it.smp_adapted.max() for it in lighten) <= REST,
        },
    )


@claim(12, "Fig. 7c, d", "The LGMD1 answers elongation and shortening, dark and light.")
def lgmd1_single_edge() -> Finding:
    """Peaks of all four."""
    peaks = [shown("LGMD1", "paper", name).peak() for name in EDGES]
    return Finding(f"LGMD1 peaks {listed(peaks)}", {"all": min(peaks) > T_SP})


LIGHTS = [f"{change} and back, 1000 ms, 0.25 of the field" for change in ("darkening", "lighting")]


@claim(
    13,
    "Fig. 8",
    "Both LGMDs are inhibited while a sub-field darkens and lights up again, or the reverse.",
    choices={"steps instead of ramps of 1 s": {"ramp_ms": 0}},
)
def luminance(ramp_ms: int = 1000) -> Finding:
    """SMP, FFI and spikes, for a quarter of the field and 140 grey levels."""
    two, one = zip(*(both(name, ramp_ms=ramp_ms) for name in LIGHTS), strict=True)
    peaks = [max(it.smp_adapted.max() for it in runs) for runs in (two, one)]
    return Finding(
        f"SMP at most {peaks[0]:.3f} (LGMD2) and {peaks[1]:.3f} (LGMD1), FFI {max(it.peak('ffi') for it in two):.1f}; "
        + (
            "a frame changes by 4.7 levels, less than T_s, so it is the S layer that stays shut"
            if ramp_ms
            else "the LGMD2 fires as its gate reopens, a frame after the field darkens; the LGMD1 fires at the step"
        ),
        {"LGMD2": peaks[0] <= REST, "LGMD1": peaks[1] <= REST},
    )


GRATINGS = [f"grating {cycles} cycles, 10 Hz" for cycles in (1, 5, 10, 20, 30, 50, 100)]
GRATINGS += [f"grating 10 cycles, {frequency} Hz" for frequency in (1, 2, 5, 14)]


@claim(14, "Fig. 9", "Gratings of any spatial and temporal frequency leave the LGMD2 quiet for six seconds.")
def gratings() -> Finding:
    """Cycles per image at 10 Hz, and frequencies at 10 cycles; Michelson contrast 1 on 127."""
    runs = [shown("LGMD2", "paper", name) for name in GRATINGS]
    smp, ffi = max(it.peak() for it in runs), [it.peak("ffi") for it in runs]
    return Finding(
        f"1 to 100 cycles per image at 10 Hz, 1 to 14 Hz at 10 cycles: SMP at most {smp:.3f} while they move, FFI "
        f"{min(ffi):.0f} to {max(ffi):.0f}; a burst of up to {max(it.burst for it in runs):.3f} when they stop. The "
        "paper's cycles per pixel end at .5, and at 30 fps nothing is faster than 15 Hz: its 20 Hz is seen as 10 Hz",
        {"quiet": smp <= REST},
    )
