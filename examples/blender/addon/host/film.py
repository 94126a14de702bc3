# SPDX-License-Identifier: GPL-3.0-or-later
"""What the passes add up to, and the picture from it."""

from dataclasses import dataclass

import covbeam
import numpy as np
from covbeam import FILM_RAY, image

from . import ask
from .plan import spectra_at

#: Pixels along the side of a block over which radius and bandwidth are averaged.
_LAYERS = 8

#: Rows that are worked on at a time: much less than a tenth of a second.
_ROWS = 128

#: Rows around a part of a picture that its errors need.
_AROUND = 2


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
    #: Standard error of the luminance of all light: (h, w). 0 after a single pass.
    error: np.ndarray


class Film:
    """A covbeam.Film, and sums for radius and bandwidth."""

    def __init__(self, scene, view, typical_radiance):
        camera = scene.camera
        self._scene, self._view = scene, view
        self._film = covbeam.Film(camera.width, camera.height, typical_radiance, view.regions)
        self._nodes = self._film.nodes()
        blocks = -(-camera.height // _LAYERS), -(-camera.width // _LAYERS)
        # Of gather weight, weight x radius, weight x bandwidth.
        self._gather = np.zeros((*blocks, 3))
        self.passes = 0

    @property
    def memory(self):
        """Bytes of all sums."""
        return self._film.memory + self._gather.nbytes

    def close(self):
        self._film.close()

    def plan(self, number, error, photons, grids, poll):
        """Density of eye rays of the pass, for each pixel.

        - error: relative bias that a filter may cause in it; photons: its light paths; grids: a resolved Grid by volume.
        """
        spectra = spectra_at(self._nodes, self._view, self._scene, grids, poll)
        self._film.plan(number, error, photons, spectra, poll=poll)
        return self._film.densities()

    def add(self, first, beyond, seen, sums):
        """Adds the pass that is planned.

        - first, beyond: bool (pixels,), where eye rays asked for the fog before the first surface and for what lies beyond.
        - seen: radiance before and beyond the first surface: float64 (2, pixels, 3).
        - sums: before the first surface, of gather weight, weight x radius, weight x bandwidth: (pixels, 3).
        """
        at = np.flatnonzero(first | beyond)
        rays = np.zeros(len(at), FILM_RAY)
        pixels = self._view.pixels[at]
        rays["pixel"], rays["has_volume"], rays["has_rest"] = pixels, first[at], beyond[at]
        rays["volume"], rays["rest"] = seen[0][at], seen[1][at]
        self._film.add(rays)
        block = pixels[:, 1] // _LAYERS * np.uint32(self._gather.shape[1]) + pixels[:, 0] // _LAYERS
        for channel in range(3):
            layer = self._gather[..., channel]
            layer += np.bincount(block, sums[at, channel], layer.size).reshape(layer.shape)
        self.passes += 1

    def picture(self, gather, poll):
        """The Picture so far. `gather`: a covbeam_rays.Gather."""
        width, height = self._film.width, self._film.height
        self._film.verify(poll=poll)
        pixels = gather.picture(self._film, poll=poll)
        error = np.zeros(height * width, np.float32)
        layers = np.zeros((2, height, width), np.float32)
        for start in range(0, height, _ROWS):
            ask(poll)
            end = min(start + _ROWS, height)
            if self.passes > 1:
                low, high = max(start - _AROUND, 0), min(end + _AROUND, height)
                part = image.errors(width, high - low, pixels[low * width : high * width])
                error[start * width : end * width] = part[(start - low) * width : (end - low) * width]
            weight, radius, bandwidth = np.moveaxis(_enlarged(self._gather, height, width, slice(start, end)), 2, 0)
            lit = weight > 0
            for layer, values in zip(layers, (radius, bandwidth)):
                layer[start:end] = np.where(lit, values / np.where(lit, weight, 1), 0)
        pixels, error = pixels.reshape(height, width), error.reshape(height, width)
        return Picture(pixels["radiance"].copy(), pixels["volume"].copy(), *layers, error)


def _enlarged(blocks, height, width, rows):
    """Some rows of a picture from its blocks, bilinear between their middles."""
    for axis, places in ((0, np.arange(height)[rows]), (1, np.arange(width))):
        position = np.clip((places + 0.5) / _LAYERS - 0.5, 0, blocks.shape[axis] - 1)
        low = position.astype(np.int64)
        high = np.minimum(low + 1, blocks.shape[axis] - 1)
        share = (position - low).reshape([-1 if i == axis else 1 for i in range(3)])
        blocks = blocks.take(low, axis) * (1 - share) + blocks.take(high, axis) * share
    return blocks
