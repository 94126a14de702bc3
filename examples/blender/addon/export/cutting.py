# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of which textures decide what they let through, send out or reflect: cut into pieces of a few materials."""

from dataclasses import dataclass

import numpy as np

from ..host import ask
from ..host.scene import MATERIAL
from .lobes import WEIGHTS
from .quarters import DEEPEST, Pieces, depths, middles, piece_at

#: No more places of a mesh are looked at.
_MOST_LOOKS = 1 << 21

#: Materials of a mesh's pieces beside what is not there at all.
_KINDS = 32

#: Places where the error is measured, and places that are looked at together.
_TRIALS, _SLICE = 4096, 65536

#: A piece that lets through more is not there.
_CLEAR = 1 - 1 / 512

#: Columns of MATERIAL as numbers, and of the radiance after it.
_WIDTH = MATERIAL.itemsize // 4
_COLUMN = {name: slice(MATERIAL.fields[name][1] // 4, MATERIAL.fields[name][1] // 4 + 3) for name in (*WEIGHTS, "shadow")}
_PASSING = np.r_[tuple(_COLUMN[name] for name in ("transparent", "shadow", "translucent", "glass_transmission"))]
_REFLECTING = np.r_[tuple(_COLUMN[name] for name in ("diffuse", "metal", "edge", "coat", "glass_reflection"))]
_ALPHA, _IOR = (MATERIAL.fields[name][1] // 4 for name in ("alpha", "ior"))
_SPECULAR = np.r_[tuple(_COLUMN[name] for name in ("metal", "glass_reflection", "glass_transmission", "coat"))]


@dataclass(frozen=True)
class Detail:
    """How finely a mesh is cut."""

    #: Places that a material is looked at on a mesh, or so many a triangle.
    looks: int
    looks_each: int
    #: Most pieces of a mesh.
    pieces: int
    #: Differences within a piece: the first under which there are few enough pieces is taken.
    tolerances: tuple[float, ...]
    #: Of what: columns of MATERIAL as numbers.
    columns: np.ndarray


#: Where textures decide how light goes on behind a surface, or how it shines: that has edges in fog.
FINE = Detail(1 << 18, 64, 1 << 18, (0.02, 0.05, 0.1, 0.2), _PASSING)

#: Where they decide what it reflects: in fog that is as even as the light of a lamp as large as a piece.
COARSE = Detail(1 << 14, 1, 1 << 12, (0.1, 0.2), np.r_[_PASSING, _REFLECTING, _ALPHA, _IOR])


@dataclass(frozen=True)
class Cut:
    """What has become of the triangles of one material."""

    #: Their kinds are indices of the next two; the first is of what lets everything through.
    pieces: Pieces
    #: MATERIAL and radiance, (k,) and (k, 3).
    rows: np.ndarray
    emission: np.ndarray
    #: Mean difference of the share of light that goes on behind the surface, or of its radiance over the mean's.
    error: float


def cut(triangles, areas, wanted, look, detail, poll):
    """Pieces of some triangles, int (m,), within which a material is alike.

    - areas: of the triangles; wanted: shares of the looks that they get, both (m,).
    - look: function of places, triangles (n,) and shares of their corners (n, 3), that returns MATERIAL and radiance there, (n,) and (n, 3).
    - detail: a Detail; poll: as for export.
    """
    cuts = depths(wanted, min(max(detail.looks, detail.looks_each * len(wanted)), _MOST_LOOKS))
    parts = [_Part(triangles[cuts == depth], areas[cuts == depth], depth, look, poll) for depth in np.unique(cuts).tolist()]
    brightest = max(float(part.fields[..., _WIDTH:].max()) for part in parts)
    for part in parts:
        part.judge(detail.columns, 1 / brightest if brightest > 0 else 0.0)
    shallowest = _few_enough(parts, detail)
    leaves = [leaf for part in parts for leaf in part.leaves(*shallowest)]
    fields, weights = (np.concatenate([getattr(leaf, name) for leaf in leaves]) for name in ("fields", "areas"))
    kinds = _kinds(fields, weights, detail.columns, 1 / brightest if brightest > 0 else 0.0)
    values = _of_kinds(fields, weights, kinds)
    first = 0
    for leaf in leaves:
        leaf.paint(kinds[first : first + len(leaf.areas)])
        first += len(leaf.areas)
    rows = values[:, :_WIDTH].astype(np.float32).copy().view(MATERIAL)[:, 0]
    pieces = Pieces.together([piece for part in parts for piece in part.pieces()])
    return Cut(pieces, rows, values[:, _WIDTH:], _error(parts, values, look))


def _numbers(rows, emission):
    """MATERIAL and radiance as float32 (n, ...)."""
    values = np.concatenate([np.ascontiguousarray(rows).view(np.float32).reshape(len(rows), -1), emission], axis=1)
    return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0).astype(np.float32)


class _Part:
    """Triangles that are cut equally often."""

    def __init__(self, triangles, areas, depth, look, poll):
        self.triangles, self.areas, self.depth = triangles, areas, depth
        self.cells = 4**depth
        shares, found = middles(depth), []
        for start in range(0, len(triangles) * self.cells, _SLICE):
            ask(poll)
            triangle, piece = np.divmod(np.arange(start, min(start + _SLICE, len(triangles) * self.cells)), self.cells)
            found.append(_numbers(*look(triangles[triangle], shares[piece])))
        #: What the material has in the middles of the smallest pieces, (triangles, pieces, fields), and kinds of these.
        self.fields = np.concatenate(found).reshape(len(triangles), self.cells, -1)
        self.kinds = np.zeros((len(triangles), self.cells), np.uint8)

    def judge(self, columns, per_radiance):
        """Finds how much there is between the largest and the smallest values in each piece, by level."""
        low = high = np.concatenate([self.fields[..., columns], self.fields[..., _WIDTH:] * per_radiance], axis=2)
        self._ranges = [np.zeros((len(low), self.cells), np.float32)]
        for _ in range(self.depth):
            low = low.reshape(len(low), -1, 4, low.shape[2]).min(axis=2)
            high = high.reshape(len(high), -1, 4, high.shape[2]).max(axis=2)
            self._ranges.insert(0, (high - low).max(axis=2))

    def _whole(self, level, tolerance, shallower):
        """Which pieces of a level are not cut further: bool (triangles, pieces)."""
        return (self._ranges[level] <= tolerance) | (level >= self.depth - shallower)

    def _ends(self, whole):
        """Pieces that are whole and not part of a larger one that is, by level: triangles and pieces. whole: function of a level."""
        before = None
        for level in range(self.depth + 1):
            here = whole(level)
            yield level, np.nonzero(here if before is None else here & ~before)
            before = np.repeat(here if before is None else here | before, 4, axis=1)

    def count(self, tolerance, shallower):
        """Number of pieces."""
        return sum(len(of[0]) for _, of in self._ends(lambda level: self._whole(level, tolerance, shallower)))

    def leaves(self, tolerance, shallower):
        """The same as _Leaf, by level."""
        for level, (triangle, piece) in self._ends(lambda level: self._whole(level, tolerance, shallower)):
            if len(triangle):
                yield _Leaf(self, level, triangle, piece)

    def pieces(self):
        """Pieces of one kind each, as large as they can be."""
        low = high = self.kinds
        whole = [np.ones_like(low, bool)]
        for _ in range(self.depth):
            low, high = low.reshape(len(low), -1, 4).min(axis=2), high.reshape(len(high), -1, 4).max(axis=2)
            whole.insert(0, low == high)
        for level, (triangle, piece) in self._ends(lambda level: whole[level]):
            kind = self.kinds[triangle, piece * 4 ** (self.depth - level)]
            yield Pieces(self.triangles[triangle], np.full(len(triangle), level), piece, kind.astype(np.int64))


class _Leaf:
    """Pieces of a _Part that are of one level: which of its triangles, and which they are."""

    def __init__(self, part, level, triangle, piece):
        self._part, self._triangle = part, triangle
        self._each = 4 ** (part.depth - level)
        # The smallest pieces that it is made of follow each other.
        self._cells = piece[:, None] * self._each + np.arange(self._each)
        self.areas = part.areas[triangle] / 4.0**level
        self.fields = part.fields[triangle[:, None], self._cells].mean(axis=1, dtype=np.float64)

    def paint(self, kinds):
        """Notes of which kind they are."""
        self._part.kinds[self._triangle[:, None], self._cells] = kinds[:, None]


def _few_enough(parts, detail):
    """The first tolerance, and how many levels must go beside it, that leave few enough pieces."""
    last = detail.tolerances[-1]
    for choice in [(tolerance, 0) for tolerance in detail.tolerances] + [(last, fewer) for fewer in range(1, DEEPEST)]:
        if sum(part.count(*choice) for part in parts) <= max(detail.pieces, sum(len(part.triangles) for part in parts)):
            return choice
    return last, DEEPEST


def _kinds(fields, areas, columns, per_radiance):
    """Kinds of pieces: 0 of what is not there, others from 1 on; uint8 (n,)."""
    values = np.concatenate([fields[:, columns], fields[:, _WIDTH:] * per_radiance], axis=1)
    kinds = np.ones(len(values), np.uint8)
    kinds[(np.minimum(fields[:, _COLUMN["transparent"]], fields[:, _COLUMN["shadow"]]) >= _CLEAR).all(axis=1)] = 0
    spread = {}
    for made in range(2, _KINDS + 1):
        for kind in set(range(1, made)) - set(spread):
            spread[kind] = _spread(values[kinds == kind], areas[kinds == kind])
        kind = max(spread, key=lambda kind: spread[kind][0])
        amount, channel, middle = spread.pop(kind)
        if not amount > 0:
            break
        kinds[(kinds == kind) & (values[:, channel] > middle)] = made
    return kinds


def _spread(values, areas):
    """How much values differ, in which channel the most, and its mean; as differences that do not matter are none."""
    if not len(values) or not np.ptp(values, axis=0).max() > 0.01:
        return 0.0, 0, 0.0
    total = max(float(areas.sum()), 1e-300)
    mean = areas @ values / total
    squares = areas @ (values - mean) ** 2
    channel = int(np.argmax(squares))
    # On both sides of it there is something, whatever the areas are.
    middle = np.clip(mean[channel], values[:, channel].min(), np.nextafter(values[:, channel].max(), -np.inf))
    return float(max(squares[channel], 1e-30)), channel, float(middle)


def _of_kinds(fields, areas, kinds):
    """Fields of each kind: means of its pieces, (k, ...)."""
    count = int(kinds.max(initial=0)) + 1
    found = np.zeros((count, fields.shape[1]))
    specular = fields[:, _SPECULAR].max(axis=1) + 1e-6
    for kind in range(count):
        of = kinds == kind
        if of.any():
            weights = np.maximum(areas[of], 1e-300)
            found[kind] = weights @ fields[of] / weights.sum()
            for column in (_ALPHA, _IOR):
                found[kind, column] = (weights * specular[of]) @ fields[of, column] / (weights * specular[of]).sum()
    found[0] = 0
    found[0, _COLUMN["transparent"]] = found[0, _COLUMN["shadow"]] = found[0, _IOR] = 1
    return found


def _error(parts, values, look):
    """As of Cut, at places drawn evenly."""
    rng = np.random.default_rng(0)
    areas = np.concatenate([part.areas for part in parts])
    if not areas.sum() > 0:
        return 0.0
    which = rng.choice(len(areas), _TRIALS, p=areas / areas.sum())
    u, v = rng.random((2, _TRIALS))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    shares = np.stack([1 - u - v, u, v], axis=1)
    triangles = np.concatenate([part.triangles for part in parts])[which]
    expected, first = _numbers(*look(triangles, shares)), 0
    kinds = np.zeros(_TRIALS, np.uint8)
    for part in parts:
        of = np.flatnonzero((which >= first) & (which < first + len(part.triangles)))
        kinds[of] = part.kinds[which[of] - first, piece_at(shares[of], part.depth)]
        first += len(part.triangles)
    off = np.abs(values[kinds] - expected)
    radiance = float(expected[:, _WIDTH:].mean())
    shining = float(off[:, _WIDTH:].mean()) / radiance if radiance > 0 else 0.0
    # What is transparent lets light of lamps through, too, for the most part.
    off[:, _COLUMN["transparent"]] = np.maximum(off[:, _COLUMN["transparent"]], off[:, _COLUMN["shadow"]])
    off[:, _COLUMN["shadow"]] = 0
    return max(float(off[:, _PASSING].sum(axis=1).mean()) / 3, shining)
