# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a pass needs eye rays, and how widely their light is filtered: the spectrum of the picture, read off the grid."""

import numpy as np
from covbeam import EYE_RAY, IMAGE_FILTER, IMAGE_SPECTRUM, PIXEL_STEP, image

from . import ask
from .sampler import mix
from .vectors import dot

#: The spectrum is found for every sixth pixel across and down, and interpolated between them: voxels are larger.
_SPACING = 6

#: Pixels that are worked on at a time: about a tenth of a second.
_SLICE = 32768

#: Largest standard deviation of a filter, as a share of the side of a square as large as the picture.
_WIDEST = 1 / 16

#: Smallest share of the pixels that get an eye ray: light may be smooth, but a ray sees few beams and is noisy.
_LEAST_DENSITY = np.float32(0.05)

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


class Plan:
    """Filters and densities of eye rays of one pass.

    - grids: a resolved Grid by volume; error: relative bias that a filter may cause in this pass.
    """

    def __init__(self, view, scene, grids, error, poll):
        camera = scene.camera
        width, height = camera.width, camera.height
        columns = np.minimum(np.arange(-(-width // _SPACING)) * _SPACING + _SPACING // 2, width - 1)
        rows = np.minimum(np.arange(-(-height // _SPACING)) * _SPACING + _SPACING // 2, height - 1)
        nodes = (rows[:, None] * width + columns).reshape(-1)
        spectra = np.zeros(len(nodes), IMAGE_SPECTRUM)
        for number, grid in grids.items():
            of = np.flatnonzero(view.volume[nodes] == number)
            # Slices of about a tenth of a second.
            for piece in np.array_split(of, max(1, len(of) // 2048)):
                ask(poll)
                at = nodes[piece]
                if len(at):
                    spectra[piece] = image.along(grid, scene.volumes[number].medium, view.rays(at), view.steps(at))
        self.filters = np.zeros(width * height, IMAGE_FILTER)
        widest = _WIDEST * np.sqrt(width * height)
        slab = max(_SLICE // width, 1)
        for row in range(0, height, slab):
            ask(poll)
            pixels = np.arange(row * width, min(row + slab, height) * width)
            here = _interpolated(spectra, view.regions, nodes, columns, rows, pixels, width, height)
            known = here["weight"] > 0
            if known.any():
                self.filters[pixels[known]] = image.filters(here[known], error, widest)
        self.density = np.maximum(image.densities(self.filters), _LEAST_DENSITY)

    def wanted(self, view, pass_, seed):
        """What the pass asks each pixel for: (the fog before the first surface, what is beyond), bool. Others in each pass."""
        shift = mix(seed ^ _VOLUME_PURPOSE) & 0xFFFFFFFF
        first = image.thresholds(pass_, shift, view.pixels) < self.density
        shift = mix(seed ^ _SURFACE_PURPOSE) & 0xFFFFFFFF
        beyond = image.thresholds(pass_, shift, view.pixels) < np.where(view.shows, np.float32(1), _BLACK_DENSITY)
        return first, beyond


def _interpolated(spectra, regions, nodes, columns, rows, pixels, width, height):
    """The spectra of some pixels, bilinear between those nodes that lie in the same region, weighted by light."""
    (x0, fx), (y0, fy) = _between(width, len(columns)), _between(height, len(rows))
    x, y = pixels % width, pixels // width
    x0, fx, y0, fy = x0[x], fx[x], y0[y], fy[y]
    out = np.zeros(len(pixels), IMAGE_SPECTRUM)
    node_regions, own = regions[nodes], regions[pixels]
    for i, wx in ((0, 1 - fx), (1, fx)):
        for j, wy in ((0, 1 - fy), (1, fy)):
            column, row = np.minimum(x0 + i, len(columns) - 1), np.minimum(y0 + j, len(rows) - 1)
            node = row * len(columns) + column
            fits = (node_regions[node] == own) & (own != 0)
            weight = np.where(fits, wx * wy * spectra["weight"][node], np.float32(0))
            out["weight"] += weight
            for name in ("xx", "xy", "yy"):
                out[name] += weight * spectra[name][node]
    lit = out["weight"] > 0
    for name in ("xx", "xy", "yy"):
        out[name] = np.where(lit, out[name] / np.where(lit, out["weight"], 1), 0)
    return out


def _between(count, nodes):
    """For each pixel of a row or column: the node before it, and how far it is on the way to the next one."""
    position = np.clip((np.arange(count) - _SPACING // 2) / _SPACING, 0, nodes - 1)
    low = np.minimum(position.astype(np.int64), max(nodes - 2, 0))
    return low, (position - low).astype(np.float32)


def _spread(x):
    """Bits of 16-bit numbers, moved to the even places."""
    x = x.astype(np.uint64)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        x = (x | x << np.uint64(shift)) & np.uint64(mask)
    return x
