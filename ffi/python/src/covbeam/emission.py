"""The numbers that light paths' decisions are drawn with, and their warp to where a lamp's light is worth more."""

import numpy as np

from ._arrays import COUNT, FLOAT, PAIR, WORD, elementwise, given, made, packed, two_outs, word
from ._library import check, lib

#: Decisions of a path that path_numbers stratifies.
EMISSION_DIMENSIONS = 8


def path_numbers(seed, sequence, paths, dimension, *, out=None):
    """One decision of many light paths: float32 in [0, 1).

    The first EMISSION_DIMENSIONS decisions are the coordinates of a scrambled Sobol' point, which place 2^k paths in a row
    evenly; those after them are independent.

    - seed: another seed is another scramble of all sequences.
    - sequence: keeps sequences of one seed apart.
    - paths: uint32, their places in the sequence, counted on over the passes of a picture.
    - dimension: which decision, from 0 on.
    """
    return elementwise(
        lib.covbeam_path_numbers,
        word("seed", seed),
        word("sequence", sequence),
        COUNT,
        given("paths", paths, WORD),
        word("dimension", dimension),
        made("out", out, FLOAT),
    )


def emission_guide_fill(weights, even):
    """A guide of a lamp's emission: a warp of the unit square in which the place and direction of its light are drawn, that sends
    more paths where they are worth more: float32 of shape (side + 1, side), for emission_guide_warp.

    - weights: float32 of shape (side, side): what light that leaves through each cell of the square is worth, finite and >= 0. The
      second coordinate runs along the last axis.
    - even: share of the paths that go everywhere alike, in (0, 1], and at least 1e-37 a cell: no more than 1/even times its own
      power has any path, however wrong the weights are.
    """
    side = _side("weights", weights, more=0)
    given_weights = packed("weights", weights.reshape(-1), FLOAT.dtype)
    guide = np.zeros((side + 1, side), np.float32)
    check(
        lib.covbeam_emission_guide_fill(
            side, given_weights.address, given_weights.count, even, guide.ctypes.data, guide.size
        )
    )
    return guide


def emission_guide_warp(guide, points, *, out=None):
    """Where points of the unit square go, and how dense they are there: (places, densities). Divide a path's power by its density.

    - guide: of emission_guide_fill; all of it is looked at once a call.
    - points: float32 of shape (2,) or (n, 2), in [0, 1), such as path_numbers of dimensions 0 and 1.
    """
    side = _side("guide", guide, more=1)
    numbers = packed("guide", guide.reshape(-1), FLOAT.dtype)
    places, densities = two_outs(out)
    return elementwise(
        lib.covbeam_emission_guide_warp,
        side,
        numbers.address,
        numbers.count,
        COUNT,
        given("points", points, PAIR),
        made("places", places, PAIR),
        made("densities", densities, FLOAT),
    )


def _side(name, array, more):
    """Cells of a guide along an axis; the array has `more` rows more."""
    if not isinstance(array, np.ndarray) or array.ndim != 2 or array.shape[0] != array.shape[1] + more:
        rows = "side + 1" if more else "side"
        raise ValueError(f"{name}: give a numpy array of shape ({rows}, side)")
    if not array.flags.c_contiguous:
        raise ValueError(f"{name}: the numbers are not side by side; use np.ascontiguousarray(...)")
    return array.shape[1]
