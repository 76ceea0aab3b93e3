"""The detectors that a model is compared with: Table I at the two ends of its T_sp, and plain baselines."""

import dataclasses
from collections.abc import Mapping, Sequence

from lgmd2jax._arguments.checked import checked
from lgmd2jax._network.lgmd2 import LGMD2
from lgmd2jax._network.parameters import preset
from lgmd2jax.alarms._baselines import BASELINES, baseline
from lgmd2jax.alarms._clip import LabelledClip
from lgmd2jax.alarms._evaluation import Evaluation, evaluate

MODEL = "model"
TABLE_I = {"table1_T_sp_0.78": 0.78, "table1_T_sp_0.65": 0.65}  # T_sp off line, and on the robot
TITLES: Mapping[str, str] = {
    "table1_T_sp_0.78": "Table I, T_sp 0.78",
    "table1_T_sp_0.65": "Table I, T_sp 0.65",
    "difference": "frame difference",
    "divergence": "divergence of flow",
}


def table1(clips: Sequence[LabelledClip], model: LGMD2) -> dict[str, Evaluation]:
    """The paper's parameters, with their own N_ts, on clips; `model`: for its eye."""
    evaluation = evaluate(LGMD2(preset("lgmd2"), eye=model.eye), clips)
    return {name: dataclasses.replace(evaluation, T_sp=T_sp) for name, T_sp in TABLE_I.items()}


@checked
def detectors(clips: Sequence[LabelledClip], model: LGMD2, flow: bool = True) -> dict[str, Evaluation]:
    """What plain detectors do on clips, by their names, for a model to be compared with.

    **Arguments:** `model`: whose eye the paper's model gets. `flow`: whether to try the divergence too, which needs
    OpenCV.

    **Returns:** `"table1_T_sp_0.78"` and `"table1_T_sp_0.65"`, the paper's model with the two thresholds that the paper
    gives; `"difference"`, the mean change between frames; `"divergence"`, that of the optical flow.

    **Raises:** `ValueError` where OpenCV is missing.
    """
    names = [name for name in BASELINES if flow or name != "divergence"]
    return {**table1(clips, model), **{name: baseline(name, clips) for name in names}}
