"""Claims 26 to 32: what the paper's text says of the model."""

import numpy as np

import lgmd2jax as lgmd
from benchmarks import cortex_m4
from notebooks.paper_claims._claim import Finding, claim, listed
from notebooks.paper_claims._shown import REST, T_SP, Seen, conditions, network, shown
from notebooks.paper_claims.recorded import FEWER
from notebooks.paper_claims.synthetic import DEPTH


def share_left(it: Seen) -> float:
    """Of the excitation above rest that the adaptation leaves, summed over the movement."""
    return float((it.during("smp_adapted", 0.5) - 0.5).sum() / (it.during("smp", 0.5) - 0.5).sum())


@claim(26, "III-C, III-F", "Balanced thetas act as a LGMD1; the opposite ones answer light objects only.")
def thetas() -> Finding:
    """Approach and recession, dark and light."""
    balanced, light = ([shown(name, "paper", it).peak() for it in DEPTH] for name in ("balanced", "light-selective"))
    return Finding(
        f"{', '.join(DEPTH)}: balanced {listed(balanced)}; light-selective {listed(light)}: of dark objects it answers "
        "what recedes, in the mirror of a LGMD2, which answers light ones that recede",
        {
            "balanced answers all": min(balanced) > T_SP,
            "opposite: light approach": light[2] > T_SP and light[0] <= REST,
            "no dark object at all": max(light[:2]) <= REST,
        },
    )


ARENAS = 100
WIDE = [("cluttered", "turning left at 90 deg/s"), ("paper", "grating 10 cycles, 10 Hz")]


@claim(27, "III-E", "Without FFI both neurons fire at rapid change in a wide field.")
def without_ffi() -> Finding:
    """A turn and a grating, with and without."""
    counts, stays = {}, {}
    for name in ("LGMD2", "LGMD1"):
        for network_name in (name, f"{name} without FFI"):
            runs = [shown(network_name, protocol, it, FEWER) for protocol, it in WIDE]
            counts[network_name] = [float(it.spike_counts.mean()) for it in runs]
        stays[name] = all(a + 1 < b for a, b in zip(counts[name], counts[f"{name} without FFI"], strict=True))
    measured = "; ".join(f"{name} {listed(values, 1)}" for name, values in counts.items())
    return Finding(f"spikes in a turn and a grating: {measured}", stays)


@claim(28, "III-C", "Grouping enhances the edges of what expands against clutter.")
def grouping() -> Finding:
    """A disc before gravel that drifts at 10 deg/s: the S' and the G layer, 300 ms before the end."""
    condition = conditions("cluttered")["approach, gravel drifting at 10 deg/s"]
    stimulus = condition.render()
    last = int(np.searchsorted(stimulus.time, -300))
    clip = stimulus.frames[last - 8 : last + 1]
    model = network("LGMD2", condition.eye)
    maps = model(clip, stimulus.fps, record=lambda layers: (layers.s_gated, layers.g)).recorded
    s, g = (np.asarray(it[-1], float) for it in maps)
    right, up = condition.eye.pixel_centres()
    beyond = np.hypot(right, up) - float(stimulus.courses["radius_px"][last])
    edge, clutter = np.abs(beyond) < 5, beyond > 15
    stands_out = [float(it[edge].mean() / it[clutter].std()) for it in (s, g)]
    apart = abs(g.sum() / s.sum() - 1)
    rounding = " but for rounding" if apart < 1e-6 else ""
    return Finding(
        f"mean at the edge by the s.d. of the clutter: {stands_out[0]:.1f} in S', {stands_out[1]:.1f} in G; but sum(G) "
        f"is sum(S'){rounding}, and the cell sees the sum alone: nothing of it reaches MP, SMP or spikes",
        {"in the map": stands_out[1] > stands_out[0], "in the response": bool(apart > 1e-6)},
    )


@claim(29, "IV-E", "SFA hardly touches movements that accelerate.")
def acceleration() -> Finding:
    """The share of excitation that is left of approach, of translation at constant and at growing speed."""
    constant, linear, squared = (
        share_left(shown("LGMD2", "paper", "dark translation 0 deg", profile=profile))
        for profile in ("constant", "linear", "accelerating")
    )
    loom = share_left(shown("LGMD2", "paper", "dark approach"))
    return Finding(
        f"SFA leaves {loom:.0%} of an approach, {linear:.0%} and {squared:.0%} of translations whose speed grows with "
        f"t and t^2, {constant:.0%} of one at constant speed; of any rise, c = tau3/(tau3 + ti) = .94 is left",
        {"accelerating": min(loom, linear, squared) > 0.75, "constant": constant < 0.25},
    )


@claim(30, "IV-C", "ON and OFF pathways and SFA are crucial for the selectivity.")
def ablations() -> Finding:
    """Without bias between the pathways, and without adaptation."""
    biased, balanced = (shown(name, "paper", "light approach").peak() for name in ("LGMD2", "balanced"))
    with_sfa, without = (
        [shown(name, "paper", it).above(0.55) for it in ("dark translation 0 deg", "light recession")]
        for name in ("LGMD2", "LGMD2 without SFA")
    )
    return Finding(
        f"light approach {biased:.3f}, {balanced:.3f} with balanced pathways; translation and light recession above "
        f".55 for {listed(with_sfa, 0)} ms, {listed(without, 0)} ms without SFA",
        {
            "pathways": biased <= REST and balanced > T_SP,
            "SFA": all(1.5 * a < b for a, b in zip(with_sfa, without, strict=True)),
        },
    )


@claim(
    31, "Fig. 14", "A robot in an arena avoids collisions.", {"fitted, thresholds set for the arena": {"name": "lgmd2"}}
)
def arena(name: str = "table1") -> Finding:
    """A simulated robot for a minute in each of 100 arenas, beside one that sees nothing."""
    detectors = lgmd.arena.detectors()
    seeing, blind = (lgmd.arena.Outcome.of(*lgmd.arena.run(detectors[each], range(ARENAS))) for each in (name, "none"))
    fewer, coverage = seeing.collisions_by(blind), seeing.coverage_by(blind)
    return Finding(
        f"simulated, {ARENAS} arenas: {seeing.collisions_per_metre} collisions a metre, {blind.collisions_per_metre} "
        f"without a detector; the floor covered is {coverage} of that without",
        {"a quarter of the collisions or fewer": fewer.high <= 0.25, "70 % of the coverage": coverage.value >= 0.7},
    )


@claim(32, "IV-A", "Vision and decision take less than 30 ms a frame on the robot's micro-controller.")
def controller() -> Finding:
    """An estimate: by the instructions of a frame on an emulated core, and the cycles that ARM states for each."""
    footprint = cortex_m4.measure(lgmd.LGMD2(eye=cortex_m4.EYE))
    return Finding(
        f"an estimate, not the robot: a frame of the C takes {footprint.instructions:,} instructions on an emulated "
        f"Cortex-M4F, at most {footprint.milliseconds:.1f} ms at 168 MHz by ARM's cycles for each; "
        f"{footprint.ram:,} bytes of RAM",
        {"below 30 ms": footprint.milliseconds < 30, "in 192 KB": footprint.ram < 192 * 1024},
    )
