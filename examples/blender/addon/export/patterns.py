# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of lamps that differs with direction -> cells of host.scene.Pattern."""

import math

import numpy as np

#: Directions of a lamp are told apart by angles from its axis and around it.
_CELLS = 512, 1024

#: The same where a ball's normals are averaged, which leaves nothing fine: by so many of them. And places that tell whether that must be.
_COARSE, _NORMALS, _LOOKS = (64, 128), 256, 64


def cells_of(shines, reach, is_ball, values):
    """Cells of a Pattern: float32 (rows, columns, 3).

    - shines: function of normals of a lamp's surface and of directions in which light leaves there, (n, 3) both, unit, of the lamp's own space, that
      returns light, (n, 3).
    - reach: angle from the axis where the lamp's light ends [rad].
    - is_ball: whether the lamp is a ball. It has a normal at each place that is seen; a disk that faces what it lights has one, as a point has.
    - values: nodes.Values, for the report.
    """
    if is_ball and _heeds_normals(shines, values):
        return _of_ball(shines, reach)
    away = directions(reach, *_CELLS)
    return shines(away, away).reshape(*_CELLS, 3).astype(np.float32)


def directions(reach, rows, columns):
    """Unit vectors in the middles of cells of a Pattern, in the lamp's own space: float64 (rows * columns, 3)."""
    angle, turn = (np.arange(rows) + 0.5) * (reach / rows), (np.arange(columns) + 0.5) * (2 * math.pi / columns)
    angle, turn = np.meshgrid(angle, turn, indexing="ij")
    # A lamp shines along its -Z.
    return np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), -np.cos(angle)], axis=-1).reshape(-1, 3)


def _heeds_normals(shines, values):
    """Whether light depends on the normal where it leaves; that it depends on its direction too is said."""
    random = np.random.default_rng(0).normal(size=(2, _LOOKS, 3))
    normals, leaving = random / np.linalg.norm(random, axis=-1, keepdims=True)
    one = np.broadcast_to(normals[:1], normals.shape)
    by_normal, by_direction = shines(normals, one), shines(one, leaving)
    if not (by_normal != by_normal[0]).any():
        return False
    if (by_direction != by_direction[0]).any():
        values.note("a pattern of a ball by normals and directions", "coarser than 3 degrees by directions", in_fog=True)
    return True


def _of_ball(shines, reach):
    """Cells of what all places of a ball that are seen from far away send there, each as large as it is seen: float32 (rows, columns, 3)."""
    rows, columns = _COARSE
    away = directions(reach, rows, columns)
    # Normals around a direction, as many for the same area that is seen: evenly over a disk (Vogel's spiral), and up from there.
    radius, turn = np.sqrt((np.arange(_NORMALS) + 0.5) / _NORMALS), np.arange(_NORMALS) * (math.pi * (3 - math.sqrt(5)))
    disk = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - radius**2)], axis=-1)
    side = np.cross(away, np.where(np.abs(away[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    total = np.zeros_like(away)
    for x, y, z in disk:
        total += shines(x * side + y * np.cross(away, side) + z * away, away)
    coarse = (total / _NORMALS).reshape(rows, columns, 3)
    # What lies beyond a pole is half a turn away.
    ends = [np.roll(coarse[row], columns // 2, axis=0)[None] for row in (0, -1)]
    coarse = np.concatenate([ends[0], coarse, ends[1] if reach == math.pi else coarse[-1:]])
    # Between the middles of coarse cells, and around.
    place = [(np.arange(fine) + 0.5) * (few / fine) - 0.5 for fine, few in zip(_CELLS, _COARSE)]
    low = [np.floor(at).astype(int) for at in place]
    rest = [(at - below)[:, None, None] for at, below in zip(place, low)]
    by_rows = (1 - rest[0]) * coarse[low[0] + 1] + rest[0] * coarse[low[0] + 2]
    turned = np.moveaxis(by_rows, 1, 0)
    cells = (1 - rest[1]) * turned[low[1] % columns] + rest[1] * turned[(low[1] + 1) % columns]
    return np.moveaxis(cells, 0, 1).astype(np.float32)
