"""Parts of a scene: lights, volumes, cameras, with defaults for what a kind does not need."""

import math
from dataclasses import dataclass, field
from enum import IntEnum, IntFlag

import numpy as np


class LightKind(IntEnum):
    """Kinds of lights, and the fields that they need."""

    #: position, intensity; radius, soft, pattern
    POINT = 0
    #: The same; axis, cosine, blend.
    SPOT = 1
    #: position, u, v, radiance; spread, round
    AREA = 2
    #: axis, irradiance; angle
    SUN = 3
    #: triangles, radiance
    MESH = 4
    #: sky, turn
    SKY = 5


class Projection(IntEnum):
    """How places in a picture become rays."""

    PERSPECTIVE = 0
    ORTHOGRAPHIC = 1
    EQUIRECTANGULAR = 2
    FISHEYE = 3


class Rays(IntFlag):
    """Kinds of rays, which go from the eye to the light: light that a diffuse surface sends to the camera is seen by a diffuse ray."""

    CAMERA = 1
    DIFFUSE = 2
    #: From what reflects as metal, coats and glass do.
    GLOSSY = 4
    #: From what lets light through, refracted or diffusely.
    TRANSMISSION = 8
    #: From a place in a volume.
    VOLUME = 16
    #: From anywhere to a lamp.
    SHADOW = 32


def _zero():
    return np.zeros(3)


@dataclass(eq=False)
class Light:
    """A light; fields that its kind does not need are not read. covbeam_light of the header tells their meaning.

    - hidden_from: Rays that do not see it: it does not fall on what they leave.
    - unlit: sets of objects and volumes that it does not fall on straight, a bit each; unshadowed: sets of objects that cast no shadow of it.
    - falloff, smooth: its straight light is times d**falloff * d**2 / (smooth + d**2) at a distance d [m], falloff from 0 to 4; not of suns and skies.
    - bounces: where a session's limits hold, the largest number of scatterings and reflections of its light, the one that sends it to the camera apart; None: no
      other than theirs.
    - pattern: None, or what has `cells` (rows, columns, 3), `axes` (3, 3) and `reach`; sky: cells (rows, columns, 3), turned by `turn`.
    """

    kind: LightKind
    position: np.ndarray = field(default_factory=_zero)
    axis: np.ndarray = field(default_factory=_zero)
    u: np.ndarray = field(default_factory=_zero)
    v: np.ndarray = field(default_factory=_zero)
    intensity: np.ndarray = field(default_factory=_zero)
    radiance: np.ndarray = field(default_factory=_zero)
    irradiance: np.ndarray = field(default_factory=_zero)
    radius: float = 0.0
    cosine: float = 0.0
    blend: float = 0.0
    spread: float = 0.0
    angle: float = 0.0
    visible: bool = False
    soft: bool = False
    round: bool = False
    triangles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3, 3), np.float32))
    pattern: object = None
    sky: np.ndarray | None = None
    turn: np.ndarray = field(default_factory=lambda: np.eye(3))
    hidden_from: int = 0
    unlit: int = 0
    unshadowed: int = 0
    falloff: float = 0.0
    smooth: float = 0.0
    bounces: int | None = None


@dataclass(eq=False)
class Voxels:
    """Numbers at the middles of voxels of a box: float32 (z, y, x), or (z, y, x, 3) for colours."""

    min: np.ndarray
    max: np.ndarray
    values: np.ndarray


@dataclass(eq=False)
class Volume:
    """A medium and where it is.

    - scattering, absorption: coefficients where the relative density is 1 [1/m], (3,).
    - min, max: corners of what it fills; not read for the world's and for what fills shapes.
    - phase: 0 isotropic, 1 Henyey-Greenstein with the mean cosine `asymmetry`, 2 Rayleigh.
    - lobes: phase functions beside that, of which it is a mixture: (phase, asymmetry, share of what is scattered (3,)) each.
    - density, glow: None, or Voxels: relative densities, and emission coefficients [W/(m^3 sr)].
    - parts: of a sum: the indices of the volumes that overlap where it counts.
    - scale_height: of the world's: height in which its density falls to 1/e [m], along `up` from `origin`, where it is 1; 0: it does not.
    - hidden_from: Rays that do not see it: CAMERA, and SHADOW, which dims no straight light of lamps in it.
    - light_set, shadow_set: sets below 64 that it is in, for lamps that light some only, and that some only dim.
    """

    scattering: np.ndarray
    absorption: np.ndarray = field(default_factory=_zero)
    min: np.ndarray = field(default_factory=_zero)
    max: np.ndarray = field(default_factory=_zero)
    phase: int = 0
    asymmetry: float = 0.0
    density: Voxels | None = None
    glow: Voxels | None = None
    parts: tuple = ()
    scale_height: float = 0.0
    origin: np.ndarray = field(default_factory=_zero)
    up: np.ndarray = field(default_factory=_zero)
    lobes: tuple = ()
    hidden_from: int = 0
    light_set: int = 0
    shadow_set: int = 0


@dataclass(eq=False)
class Camera:
    """A camera. `Camera.at` makes one that looks at a point.

    - forward, up: any length but 0; half_height: of the picture in its projection's unit, tan(fov / 2) in perspective.
    - aperture: None, or what has `radius`, `focus`, `blades`, `rotation`, `ratio`.
    """

    position: np.ndarray
    forward: np.ndarray
    up: np.ndarray
    half_height: float
    width: int
    height: int
    projection: Projection = Projection.PERSPECTIVE
    widest: float = math.pi
    near: float = 0.0
    aperture: object = None

    @classmethod
    def at(cls, position, look_at, fov, width, height, up=(0.0, 1.0, 0.0)):
        """A pinhole that looks at a point, with a vertical field of view [rad]."""
        position = np.asarray(position, float)
        return cls(position, np.asarray(look_at, float) - position, np.asarray(up, float), math.tan(0.5 * fov), width, height)
