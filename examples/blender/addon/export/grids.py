# SPDX-License-Identifier: GPL-3.0-or-later
"""What objects hold on lattices of their own, such as smoke: values by name, as Cycles looks them up."""

from dataclasses import dataclass
from zlib import crc32

import bpy
import numpy as np


@dataclass(frozen=True)
class Grid:
    """Values at the middles of cells: trilinear between them, and fading to 0 over a cell outside of the outermost."""

    #: float32 (nz, ny, nx, channels): one channel, three, or four: a colour times its alpha, and that.
    values: np.ndarray
    #: From the object's space to cells, whose middles are at whole numbers: float64 (4, 4).
    to_cells: np.ndarray

    def at(self, inside, change=None):
        """Values at places in the object's space, float64 (n, 3): (n, channels); change: what is made of them before they are mixed,
        a function of (n, channels)."""
        at = inside @ self.to_cells[:3, :3].T + self.to_cells[:3, 3]
        cells, flat = self.values.shape[2::-1], self.values.reshape(-1, self.values.shape[3])
        near = np.flatnonzero(((at > -1) & (at < cells)).all(axis=1))
        # For each axis and both cells beside a place: how far that is into the array, and its weight, 0 outside.
        sides, step = [], 1
        for axis, count in enumerate(cells):
            of = at[near, axis]
            low = np.floor(of).astype(np.int64)
            rest = of - low
            below, above = step * np.maximum(low, 0), step * np.minimum(low + 1, count - 1)
            sides.append(((below, np.where(low >= 0, 1 - rest, 0)), (above, np.where(low + 1 < count, rest, 0))))
            step *= count
        total = 0
        for x, y, z in np.ndindex(2, 2, 2):
            parts = sides[0][x], sides[1][y], sides[2][z]
            values = flat[parts[0][0] + parts[1][0] + parts[2][0]]
            weight = parts[0][1] * parts[1][1] * parts[2][1]
            total = total + weight[:, None] * (values if change is None else change(values))
        found = np.zeros((len(at), total.shape[1]))
        found[near] = total
        return found


class Grids:
    """The grids of an object by name, read when they are first asked for."""

    def __init__(self, read, lattices):
        """read: function of a name that returns a Grid, or None if there is none; lattices: cells along x, y, z, int (3,), and to_cells of
        each Grid, or of one that has room for all."""
        self._read, self._found, self._to_cells = read, {}, [to_cells for _, to_cells in lattices]
        corners = np.concatenate([_corners(*lattice) for lattice in lattices])
        #: Corners of where there may be something, in the object's space [m]: float64 (3,).
        self.low, self.high = corners.min(axis=0), corners.max(axis=0)

    def find(self, name):
        """The Grid of a name, or None."""
        if name not in self._found:
            self._found[name] = self._read(name) if name else None
        return self._found[name]

    def cells_a_metre(self, matrix):
        """How many cells of the finest Grid there are along the axes of the world [1/m], float64 (3,); matrix: from the object to the world
        (4, 4)."""
        back = np.linalg.pinv(matrix[:3, :3])
        return np.max([np.linalg.norm(to_cells[:3, :3] @ back, axis=0) for to_cells in self._to_cells], axis=0)


def _corners(cells, to_cells):
    """Corners of the box that so many cells fill, in the object's space, float64 (8, 3)."""
    back = np.linalg.inv(to_cells)
    # A cell more on all sides, in which values fade: the middles of voxels in the box are those of cells.
    ends = [(-1.5, n + 0.5) for n in cells]
    corners = np.array([[ends[axis][k] for axis, k in enumerate(corner)] for corner in np.ndindex(2, 2, 2)])
    return corners @ back[:3, :3].T + back[:3, 3]


class Lookup:
    """Values of some Grids at places in the object's space, float64 (n, 3)."""

    def __init__(self, grids, inside):
        self._grids, self._inside, self._found = grids, inside, {}

    @property
    def misses_all(self):
        """Whether there are grids, but nothing that has been asked for is one of them."""
        return self._grids is not None and all(found is None for found in self._found.values())

    def number(self, name):
        """A number, (n, 1), or None if there is no such grid."""
        found = self._at(name)
        return found if found is None else found[:, :3].mean(axis=1, keepdims=True)

    def colour(self, name):
        """A colour or vector, (n, 3), or None."""
        found = self._at(name)
        if found is None or found.shape[1] == 3:
            return found
        if found.shape[1] == 1:
            return np.repeat(found, 3, axis=1)
        # Up to Blender 4.5 Cycles divides by what alpha is between the cells.
        return _divided(found) if bpy.app.version < (5, 0) else self._at(name, _divided)

    def alpha(self, name):
        """Alpha, (n, 1), or None."""
        found = self._at(name)
        return found if found is None else found[:, 3:] if found.shape[1] == 4 else np.ones((len(found), 1))

    def _at(self, name, change=None):
        key = name, change
        if key not in self._found:
            grid = self._grids.find(name) if self._grids is not None else None
            self._found[key] = None if grid is None else grid.at(self._inside, change)
        return self._found[key]


class Asked:
    """Stands for a Lookup of n places where it is not known yet what is held: values at random, by which `names` becomes what is asked for."""

    misses_all = False

    def __init__(self, count):
        self.names, self._count = set(), count

    def number(self, name):
        """As of Lookup."""
        return self._drawn(name, 1)

    def colour(self, name):
        """As of Lookup."""
        return self._drawn(name, 3)

    alpha = number

    def _drawn(self, name, channels):
        if not name:
            return None
        self.names.add(name)
        return np.random.default_rng(crc32(name.encode())).random((self._count, channels))


def _divided(values):
    """Colours times their alpha, (n, 4), as colours (n, 3)."""
    alpha = values[:, 3:]
    return values[:, :3] / np.where(alpha > 1e-6, alpha, 1)
