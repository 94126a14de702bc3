# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums over passes, and the picture from them."""

from dataclasses import dataclass

import numpy as np
from covbeam import FILM_SAMPLE, Reconstruction

from . import ask

#: Pixels from one to the next in which radius and bandwidth are found.
_LAYERS = 4

#: Pixels from one to the next of a coarse picture.
_COARSE = 8

#: Pixels, and rows of them, that are worked on at a time: much less than a tenth of a second.
_SLICE, _ROWS = 1 << 18, 128


@dataclass(frozen=True)
class Picture:
    """A picture, rows from the top, linear Rec. 709 in Blender's unit of radiance [W/(m^2 sr)]; float32."""

    #: All light that fog scatters to the camera, through glass and mirrors too: (h, w, 3).
    in_scattered: np.ndarray
    #: The part of it that is scattered before the first surface: (h, w, 3).
    first: np.ndarray
    #: Of that part: mean kernel radius [m] and mean bandwidth of the fluence across the kernel [cycles/m], weighted by light:
    #: (h, w), 0 where nothing was gathered.
    radius: np.ndarray
    bandwidth: np.ndarray


class Film:
    """Adds up passes in double precision, in their order."""

    def __init__(self, width, height):
        self._size = width, height
        pixels = width * height
        self._volume, self._surfaces = np.zeros((pixels, 4)), np.zeros((pixels, 4))
        self._density, self._gather = np.zeros(pixels), np.zeros((pixels, 3))
        self.passes = 0

    @property
    def memory(self):
        """Bytes of all sums."""
        return sum(a.nbytes for a in (self._volume, self._surfaces, self._density, self._gather))

    def add(self, first, beyond, density, seen, sums):
        """Adds a pass.

        - first, beyond: bool (pixels,), where eye rays asked for the fog before the first surface and for what lies beyond.
        - density: of the former.
        - seen: radiance before and beyond the first surface: float64 (2, pixels, 3).
        - sums: before the first surface, of gather weight, weight x radius, weight x bandwidth: (pixels, 3).
        """
        self._volume[:, :3] += seen[0]
        self._volume[:, 3] += first
        # In most pictures few pixels see beyond.
        at = np.flatnonzero(beyond)
        self._surfaces[at, :3] += seen[1][at]
        self._surfaces[at, 3] += 1
        self._density += density
        self._gather += sums
        self.passes += 1

    def picture(self, gather, view, filters, poll, coarse=False):
        """The Picture so far, filtered with the filters of the latest pass. `gather`: a covbeam_rays.Gather.

        `coarse`: all that is filtered at every _COARSE-th pixel across and down, and straight lines between them.
        """
        width, height = self._size
        step = _COARSE if coarse else 1
        nodes = np.arange(width * height).reshape(height, width)[::step, ::step]
        # A pixel's sums over the passes' mean density, not each ray over its own: one from an early pass, when the grid knew
        # little and wanted few, must not outweigh all later ones (the balance heuristic).
        volume = self._filtered(gather, view, self._volume, nodes.ravel(), filters, poll).reshape(*nodes.shape, 3)
        volume = _enlarged(volume, step, height, width, slice(None)) if coarse else volume
        ask(poll)
        # What is beyond has no filter.
        rays = self._surfaces[:, 3:]
        surfaces = (self._surfaces[:, :3] / np.maximum(rays, 1)).astype(np.float32).reshape(height, width, 3)
        ask(poll)
        # Radius and bandwidth vary slowly: every fourth pixel is enough.
        step = _COARSE if coarse else _LAYERS
        nodes = np.arange(width * height).reshape(height, width)[::step, ::step]
        sums = np.concatenate([self._gather, self._volume[:, 3:]], axis=1)
        layer_sums = self._filtered(gather, view, sums, nodes.ravel(), filters, poll).reshape(*nodes.shape, 3)
        layers = np.zeros((2, height, width), np.float32)
        for start in range(0, height, _ROWS):
            ask(poll)
            rows = slice(start, start + _ROWS)
            weight, radius, bandwidth = np.moveaxis(_enlarged(layer_sums, step, height, width, rows), 2, 0)
            lit = weight > 0
            for layer, values in zip(layers, (radius, bandwidth)):
                layer[rows] = np.where(lit, values / np.where(lit, weight, 1), 0)
        return Picture(volume + surfaces, volume, *layers)

    def _filtered(self, gather, view, sums, at, filters, poll):
        """Sums, (pixels, 4) with the number of rays last, of some pixels through their filters: float32 (n, 3)."""
        samples = np.zeros(len(sums), FILM_SAMPLE)
        for start in range(0, len(sums), _SLICE):
            ask(poll)
            here = slice(start, start + _SLICE)
            share = (1 / np.maximum(self._density[here], 1e-30))[:, None]
            samples["radiance"][here] = sums[here, :3] * share
            samples["weight"][here] = sums[here, 3] * share[:, 0]
        with Reconstruction(*self._size) as reconstruction:
            reconstruction.update(samples, view.regions)
            return gather.reconstruct(reconstruction, view.pixels[at], filters[at], poll=poll)


def _enlarged(nodes, step, height, width, rows):
    """Some rows of a picture from every step-th pixel across and down, bilinear between them."""
    for axis, places in ((0, np.arange(height)[rows]), (1, np.arange(width))):
        position = np.minimum(places / step, nodes.shape[axis] - 1)
        low = position.astype(np.int64)
        high = np.minimum(low + 1, nodes.shape[axis] - 1)
        share = (position - low).astype(np.float32).reshape([-1 if i == axis else 1 for i in range(3)])
        nodes = nodes.take(low, axis) * (1 - share) + nodes.take(high, axis) * share
    return nodes
