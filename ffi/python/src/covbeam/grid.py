"""Covariance grids: what photons leave in them, and what a gather looks up."""

import ctypes

import numpy as np

from . import _abi
from ._arrays import COUNT, FLAG, FLOAT, VECTOR, Kind, elementwise, given, made, packed, struct, two_outs, voxels
from ._callbacks import Call
from ._handles import Object, Owner, using
from ._library import check, lib
from .dtypes import FLUENCE_CELL, GRID_CELL, KNOT, SEGMENT, SPECTRUM
from .media import GridLayout, Medium, _layout


class _Memory:
    """A piece of the library's memory that numpy may look at; keeps its owner."""

    def __init__(self, owner, address, shape, dtype):
        self.owner = owner
        read_only = True
        self.__array_interface__ = {
            "version": 3,
            "shape": shape,
            "typestr": f"|V{dtype.itemsize}",
            "data": (address, read_only),
        }


class Grid(Object):
    """A grid of fluence spectra. It collects (deposit), adds up (merge), is resolved once the photons of a pass are in
    (resolve), and is looked up from then on, by BeamMap.gather too.

    Grid(layout) is empty and in the library's memory: 56 bytes a voxel, and 28 more from the first resolve on.
    """

    def __init__(self, layout):
        box = _layout(layout)
        self._owner = Owner(lib.covbeam_grid_new, lib.covbeam_grid_free, ctypes.addressof(box))

    @classmethod
    def new_in(cls, layout, cells, means):
        """Makes a grid in memory of yours, which it keeps alive, and which you may read and write between calls.

        - cells: GRID_CELL of shape (nz, ny, nx) or (n,), packed; zero them for an empty grid.
        - means: FLUENCE_CELL likewise; written by resolve.
        """
        box = _layout(layout)
        first = voxels("cells", cells, GRID_CELL, layout.cells, written=True, packed=True)
        second = voxels("means", means, FLUENCE_CELL, layout.cells, written=True, packed=True)
        if np.may_share_memory(cells, means):
            raise ValueError("means: shares memory with cells; give an array of its own")
        grid = cls.__new__(cls)
        grid._owner = Owner(
            lib.covbeam_grid_new_in,
            lib.covbeam_grid_free,
            ctypes.addressof(box),
            first.address,
            first.count,
            second.address,
            second.count,
            borrowed=(cells, means),
        )
        return grid

    @classmethod
    def load(cls, data):
        """Makes a grid from the bytes of save(); it is not resolved yet. Bytes that save() has not written are refused."""
        view = memoryview(data).cast("B")
        memory = np.frombuffer(view, np.uint8) if len(view) else np.zeros(0, np.uint8)
        grid = cls.__new__(cls)
        grid._owner = Owner(lib.covbeam_grid_load, lib.covbeam_grid_free, memory.ctypes.data, len(memory))
        return grid

    @property
    def layout(self):
        """Box and resolution: a GridLayout."""
        box = _abi.GridLayout()
        with using(self) as [grid]:
            check(lib.covbeam_grid_get_layout(grid, ctypes.addressof(box)))
        return GridLayout(tuple(box.min), tuple(box.max), tuple(box.cells))

    def clear(self):
        """Empties the grid, and forgets what was resolved."""
        with using(changed=self) as [grid]:
            check(lib.covbeam_grid_clear(grid))

    def deposit(self, medium, segments, *, knots=None, poll=None):
        """Adds the light fields along segments of light paths, in their order.

        - medium: a Medium that the segments run through.
        - segments: SEGMENT of shape () or (n,). Unless you have a medium of your own, leave their `knots` and `knot_count` 0.
        - knots: for a medium of your own: one packed KNOT array with the tables of all segments, distances from the origin
          growing, columns (optical depth / extinction of `medium`) not falling. Segment i uses m rows from row k on after
          segments["knots"][i] = knots.ctypes.data + k * KNOT.itemsize and segments["knot_count"][i] = m.
        - poll: as in BeamMap.commit; stopped, the grid keeps what it has of the first segments.
        """
        argument = given("segments", segments, Kind(SEGMENT))
        table = None if knots is None else packed("knots", knots, KNOT)
        _check_tables(segments, table)
        call = Call(poll)
        with using(changed=self) as [grid]:
            elementwise(
                lib.covbeam_grid_deposit,
                grid,
                struct("medium", medium, Medium),
                COUNT,
                argument,
                call.poll,
                None,
                ended=call.check,
            )

    def deposit_spectra(self, positions, spectra, weights):
        """Adds spectra to the voxels around points, in their order: for hosts that estimate bandwidth in a way of their own.

        - positions: [m]; one outside the grid adds nothing.
        - spectra: SPECTRUM, finite.
        - weights: contributions to the fluence [W m], finite and >= 0.
        """
        with using(changed=self) as [grid]:
            elementwise(
                lib.covbeam_grid_deposit_spectra,
                grid,
                COUNT,
                given("positions", positions, VECTOR),
                given("spectra", spectra, Kind(SPECTRUM)),
                given("weights", weights, FLOAT),
            )

    def merge(self, others):
        """Adds what other grids of the same layout have collected, in their order; they stay as they are."""
        others = list(others)
        with using(*others, changed=self) as [*handles, grid]:
            array = (ctypes.c_void_p * len(handles))(*handles)
            check(lib.covbeam_grid_merge(grid, ctypes.addressof(array), len(handles)))

    def resolve(self):
        """Computes the mean spectrum of every voxel; look-ups see the state of this call until the next one."""
        with using(changed=self) as [grid]:
            check(lib.covbeam_grid_resolve(grid))

    def look_up(self, positions, *, out=None):
        """The spectra of the fluence around points [m]: (spectra, found), SPECTRUM and bool. Where nothing is found, all 0."""
        spectra, found = two_outs(out)
        with using(self) as [grid]:
            return elementwise(
                lib.covbeam_grid_look_up,
                grid,
                COUNT,
                given("positions", positions, VECTOR),
                made("spectra", spectra, Kind(SPECTRUM)),
                made("found", found, FLAG),
            )

    @property
    def cells(self):
        """What the voxels have collected: GRID_CELL of shape (nz, ny, nx), read-only, without a copy.

        The view shows what the grid holds at each moment, deposits and clear included, and keeps its memory alive.
        """
        return self._view(lib.covbeam_grid_get_cells, GRID_CELL)

    @property
    def means(self):
        """The mean spectra that look-ups see: FLUENCE_CELL of shape (nz, ny, nx), read-only, without a copy.

        The view shows the latest resolve, the next ones included, and keeps its memory alive.
        """
        return self._view(lib.covbeam_grid_get_means, FLUENCE_CELL)

    def _view(self, function, dtype):
        first, count = ctypes.c_void_p(), ctypes.c_size_t()
        shape = self.layout.cells[::-1]
        with using(self) as [grid]:
            check(function(grid, ctypes.addressof(first), ctypes.addressof(count)))
        return np.asarray(_Memory(self._owned(), first.value, shape, dtype)).view(dtype)

    def save(self):
        """What the grid has collected as bytes, the same on every machine."""
        size = ctypes.c_size_t()
        with using(self) as [grid]:
            check(lib.covbeam_grid_get_saved_size(grid, ctypes.addressof(size)))
            memory = np.empty(size.value, np.uint8)
            check(lib.covbeam_grid_save(grid, memory.ctypes.data, size.value))
        return memory.tobytes()


def _check_tables(segments, table):
    """An address in an array may be anything: only those inside `table` are followed."""
    first, count = segments["knots"], segments["knot_count"]
    begin, rows = (0, 0) if table is None else (table.address, table.count)
    # Unsigned: an address below wraps around to a large number.
    row, odd = np.divmod(first - np.uintp(begin), np.uintp(KNOT.itemsize))
    inside = (odd == 0) & (row <= rows) & (count <= np.uintp(rows) - np.minimum(row, np.uintp(rows)))
    wrong = np.flatnonzero(np.where(first == 0, count != 0, ~inside))
    if len(wrong):
        raise ValueError(
            f"segments: element {wrong[0]} points at knots outside the array `knots`; "
            "give that array, or leave knots and knot_count 0 (make segments with np.zeros)"
        )
