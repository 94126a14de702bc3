# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a pass needs eye rays: the spectrum of the picture, read off the grid, from which covbeam.Film plans."""

import numpy as np
from covbeam import EYE_RAY, IMAGE_SPECTRUM, PIXEL_STEP, image

from . import ask
from .columns import Columns
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
        self._scene, self._columns = scene, Columns(scene)
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
        #: Where the lens blurs what is beside a border: a pixel may see fog where its middle does not, bool (n,).
        self.blurred = self._blurred(depth * along, poll)
        self.regions = np.where(self.blurred, np.uint32(0), self.regions)

    def _blurred(self, depth, poll):
        """Which pixels are no farther from a border than the lens blurs what is beside it: bool (n,).

        - depth: of first surfaces, along the camera's axis: (n,).
        """
        camera = self._scene.camera
        shape = (camera.height, camera.width)
        start = np.where(self.stretch[:, 0] > 0, self.stretch[:, 0], np.inf)
        nearest = np.minimum(depth, start)
        # Behind the sharp distance blur ends at that of infinity.
        blur = np.minimum(camera.blur(nearest), max(shape)).reshape(shape)
        if not blur.any():
            return np.zeros(len(self.regions), bool)
        reach = np.where(self.regions.reshape(shape) == 0, blur + 1, 0)
        # Beside a border is the nearer thing that makes it.
        for _ in range(2):
            reach = np.where(reach > 0, _largest_around(np.where(reach > 0, blur + 1, blur)), reach)
        for _ in range(int(np.ceil(reach.max()))):
            ask(poll)
            reach = np.maximum(reach, _largest_around(reach) - 1)
        return reach.reshape(-1) > 0

    def _fog_seen(self, at):
        """Share of the light on the way through the first fog of some pixels that this takes: as many."""
        extinction = self._scene.extinctions.mean(axis=1)[self.volume[at]]
        rays = self.rays(at)
        column = self._columns.at(self.volume[at], rays["origin"], rays["direction"], rays["length"])
        depth = np.where(extinction > 0, extinction * column, 0)
        return -np.expm1(-depth)

    def bend(self, at):
        """Covariance of the spectrum of even light in the fog, which is as bright as there is fog to be seen, around some pixels:
        xx, xy and yy [cycles^2/pixel^2], float32 (n, 3), 0 beside other regions.

        That of f is -f''/f / (4 pi^2) if it is positive; where f bends the other way filters err as much.
        """
        width, height = self._scene.camera.width, self._scene.camera.height
        y, x = np.divmod(at, width)
        inside = (x > 0) & (x < width - 1) & (y > 0) & (y < height - 1)
        at, bend = at[inside], np.zeros((len(at), 3), np.float32)
        steps = {(i, j): at + i * width + j for i in (-1, 0, 1) for j in (-1, 0, 1)}
        seen = {step: self._fog_seen(pixels) for step, pixels in steps.items()}
        here, region = seen[0, 0], self.regions[at]
        xx = seen[0, 1] - 2 * here + seen[0, -1]
        yy = seen[1, 0] - 2 * here + seen[-1, 0]
        xy = 0.25 * (seen[1, 1] - seen[1, -1] - seen[-1, 1] + seen[-1, -1])
        # |H|: with the eigenvalues m +- r, H or -H where they have the same sign, else what turns one around.
        mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
        size = np.hypot(half, xy)
        same = np.abs(mean) >= size
        even = np.where(same, np.abs(mean), size)
        along = np.where(same, np.sign(mean), mean / np.maximum(size, 1e-30))
        borders = [self.regions[pixels] != region for pixels in steps.values()]
        known = (here > 0) & (region != 0) & ~np.any(borders, axis=0)
        scale = np.where(known, 1 / (4 * np.pi**2 * np.maximum(here, 1e-30)), 0)
        bend[inside] = np.stack([even + along * half, along * xy, even - along * half], axis=-1) * scale[:, None]
        return bend

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


def _largest_around(values):
    """The largest of each value of an image (h, w) and its four neighbours."""
    padded = np.pad(values, 1, mode="edge")
    return np.max([values, padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]], axis=0)


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
                for name, bend in zip(("xx", "xy", "yy"), view.bend(at).T):
                    spectra[name][piece] += np.where(spectra["weight"][piece] > 0, bend, 0)
    return spectra


def wanted(density, view, pass_, seed):
    """What the pass asks each pixel for: (the fog before the first surface, what is beyond), bool. Others in each pass."""
    shift = mix(seed ^ _VOLUME_PURPOSE) & 0xFFFFFFFF
    first = image.thresholds(pass_, shift, view.pixels) < np.where(view.blurred, np.float32(1), density)
    shift = mix(seed ^ _SURFACE_PURPOSE) & 0xFFFFFFFF
    shows = view.shows | view.blurred
    beyond = image.thresholds(pass_, shift, view.pixels) < np.where(shows, np.float32(1), _BLACK_DENSITY)
    return first, beyond


def _spread(x):
    """Bits of 16-bit numbers, moved to the even places."""
    x = x.astype(np.uint64)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        x = (x | x << np.uint64(shift)) & np.uint64(mask)
    return x
