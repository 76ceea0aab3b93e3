"""Tiles: rows of the field that are worked through by themselves, through all frames of a clip.

What a pixel remembers depends on that pixel alone, and neighbours only feed forward. So all that a tile needs of the
rest of the field is one row of the frames above it and one below, and MP and F of the field are sums over its tiles.
The maps of a tile stay in the cache from frame to frame, where those of a large field do not.
"""

from collections.abc import Callable
from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Int, Real

from lgmd2jax._network.maps import Bordered, Row, bordered_onto
from lgmd2jax._types import Map

_BYTES = 2**19  # of the maps of a tile, which then fit in a second-level cache of 1 MB
FORWARD, DERIVED = 8, 16  # maps that a response keeps at hand, and its derivative by some parameters
_ROWS = 16  # of a tile of large frames, however wide; each tile computes two rows beside its own

Frames = Real[Array, "time row col"]
OfTile = TypeVar("OfTile")


def over_tiles(of_tile: Callable[[int | Int[Array, ""], int], OfTile], frames: Frames, maps: int = FORWARD) -> OfTile:
    """What `of_tile` returns of each tile, a first row and a number of rows, along a first axis.

    On an accelerator, and where the field is small, it is one tile.

    **Arguments:** `maps`: how many maps `of_tile` has at hand in a frame.
    """
    rows, cols = frames.shape[1:]
    row_bytes = cols * jnp.promote_types(frames.dtype, jnp.float32).itemsize  # of a map; frames may be whole numbers
    height = rows if jax.default_backend() != "cpu" else tile_height(rows, row_bytes, maps)
    if height == rows:
        return jax.tree.map(lambda leaf: leaf[None], of_tile(0, rows))
    return jax.lax.map(lambda first: of_tile(first, height), jnp.arange(0, rows, height))


def tile_height(rows: int, row_bytes: int, maps: int = FORWARD) -> int:
    """How many rows a tile has: all tiles of a field have as many, and where that would be few it stays whole."""
    most = max(_BYTES // (maps * row_bytes), _ROWS)
    height = max(height for height in range(1, min(most, rows) + 1) if rows % height == 0)
    return height if 2 * height >= most else rows


def change(frames: Frames, t: Int[Array, ""], first: int | Int[Array, ""], onto: Bordered) -> Bordered:
    """L(t) - L(t-1) of a tile, the rows of the field from `first` on, with what lies around it.

    The first frame is what was there before it. Frames are read where they lie; integers stay so until here.

    **Arguments:** `onto`: a map that is no longer needed, which is written over.
    """
    height, first = onto.shape[0] - 2, jnp.asarray(first, t.dtype)

    def of_rows(first, count) -> Map:
        def read(moment):
            # Indices below 0 or too large are moved inside: so the first frame and the edges of the field repeat.
            at, size = (moment, first, jnp.zeros_like(t)), (1, count, frames.shape[2])
            levels = jax.lax.dynamic_slice(frames, at, size, allow_negative_indices=False)[0]
            return levels.astype(onto.dtype)

        return read(t) - read(t - 1)

    def row(at) -> Row:
        return of_rows(at, 1)[0]

    return bordered_onto(onto, of_rows(first, height), above=row(first - 1), below=row(first + height))
