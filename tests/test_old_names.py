"""Names of the package that were changed: the old ones work, and name the new ones."""

import pytest

import lgmd2jax as lgmd


def test_a_network_was_not_called_abstract():
    with pytest.warns(DeprecationWarning, match=r"^lgmd2jax.Network is now lgmd2jax.AbstractNetwork;"):
        assert lgmd.Network is lgmd.AbstractNetwork  # pyright: ignore[reportAttributeAccessIssue]
