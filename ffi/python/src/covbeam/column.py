"""The column (integral of the relative density) along one ray that is asked many times."""

import ctypes

from . import _abi
from ._arrays import COUNT, FLOAT, elementwise, given, made, packed
from ._library import lib
from .dtypes import KNOT


class Column:
    """The column along one ray as a function of the distance; made by Medium.column or Column.of_knots. Never changes."""

    @classmethod
    def _empty(cls, knots):
        column = cls.__new__(cls)
        column._struct = _abi.Column()
        # Not copied by the library.
        column._knots = knots
        return column

    def __init__(self):
        raise TypeError("Column: made by Medium.column(...) or Column.of_knots(...)")

    @classmethod
    def of_knots(cls, knots):
        """The column of a medium of your own, from a table.

        - knots: packed KNOT, distances and columns not falling (not checked: without it the values mean nothing). Kept, not copied.
        """
        table = packed("knots", knots, KNOT)
        column = cls._empty(knots)
        column._struct.kind = 2
        column._struct.knots, column._struct.knot_count = table.count and table.address, table.count
        return column

    def at(self, distances, *, out=None):
        """Columns [m] up to distances [m] >= 0; inf allowed."""
        return elementwise(
            lib.covbeam_column_at_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("distances", distances, FLOAT),
            made("out", out, FLOAT),
        )

    def distance_at(self, values, *, out=None):
        """Distances [m] at which the column reaches values [m] >= 0; inf if it never does."""
        return elementwise(
            lib.covbeam_column_distance_at_many,
            ctypes.addressof(self._struct),
            COUNT,
            given("values", values, FLOAT),
            made("out", out, FLOAT),
        )
