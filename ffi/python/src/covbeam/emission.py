"""The numbers that light paths' decisions are drawn with."""

from ._arrays import COUNT, FLOAT, WORD, elementwise, given, made, word
from ._library import lib

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
