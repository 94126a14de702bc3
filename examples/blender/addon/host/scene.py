# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene as the host traces it: triangles, materials, lights, media and a camera, in metres and watts, without Blender.

All vectors are in world space. Channels are linear Rec. 709.
"""

from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
from covbeam.session import MATERIAL, OBJECT_RULES, Geometry, Rays

__all__ = [
    "MATERIAL",
    "OBJECT_RULES",
    "Aperture",
    "Camera",
    "Density",
    "Glow",
    "Light",
    "LightKind",
    "Pattern",
    "Phase",
    "Projection",
    "Rays",
    "Scene",
    "Volume",
]


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
    #: The light group that it is in; empty: none.
    group: str = ""
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
    sky: np.ndarray | None = None
    #: WORLD: the direction in `sky` is this matrix times that in the scene; a rotation, float64 of shape (3, 3).
    turn: np.ndarray = field(default_factory=lambda: np.eye(3))
    #: What does not see it: it does not fall on what these rays leave.
    hidden_from: Rays = Rays(0)
    #: Sets of objects and volumes that its light does not fall on straight, and of those that cast no shadow of it: a bit each.
    unlit: int = 0
    unshadowed: int = 0
    #: Of all but suns and worlds: its straight light is times d^falloff d^2 / (smooth + d^2) at a distance d [m].
    falloff: float = 0.0
    smooth: float = 0.0
    #: Where bounces are limited, most of its light on the way to the camera; None: as many as these limits let.
    bounces: int | None = None


class Phase(IntEnum):
    """How scattered light is spread over directions."""

    ISOTROPIC = 0
    #: Of the mean cosine Volume.asymmetry.
    HENYEY_GREENSTEIN = 1
    RAYLEIGH = 2


@dataclass(frozen=True)
class Density:
    """Relative densities, the largest 1: trilinear between the middles of voxels, held beyond the outermost ones, 0 outside of the box."""

    #: Corners of the box [m].
    min: np.ndarray
    max: np.ndarray
    #: >= 0, float32 (z, y, x).
    values: np.ndarray


@dataclass(frozen=True)
class Glow:
    """Light that a medium sends out, the same in all directions: voxels as those of Density."""

    #: Corners of the box [m].
    min: np.ndarray
    max: np.ndarray
    #: Emission coefficient per channel [W/(m^3 sr)], >= 0, float32 (z, y, x, 3).
    values: np.ndarray


@dataclass(frozen=True)
class Volume:
    """A medium and where it is: inside the closed meshes of its objects, or everywhere. Coefficients hold where the relative density is
    1, its largest value."""

    name: str
    #: Scattering and absorption coefficients [1/m], float64 of shape (3,).
    scattering: np.ndarray
    absorption: np.ndarray
    #: Corners of what it fills [m]; infinite for the world's.
    min: np.ndarray
    max: np.ndarray
    phase: Phase = Phase.ISOTROPIC
    #: Mean cosine of Henyey-Greenstein, in (-1, 1), forward positive.
    asymmetry: float = 0.0
    #: How much of the medium there is; None: 1 everywhere.
    density: Density | None = None
    #: What it sends out, however much of it there is; None: it is dark. The world's is.
    glow: Glow | None = None
    #: Indices of the volumes whose sum this is, where all of them and no others are; empty: it is one of a scene's own. The world's is in
    #: all of them.
    parts: tuple[int, ...] = ()
    #: Phase functions beside its own, of which it is a mixture: Phase, mean cosine, and share of what is scattered, float64 (3,), each.
    lobes: tuple = ()
    #: CAMERA: the camera does not see it; SHADOW: it dims no straight light.
    hidden_from: Rays = Rays(0)
    #: Sets that it is in, for lamps that light some only, and that some only dim.
    light_set: int = 0
    shadow_set: int = 0


@dataclass(frozen=True)
class Aperture:
    """A lens' opening: a disk, or a regular polygon of 3 and more blades, `radius` around the camera's position.

    What is sharp is at `focus` along `forward`, of panoramas from the camera. All lengths in metres, > 0.
    """

    radius: float
    focus: float
    #: Of the polygon: number of corners, 0 for a disk; and angle from `right` towards `up` of an edge's middle [rad].
    blades: int = 0
    rotation: float = 0.0
    #: Height over width.
    ratio: float = 1.0


class Projection(IntEnum):
    """How a place (h, v) in the plane of a picture becomes an eye ray."""

    #: Along forward + h * right + v * up.
    PERSPECTIVE = 0
    #: Along forward, from h * right + v * up of the camera's position [m].
    ORTHOGRAPHIC = 1
    #: At the longitude h, from forward towards right, and the latitude v [rad].
    EQUIRECTANGULAR = 2
    #: At the angle from forward that is the length of (h, v) [rad]. Dark beyond `widest`.
    FISHEYE = 3


@dataclass(frozen=True)
class Camera:
    """A camera, with a thin lens or without, and the part of its picture that is rendered.

    Its eye ray through (x, y), in pixels from the upper left corner of that part, is that of (left + x * step[0], top - y * step[1]) in
    its projection. What is nearer than `near` along `forward`, of panoramas to the camera, is not there.
    """

    position: np.ndarray
    #: Unit, orthogonal: to the right, up, and into the picture.
    right: np.ndarray
    up: np.ndarray
    forward: np.ndarray
    #: h and v of the upper left corner.
    left: float
    top: float
    #: A pixel's width and height in that plane, both > 0.
    step: tuple[float, float]
    width: int
    height: int
    #: [m] >= 0
    near: float = 0.0
    #: None: a pinhole.
    aperture: Aperture | None = None
    projection: Projection = Projection.PERSPECTIVE
    #: FISHEYE: in [0, pi]
    widest: float = 0.0

    def coarser(self, pixel):
        """The camera with pixels of that many times the size, from the same corner: as many as cover what it sees."""
        step = (self.step[0] * pixel, self.step[1] * pixel)
        return replace(self, step=step, width=-(-self.width // pixel), height=-(-self.height // pixel))


@dataclass(frozen=True)
class Scene:
    """What is rendered. `geometry` has been built; its hits' `material` and `object` index `materials` and `object_volumes`."""

    geometry: Geometry
    #: MATERIAL, (n,)
    materials: np.ndarray
    #: For each object: the index in `volumes` of what it is filled with, or -1: int32, (m,).
    object_volumes: np.ndarray
    #: Which objects have an inside: bool, (m,). Fog inside of those of glass is kept apart from that outside.
    object_closed: np.ndarray
    #: By which rays and lamps objects are not heeded: OBJECT_RULES, (m,).
    object_rules: np.ndarray
    volumes: list[Volume]
    #: Index in `volumes` of what is outside of all objects, or -1.
    world_volume: int
    lights: list[Light]
    camera: Camera
    #: Factor on all light of the picture, >= 0.
    exposure: float = 1.0

    @property
    def shines(self):
        """Whether there is any light: of lamps, or of volumes that send it out."""
        return bool(self.lights) or any(volume.glow is not None for volume in self.volumes)
