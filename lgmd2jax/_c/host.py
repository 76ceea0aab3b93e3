"""A model in C on this machine: compiled by its C compiler, and called from here."""

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float, UInt8

from lgmd2jax.hard import CHANNELS, Response

Program = Callable[[UInt8[np.ndarray, "time row col"], Float[np.ndarray, " time"]], Response]
_DRIVER = Path(__file__).with_name("clip.c")


# `lgmd2_output` of lgmd2.h.
_NUMBERS = [(name, "f4") for name in ("mp", "ffi", "smp", "smp_adapted")]
_OUTPUT = np.dtype(
    [*_NUMBERS, ("spikes", "i4"), ("collision", "?"), ("mp_sides", "f4", 3), ("urgency", "f4")], align=True
)


def compiler() -> str | None:
    """The path of the C compiler, `CC` or `cc`; None where there is none."""
    return shutil.which(os.environ.get("CC", "cc"))


def compiled(files: Mapping[str, str], rows: int, cols: int, flags: Sequence[str] = ("-O3",)) -> Program:
    """The response to a clip of this size by the C of `sources`, from rest.

    What is returned takes grey levels and, for each frame, ms since the one before.

    **Raises:** `ValueError` with the compiler's first line, where there is none or it refuses.
    """
    command = compiler()
    if command is None:
        raise ValueError("there is no C compiler; install one, or name it by the environment variable CC")
    with tempfile.TemporaryDirectory() as folder:
        for name in ("lgmd2.h", "lgmd2.c"):
            Path(folder, name).write_text(files[name], encoding="utf-8")
        size = (f"-DLGMD2_ROWS={rows}", f"-DLGMD2_COLS={cols}")
        own = ("-std=c99", "-shared", "-fPIC", "-I.", "-o", "lgmd2.so", "lgmd2.c", str(_DRIVER), "-lm")
        result = subprocess.run([command, *flags, *size, *own], cwd=folder, capture_output=True, text=True)
        if result.returncode:
            raise ValueError(f"{command} does not compile lgmd2.c: {result.stderr.strip().partition(chr(10))[0]}")
        clip = ctypes.CDLL(str(Path(folder, "lgmd2.so"))).lgmd2_clip
    clip.argtypes = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
    clip.restype = None

    def respond(frames: UInt8[np.ndarray, "time row col"], interval: Float[np.ndarray, " time"]) -> Response:
        if frames.shape[1:] != (rows, cols):
            raise ValueError(f"frames has shape {frames.shape}; the program is compiled for {rows} x {cols}")
        frames, lasts = np.ascontiguousarray(frames), np.ascontiguousarray(interval, np.float32)
        outputs = np.empty(len(frames), _OUTPUT)
        clip(frames.ctypes.data, lasts.ctypes.data, len(frames), outputs.ctypes.data)
        return Response(**{name: outputs[name] for name in (*CHANNELS, "mp_sides", "urgency")})

    return respond
