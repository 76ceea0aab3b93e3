"""Parameters, presets and what is declared of each."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lgmd2jax as lgmd
from tests import clips

TABLE_I = {
    "sigma1": 0.1, "w_bias": 0.3, "T_s": 10, "T_ffi": 10, "T_sfa": 0.001, "sigma_sp": 0.1, "k": 1, "theta1": 0,
    "theta2": 1, "theta3": 0, "tau1": 30, "tau2": 30, "tau3": 500, "T_sp": 0.78, "N_sp": 6,
}  # fmt: skip


def test_defaults_are_the_papers():
    parameters = lgmd.Parameters()
    for name, value in TABLE_I.items():
        assert getattr(parameters, name) == value
    of_the_paper = {name for name, symbol in lgmd.symbols().items() if symbol.mechanism is None}
    assert of_the_paper == {*TABLE_I, "u"}


def test_every_mechanism_but_change_per_time_has_parameters_of_its_own():
    assert {symbol.mechanism for symbol in lgmd.symbols().values()} | {"rate"} == {None, *lgmd.MECHANISMS}


def test_every_leaf_is_a_strong_float_scalar():
    for leaf in jax.tree.leaves(lgmd.Parameters(N_sp=5, tau1=np.float32(20), k=jnp.asarray(2))):
        assert leaf.shape == ()
        assert jnp.issubdtype(leaf.dtype, jnp.floating)
        assert not leaf.weak_type


def test_declarations_are_consistent():
    for name, symbol in lgmd.symbols().items():
        low, high = symbol.bounds
        assert low < high
        assert symbol.contains(low) or low == symbol.limits[0]
        assert symbol.contains(high)
        assert symbol.contains(getattr(lgmd.Parameters(), name))
        assert not symbol.contains(np.nan)
        assert not symbol.contains(np.inf)
        assert symbol.meaning
        assert symbol.unit
        assert symbol.source


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("tau1", -1.0), ("tau2", 0.0), ("tau3", np.inf), ("k", 0.0), ("k", -1), ("T_sp", 0.5), ("T_sp", 1.0),
        ("theta2", -0.1), ("sigma1", 1.0), ("w_bias", np.nan), ("N_sp", 0), ("T_sfa", 2.0), ("T_ffi", -3),
    ],
)  # fmt: skip
def test_values_outside_their_domain_are_refused(name, value):
    with pytest.raises(ValueError, match=rf"^{name} is .*must lie in"):
        lgmd.Parameters(**{name: value})


@pytest.mark.usefixtures("untyped")
def test_what_is_not_a_scalar_is_refused():
    with pytest.raises(ValueError, match=r"theta2 has shape \(2,\)"):
        lgmd.Parameters(theta2=jnp.ones(2))
    with pytest.raises(ValueError, match="is much; give a number"):
        lgmd.Parameters(theta2="much")


def test_traced_values_pass():
    leaves = jax.vmap(lambda tau1: lgmd.Parameters(tau1=tau1))(jnp.array([-1.0, 10.0])).tau1
    np.testing.assert_array_equal(leaves, [-1.0, 10.0])


def test_repr_names_value_unit_and_meaning():
    text = repr(lgmd.Parameters(tau1=12.5))
    assert "tau1       = 12.5       ms" in text
    assert len(text.splitlines()) == len(lgmd.symbols()) + 2
    assert "delay of the lateral flow" in text
    assert "f64[3]" in repr(jax.tree.map(lambda leaf: jnp.full(3, leaf), lgmd.Parameters()))


@pytest.mark.parametrize(
    ("name", "thetas"), [("lgmd2", (0, 1, 0)), ("balanced", (1, 1, 0)), ("light_selective", (1, 0, 0))]
)
def test_presets(name, thetas):
    parameters = lgmd.preset(name)
    assert (parameters.theta1, parameters.theta2, parameters.theta3) == thetas


@pytest.mark.parametrize(
    ("give", "message"),
    [
        (lambda: lgmd.Parameters(tau1=0.03), "tau1 is 0.03 ms; was 30 ms meant, given in seconds?"),
        (lambda: lgmd.Eye(5, 6, 2.0, 1 / 60), "fps is 0.01667; were 60 frames per second meant"),
        (lambda: lgmd.LGMD2()(clips.loom(0, (6, 5, 7)) / 255, 30.0), "frames lie in 0..1; were grey levels"),
        (lambda: lgmd.LGMD2()(clips.loom(0, (6, 5, 7)) / 127 - 1, 30.0), "frames lie in -1..1; were grey levels"),
        (lambda: lgmd.LGMD2().init(clips.loom(0, (6, 5, 7))[0] / 255), "frames lie in 0..1; were grey levels"),
    ],
)
def test_what_is_hardly_meant_in_this_unit_gets_a_warning(give, message):
    with pytest.warns(UserWarning, match=message.replace("?", "[?]")):
        give()


def test_the_warning_looks_at_values_and_traces_nothing():
    """A clip and a parameter that a traced function closes over are known, and may be looked at."""
    clip, tau1 = jnp.asarray(clips.loom(0, (6, 5, 7)) / 255), jnp.asarray(0.03, dtype=float)

    @jax.jit
    def peak(theta2):
        return lgmd.LGMD2(lgmd.Parameters(theta2=theta2, tau1=tau1))(clip, 30.0).smp.max()

    with pytest.warns(UserWarning, match="frames lie in 0..1"), pytest.warns(UserWarning, match="tau1 is 0.03 ms"):
        peak(2.0)


def test_what_is_meant_gets_none():
    lgmd.Parameters(tau1=1.0, tau_cell=0.0, lag=0.0)
    lgmd.LGMD2()(np.zeros((4, 5, 6)), 30.0)
    lgmd.Eye(5, 6, 2.0, 1.0)
