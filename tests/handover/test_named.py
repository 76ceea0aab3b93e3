"""How a command is told its model."""

import pytest

import lgmd2jax as lgmd
from lgmd2jax._handover.named import model_named, with_parameters


def test_a_model_is_named_by_file_preset_or_shipped_name(tmp_path):
    lgmd.save(lgmd.LGMD2(lgmd.Parameters(k=0.25)), tmp_path / "mine.json")
    assert float(model_named(str(tmp_path / "mine.json")).parameters.k) == 0.25
    assert float(model_named("preset:balanced").parameters.theta1) == 1
    with pytest.raises(ValueError, match=r"preset is 'lgm2'; choose 'lgmd2'"):
        model_named("preset:lgm2")
    with pytest.raises(FileNotFoundError, match="no such file: nowhere"):
        model_named("nowhere")


def test_parameters_are_set_by_name():
    model = with_parameters(lgmd.LGMD2(n_p=1), ["T_sp=0.65", "tau1=12"])
    assert (float(model.parameters.T_sp), float(model.parameters.tau1), model.n_p) == (0.65, 12, 1)
    for setting, message in [
        ("T_spp=.6", "parameter is 'T_spp'; choose 'T_sp'"),
        ("T_sp", "'T_sp' gives no number; write T_sp=VALUE"),
        ("T_sp=high", "'T_sp=high' gives no number"),
        ("T_sp=2", "T_sp is 2; it must lie in"),
        ("T_sp=nan", "T_sp is nan; it must lie in"),
    ]:
        with pytest.raises(ValueError, match=message):
            with_parameters(lgmd.LGMD2(), [setting])
