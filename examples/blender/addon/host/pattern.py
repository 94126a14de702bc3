# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps whose light depends on its direction: a picture in front of them, or what was measured."""

import numpy as np

from .cells import Cells
from .emitting import CURVATURE

#: How far fine things are felt, in doublings of a cell.
_SCALES = 6


class PatternedDirections:
    """Directions of a lamp with a scene.Pattern, drawn by how bright they are.

    - falloff: a factor by the cosine from the axis.
    """

    def __init__(self, pattern, falloff):
        rows, _, _ = pattern.cells.shape
        middles = np.cos((np.arange(rows) + 0.5) * (pattern.reach / rows))
        self._pattern, self._falloff = pattern, falloff
        # A row that is dark in its middle may be lit at its border.
        self._cells = Cells(pattern.cells, pattern.reach, np.maximum(falloff(middles), 0.01))
        self._variance = _variance(pattern.cells.max(axis=2), pattern.reach).reshape(-1)
        #: Integral of the pattern over its directions, (3,) [sr].
        self.total = np.einsum("ijk,i->k", pattern.cells.astype(np.float64), self._cells.angles * falloff(middles))

    def draw(self, u, v):
        """Unit directions, float32 (n, 3), and the pattern there over their density [sr], (n, 3)."""
        cosine, turn, weight = self._cells.draw(u, v)
        sine, phi = np.sqrt(np.maximum(1 - cosine * cosine, 0)), 2 * np.pi * turn
        local = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=1)
        direction = local @ self._pattern.axes
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        return direction.astype(np.float32), weight * self._falloff(cosine)[:, None]

    def variances(self, direction):
        """Angular variances of the pattern's spectrum in some directions, float32 (n,) [cycles^2/rad^2]."""
        rows, columns, _ = self._pattern.cells.shape
        local = direction.astype(np.float64) @ self._pattern.axes.T
        angle = np.arccos(np.clip(local[:, 2], -1, 1))
        row = np.clip(angle * (rows / self._pattern.reach), 0, rows - 1).astype(int)
        turn = np.arctan2(local[:, 1], local[:, 0]) / (2 * np.pi) % 1.0
        column = np.minimum((turn * columns).astype(int), columns - 1)
        return self._variance[row * columns + column].astype(np.float32)


def _variance(cells, reach):
    """The largest squared relative gradient of cells (h, w) around each, over 4 pi^2: of the cells, and of what is left of them when they
    are blurred, so that an edge is felt at a distance as one over that."""
    rows, columns = cells.shape
    found, blurred = np.zeros(cells.shape), cells.astype(np.float64)
    sine = np.maximum(np.sin((np.arange(rows) + 0.5) * (reach / rows)), 0.5 * reach / rows)
    across = (sine * (2 * np.pi / columns))[:, None]
    for scale in range(_SCALES):
        step = 1 << scale
        up = np.concatenate([np.repeat(blurred[:1], step, axis=0), blurred])[:rows]
        down = np.concatenate([blurred, np.repeat(blurred[-1:], step, axis=0)])[-rows:]
        left, right = np.roll(blurred, step, axis=1), np.roll(blurred, -step, axis=1)
        along = np.maximum(np.abs(blurred - up), np.abs(down - blurred)) / (step * reach / rows)
        beside = np.maximum(np.abs(blurred - left), np.abs(right - blurred)) / (step * across)
        mean = np.maximum((up + down + left + right + blurred) / 5, 1e-300)
        found = np.maximum(found, (along / mean) ** 2 + (beside / mean) ** 2)
        blurred = 0.25 * (up + down) + 0.5 * blurred
        blurred = 0.25 * (np.roll(blurred, step, axis=1) + np.roll(blurred, -step, axis=1)) + 0.5 * blurred
    return found * CURVATURE
