"""Settings of the whole suite: float64, no silent broadcasting, shapes and types checked on every call."""

import gc
import os
import pathlib
import pkgutil
from importlib.metadata import version

# Compiling takes most of the suite's time: XLA's newer emitters and most of its optimisations double it. The releases
# that know this flag are named, since others end the process.
if version("jaxlib").startswith(("0.8.", "0.9.", "0.10.")):
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_use_fusion_emitters=false")

# The suite tests what is compiled now; the commands, some of them in processes of their own, would keep their programs.
os.environ["JAX_ENABLE_COMPILATION_CACHE"] = "false"

import jax
import jaxtyping
import pytest

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_disable_most_optimizations", True)
# Tracing makes objects by the million and few of them in circles: looks for those took a tenth of the suite's time.
USUAL_GC, RARE_GC = gc.get_threshold(), (200_000, 20, 100)
gc.set_threshold(*RARE_GC)
# All rooms but hard.py: the search for a hand-over file's test vector steps the robot's program by 100,000 frames, and
# checks of calls take three quarters of that time. Its arrays have no declared shapes; pyright checks its types.
PACKAGE = pathlib.Path(__file__).parents[1] / "lgmd2jax"
ROOMS = [f"lgmd2jax.{room.name}" for room in pkgutil.iter_modules([str(PACKAGE)]) if room.name != "hard"]
jaxtyping.install_import_hook(ROOMS, "beartype.beartype")


@pytest.fixture(autouse=True, scope="module")
def few_programs():
    """Compiled programs dropped where a process holds many: each maps memory, and past 65,530 maps XLA ends it."""
    yield
    maps = pathlib.Path("/proc/self/maps")
    if maps.exists() and len(maps.read_bytes().splitlines()) > 10_000:
        jax.clear_caches()
        gc.collect()


@pytest.fixture
def usual_gc():
    """Circles of objects looked for as often as for a user, where memory is measured."""
    gc.set_threshold(*USUAL_GC)
    yield
    gc.set_threshold(*RARE_GC)


@pytest.fixture
def untyped():
    """Shape annotations switched off, as for a user, so that the library's own errors are what is seen."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


@pytest.fixture(scope="session")
def data() -> pathlib.Path:
    """The folder with recorded responses and clips, or a skip."""
    folder = pathlib.Path(os.environ.get("LGMD2JAX_DATA") or pathlib.Path(__file__).parents[2] / "shared" / "data")
    if not folder.is_dir():
        pytest.skip(f"no recordings at {folder}; set LGMD2JAX_DATA to the folder that holds them")
    return folder


def pytest_terminal_summary(terminalreporter):
    """Print the tables that tests recorded, whichever worker ran them."""
    for report in terminalreporter.getreports("passed"):
        for name, value in report.user_properties:
            if name == "table":
                terminalreporter.section(report.nodeid)
                terminalreporter.write_line(value)
