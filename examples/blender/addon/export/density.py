# SPDX-License-Identifier: GPL-3.0-or-later
"""What varies in a volume -> voxels: as many as it takes."""

from dataclasses import dataclass

import numpy as np

from ..host import ask
from ..host.scene import Density

#: Voxels along the longest side, from the first trial to the last; and the mean error over the mean density that ends the trials.
_SIDES, _WANTED = (24, 48, 96), 0.01

#: No more voxels than this, however fine what an object holds: 32 MiB.
MOST = 1 << 23

#: Places where the error is measured; and places that are looked at together.
_TRIALS, _SLICE = 4096, 65536


@dataclass(frozen=True)
class Baked:
    """A medium's coefficients where its density is 1, float64 (3,) [1/m], and its density; None if there is nothing."""

    scattering: np.ndarray
    absorption: np.ndarray
    density: Density | None
    #: Voxels along x, y, z.
    cells: tuple[int, int, int]
    #: Mean error of the density between the voxels' middles, over its mean.
    error: float
    #: How much of the light that is scattered or absorbed is of a colour that the mean's is not, as a share.
    coloured: float


def bake(coefficients, low, high, finest, poll):
    """Voxels between the corners `low` and `high` [m] for what `coefficients` says: a function of places, float64 (n, 3), that returns
    scattering and absorption coefficients there, (n, 3) both [1/m], in the same order.

    - finest: voxels along x, y and z that show all there is to see, int (3,); ones if that is not known.
    - poll: as for export.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    # What is flat is as thick as a voxel.
    size = np.maximum(high - low, 1e-3 * float((high - low).max()))
    trials = low + np.random.default_rng(0).random((_TRIALS, 3)) * size
    samples = coefficients(trials)
    expected = _extinction(*samples)
    for cells in _tries(size, finest):
        values, sums = _at_middles(coefficients, low, size, cells, poll)
        found = _between(values.reshape(cells[::-1]), (trials - low) / size * cells - 0.5)
        mean = float(expected.mean())
        error = float(np.abs(found - expected).mean()) / mean if mean > 0 else 0.0
        if error <= _WANTED:
            break
    largest = float(values.max())
    if not largest > 0:
        return Baked(np.zeros(3), np.zeros(3), None, tuple(cells.tolist()), 0.0, 0.0)
    relative = values / np.float32(largest)
    parts = [of / relative.sum(dtype=np.float64) for of in sums]
    other = sum(np.abs(of - (expected / largest)[:, None] * part).sum() for of, part in zip(samples, parts))
    density = Density(low, low + size, relative.astype(np.float32).reshape(cells[::-1]))
    coloured = float(other) / max(3 * float(expected.sum()), 1e-30)
    return Baked(*parts, density, tuple(cells.tolist()), error, coloured)


def _tries(size, finest):
    """Numbers of voxels along x, y and z, int (3,), from few to many. If the finest is known, that, and half of that for voxels that lie
    otherwise than what an object holds: a wisp of smoke may be where no trial is."""
    if np.prod(finest) == 1:
        return [np.maximum(1, np.ceil(size / (float(size.max()) / side) - 1e-6)).astype(int) for side in _SIDES]
    found = []
    for cells in (finest, 2 * finest):
        share = min(1.0, (MOST / float(np.prod(cells, dtype=float))) ** (1 / 3))
        found.append(np.maximum(1, cells * share).astype(int) if share < 1 else cells)
    return found


def _extinction(scattering, absorption):
    """Mean of the channels: (n,)."""
    return (scattering + absorption).mean(axis=1)


def _at_middles(coefficients, low, size, cells, poll):
    """Extinction at the middles of voxels, x first, float32 (n,), and sums of scattering and absorption coefficients, (3,) both [1/m]."""
    nx, ny, _ = cells
    found, sums = [], np.zeros((2, 3))
    for first in range(0, int(np.prod(cells)), _SLICE):
        ask(poll)
        index = np.arange(first, min(first + _SLICE, int(np.prod(cells))))
        place = np.stack([index % nx, index // nx % ny, index // (nx * ny)], axis=1)
        parts = coefficients(low + (place + 0.5) / cells * size)
        found.append(_extinction(*parts).astype(np.float32))
        sums += [of.sum(axis=0) for of in parts]
    return np.concatenate(found), sums


def _between(values, at):
    """Values (nz, ny, nx) between the middles of voxels, trilinear, as host.scene.Density has them; at: (n, 3) in voxels."""
    most = np.array(values.shape[::-1]) - 1
    at = np.clip(at, 0, most)
    low = at.astype(int)
    rest, high = at - low, np.minimum(low + 1, most)
    found = np.zeros(len(at))
    for corner in np.ndindex(2, 2, 2):
        x, y, z = (np.where(corner, high, low)).T
        found += np.prod(np.where(corner, rest, 1 - rest), axis=1) * values[z, y, x]
    return found
