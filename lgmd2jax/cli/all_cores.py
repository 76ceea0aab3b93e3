"""All cores for commands that work on many things at once."""

import os

import jax


def use_all_cores() -> None:
    """As many devices as cores, where JAX has not begun to work yet."""
    try:
        jax.config.update("jax_num_cpu_devices", os.cpu_count())
    except RuntimeError:
        return
