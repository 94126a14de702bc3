# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles cut into four alike, again and again: pieces, where they are, and meshes of them without gaps.

A piece has a level, 0 for a whole triangle, and a number below 4^level: that of the piece it is a part of, times 4, and 0, 1 or 2 for the part
at that corner, 3 for the one in the middle.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .meshes import Triangles

#: No triangle is cut more often.
DEEPEST = 9


@dataclass(frozen=True)
class Pieces:
    """Pieces of the triangles of a mesh, each int (n,): of which triangle, which they are, and what kind."""

    triangle: np.ndarray
    level: np.ndarray
    number: np.ndarray
    kind: np.ndarray

    def __getitem__(self, which):
        return Pieces(self.triangle[which], self.level[which], self.number[which], self.kind[which])

    @staticmethod
    def together(parts):
        """All pieces of some Pieces."""
        return Pieces(*(np.concatenate(of) for of in zip(*((p.triangle, p.level, p.number, p.kind) for p in parts))))


def depths(wanted, most):
    """How often triangles are cut, int (m,), that get shares of `most` pieces: `wanted`, float64 (m,), is what these are like."""
    share = wanted / max(float(wanted.sum()), 1e-300)
    return np.clip(np.floor(np.log2(np.maximum(share * most, 1)) / 2), 0, DEEPEST).astype(int)


@lru_cache
def corners(level):
    """Where the corners of the pieces of a level are, in 2^level steps from a triangle's first corner to the others: int (4^level, 3, 2)."""
    if level == 0:
        return np.array([[(0, 0), (1, 0), (0, 1)]])
    a, b, c = (2 * corners(level - 1)).transpose(1, 0, 2)
    ab, bc, ca = (a + b) // 2, (b + c) // 2, (c + a) // 2
    parts = np.array([(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)])
    return parts.transpose(2, 0, 1, 3).reshape(-1, 3, 2)


def middles(level):
    """Shares of a triangle's corners in the middles of the pieces of a level: float64 (4^level, 3)."""
    return _shares(corners(level).mean(axis=1) / 2**level)


def _shares(at):
    """Shares of the corners at places that are given by those of the second and third."""
    return np.concatenate([1 - at.sum(axis=-1, keepdims=True), at], axis=-1)


def piece_at(shares, level):
    """Numbers of the pieces of a level that have places in them; shares: of a triangle's corners, (n, 3)."""
    number = np.zeros(len(shares), np.int64)
    _, u, v = shares.T
    for _ in range(level):
        part = np.select([u + v <= 0.5, u >= 0.5, v >= 0.5], [0, 1, 2], 3)
        u, v = (
            np.choose(part, (2 * u, 2 * u - 1, 2 * u, 2 * (u + v) - 1)),
            np.choose(part, (2 * v, 2 * v, 2 * v - 1, 1 - 2 * u)),
        )
        number = 4 * number + part
    return number


def mesh_of(mesh, pieces, normals=None):
    """The Triangles that are some Pieces of those of a mesh, and which piece each is of: int (m,). Their slots are the pieces' kinds.

    Where a piece meets smaller ones it is cut so that they share their corners.

    normals: function of triangles of the mesh, (n,), and shares of their corners (n, 3), that returns unit normals there (n, 3); None: they are
    between those of the mesh.
    """
    finest = int(pieces.level.max(initial=0))
    ends = np.zeros((len(pieces.level), 3, 2), np.int64)
    for level in range(finest + 1):
        of = np.flatnonzero(pieces.level == level)
        ends[of] = corners(level)[pieces.number[of]] << (finest - level)
    name = _Names(mesh.corners, finest)
    # Edges of pieces, cut in the middle as long as another piece has a corner there.
    piece = np.repeat(np.arange(len(ends)), 3)
    start, end = ends.reshape(-1, 2), np.roll(ends, -1, axis=1).reshape(-1, 2)
    taken = np.unique(name(pieces.triangle[piece], start))
    for _ in range(finest):
        middle = (start + end) // 2
        longer = ((start + end) % 2 == 0).all(axis=1)
        found = name(pieces.triangle[piece], middle)
        cut = longer & (taken[np.minimum(np.searchsorted(taken, found), len(taken) - 1)] == found)
        if not cut.any():
            break
        start, end = np.concatenate([start, middle[cut]]), np.concatenate([np.where(cut[:, None], middle, end), end[cut]])
        piece = np.concatenate([piece, piece[cut]])
    # Whole pieces are one triangle; others one for each edge, and a corner in their middle.
    whole = np.bincount(piece, minlength=len(ends)) == 3
    single, cut = np.flatnonzero(whole), ~whole[piece]
    of = np.concatenate([single, piece[cut]])
    triangle = pieces.triangle[of]
    middle = ends.sum(axis=1)[piece[cut]] / 3
    at = np.concatenate([ends[single], np.stack([start[cut], end[cut], middle], axis=1)]).astype(np.float64)
    names = np.concatenate(
        [
            name(np.repeat(pieces.triangle[single], 3), ends[single].reshape(-1, 2)).reshape(-1, 3),
            np.stack([*(name(pieces.triangle[piece[cut]], edge[cut]) for edge in (start, end)), -1 - piece[cut]], axis=1),
        ]
    )
    _, first, index = np.unique(names, return_index=True, return_inverse=True)
    shares = _shares(at / 2**finest)
    positions = np.einsum("nkc,ncx->nkx", shares, mesh.positions[mesh.corners[triangle]].astype(np.float64))
    if normals is not None:
        # Once for each place of a triangle.
        _, places, which = np.unique(np.stack([np.repeat(triangle, 3), index.ravel()]), axis=1, return_index=True, return_inverse=True)
        normals = normals(np.repeat(triangle, 3)[places], shares.reshape(-1, 3)[places])[which.ravel()].reshape(-1, 3, 3).astype(np.float32)
    elif mesh.normals is not None:
        normals = np.einsum("nkc,ncx->nkx", shares, mesh.normals[triangle])
        length = np.linalg.norm(normals, axis=2, keepdims=True)
        # Of normals that cancel each other out the first corner's is left.
        normals = np.where(length > 1e-6, normals / np.maximum(length, 1e-6), mesh.normals[triangle][:, :1]).astype(np.float32)
    kinds = pieces.kind[of].astype(np.int32)
    made = Triangles(
        positions=positions.reshape(-1, 3)[first].astype(np.float32),
        corners=index.reshape(-1, 3).astype(np.int32),
        slots=kinds,
        used=np.unique(kinds),
        normals=normals,
        extent=mesh.extent,
        part_of=(triangle, shares) if mesh.part_of is None else (mesh.part_of[0][triangle], shares @ mesh.part_of[1][triangle]),
    )
    return made, of


class _Names:
    """Numbers for places on the edges and inside of the triangles of a mesh, the same for places that triangles have in common."""

    def __init__(self, corners, finest):
        self._corners, self._steps = corners.astype(np.int64), 1 << finest
        sides = np.stack([self._corners, np.roll(self._corners, -1, axis=1)], axis=2)
        self._low = sides.min(axis=2)
        _, edges = np.unique(self._low << 32 | sides.max(axis=2), return_inverse=True)
        self._edges = edges.reshape(-1, 3)
        self._points = int(self._corners.max(initial=0)) + 1
        self._inner = self._points + (int(self._edges.max(initial=0)) + 1) * (self._steps + 1)

    def __call__(self, triangle, at):
        """Names, int64 (n,), of places in `steps` from the first corner of some triangles: (n,) and (n, 2)."""
        steps = self._steps
        i, j = at.T
        names = self._inner + (triangle * (steps + 1) + i) * (steps + 1) + j
        # From the first corner to the second, on to the third, and back: which edge, and how far along.
        for edge, on, along in ((0, j == 0, i), (1, i + j == steps, j), (2, i == 0, steps - j)):
            of = triangle[on]
            far = np.where(self._corners[of, edge] == self._low[of, edge], along[on], steps - along[on])
            names[on] = self._points + self._edges[of, edge] * (steps + 1) + far
        for corner, on in enumerate((i + j == 0, i == steps, j == steps)):
            names[on] = self._corners[triangle[on], corner]
        return names
