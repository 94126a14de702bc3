# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a scene pass by pass: the native renderer's session of what was exported."""

from dataclasses import asdict, dataclass, fields

import covbeam_rays
from covbeam_rays import Picture

__all__ = ["Picture", "Session", "Settings"]


@dataclass(frozen=True)
class Settings:
    """How to render.

    - seed: the same picture for the same seed.
    - photons: light paths a pass; 0: as many as the scene asks for.
    - grid: voxels along the longest side of the covariance grid, up to 256; 0: the scene's own.
    - radius: of the kernels in pass 1 [m]; 0: the scene's own.
    - quality: relative bias that kernels and filters of pass 1 may cause, in (0, 1]; it falls with the passes.
    - bounces: largest number of scatterings and reflections of light, None for any.
    - beyond: whether fog behind the first surface is rendered too, through glass and in mirrors.
    - threads: 0 for all cores.
    """

    seed: int = 0
    photons: int = 0
    grid: int = 0
    radius: float = 0.0
    quality: float = 0.01
    bounces: int | None = None
    beyond: bool = True
    threads: int = 0


class Session(covbeam_rays.Session):
    """Renders the passes of one picture of a host.scene.Scene, or of the same one at several instants while a shutter is open.

    - instants: more Scenes, see covbeam_rays.Session; poll: asked whether to go on while it gets ready.
    """

    def __init__(self, scene, settings, poll=None, instants=()):
        super().__init__(described(scene), instants=[described(each) for each in instants], **asdict(settings), poll=poll)


def described(scene):
    """The covbeam_rays.Scene of a host.scene.Scene."""
    return covbeam_rays.Scene(**{part.name: getattr(scene, part.name) for part in fields(scene)})
