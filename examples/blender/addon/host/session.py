# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a scene pass by pass: the library's session of what was exported."""

from dataclasses import dataclass, field, fields, replace

import numpy as np
from covbeam import session
from covbeam.session import Layer

__all__ = ["Picture", "Session", "Settings"]


@dataclass(frozen=True)
class Settings:
    """How to render.

    - seed: the same picture for the same seed.
    - photons: light paths a pass; 0: as many as the scene asks for.
    - grid: voxels along the longest side of the covariance grid, up to 256; 0: the scene's own.
    - radius: of the kernels in pass 1 [m]; 0: the scene's own.
    - quality: relative bias that kernels and filters of pass 1 may cause, in (0, 1]; it falls with the passes.
    - bounces: largest number of scatterings and reflections of light, None for any; limits: a covbeam.session.BounceLimits beside that, or None.
    - beyond: whether fog behind the first surface is rendered too, through glass and in mirrors.
    - threads: 0 for all cores.
    """

    seed: int = 0
    photons: int = 0
    grid: int = 0
    radius: float = 0.0
    quality: float = 0.01
    bounces: int | None = None
    limits: session.BounceLimits | None = None
    beyond: bool = True
    threads: int = 0


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
    #: `first` by light groups, of host.groups.GroupSession: what each of them adds to it.
    groups: dict[str, np.ndarray] = field(default_factory=dict)


#: The library's layers, by field of Picture.
_LAYERS = {
    "in_scattered": Layer.ALL,
    "first": Layer.FIRST,
    "radius": Layer.RADIUS,
    "bandwidth": Layer.BANDWIDTH,
    "error": Layer.ERROR,
}

#: Fields of Picture that grow with the exposure.
_LIGHT = ("in_scattered", "first", "error")


class Session(session.Session):
    """Renders the passes of one picture of a host.scene.Scene, or of the same one at several instants while a shutter is open.

    - instants: more Scenes, see covbeam.session.Session; poll: asked whether to go on while it gets ready.
    """

    def __init__(self, scene, settings, poll=None, instants=()):
        more = {"instants": [described(each) for each in instants], "first_apart": True, "poll": poll}
        chosen = {each.name: getattr(settings, each.name) for each in fields(settings)}
        super().__init__(described(scene), **chosen, **more)
        self._is_mirrored = _is_mirrored(scene.camera)
        self._exposure = np.float32(scene.exposure)

    def picture(self, poll=None):
        """The Picture of the passes done, at least one."""
        # It is made with the first layer; the others are there then.
        of_layer = super().picture
        found = {name: of_layer(layer, poll) for name, layer in _LAYERS.items()}
        if self._exposure != 1:
            found |= {name: found[name] * self._exposure for name in _LIGHT}
        if self._is_mirrored:
            found = {name: np.ascontiguousarray(values[:, ::-1]) for name, values in found.items()}
        return Picture(**found)


def described(scene):
    """The covbeam.session.Scene of a host.scene.Scene."""
    given = {part.name: getattr(scene, part.name) for part in fields(scene) if part.name != "exposure"}
    if _is_mirrored(scene.camera):
        given["camera"] = _mirrored(scene.camera)
    return session.Scene(**given, fog_alone=True)


def _is_mirrored(camera):
    """Whether a camera shows what is on its right on the left, as Blender's do where their scale is negative. The library's never do."""
    return np.cross(camera.forward, camera.up) @ camera.right < 0


def _mirrored(camera):
    """The camera that sees the mirror image of a camera's picture: `right` is on the other side."""
    lens = camera.aperture
    return replace(
        camera,
        right=-camera.right,
        left=-(camera.left + camera.width * camera.step[0]),
        aperture=lens and replace(lens, rotation=np.pi - lens.rotation),
    )
