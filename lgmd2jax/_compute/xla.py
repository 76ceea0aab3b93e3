"""How programs of ours ask XLA to compile. A library asks for nothing: the process is its user's."""

import os
from importlib.metadata import version

# A loop over frames becomes one kernel on one core, which takes about half as long to compile. XLA would launch a dozen
# for every frame, and split each between threads; the starts of a fit and the conditions of a sweep keep cores busier.
# A loop that touches more than 20 MB a frame is split as ever.
_WHOLE_LOOPS = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=20000000"
# All of a vector register, where XLA would use half of it.
_WIDE_VECTORS = "--xla_cpu_prefer_vector_width=512"
# What a loop carries is updated where it lies, after the last look at what was there, as on a GPU. XLA would copy it.
_NO_COPIES = "--xla_cpu_copy_insertion_use_region_analysis=true"

FLAGS = f"{_WHOLE_LOOPS} {_WIDE_VECTORS} {_NO_COPIES}"


def set_flags() -> None:
    """Before the first array of a process: set `XLA_FLAGS`, unless its user did.

    The last two flags end a process whose XLA does not know them, so the releases that do are named.
    """
    known = version("jaxlib").startswith(("0.9.", "0.10."))
    os.environ.setdefault("XLA_FLAGS", FLAGS if known else _WHOLE_LOOPS)
