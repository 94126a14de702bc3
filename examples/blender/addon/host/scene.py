# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene as the host traces it: triangles, materials, lights, media and a camera, in metres and watts, without Blender.

All vectors are in world space. Channels are linear Rec. 709.
"""

from dataclasses import dataclass, field
from enum import IntEnum

import covbeam
import covbeam_rays
import numpy as np

#: How a surface treats light: weights per channel of the lobes that it is the sum of; what they leave is absorbed.
#:
#: - diffuse: of Lambert reflection; translucent: of Lambert transmission.
#: - metal: reflectance of a microfacet mirror at normal incidence; edge: at grazing incidence (Schlick's curve between them).
#: - glass_reflection, glass_transmission: factors on what Fresnel's equations reflect and transmit at a dielectric boundary.
#: - coat: weight of a dielectric reflection over what is diffuse: Fresnel's share of it is reflected, the rest goes on to `diffuse`.
#: - transparent: of light that goes straight on, as if nothing were there.
#: - ior: refractive index of glass and coat, over that of the side that the normal points to.
#: - roughness: GGX's alpha of metal, glass and coat; below 1e-3 they are perfectly smooth.
MATERIAL = np.dtype(
    [
        ("diffuse", np.float32, (3,)),
        ("translucent", np.float32, (3,)),
        ("metal", np.float32, (3,)),
        ("edge", np.float32, (3,)),
        ("glass_reflection", np.float32, (3,)),
        ("glass_transmission", np.float32, (3,)),
        ("coat", np.float32, (3,)),
        ("transparent", np.float32, (3,)),
        ("ior", np.float32),
        ("roughness", np.float32),
    ]
)

#: Absorbs everything; the material of triangles that have none is the exporter's choice.
BLACK = np.zeros((), MATERIAL)
BLACK["ior"] = 1.0


class LightKind(IntEnum):
    """What a light is; fields of Light that its kind does not name have no meaning."""

    #: A ball of `radius` around `position` with `intensity`, the same from everywhere far away. Radius 0: a point.
    POINT = 0
    #: The same, times smoothstep((cos - cosine) / blend) of the angle between the emitted direction and `axis`. `soft`: of both.
    SPOT = 1
    #: A parallelogram of edges `u`, `v` (or, if `round`, the ellipse that fits it) around `position`, with `radiance` on the side
    #: of u x v; `spread` < pi/2 narrows it as Blender's area lights.
    AREA = 2
    #: A disk infinitely far away, of angular radius `angle` [rad], whose light runs along `axis`; `irradiance` across that.
    SUN = 3
    #: Triangles with `radiance` on both sides.
    MESH = 4
    #: What is around the scene, infinitely far away: `sky`, turned by `turn`.
    WORLD = 5


@dataclass(frozen=True)
class Pattern:
    """Factors on a lamp's intensity by direction: cells of equal angles."""

    #: >= 0, float32 (h, w, 3): rows from the lamp's axis to the angle `reach` from it, columns from the first of `axes` towards the second.
    cells: np.ndarray
    #: Unit vectors, float64 (3, 3): to the right of the lamp, up, and along its axis.
    axes: np.ndarray
    #: [rad] in (0, pi]
    reach: float


@dataclass(frozen=True)
class Light:
    """A light source. Vectors are float64 of shape (3,); radiometric values are per channel."""

    name: str
    kind: LightKind
    #: [m]
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    #: Unit.
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, -1.0]))
    #: [m] >= 0
    radius: float = 0.0
    #: POINT, SPOT: whether all points see a disk of that radius that faces them, and no ball (Blender's Soft Falloff).
    soft: bool = False
    #: [W/sr]
    intensity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    #: SPOT: cosine of the half angle of the cone, and how far the cosine rises inside until the light is full, > 0.
    cosine: float = -1.0
    blend: float = 0.0
    #: POINT, SPOT: how the intensity differs with direction; None: not at all.
    pattern: Pattern | None = None
    #: AREA: whole edges [m].
    u: np.ndarray = field(default_factory=lambda: np.zeros(3))
    v: np.ndarray = field(default_factory=lambda: np.zeros(3))
    round: bool = False
    #: AREA: half angle of the light's honeycomb [rad] in (0, pi/2]; pi/2: none.
    spread: float = np.pi / 2
    #: AREA, MESH: [W/(m^2 sr)]
    radiance: np.ndarray = field(default_factory=lambda: np.zeros(3))
    #: SUN: [W/m^2], and [rad]
    irradiance: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angle: float = 0.0
    #: MESH: corners, float32 of shape (n, 3, 3) [m].
    triangles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 3), np.float32))
    #: WORLD: radiance [W/(m^2 sr)] that arrives from cells of equal angles, float32 of shape (h, w, 3). Rows run from +Z down to -Z,
    #: columns in azimuth from pi, by way of +X in the middle, down to -pi.
    sky: np.ndarray = field(default_factory=lambda: np.zeros((1, 1, 3), np.float32))
    #: WORLD: the direction in `sky` is this matrix times that in the scene; a rotation, float64 of shape (3, 3).
    turn: np.ndarray = field(default_factory=lambda: np.eye(3))


@dataclass(frozen=True)
class Volume:
    """A medium and where it is: inside the closed meshes of its objects, or everywhere. Coefficients hold where the relative density is
    1, its largest value."""

    name: str
    medium: covbeam.Medium
    #: Scattering and absorption coefficients [1/m], float64 of shape (3,), and the phase function's mean cosine.
    scattering: np.ndarray
    absorption: np.ndarray
    asymmetry: float
    #: Corners of what it fills [m]; infinite for the world's.
    min: np.ndarray
    max: np.ndarray
    #: Whether the medium's density varies.
    varies: bool = False
    #: Indices of the volumes whose sum this is, where all of them and no others are; empty: it is one of a scene's own. The world's is in
    #: all of them.
    parts: tuple[int, ...] = ()


@dataclass(frozen=True)
class Aperture:
    """A lens' opening: a disk, or a regular polygon of 3 and more blades, `radius` around the camera's position.

    What is sharp is at `focus` along `forward`. All lengths in metres, > 0.
    """

    radius: float
    focus: float
    #: Of the polygon: number of corners, 0 for a disk; and angle from `right` towards `up` of an edge's middle [rad].
    blades: int = 0
    rotation: float = 0.0
    #: Height over width.
    ratio: float = 1.0

    def places(self, u, v):
        """Places in the opening, to the right and up [m], float64 (n, 2), evenly for even u and v in [0, 1)."""
        if self.blades < 3:
            around, far = 2 * np.pi * v, np.sqrt(u)
            across, upward = far * np.cos(around), far * np.sin(around)
        else:
            # A triangle of the middle and an edge, and a place in it: the corners' weights.
            edge = np.floor(u * self.blades)
            far = np.sqrt(u * self.blades - edge)
            half = np.pi / self.blades
            middle, aside = far * np.cos(half), far * (2 * v - 1) * np.sin(half)
            turn = self.rotation + 2 * half * edge
            across = middle * np.cos(turn) - aside * np.sin(turn)
            upward = middle * np.sin(turn) + aside * np.cos(turn)
        return self.radius * np.stack([across / self.ratio, upward], axis=-1)


@dataclass(frozen=True)
class Camera:
    """A pinhole or a thin lens, and the part of its picture that is rendered.

    The pinhole's eye ray through (x, y), in pixels from the upper left corner of that part, runs along
    forward + (left + x * step[0]) * right + (top - y * step[1]) * up. What is nearer than `near` along `forward` is not there.
    """

    position: np.ndarray
    #: Unit, orthogonal: to the right, up, and into the picture.
    right: np.ndarray
    up: np.ndarray
    forward: np.ndarray
    #: Tangents at the upper left corner: towards `right` and towards `up`.
    left: float
    top: float
    #: Tangents a pixel, both > 0.
    step: tuple[float, float]
    width: int
    height: int
    #: [m] >= 0
    near: float = 0.0
    #: None: a pinhole.
    aperture: Aperture | None = None

    def through_lens(self, directions, u, v):
        """Where in the opening eye rays start that a pinhole would send along `directions`, from the position [m], and where they go:
        float32 (n, 3) both. u, v: even numbers in [0, 1), (n,)."""
        place = self.aperture.places(u, v)
        offset = place[:, :1] * self.right + place[:, 1:] * self.up
        sharp = directions * (self.aperture.focus / (directions @ self.forward))[:, None]
        way = sharp - offset
        return offset.astype(np.float32), (way / np.linalg.norm(way, axis=1, keepdims=True)).astype(np.float32)

    def blur(self, depth):
        """Radius of what a point at a distance along `forward`, (n,) [m], is blurred to [pixels]: (n,)."""
        if self.aperture is None:
            return np.zeros_like(depth)
        lens = self.aperture
        widest = lens.radius * max(1.0, 1 / lens.ratio)
        return widest * np.abs(1 / lens.focus - 1 / np.maximum(depth, 1e-30)) / min(self.step)

    def starts(self, directions):
        """Where eye rays of some unit directions begin: distances from the position, float32 (n,)."""
        return (self.near / (directions @ self.forward)).astype(np.float32)

    def directions(self, x, y):
        """Unit directions of eye rays: float32 (n, 3). x, y: float arrays (n,), in pixels from the upper left corner."""
        across = self.left + np.asarray(x, np.float64) * self.step[0]
        upward = self.top - np.asarray(y, np.float64) * self.step[1]
        d = self.forward + across[:, None] * self.right + upward[:, None] * self.up
        return (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(np.float32)


@dataclass(frozen=True)
class Scene:
    """What is rendered. `geometry` has been built; its hits' `material` and `object` index `materials` and `object_volumes`."""

    geometry: covbeam_rays.Geometry
    #: MATERIAL, (n,)
    materials: np.ndarray
    #: For each object: the index in `volumes` of what it is filled with, or -1: int32, (m,).
    object_volumes: np.ndarray
    #: Which objects have an inside: bool, (m,). Fog inside of those of glass is kept apart from that outside.
    object_closed: np.ndarray
    volumes: list[Volume]
    #: Index in `volumes` of what is outside of all objects, or -1.
    world_volume: int
    lights: list[Light]
    camera: Camera

    @property
    def extinctions(self):
        """Extinction coefficients of the volumes [1/m], and of nothing: float32 (n + 1, 3), so that -1 is nothing's index."""
        values = [volume.scattering + volume.absorption for volume in self.volumes]
        return np.array([*values, np.zeros(3)], np.float32)

    @property
    def bounds(self):
        """Which materials do nothing but bound fog: bool, (n,)."""
        return (self.materials["transparent"] >= 1).all(axis=1)
