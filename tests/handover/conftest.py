"""Hand-over files that several modules read; to find a test vector takes longer than to read it."""

import shutil

import jaxtyping
import numpy as np
import pytest

import lgmd2jax as lgmd
from tests import clips

EYE = lgmd.Eye(rows=7, cols=9, degrees_per_pixel=2.0, fps=50.0)
MODEL = lgmd.LGMD2(lgmd.Parameters(theta1=0.4, k=10.0, N_sp=3, T_ffi=80.0), n_p=1, low_pass="exact", N_ts=3, eye=EYE)
FRAMES = np.round(clips.loom(0, (12, 7, 9))).astype(np.uint8)
RICH = lgmd.LGMD2(
    lgmd.Parameters(theta1=0.4, k=2.0, T_p=30.0, A_ffi=0.2, lag=21.0, N_sp=3),
    eye=EYE,
    mechanisms=("size", "shunt", "lag", "membrane", "rate"),
)
LGMD1 = lgmd.YueRindLGMD1(lgmd.YueRindParameters(T_de=6.0, k=2.0, alpha_ffi=0.3), N_sp=3, eye=EYE)


@pytest.fixture(scope="session")
def others(tmp_path_factory):
    """The folder with the files of a model that has all mechanisms, and of the other network."""
    folder = tmp_path_factory.mktemp("others")
    jaxtyping.config.update("jaxtyping_disable", True)  # type checks take two thirds of the time
    lgmd.save(RICH, folder / "rich.json")
    lgmd.save(LGMD1, folder / "lgmd1.json")
    jaxtyping.config.update("jaxtyping_disable", False)
    return folder


@pytest.fixture(scope="session")
def original(tmp_path_factory):
    path = tmp_path_factory.mktemp("original") / "model.json"
    lgmd.save(MODEL, path)
    return path


@pytest.fixture
def path(original, tmp_path):
    shutil.copy(original, tmp_path / "model.json")
    return tmp_path / "model.json"
