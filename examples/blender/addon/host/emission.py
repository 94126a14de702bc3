# SPDX-License-Identifier: GPL-3.0-or-later
"""How photons leave lights, and the light field that they have there."""

from dataclasses import dataclass

import numpy as np
from covbeam import LIGHT_FIELD, light_field

from .emitting import CURVATURE, Ball, Emitting, Starts, disk, f32
from .far_lights import Sun, World
from .interior import clearance, cleared
from .pattern import PatternedDirections
from .scene import LightKind
from .vectors import around, basis, dot, normalized

#: Lights on surfaces shine from this far above them, in sizes of the light; and by twice what rounding is worth there.
_LIFT = 1e-5


@dataclass
class Emitted:
    """Photons that leave lights. power [W] is divided by the probability of being drawn, not by how many they are."""

    origin: np.ndarray
    direction: np.ndarray
    power: np.ndarray
    #: Of the emitting surface; 0 for a light without one.
    normal: np.ndarray
    #: How far along their way their light begins, and ends [m]; what they meet before is not lit.
    dark: np.ndarray
    until: np.ndarray
    #: Index of the light.
    light: np.ndarray
    #: LIGHT_FIELD, or None if not asked for.
    field: np.ndarray | None


class Emitter:
    """All lights of a scene, drawn in proportion to their flux, and the insides of balls by how much fog they have.

    - fog: where light is wanted; scene: all that light can meet. Suns shine on both.
    """

    def __init__(self, lights, fog: Ball, scene: Ball):
        made = [(_EMITTERS[light.kind](light, fog, scene), index) for index, light in enumerate(lights)]
        made += [(_Within(light, fog, scene), index) for index, light in enumerate(lights) if _is_filled(light)]
        self._emitters = [emitter for emitter, _ in made]
        self._lights = np.array([index for _, index in made], np.int32)
        wanted = np.array([float(np.sum(e.flux)) * e.worth for e in self._emitters], np.float64)
        self._bounds = np.cumsum(wanted) / max(wanted.sum(), 1e-300)
        self.is_dark = not wanted.sum() > 0
        #: Of the brightest channel, of all lights [W].
        self.flux = float(np.sum([np.max(e.flux) for e in self._emitters]))

    def emit(self, sampler, count, with_fields):
        """Draws the starts of `count` paths."""
        u = sampler.uniform() if len(self._emitters) > 1 else np.zeros(count, np.float32)
        chosen = np.minimum(np.searchsorted(self._bounds, u, side="right"), len(self._bounds) - 1)
        shares = np.diff(self._bounds, prepend=0.0)
        numbers = np.stack([sampler.uniform() for _ in range(4)], axis=1)
        out = Emitted(
            *(np.zeros((count, 3), np.float32) for _ in range(4)),
            *(np.zeros(count, np.float32) for _ in range(2)),
            light=self._lights[chosen],
            field=np.zeros(count, LIGHT_FIELD) if with_fields else None,
        )
        for index, emitter in enumerate(self._emitters):
            here = np.flatnonzero(chosen == index)
            if len(here) == 0:
                continue
            start = emitter.emit(numbers[here])
            out.origin[here], out.direction[here], out.normal[here] = start.origin, start.direction, start.normal
            out.dark[here], out.until[here] = start.dark, start.until
            out.power[here] = start.power / np.float32(shares[index])
            if with_fields:
                out.field[here] = emitter.fields(start.direction, start.normal)
        return out


def _lifted(origin, size, normal):
    """Places on a light of some size, moved off it: float64 (n, 3)."""
    return origin + (_LIFT * size + 2 * clearance(origin))[:, None] * normal


def _across(direction, u, v):
    """Points of the unit disks across directions: (n, 3), and their squared distances from the centre: (n,)."""
    place = disk(u, v)
    e, f = basis(direction)
    return place[:, :1] * e + place[:, 1:] * f, np.minimum(np.sum(place * place, axis=1), np.float32(1 - 2.0**-24))


class _Point(Emitting):
    """A ball, or a point. In each direction a ball shines as a disk across it, evenly: the cosine foreshortens it.

    So it sends the same radiance L along all lines that meet it. Lamps differ in where along such a line, at b < R from the
    ball's centre, the light begins, at a distance s past the middle of its chord (Cycles' lamps shine so on fog and surfaces alike;
    to its noise of 0.1 % the closed forms below are what it renders):

    - A ball: s = sqrt(R^2 - b^2), its surface. Fluence 2 pi L (1 - sqrt(1 - R^2/d^2)) at d > R. The inside is _Within's.
    - A soft one (Blender's Soft Falloff): all points see a disk of radius R around the centre that faces them. A line at s is seen
      from the distance d at an angle of tangent b/s to the centre, which is less than R/d where s > b^2/sqrt(R^2 - b^2): there the
      light begins, for some lines inside of the ball and for others far outside. Fluence 2 pi L (1 - d/sqrt(d^2 + R^2)).
      Fog dims it from the plane through the centre on, across the line; Cycles' disks face each point, b^2/s farther away.
    """

    #: Solid angle that _directions fill [sr].
    _angle = 4 * np.pi

    def __init__(self, light, fog, scene):
        self._light, self._patterned = light, None
        self.flux = self._angle * light.intensity
        if light.pattern is not None:
            self._patterned = PatternedDirections(light.pattern, self._falloff)
            self.flux = self._patterned.total * light.intensity

    def _falloff(self, cosine):
        """Factor on the intensity by the cosine from the axis."""
        return np.ones_like(cosine)

    def _directions(self, u, v):
        axis = np.broadcast_to(f32((0, 0, 1)), (len(u), 3))
        return around(axis, 1 - 2 * u, v), np.ones_like(u)

    def _powers(self, numbers):
        """Directions, and the power of photons along them: float32 (n, 3) both."""
        if self._patterned is not None:
            direction, weight = self._patterned.draw(numbers[:, 0], numbers[:, 1])
            return direction, f32(weight * self._light.intensity)
        direction, weight = self._directions(numbers[:, 0], numbers[:, 1])
        return direction, weight[:, None] * f32(self._angle * self._light.intensity)

    def emit(self, numbers):
        light = self._light
        (direction, power), center = self._powers(numbers), f32(cleared(light.position))
        nowhere, radius = np.zeros_like(direction), f32(light.radius)
        if light.radius == 0:
            return Starts(np.broadcast_to(center, direction.shape), direction, power, nowhere)
        across, distance2 = _across(direction, numbers[:, 2], numbers[:, 3])
        height = np.sqrt(1 - distance2)
        if light.soft:
            return Starts(center + radius * across, direction, power, nowhere, dark=radius * distance2 / height)
        normal = across + height[:, None] * direction
        return Starts(center + radius * normal, direction, power, normal)

    def fields(self, direction, normal):
        return self._widened(direction, light_field.EVEN_LAMP)

    def _widened(self, direction, variances):
        """A ball looks the same from all sides: a disk across the ray."""
        if self._patterned is not None:
            variances = np.maximum(self._patterned.variances(direction), np.float32(variances))
        return light_field.disk(direction, direction, self._light.radius, variances)


def _is_filled(light):
    return light.kind in (LightKind.POINT, LightKind.SPOT) and light.radius > 0 and not light.soft


class _Within(_Point):
    """The inside of a ball that is not soft: fog in there sees the radiance L all around, as in Cycles.

    Light that starts at the far side of the ball and ends at the near one, where that of _Point begins. Of a spot, too, L comes from
    all sides, but from beyond the centre only, so these lines begin at their middle. In Cycles the two ways to sample such a spot
    differ: one of them sees the nearer side as well. With isotropic fog and one lamp it shows the mean of both, 3 pi L; with many
    lamps what is here, 2 pi L.
    """

    def __init__(self, light, fog, scene):
        super().__init__(light, fog, scene)
        self._begin = -1.0 if light.kind == LightKind.POINT else 0.0
        # The mean length of these lines, over how far other light goes through fog.
        self.worth = min(1.0, (1 - self._begin) * 2 / 3 * light.radius / max(fog.radius, 1e-30))

    def emit(self, numbers):
        direction, power = self._powers(numbers)
        across, distance2 = _across(direction, numbers[:, 2], numbers[:, 3])
        height, radius = np.sqrt(1 - distance2), f32(self._light.radius)
        begin = f32(self._begin) * height
        origin = f32(cleared(self._light.position)) + radius * (across + begin[:, None] * direction)
        return Starts(origin, direction, power, np.zeros_like(direction), until=radius * (height - begin))


class _Spot(_Point):
    def __init__(self, light, fog, scene):
        self._angle = 2 * np.pi * (1 - light.cosine)
        super().__init__(light, fog, scene)

    def _falloff(self, cosine):
        q = np.clip((cosine - self._light.cosine) / self._light.blend, 0, 1)
        return q * q * (3 - 2 * q)

    def _directions(self, u, v):
        light = self._light
        axis = np.broadcast_to(f32(light.axis), (len(u), 3))
        direction = around(axis, 1 - u * np.float32(1 - light.cosine), v)
        q = np.clip((dot(direction, axis) - f32(light.cosine)) / f32(light.blend), 0, 1)
        return direction, q * q * (3 - 2 * q)

    def fields(self, direction, normal):
        # The Hessian of I(theta)/d^2 across the ray, over I/d^2: I''/I - 2 towards the axis and I' cot(theta)/I - 2
        # around it. Where I has its inflection the gradient speaks.
        light = self._light
        axis = np.broadcast_to(light.axis, direction.shape)
        cosine = np.clip(np.einsum("ij,ij->i", direction.astype(np.float64), axis), -1, 1)
        sine = np.sqrt(1 - cosine * cosine)
        q = np.clip((cosine - light.cosine) / light.blend, 0, 1)
        soft = (q > 1e-3) & (q < 1)
        q = np.where(soft, q, 1.0)
        intensity = q * q * (3 - 2 * q)
        # By the cosine: I' and I''; by the angle: -sin I', and sin^2 I'' - cos I'.
        first, second = 6 * q * (1 - q) / light.blend / intensity, (6 - 12 * q) / light.blend**2 / intensity
        slope = np.where(soft, -sine * first, 0)
        bend = np.where(soft, sine**2 * second - cosine * first, 0)
        towards = np.maximum(np.abs(bend - 2), slope**2)
        about = np.abs(np.where(soft, -cosine * first, 0) - 2)
        variances = np.stack([towards, about], axis=1).astype(np.float32) * np.float32(CURVATURE)
        if self._patterned is not None:
            variances = np.maximum(variances, self._patterned.variances(direction)[:, None])
        axes = np.where(soft[:, None], axis, basis(direction)[0]).astype(np.float32)
        spatial = 1 / (np.pi * light.radius) ** 2 if light.radius > 0 else np.inf
        return light_field.gaussian(direction, axes, (spatial, spatial), variances)


def _diffuse_fields(direction, normal, radius):
    """Of a patch that shines as a Lambert surface: cos/d^2 has a relative curvature of 3/d^2, and beyond 60 degrees the
    gradient of the cosine, its tangent squared, outweighs it."""
    field = light_field.disk(direction, normal, radius, 3 * CURVATURE)
    cosine = np.maximum(np.abs(dot(direction, normal)), 1e-3)
    more = np.maximum((1 / cosine**2 - 4) * np.float32(CURVATURE), 0)
    light_field.narrow(field, normal, more)
    return field


class _Area(Emitting):
    def __init__(self, light, fog, scene):
        self._light = light
        self._normal = np.cross(light.u, light.v)
        length = float(np.linalg.norm(self._normal))
        self._area = length * (np.pi / 4 if light.round else 1.0)
        # One without area has no flux and is never drawn.
        self._normal = self._normal / (length or 1.0)
        self.flux = np.pi * self._area * light.radiance
        self._size = np.sqrt(self._area)

    def emit(self, numbers):
        light, normal = self._light, f32(self._normal)
        if light.round:
            place = 0.5 * disk(numbers[:, 2], numbers[:, 3])
        else:
            place = numbers[:, 2:4] - np.float32(0.5)
        origin = _lifted(light.position + place[:, :1] * light.u + place[:, 1:] * light.v, self._size, self._normal)
        normals = np.broadcast_to(normal, (len(numbers), 3))
        # In proportion to the cosine, as far out as the light reaches.
        full = light.spread >= np.pi / 2
        limit = 1.0 if full else np.sin(light.spread) ** 2
        sine2 = np.minimum(numbers[:, 0] * np.float32(limit), np.float32(1 - 1e-7))
        cosine = np.sqrt(1 - sine2)
        weight = np.full(len(numbers), limit, np.float32)
        if not full:
            # (tan a - tan x) / (tan a - a): slats of a honeycomb, normalised to the same flux.
            tangent = np.tan(light.spread)
            weight *= np.maximum((tangent - np.sqrt(sine2) / cosine) / (tangent - light.spread), 0)
        direction = around(normals, cosine, numbers[:, 1])
        return Starts(f32(origin), direction, weight[:, None] * f32(self.flux), normals)

    def fields(self, direction, normal):
        field = _diffuse_fields(direction, normal, np.float32(np.sqrt(self._area / np.pi)))
        if self._light.spread < np.pi / 2:
            light_field.narrow(field, normal, np.float32(CURVATURE / np.tan(self._light.spread) ** 2))
        return field


class _Mesh(Emitting):
    """Triangles that shine on both sides, drawn by area."""

    def __init__(self, light, fog, scene):
        corners = light.triangles.astype(np.float64)
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        cross = np.cross(b - a, c - a)
        areas = 0.5 * np.linalg.norm(cross, axis=1)
        real = areas > 0
        self._corners, self._cross = corners[real], cross[real]
        self._bounds = np.cumsum(areas[real])
        self._area = float(areas.sum())
        self.flux = 2 * np.pi * self._area * light.radiance

    def emit(self, numbers):
        # Two numbers for triangle, side and place: the side from what the choice of the triangle leaves of the first.
        at = numbers[:, 2].astype(np.float64) * self._area
        index = np.minimum(np.searchsorted(self._bounds, at, side="right"), len(self._bounds) - 1)
        below = np.where(index > 0, self._bounds[index - 1], 0.0)
        rest = 2 * np.clip((at - below) / (self._bounds[index] - below), 0, 1 - 1e-12)
        side = np.where(rest < 1, 1.0, -1.0)
        rest = rest % 1.0
        root, v = np.sqrt(rest), numbers[:, 3].astype(np.float64)
        a, b, c = (self._corners[index, k] for k in range(3))
        normal = side[:, None] * self._cross[index] / np.linalg.norm(self._cross[index], axis=1, keepdims=True)
        origin = a + (root * (1 - v))[:, None] * (b - a) + (root * v)[:, None] * (c - a)
        origin = _lifted(origin, np.sqrt(self._area), normal)
        normals = normalized(f32(normal))
        direction = around(normals, np.sqrt(np.maximum(1 - numbers[:, 0], np.float32(1e-7))), numbers[:, 1])
        return Starts(f32(origin), direction, np.broadcast_to(f32(self.flux), (len(numbers), 3)), normals)

    def fields(self, direction, normal):
        return _diffuse_fields(direction, normal, np.float32(np.sqrt(self._area / np.pi)))


_EMITTERS = {
    LightKind.POINT: _Point,
    LightKind.SPOT: _Spot,
    LightKind.AREA: _Area,
    LightKind.SUN: Sun,
    LightKind.MESH: _Mesh,
    LightKind.WORLD: World,
}
