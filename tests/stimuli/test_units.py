"""Units that arguments declare: in messages, on the axes of sweeps, and against numbers in another unit."""

import inspect
import math
import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lgmd2jax import Eye, stimuli
from lgmd2jax.stimuli import _scene
from lgmd2jax.stimuli._family import outline
from lgmd2jax.stimuli._units import parts_of, units_of

EYE = Eye(rows=24, cols=32, degrees_per_pixel=4.0, fps=50.0)

DECLARED = [
    (family, name, unit) for family in stimuli.FAMILIES for name, unit in units_of(stimuli.FAMILIES[family]).items()
]


def company(family: str, name: str) -> dict[str, float]:
    """The arguments that this one is given together with."""
    small, large = (
        ("stop_radius_px", "start_radius_px") if family == "receding" else ("start_radius_px", "stop_radius_px")
    )
    groups = (
        {"growth_px": 9.0, small: 1.0, large: 5.0},
        {"speed_px": 9.0, "start_px": -5.0, "stop_px": 5.0},
        {"speed_cm_s": 40.0, "size_cm": 6.0, "distance_cm": 30.0},
    )
    return next((group for group in groups if name in group), groups[0] if name == "acceleration_px" else {})


@pytest.mark.parametrize(("family", "name", "unit"), DECLARED, ids=[f"{family} {name}" for family, name, _ in DECLARED])
def test_the_unit_that_is_declared_is_the_one_that_is_checked(family, name, unit):
    """What is refused says its unit, in brackets where it is the kind of a contrast."""
    others = company(family, name) | ({"checks": 2} if name.startswith("check_") else {})
    with pytest.raises(ValueError, match=name) as error:
        stimuli.FAMILIES[family](EYE, **others | {name: math.nan})
    bracketed = f"({unit})" if unit in ("Weber", "Michelson") else unit
    assert str(error.value).startswith(f"{name} is nan {bracketed}; give a ")


def test_every_number_but_the_window_declares_a_unit():
    for family, renderer in stimuli.FAMILIES.items():
        defaults = {name: argument.default for name, argument in inspect.signature(renderer).parameters.items()}
        numbers = {name for name, default in defaults.items() if isinstance(default, float)}
        plain = {"direction"} if family in ("elongating", "shortening") else set()  # one of four, which is no axis
        assert numbers - set(units_of(renderer)) == plain


@pytest.mark.parametrize("renderer", stimuli.FAMILIES.values(), ids=stimuli.FAMILIES)
def test_a_signature_can_be_read(renderer):
    shown = str(inspect.signature(renderer))
    assert len(shown) < 800
    assert shown.startswith("(eye: Eye, ")
    assert shown.endswith(" -> Stimulus")
    assert not re.search("Optional|Union|Shaped|lgmd2jax", shown)


def test_the_types_of_an_annotation_are_those_of_its_parts():
    annotation = inspect.get_annotations(inspect.unwrap(stimuli.looming))["background"]
    assert {float, int, stimuli.Background} <= set(parts_of(annotation))
    assert str not in set(parts_of(annotation))


def test_a_family_is_outlined_without_being_drawn(monkeypatch):
    stimulus = stimuli.looming(EYE, l_over_v=20.0)
    monkeypatch.setattr(_scene, "_draw", None)
    time, units = outline(stimuli.looming, EYE, l_over_v=20.0)
    np.testing.assert_array_equal(time, stimulus.time)
    assert (units["l_over_v"], units["contrast"]) == ("ms", "Weber")
    with pytest.raises(ValueError, match="contrast is 3"):
        outline(stimuli.looming, EYE, contrast=3.0)


def test_the_arguments_of_a_renderer_of_ones_own_have_the_units_of_the_family_in_it():
    def stripes(eye, *, contrast, other):
        return stimuli.grating(eye, contrast=contrast, spatial_frequency=0.03 * other)

    time, units = outline(stripes, EYE, contrast=0.5, other=1.0)
    assert units["contrast"] == "Michelson"
    assert "other" not in units
    assert time[0] == -500


CONFUSED = {
    "seconds": ({"l_over_v": 0.04}, "l_over_v is 0.04 ms; was 40 ms meant, given in seconds?"),
    "radians": ({"stop_angle": np.radians(80)}, "stop_angle is 1.396 degrees; was 80 degrees meant, given in radians?"),
    "half a degree": ({"start_angle": np.radians(1.5)}, "was 1.5 degrees meant, given in radians?"),
    "radians a second": ({"growth": np.radians(100)}, "growth is 1.745 deg/s; was 100 deg/s meant, given in radians?"),
    "shares of white": (
        {"background": 0.8},
        "background is 0.8 grey levels; was 204 grey levels meant, given in 0..1?",
    ),
}


@pytest.mark.parametrize(("arguments", "message"), CONFUSED.values(), ids=CONFUSED)
def test_a_number_that_was_surely_given_in_another_unit_is_warned_of(arguments, message):
    usual = {"start_angle": 1.0, "start_ms": -200, "end_ms": 0}
    with pytest.warns(UserWarning, match=re.escape(message)):
        stimuli.looming(EYE, **usual | arguments)


def test_a_picture_in_shares_of_white_is_warned_of():
    with pytest.warns(UserWarning, match=r"image holds no grey level above 1; was 0..255 meant"):
        stimuli.Photograph(np.eye(4))


def test_rare_but_meant_numbers_pass_without_a_warning():
    """Steps of no length, a straight line, black, small and odd angles, an eighth of a turn that is not one."""
    stimuli.luminance(EYE, level=0.0, ramp_ms=0.0, hold_ms=1.0)
    stimuli.looming(EYE, l_over_v=1.0, start_angle=0.5, deviation=0.0, azimuth=0.7854, start_ms=-200, end_ms=0)
    stimuli.translating(EYE, speed=1.0, direction=1.57, start_ms=0, end_ms=100)
    stimuli.Photograph(np.zeros((4, 4)) + 1.5)


def test_a_traced_number_is_not_warned_of():
    jax.jit(lambda l_over_v: stimuli.looming(EYE, l_over_v=l_over_v, start_ms=-100, end_ms=0).frames)(jnp.asarray(0.04))
