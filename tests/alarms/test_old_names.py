"""Names that were changed: the old ones work, and name the new ones."""

import numpy as np
import pytest

import lgmd2jax as lgmd
from lgmd2jax import alarms

EYE = lgmd.Eye.from_field_of_view(9, 12, 70.0, 30.0, "pinhole")
FRAMES = np.zeros((20, 9, 12), np.uint8)


def old_name(name):
    return getattr(alarms, name)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Footage", "LabelledClip"),
        ("FootageFile", "LabelFile"),
        ("load_footage", "load_labels"),
        ("Rendered", "Rendering"),
        ("Watch", "Evaluation"),
        ("watch", "evaluate"),
        ("Held", "HeldOutScores"),
    ],
)
def test_an_old_name_is_the_new_one_and_says_so(old, new):
    with pytest.warns(DeprecationWarning, match=rf"^lgmd2jax.alarms.{old} is now lgmd2jax.alarms.{new};"):
        assert getattr(alarms, old) is getattr(alarms, new)


def test_old_functions_that_became_methods():
    with pytest.warns(DeprecationWarning, match="footage is now lgmd2jax.alarms.LabelledClip.of"):
        clip = old_name("footage")("c", FRAMES, 30, windows=[(3, 5)])
    assert isinstance(clip, alarms.LabelledClip)
    assert clip.windows == ((3, 5),)
    with pytest.warns(DeprecationWarning, match="rendered is now lgmd2jax.alarms.Rendering.clips"):
        old = old_name("rendered")
    (here,), (there,) = old(EYE, alarms.Rendering(1, seed=2)), alarms.Rendering(1, seed=2).clips(EYE)
    np.testing.assert_array_equal(here.frames, there.frames)
    assert list(old(EYE, None)) == []


def test_a_name_that_never_was_is_unknown():
    with pytest.raises(AttributeError, match="attribute footages"):
        _ = alarms.footages  # pyright: ignore[reportAttributeAccessIssue]
