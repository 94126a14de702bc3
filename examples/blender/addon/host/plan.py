# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a pass needs eye rays: the spectrum of the picture, read off the grid, from which covbeam.Film plans."""

import numpy as np
from covbeam import EYE_RAY, IMAGE_SPECTRUM, PIXEL_STEP, image

from . import ask
from .sampler import mix
from .vectors import dot

#: Pixels that are worked on at a time: about a tenth of a second.
_SLICE = 32768

#: Share of the passes in which pixels with nothing to see look beyond the fog: for what is smaller than a pixel.
_BLACK_DENSITY = np.float32(1 / 16)

#: Keep the choices of pixels for both apart.
_VOLUME_PURPOSE, _SURFACE_PURPOSE = 0xF0900000, 0x5AFACE00


class View:
    """The first piece of fog and the first surface behind the middle of each pixel."""

    def __init__(self, scene, eyes, poll):
        self._scene = scene
        camera = scene.camera
        width, height = camera.width, camera.height
        y, x = np.mgrid[0:height, 0:width]
        x, y = x.reshape(-1), y.reshape(-1)
        self.pixels = np.stack([x, y], axis=1).astype(np.uint32)
        #: Places of the pixels along a Z-shaped curve: rays that follow each other lie close together however few there are.
        self.curve = _spread(x) | _spread(y) << np.uint64(1)
        found = []
        for i in range(0, len(x), _SLICE):
            directions = camera.directions(x[i : i + _SLICE] + 0.5, y[i : i + _SLICE] + 0.5)
            found.append((directions, *eyes.first_surfaces(directions, poll)))
        self.directions, self.stretch, self.volume, depth, self.shows = (np.concatenate(a) for a in zip(*found))
        ask(poll)
        along = self.directions @ np.asarray(camera.forward, np.float32)
        #: Equal where the fog's light is continuous; 0 at borders.
        self.regions = image.regions(width, height, (depth * along).astype(np.float32))
        ask(poll)
        # Where fog starts at a bound, that has a silhouette too.
        starts = self.stretch[:, 0] * along
        if np.ptp(self.volume) > 0 or np.ptp(starts) > 1e-4 * starts.max():
            fog = image.regions(width, height, np.where(starts > 0, starts, np.float32(1)).astype(np.float32))
            ask(poll)
            # Only which are equal matters.
            labels = mix(mix(self.regions.astype(np.uint64) << np.uint64(32) | fog) ^ self.volume.astype(np.uint64))
            labels = (labels >> np.uint64(32)).astype(np.uint32) | np.uint32(1)
            ask(poll)
            self.regions = np.where((self.regions == 0) | (fog == 0), np.uint32(0), labels)

    def steps(self, at):
        """PIXEL_STEP (n, 2) of the pieces of fog of some pixels."""
        camera = self._scene.camera
        direction = self.directions[at]
        cosine = direction @ np.asarray(camera.forward, np.float32)
        steps = np.zeros((len(at), 2), PIXEL_STEP)
        for i, (axis, tangent) in enumerate(((camera.right, camera.step[0]), (-camera.up, camera.step[1]))):
            moved = np.float32(tangent) * cosine[:, None] * np.asarray(axis, np.float32)
            moved = moved - dot(moved, direction)[:, None] * direction
            steps["direction"][:, i] = moved
            steps["origin"][:, i] = self.stretch[at, :1] * moved
        return steps

    def rays(self, at):
        """EYE_RAY of the pieces of fog of some pixels."""
        rays = np.zeros(len(at), EYE_RAY)
        start = self.stretch[at, 0]
        rays["direction"] = self.directions[at]
        rays["origin"] = np.asarray(self._scene.camera.position, np.float32) + start[:, None] * rays["direction"]
        rays["length"] = self.stretch[at, 1] - start
        return rays


def spectra_at(pixels, view, scene, grids, poll):
    """IMAGE_SPECTRUM of some pixels: (n, 2) of x and y.

    - grids: a resolved Grid by volume.
    """
    nodes = pixels[:, 1].astype(np.int64) * scene.camera.width + pixels[:, 0]
    spectra = np.zeros(len(nodes), IMAGE_SPECTRUM)
    for number, grid in grids.items():
        of = np.flatnonzero(view.volume[nodes] == number)
        # Slices of about a tenth of a second.
        for piece in np.array_split(of, max(1, len(of) // 2048)):
            ask(poll)
            at = nodes[piece]
            if len(at):
                spectra[piece] = image.along(grid, scene.volumes[number].medium, view.rays(at), view.steps(at))
    return spectra


def wanted(density, view, pass_, seed):
    """What the pass asks each pixel for: (the fog before the first surface, what is beyond), bool. Others in each pass."""
    shift = mix(seed ^ _VOLUME_PURPOSE) & 0xFFFFFFFF
    first = image.thresholds(pass_, shift, view.pixels) < density
    shift = mix(seed ^ _SURFACE_PURPOSE) & 0xFFFFFFFF
    beyond = image.thresholds(pass_, shift, view.pixels) < np.where(view.shows, np.float32(1), _BLACK_DENSITY)
    return first, beyond


def _spread(x):
    """Bits of 16-bit numbers, moved to the even places."""
    x = x.astype(np.uint64)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        x = (x | x << np.uint64(shift)) & np.uint64(mask)
    return x
