# SPDX-License-Identifier: GPL-3.0-or-later
"""What varies in a volume -> voxels: as many as it takes."""

from dataclasses import dataclass

import bpy
import numpy as np

from ..host import ask
from ..host.scene import Density, Glow

#: Voxels along the longest side, from the first trial to the last; and the mean error over the mean density that ends the trials.
_SIDES, _WANTED = (24, 48, 96), 0.01

#: No more voxels than this, however fine what an object holds: 32 MiB.
MOST = 1 << 23

#: Places where the error is measured; and places that are looked at together.
_TRIALS, _SLICE = 4096, 65536


@dataclass(frozen=True)
class Baked:
    """A medium's coefficients where its density is 1, float64 (3,) [1/m], and its density; None: 1 everywhere."""

    scattering: np.ndarray
    absorption: np.ndarray
    density: Density | None
    #: What it sends out, however dense it is; None: it is dark.
    glow: Glow | None
    #: Voxels along x, y, z.
    cells: tuple[int, int, int]
    #: Mean errors of the density and of what is sent out between the voxels' middles, over their means.
    error: float
    glow_error: float
    #: How much of the light that is scattered or absorbed is of a colour that the mean's is not, as a share.
    coloured: float


def bake(coefficients, low, high, finest, poll):
    """Voxels between the corners `low` and `high` [m] for what `coefficients` says: a function of places, float64 (n, 3), that returns
    coefficients of scattering, absorption [1/m] and emission [W/(m^3 sr)] there, (n, 3) each, in the same order.

    - finest: voxels along x, y and z that show all there is to see, int (3,); ones if that is not known.
    - poll: as for export.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    # What is flat is as thick as a voxel.
    size = np.maximum(high - low, 1e-3 * float((high - low).max()))
    trials = low + np.random.default_rng(0).random((_TRIALS, 3)) * size
    *samples, emitted = coefficients(trials)
    expected = _extinction(*samples)
    for cells in _tries(size, finest, 2):
        corner, extent, cells = _to_faces(low, size, cells, finest)
        values, sums, glows = _at_middles(coefficients, corner, extent, cells, poll)
        error = _error(_between(values.reshape(cells[::-1]), (trials - corner) / extent * cells - 0.5), expected)
        if error <= _WANTED:
            break
    glow, glow_error = _glow(coefficients, low, size, finest, trials, emitted, poll) if glows else (None, 0.0)
    largest = float(values.max())
    if not largest > 0:
        return Baked(np.zeros(3), np.zeros(3), None, glow, tuple(cells.tolist()), 0.0, glow_error, 0.0)
    relative = values / np.float32(largest)
    parts = [of / relative.sum(dtype=np.float64) for of in sums]
    other = sum(np.abs(of - (expected / largest)[:, None] * part).sum() for of, part in zip(samples, parts))
    # What varies may be no more than what is sent out.
    is_even = bool((values == values[0]).all())
    density = None if is_even else Density(corner, corner + extent, relative.astype(np.float32).reshape(cells[::-1]))
    coloured = float(other) / max(3 * float(expected.sum()), 1e-30)
    return Baked(*parts, density, glow, tuple(cells.tolist()), error, glow_error, coloured)


def _glow(coefficients, low, size, finest, trials, expected, poll):
    """The host.scene.Glow of what is sent out, and its mean error over its mean."""
    # Up to Blender 4.5 Cycles' nodes see what is between an object's cells, where colours and powers bend; middles of three times as many
    # voxels have those of the cells among them. Later ones see the cells alone, and mix what they make of them.
    of_cells = np.prod(finest) > 1 and bpy.app.version >= (5, 0)
    for cells in _tries(size, finest, 3)[: 1 if of_cells else None]:
        corner, extent, cells = _to_faces(low, size, cells, finest)
        parts = [coefficients(places)[2].astype(np.float32) for places in _middles(corner, extent, cells, poll)]
        values = np.concatenate(parts).reshape(*cells[::-1], 3)
        if (values == values[0, 0, 0]).all():
            values = values[:1, :1, :1]
        at = (trials - corner) / extent * values.shape[2::-1] - 0.5
        error = 0.0 if of_cells else _error(_between(values, at), expected)
        if error <= _WANTED:
            break
    return Glow(corner, corner + extent, values), error


def _to_faces(low, size, cells, finest):
    """Corner, size and numbers of voxels whose outer middles lie on the box's faces: beyond them values are held, and fog that thins with height
    would be thinner at its foot. An object's own voxels stay."""
    if np.prod(finest) != 1:
        return low, size, cells
    return low - 0.5 * size / cells, size + size / cells, cells + 1


def _error(found, expected):
    """Mean error over the mean of what is expected; 0 where that is 0."""
    mean = float(expected.mean())
    return float(np.abs(found - expected).mean()) / mean if mean > 0 else 0.0


def _tries(size, finest, finer):
    """Numbers of voxels along x, y and z, int (3,), from few to many. If the finest is known, that, and `finer` times as many, for voxels
    that lie otherwise than what an object holds: a wisp of smoke may be where no trial is."""
    if np.prod(finest) == 1:
        return [np.maximum(1, np.ceil(size / (float(size.max()) / side) - 1e-6)).astype(int) for side in _SIDES]
    found = []
    for cells in (finest, finer * finest):
        share = min(1.0, (MOST / float(np.prod(cells, dtype=float))) ** (1 / 3))
        found.append(np.maximum(1, cells * share).astype(int) if share < 1 else cells)
    return found


def _extinction(scattering, absorption):
    """Mean of the channels: (n,)."""
    return (scattering + absorption).mean(axis=1)


def _at_middles(coefficients, low, size, cells, poll):
    """Extinction at the middles of voxels, x first, float32 (n,); sums of scattering and absorption coefficients, (3,) both [1/m]; and
    whether anything is sent out there."""
    found, sums, glows = [], np.zeros((2, 3)), False
    for places in _middles(low, size, cells, poll):
        *parts, emission = coefficients(places)
        found.append(_extinction(*parts).astype(np.float32))
        sums += [of.sum(axis=0) for of in parts]
        glows |= bool(emission.any())
    return np.concatenate(found), sums, glows


def _middles(low, size, cells, poll):
    """Middles of voxels, x first, float64 (n, 3), some at a time."""
    nx, ny, _ = cells
    for first in range(0, int(np.prod(cells)), _SLICE):
        ask(poll)
        index = np.arange(first, min(first + _SLICE, int(np.prod(cells))))
        place = np.stack([index % nx, index // nx % ny, index // (nx * ny)], axis=1)
        yield low + (place + 0.5) / cells * size


def _between(values, at):
    """Values (nz, ny, nx, ...) between the middles of voxels, trilinear, as host.scene.Density has them; at: (n, 3) in voxels."""
    most = np.array(values.shape[2::-1]) - 1
    at = np.clip(at, 0, most)
    low = at.astype(int)
    rest, high = at - low, np.minimum(low + 1, most)
    found = np.zeros((len(at), *values.shape[3:]))
    for corner in np.ndindex(2, 2, 2):
        x, y, z = (np.where(corner, high, low)).T
        weight = np.prod(np.where(corner, rest, 1 - rest), axis=1)
        found += (values[z, y, x].T * weight).T
    return found
