# SPDX-License-Identifier: GPL-3.0-or-later
"""How photons leave suns and the sky, which are infinitely far away."""

import numpy as np
from covbeam import light_field

from .cells import Cells, sky_cells
from .emitting import CURVATURE, Emitting, Starts, disk, f32
from .vectors import basis

#: Share of the photons that are aimed at the fog; the others are spread over all that the scene has.
_AIMED = 0.75


class Far(Emitting):
    """Light from infinitely far away. Photons start on disks across it, one as wide as the fog and one as wide as the scene, ahead of
    both."""

    def __init__(self, fog, scene):
        self._balls = [fog, scene]
        self._areas = [np.pi * ball.radius**2 for ball in self._balls]
        self._start = fog.radius + scene.radius + float(np.linalg.norm(fog.center - scene.center))

    def _density_at_best(self):
        return _AIMED / self._areas[0] + (1 - _AIMED) / self._areas[1]

    def _starts(self, direction, numbers):
        """Where photons of some directions, float64 (n, 3), start; and the density of that across them [1/m^2]: (n,)."""
        # The choice of the disk takes its share of a number, which is then uniform again.
        aimed = numbers[:, 0] < _AIMED
        u = np.where(aimed, numbers[:, 0] / _AIMED, (numbers[:, 0] - _AIMED) / (1 - _AIMED))
        place = disk(np.clip(u, 0, 1), numbers[:, 1]).astype(np.float64)
        e, f = basis(direction)
        radius = np.where(aimed, self._balls[0].radius, self._balls[1].radius)[:, None]
        center = np.where(aimed[:, None], self._balls[0].center, self._balls[1].center)
        origin = center + radius * (place[:, :1] * e + place[:, 1:] * f) - self._start * direction
        # The density of both disks together at this photon's line. In double precision, directions too: the scene may
        # be 1e6 times as large as the fog.
        density = np.zeros(len(direction))
        for ball, area, share in zip(self._balls, self._areas, (_AIMED, 1 - _AIMED)):
            to = origin - ball.center
            across = to - np.einsum("ij,ij->i", to, direction)[:, None] * direction
            density += np.where(np.einsum("ij,ij->i", across, across) <= ball.radius**2 * (1 + 1e-6), share / area, 0)
        return origin, density


class Sun(Far):
    def __init__(self, light, fog, scene):
        super().__init__(fog, scene)
        self._light = light
        self.flux = light.irradiance / self._density_at_best()

    def _directions(self, u, v):
        # Evenly over the cap; its height is 2 sin^2(angle/2), of which single precision would leave little.
        fall = u * 2 * np.sin(0.5 * self._light.angle) ** 2
        sine, phi = np.sqrt(fall * (2 - fall)), 2 * np.pi * v
        axis = np.asarray(self._light.axis, np.float64)[None]
        axis = axis / np.linalg.norm(axis)
        e, f = basis(axis)
        direction = (sine * np.cos(phi))[:, None] * e + (sine * np.sin(phi))[:, None] * f + (1 - fall)[:, None] * axis
        return direction / np.linalg.norm(direction, axis=1, keepdims=True)

    def emit(self, numbers):
        light = self._light
        direction = self._directions(numbers[:, 0].astype(np.float64), numbers[:, 1].astype(np.float64))
        origin, density = self._starts(direction, numbers[:, 2:4])
        # The directions lie aslant to the axis, across which the irradiance is: (1 + cos)/2 on average.
        aslant = 2 / (1 + np.cos(light.angle))
        power = aslant * light.irradiance / density[:, None]
        return Starts(f32(origin), f32(direction), f32(power), np.zeros((len(numbers), 3), np.float32))

    def fields(self, direction, normal):
        # Uniform in space; its directions fill a disk, whose spectrum is that of a uniform disk of this radius.
        angle = max(self._light.angle, 1e-6)
        variance = np.float32(1 / (np.pi * angle) ** 2)
        return light_field.gaussian(direction, basis(direction)[0], (0.0, 0.0), (variance, variance))


class World(Far):
    """A picture of the sky; its cells are drawn by the power that comes from them."""

    def __init__(self, light, fog, scene):
        super().__init__(fog, scene)
        sky = light.sky.astype(np.float64)
        self._shape, self._turn = sky.shape[:2], light.turn
        self._cells = Cells(sky)
        angles = self._cells.angles
        self._variance = _sky_variance(sky.max(axis=2), angles).reshape(-1)
        self.flux = np.einsum("ijk,i->k", sky, angles) / self._density_at_best()

    def emit(self, numbers):
        cosine, turn, radiance = self._cells.draw(numbers[:, 0], numbers[:, 1])
        sine, azimuth = np.sqrt(np.maximum(1 - cosine * cosine, 0)), np.pi * (1 - 2 * turn)
        from_ = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=1) @ self._turn
        direction = -from_ / np.linalg.norm(from_, axis=1, keepdims=True)
        origin, density = self._starts(direction, numbers[:, 2:4])
        power = radiance / density[:, None]
        return Starts(f32(origin), f32(direction), f32(power), np.zeros((len(numbers), 3), np.float32))

    def fields(self, direction, normal):
        variance = self._variance[self._cell_of(direction)].astype(np.float32)
        return light_field.gaussian(direction, basis(direction)[0], (0.0, 0.0), np.stack([variance, variance], axis=1))

    def _cell_of(self, direction):
        rows, columns = self._shape
        row, column = sky_cells(-direction.astype(np.float64) @ self._turn.T, rows, columns)
        return row * columns + column


def _sky_variance(sky, angles):
    """Angular variance of the spectrum of light from each cell of a sky, (h, w) [cycles^2/rad^2].

    Of light as bright as a cell's all power of the sky fills a disk, and has that disk's spectrum: a sun's cells are a small bright one.
    Where the sky changes from cell to cell, its relative gradient speaks.

    - sky: brightness, (h, w); angles: solid angle of the cells of each row [sr], (h,).
    """
    rows, columns = sky.shape
    power = float(angles @ sky.sum(axis=1))
    radius = np.sqrt(np.minimum(power / np.maximum(sky, 1e-300) / np.pi, 2 * np.pi))
    steps = []
    if columns > 1:
        around = np.stack([np.roll(sky, 1, axis=1), sky, np.roll(sky, -1, axis=1)])
        sine = np.maximum(np.sin((np.arange(rows) + 0.5) * (np.pi / rows)), 0.5 / rows)
        steps.append(_steepest(around) / (sine * (2 * np.pi / columns))[:, None])
    if rows > 1:
        padded = np.pad(sky, ((1, 1), (0, 0)), mode="edge")
        steps.append(_steepest(np.stack([padded[:-2], sky, padded[2:]])) / (np.pi / rows))
    gradient = np.max(steps, axis=0) if steps else 0.0
    return np.maximum(1 / (np.pi * radius) ** 2, gradient**2 * CURVATURE)


def _steepest(around):
    """The larger of two differences of neighbours in a row of three, over their mean: (3, h, w) -> (h, w)."""
    mean = np.maximum(around.mean(axis=0), 1e-300)
    return np.max(np.abs(np.diff(around, axis=0)), axis=0) / mean
