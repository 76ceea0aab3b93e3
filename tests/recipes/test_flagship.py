"""What the shipped fit of the LGMD2 does, as README and its gallery say."""

import lgmd2jax as lgmd


def test_it_raises_an_alarm_for_dark_approaches_alone():
    model = lgmd.load_fit("lgmd2").model
    stimuli = [condition.render() for condition in lgmd.load_protocol("lgmd2").conditions]
    alarmed = {stimulus.name for stimulus in stimuli if model(stimulus.frames, stimulus.fps).collision.any()}
    assert alarmed == {stimulus.name for stimulus in stimuli if stimulus.name.startswith("dark approach")}
    assert len(alarmed) == 4
