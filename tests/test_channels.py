"""One table of channels: what every room says of a channel comes from it."""

import dataclasses
import typing

import numpy as np

import lgmd2jax as lgmd
from lgmd2jax._channels import RESPONSE, TARGETS, Channel
from lgmd2jax._video.trace import Row, Trace


def test_the_table_holds_what_a_network_answers():
    assert set(RESPONSE) <= {field.name for field in dataclasses.fields(lgmd.Response)}
    assert Trace._fields == Row._fields == ("frame", "time_ms", *RESPONSE)
    assert set(TARGETS) == set(typing.get_args(Channel))


def test_rest_and_span_are_those_of_the_model():
    """A uniform grey clip leaves the cell at rest; a huge disc that rushes in drives it as far as it goes."""
    eye = lgmd.Eye(rows=20, cols=20, degrees_per_pixel=5.0, fps=50.0)
    model = lgmd.LGMD2(lgmd.preset("lgmd2", T_ffi=1e6))
    grey = model(np.full((30, 20, 20), 128.0), 50.0)
    stimulus = lgmd.stimuli.looming(eye, l_over_v=30.0, contrast=-1.0, start_ms=-900.0, end_ms=100.0, stop_angle=120.0)
    driven = model(stimulus.frames, stimulus.fps)
    for name, described in RESPONSE.items():
        if described.rest is None:
            continue
        np.testing.assert_allclose(getattr(grey, name), described.rest, atol=1e-12)
        reached = np.ptp(np.asarray(getattr(driven, name)))
        assert described.span is not None
        assert 0.75 * described.span <= reached <= described.span, name
