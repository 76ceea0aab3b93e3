"""The files of a ROS 2 package, from the templates beside this module and `hard.py`."""

from importlib.metadata import version
from pathlib import Path

from lgmd2jax import hard
from lgmd2jax._eye import Eye
from lgmd2jax._files.templates import rendered, templates

_TEMPLATES = Path(__file__).parent / "templates"
_COLS, _FPS = 99, 30.0  # of the paper's robot, for a model that belongs to no eye
MODEL_FILE = "config/model.json"
PROGRAM = "lgmd2/hard.py"


def sources(eye: Eye | None) -> dict[str, str]:
    """The text of each file, by its path; the model's hand-over file, `MODEL_FILE`, is still to come.

    **Arguments:** `eye` of the model, by which the parameters of the node have their defaults.
    """
    values = {
        "program": f"lgmd2jax {version('lgmd2jax')}",
        "version": version("lgmd2jax"),
        "cols": _COLS if eye is None else eye.cols,
        "fps": _FPS if eye is None else float(eye.fps),
    }
    texts = {name: rendered(text, values) for name, text in templates(_TEMPLATES).items()}
    return texts | {PROGRAM: Path(hard.__file__).read_text(encoding="utf-8")}
