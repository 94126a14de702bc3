# SPDX-License-Identifier: GPL-3.0-or-later
"""What varies in a volume -> voxels: as many as it takes."""

from dataclasses import dataclass

import covbeam
import numpy as np

from ..host import ask

#: Voxels along the longest side, from the first trial to the last; and the mean error over the mean density that ends the trials.
_SIDES, _WANTED = (24, 48, 96), 0.01

#: Places where the error is measured; and places that are looked at together.
_TRIALS, _SLICE = 4096, 65536


@dataclass(frozen=True)
class Baked:
    """A medium's coefficients where its density is 1, float64 (3,) [1/m], and its density; None if there is nothing."""

    scattering: np.ndarray
    absorption: np.ndarray
    density: covbeam.Density | None
    #: Voxels along x, y, z.
    cells: tuple[int, int, int]
    #: Mean error of the density between the voxels' middles, over its mean.
    error: float
    #: How much of the light that is scattered or absorbed is of a colour that the mean's is not, as a share.
    coloured: float


def bake(coefficients, low, high, poll):
    """Voxels between the corners `low` and `high` [m] for what `coefficients` says: a function of places, float64 (n, 3), that returns
    scattering and absorption coefficients there, (n, 3) both [1/m], in the same order.

    - poll: as for export.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    # What is flat is as thick as a voxel.
    size = np.maximum(high - low, 1e-3 * float((high - low).max()))
    trials = low + np.random.default_rng(0).random((_TRIALS, 3)) * size
    expected = _extinction(*coefficients(trials))
    for side in _SIDES:
        cells = np.maximum(1, np.ceil(size / (float(size.max()) / side) - 1e-6)).astype(int)
        scattering, absorption = _at_middles(coefficients, low, size, cells, poll)
        values = _extinction(scattering, absorption)
        found = _between(values.reshape(cells[::-1]), (trials - low) / size * cells - 0.5)
        mean = float(expected.mean())
        error = float(np.abs(found - expected).mean()) / mean if mean > 0 else 0.0
        if error <= _WANTED:
            break
    largest, total = float(values.max()), float(values.sum())
    if not largest > 0:
        return Baked(np.zeros(3), np.zeros(3), None, tuple(cells.tolist()), 0.0, 0.0)
    relative = values / largest
    parts = [of.sum(axis=0) / relative.sum() for of in (scattering, absorption)]
    other = sum(np.abs(of - relative[:, None] * part).sum() for of, part in zip((scattering, absorption), parts))
    layout = covbeam.GridLayout(tuple(low.tolist()), tuple((low + size).tolist()), tuple(cells.tolist()))
    density = covbeam.Density(layout, relative.astype(np.float32))
    return Baked(*parts, density, layout.cells, error, float(other) / (3 * total))


def _extinction(scattering, absorption):
    """Mean of the channels: (n,)."""
    return (scattering + absorption).mean(axis=1)


def _at_middles(coefficients, low, size, cells, poll):
    """Scattering and absorption coefficients at the middles of voxels, x first: (n, 3) both."""
    nx, ny, _ = cells
    found = []
    for first in range(0, int(np.prod(cells)), _SLICE):
        ask(poll)
        index = np.arange(first, min(first + _SLICE, int(np.prod(cells))))
        place = np.stack([index % nx, index // nx % ny, index // (nx * ny)], axis=1)
        found.append(coefficients(low + (place + 0.5) / cells * size))
    return tuple(np.concatenate(parts) for parts in zip(*found))


def _between(values, at):
    """Values (nz, ny, nx) between the middles of voxels, trilinear, as covbeam.Density has them; at: (n, 3) in voxels."""
    most = np.array(values.shape[::-1]) - 1
    at = np.clip(at, 0, most)
    low = at.astype(int)
    rest, high = at - low, np.minimum(low + 1, most)
    found = np.zeros(len(at))
    for corner in np.ndindex(2, 2, 2):
        x, y, z = (np.where(corner, high, low)).T
        found += np.prod(np.where(corner, rest, 1 - rest), axis=1) * values[z, y, x]
    return found
