"""What XLA does for a frame: the instructions in the body of the scan over frames, once compiled."""

import re
from typing import NamedTuple

import jax
import jax.numpy as jnp

import lgmd2jax as lgmd
from benchmarks import _library, _traffic
from benchmarks._task import FPS, Size
from lgmd2jax._network.tiles import tile_height


class Work(NamedTuple):
    """How many instructions of each kind a frame costs, and whether the whole loop over frames is one kernel."""

    kinds: dict[str, int]
    whole: bool


def work_per_frame(size: Size) -> Work:
    """Of the hard forward, cell not counted."""
    frames = jax.ShapeDtypeStruct((60, *size), jnp.float32)
    respond = jax.jit(lambda parameters, frames: lgmd.LGMD2(parameters)(frames, FPS))
    text = respond.lower(_library.parameters(), frames).compile().as_text()
    assert text is not None
    height = tile_height(size.rows, 4 * size.cols)
    loop = _traffic.body_of_loop(text, f"f32[{height + 2},{size.cols + 2}]")
    (body,) = re.findall(r"^%[\w.-]+", loop)
    (around,) = (part for part in text.split("\n}") if re.search(rf"body={re.escape(body)}(?![\w.-])", part))
    name = re.findall(r"^(?:ENTRY )?(%[\w.-]+) \(", around, re.MULTILINE)[0]
    called = rf" call\(.*to_apply={re.escape(name)}(?![\w.-])"  # which XLA makes of a loop that it hoists into a kernel
    return Work(count_instructions(loop), whole=re.search(called, text) is not None)


def count_instructions(computation: str) -> dict[str, int]:
    """The instructions of a computation by kind, but for those that cost nothing."""
    kinds = [it.operation for it in _traffic.instructions(computation) if it.operation not in _traffic.FREE]
    return {kind: kinds.count(kind) for kind in sorted(set(kinds))}
