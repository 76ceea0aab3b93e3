"""A small eye, on which a condition takes a millisecond."""

import pytest

import lgmd2jax as lgmd


@pytest.fixture
def eye():
    return lgmd.Eye(rows=10, cols=13, degrees_per_pixel=7.0, fps=50.0)
