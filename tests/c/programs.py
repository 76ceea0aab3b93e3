"""Models of every structure, their C in folders, and the tools of a firmware developer."""

import dataclasses
import functools
import json
import os
import pathlib
import shutil
import subprocess

import pytest

import lgmd2jax as lgmd
from lgmd2jax._c.source import sources
from lgmd2jax._handover.model_file import document

ROOT = pathlib.Path(__file__).parents[2]
EYE = lgmd.Eye(12, 15, 3.0, 50.0)
ROBOT = lgmd.Eye(72, 99, 0.7, 30.0)
EVERY = ("size", "shunt", "lag", "membrane", "rate")
# Thresholds that no whole grey level meets by chance.
_CELL = {"N_sp": 4, "T_sp": 0.7, "T_p": 19.31, "T_s": 10.137, "tau1": 23.71}
MODELS = {
    "the paper's circuit": lgmd.LGMD2(lgmd.Parameters(**_CELL, k=4.0, T_ffi=25.0), eye=EYE),
    "persistence, exact low-pass": lgmd.LGMD2(
        lgmd.Parameters(**_CELL, theta1=0.4, theta3=0.002, k=6.0, T_ffi=25.0),
        n_p=2,
        low_pass="exact",
        N_ts=3,
        eye=EYE,
    ),
    "all mechanisms": lgmd.LGMD2(lgmd.Parameters(**_CELL, theta1=0.1, k=0.5, A_ffi=0.6), eye=EYE, mechanisms=EVERY),
    "size behind the gate": lgmd.LGMD2(
        lgmd.Parameters(**_CELL, theta1=0.1, k=2.0, A_ffi=0.5), low_pass="exact", eye=EYE, mechanisms=("size",)
    ),
    "shunt and lag, no window": lgmd.LGMD2(
        lgmd.Parameters(**_CELL | {"N_sp": 1}, k=2.0, T_ffi=30.0), N_ts=0, eye=EYE, mechanisms=("shunt", "lag", "rate")
    ),
    "size behind a lamina": lgmd.LGMD2(
        lgmd.Parameters(**_CELL, theta1=0.1, k=4.0, A_ffi=0.5), eye=EYE, mechanisms=("size", "lamina")
    ),
    "habituation behind a lamina": lgmd.LGMD2(
        lgmd.Parameters(**_CELL, theta1=0.1, k=2.0, T_ffi=25.0, S_hab=40.0, tau_hab=150.0),
        eye=EYE,
        mechanisms=("lamina", "habituation"),
    ),
}


def tool(name: str) -> str:
    """The path of a program, or a skip; a failure where LGMD2JAX_REQUIRE_TOOLS says that all are installed."""
    path = shutil.which(name)
    if path is None:
        if os.environ.get("LGMD2JAX_REQUIRE_TOOLS"):
            pytest.fail(f"{name} is not installed, and LGMD2JAX_REQUIRE_TOOLS is set")
        pytest.skip(f"{name} is not installed")
    return path


@functools.cache
def vector(name: str) -> dict:
    """The test vector of one of `MODELS`, which does not depend on the eye but for its rate."""
    return document(MODELS[name])["test_vector"]


@functools.cache
def files(name: str, eye: lgmd.Eye = EYE) -> dict[str, str]:
    """The C of one of `MODELS`, its parameters as they are, for an eye."""
    return sources(dataclasses.replace(MODELS[name], eye=eye), vector(name))


def written(folder: pathlib.Path, texts: dict[str, str]) -> pathlib.Path:
    """The folder, with the files in it."""
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def run(*command: str, folder: pathlib.Path) -> str:
    """What a command prints, on both streams; a failure that shows them where it fails."""
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}"
    return done.stdout


def shipped(name: str) -> lgmd.LGMD2:
    """A shipped fit, for the robot's eye."""
    return lgmd.at_eye(lgmd.load(ROOT / "fits" / name / "model.json"), ROBOT)


def robot_files(model: lgmd.LGMD2) -> dict[str, str]:
    """The C of a model, with its own test vector."""
    return sources(model, json.loads(json.dumps(document(model)))["test_vector"])
