"""Whether one parameter set gives the same alarms at 10, 15, 30 and 60 frames a second, on the same scenes.

python -m benchmarks.film_rates                    the fit `video`, 100 scenes
python -m benchmarks.film_rates MODEL --count 40   another model, fewer scenes

A verdict is which windows are hit, and whether silence is broken. The set runs as it is, which the time since the last
frame alone adapts, and taken to each rate by `lgmd.at_frame_rate`.
"""

import argparse
from collections.abc import Mapping
from typing import NamedTuple

import jax

import lgmd2jax as lgmd
from lgmd2jax._handover.named import model_named
from lgmd2jax.alarms import Rendering, evaluate

RATES = 10.0, 15.0, 30.0, 60.0
EYE = lgmd.Eye(20, 36, 1.95, 30.0, "pinhole")


class Verdict(NamedTuple):
    """Which windows of a clip are hit, and whether its silence is broken."""

    hits: tuple[bool, ...]
    false_alarm: bool


def verdicts(model: lgmd.LGMD2, count: int, seed: int, fps: float) -> list[Verdict]:
    """Of so many films at a rate."""
    labels = Rendering(count, seed, world="films", alarm_below_ms=850)
    shown = lgmd.stimuli.films(EYE, jax.random.key(seed), count, fps=fps)
    clips = [labels.labelled(film.kind, film) for film in shown]
    return [Verdict(each.hits, each.false_alarms > 0) for each in evaluate(model, clips).verdicts()]


def agreement(by_rate: Mapping[float, list[Verdict]]) -> float:
    """The share of clips whose verdict is the same at all rates."""
    return sum(len(set(of_clip)) == 1 for of_clip in zip(*by_rate.values(), strict=True)) / len(by_rate[RATES[0]])


def main() -> None:
    """Judge at each rate, and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", nargs="?", default="video", help="a model file, or the name of a shipped one")
    parser.add_argument("--count", type=int, default=100, help="scenes")
    parser.add_argument("--seed", type=int, default=78, help="of the scenes; 78 is one that no fit uses")
    options = parser.parse_args()
    model = model_named(options.model)
    assert isinstance(model, lgmd.LGMD2)
    as_it_is = {fps: verdicts(model, options.count, options.seed, fps) for fps in RATES}
    scaled = {fps: verdicts(lgmd.at_frame_rate(model, fps), options.count, options.seed, fps) for fps in RATES}
    for name, by_rate in (("as it is", as_it_is), ("taken to the rate", scaled)):
        print(f"{name}: the same verdict at all rates on {agreement(by_rate):.1%} of {options.count} clips")
        for fps, of_rate in by_rate.items():
            hits = sum(all(each.hits) for each in of_rate if each.hits)
            same = sum(one == other for one, other in zip(of_rate, by_rate[30.0], strict=True))
            false = sum(each.false_alarm for each in of_rate)
            print(f"  {fps:3g} fps: {hits} hits, {false} clips with false alarms, {same} as at 30")


if __name__ == "__main__":
    main()
