# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that has a picture of its directions: cells of equal angles around an axis, drawn by how bright they are."""

import numpy as np


def sky_cells(direction, rows, columns):
    """Rows and columns of a sky (scene.Light) that lie in unit directions (n, 3): int (n,) both."""
    row = np.clip(np.arccos(np.clip(direction[:, 2], -1, 1)) * (rows / np.pi), 0, rows - 1).astype(int)
    azimuth = np.arctan2(direction[:, 1], direction[:, 0])
    return row, np.clip((1 - azimuth / np.pi) * (0.5 * columns), 0, columns - 1).astype(int)


class Cells:
    """Directions of a picture, drawn in proportion to its brightest channel.

    - values: (h, w, 3) >= 0. Rows run from the axis to the angle `reach` [rad] from it, columns around it.
    - shares: (h,), how much a row is wanted beside that.
    """

    def __init__(self, values, reach=np.pi, shares=1.0):
        values = values.astype(np.float64)
        rows, columns, _ = values.shape
        self._columns = columns
        #: Cosines of the rows' borders, from 1 down.
        self._cosines = np.cos(np.linspace(0, reach, rows + 1))
        #: Solid angles of the cells of each row [sr].
        self.angles = -np.diff(self._cosines) * (2 * np.pi / columns)
        wanted = values.max(axis=2) * (self.angles * shares)[:, None]
        self._bounds = np.cumsum(wanted)
        self._total = max(float(self._bounds[-1]), 1e-300)
        density = np.maximum(wanted, 1e-300) / (self._total * self.angles[:, None])
        #: Values over the density of their directions.
        self._weights = (values / density[..., None]).reshape(-1, 3)

    def draw(self, u, v):
        """Directions for uniform numbers (n,): their cosines from the axis, turns about it in [0, 1), and the picture over the density
        of the directions [sr], (n, 3)."""
        at = u.astype(np.float64) * self._bounds[-1]
        cell = np.minimum(np.searchsorted(self._bounds, at, side="right"), len(self._bounds) - 1)
        below = np.where(cell > 0, self._bounds[cell - 1], 0.0)
        rest = np.clip((at - below) / np.maximum(self._bounds[cell] - below, 1e-300), 0, 1)
        row, column = np.divmod(cell, self._columns)
        upper, lower = self._cosines[row], self._cosines[row + 1]
        return upper + v * (lower - upper), (column + rest) / self._columns, self._weights[cell]
