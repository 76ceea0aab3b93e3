"""The detectors that are compared, with the settings that were found for them on arenas kept for that."""

from lgmd2jax._arguments.checked import checked
from lgmd2jax._files.atomic import read_json
from lgmd2jax._files.catalogue import folder
from lgmd2jax._network.abstract import AbstractNetwork
from lgmd2jax.arena._detectors import AbstractDetector, NetworkDetector, NoDetector
from lgmd2jax.arena._training import SPACES

SETTINGS = "arena/detectors.json"  # in fits/; `python -m benchmarks.arena --train` writes it


@checked
def detectors(model: AbstractNetwork | None = None) -> dict[str, AbstractDetector]:
    """The detectors that `lgmd2jax arena` compares, by name.

    - `"none"`: no alarm ever. `"table1"`: the paper's model, within Table I's ranges. `"lgmd2"`: the fitted one.
    - `"lgmd1"`: that of Yue & Rind. `"difference"`: a threshold on the mean change of the image.

    `train` chose the settings of all four, on arenas of other seeds.

    **Arguments:** `model`: takes the place of the fitted one, for the robot's camera and otherwise as it is.

    **Raises:** `ValueError` for a model whose field of view is not known.
    """
    settings = read_json(folder("fits") / SETTINGS)
    chosen: dict[str, AbstractDetector] = {"none": NoDetector()}
    for name, space in SPACES.items():
        chosen[name] = space.detector(settings[name]["settings"])
    if model is not None:
        chosen["lgmd2"] = NetworkDetector.of(model)
    return chosen
