"""Sobol points of the unit box, those of SciPy's `qmc.Sobol`: `scipy.stats` takes half a second to load."""

import numpy as np
from jaxtyping import Float, UInt32

_BITS = 30
# Of each dimension from the second on a primitive polynomial and its first direction numbers: Joe & Kuo (2008), SIAM J.
# Sci. Comput. 30, 2635.
_JOE_KUO = """
    3: 1, 7: 1 3, 11: 1 3 1, 13: 1 1 1, 19: 1 1 3 3, 25: 1 3 5 13, 37: 1 1 5 5 17, 41: 1 1 5 5 5, 47: 1 1 7 11 19,
    55: 1 1 5 1 1, 59: 1 1 1 3 11, 61: 1 3 5 5 31, 67: 1 3 3 9 7 49, 91: 1 1 1 15 21 21, 97: 1 3 1 13 27 49,
    103: 1 1 1 15 7 5, 109: 1 3 1 15 13 25, 115: 1 1 5 5 19 61, 131: 1 3 7 11 23 15 103, 137: 1 3 7 13 13 15 69,
    143: 1 1 3 13 7 35 63, 145: 1 3 5 9 1 25 53, 157: 1 3 1 13 9 35 107, 167: 1 3 1 5 27 61 31,
    171: 1 1 5 11 19 41 61, 185: 1 3 5 3 3 13 69, 191: 1 1 7 13 1 19 1, 193: 1 3 7 5 13 19 59,
    203: 1 1 3 9 25 29 41, 211: 1 3 5 13 23 1 55, 213: 1 3 7 3 13 59 17, 229: 1 3 1 3 5 53 69,
    239: 1 1 5 5 23 33 13, 241: 1 1 7 7 1 61 123, 247: 1 1 7 9 13 61 49, 253: 1 3 3 5 3 55 33
"""
_POLYNOMIALS = [
    (int(polynomial), [int(word) for word in first.split()])
    for polynomial, first in (entry.split(":") for entry in _JOE_KUO.split(","))
]
DIMENSIONS = 1 + len(_POLYNOMIALS)  # at most

Words = UInt32[np.ndarray, "dimension bit"]


def scrambled_sobol(
    dimensions: int, count: int, generator: np.random.Generator
) -> Float[np.ndarray, "count dimensions"]:
    """The first `count` points, scrambled by random lower triangular matrices and a random shift (Matousek, 1998)."""
    own = generator.spawn(1)[0]
    shift = own.integers(2, size=(dimensions, _BITS), dtype=np.uint32) @ (1 << np.arange(_BITS, dtype=np.uint32))
    directions = _scrambled(_directions(dimensions), own.integers(2, size=(dimensions, _BITS, _BITS), dtype=np.uint32))
    # By Gray codes each point differs from the one before it in one direction: that of the lowest bit that changes.
    number = np.arange(1, count)
    steps = directions[:, np.bitwise_count((number & -number) - 1)]
    words = np.bitwise_xor.accumulate(np.concatenate([shift[:, None], steps], axis=1), axis=1)
    return words.T / 2.0**_BITS


def _directions(dimensions: int) -> Words:
    """The direction numbers, of which each bit of a point's number adds one."""
    rows = [[1] * _BITS]
    for polynomial, first in _POLYNOMIALS[: dimensions - 1]:
        row, degree = list(first), len(first)
        while len(row) < _BITS:
            word = row[-degree]
            for back in range(1, degree + 1):
                if polynomial >> (degree - back) & 1:
                    word ^= row[-back] << back
            row.append(word)
        rows.append(row)
    return np.array(rows, np.uint32) << np.arange(_BITS - 1, -1, -1, dtype=np.uint32)


def _scrambled(directions: Words, random: UInt32[np.ndarray, "dimension bit bit"]) -> Words:
    """The direction numbers as columns of bits, the highest first, multiplied by lower triangular matrices modulo 2."""
    highest_first = np.arange(_BITS - 1, -1, -1, dtype=np.uint32)
    bits = directions[:, None] >> highest_first[:, None] & 1
    matrices = np.tril(random, -1) + np.eye(_BITS, dtype=np.uint32)
    return ((matrices @ bits & 1) << highest_first[:, None]).sum(axis=1, dtype=np.uint32)
