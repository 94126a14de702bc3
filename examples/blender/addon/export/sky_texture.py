# SPDX-License-Identifier: GPL-3.0-or-later
"""What a Sky Texture looks like: another Blender is asked."""

import json
from dataclasses import dataclass
from functools import lru_cache
from math import cos, sin

import numpy as np

from .other_blender import Unseen, answered
from .working_space import working_space

#: Settings of the node that its sky depends on, in any version of Blender.
_SETTINGS = (
    *("sky_type", "sun_direction", "turbidity", "ground_albedo", "sun_disc", "sun_size", "sun_intensity", "sun_elevation"),
    *("sun_rotation", "altitude", "air_density", "dust_density", "aerosol_density", "ozone_density"),
)

#: Models that have a disc of the sun.
_WITH_SUN = ("NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING")


@dataclass(frozen=True)
class Sky:
    """A sky as the node gives it for the directions of the world."""

    #: Radiance without the sun's disc: cells as those of host.scene.Light.
    cells: np.ndarray
    #: Where the sun is, unit, float64 (3,); its angular radius [rad], and irradiance [W/m^2], float64 (3,): 0 without a disc.
    direction: np.ndarray
    angle: float
    irradiance: np.ndarray


def sky_of(node, poll):
    """The Sky of a node of type TEX_SKY. Raises other_blender.Failed; poll: as for export."""
    settings = {}
    for name in _SETTINGS:
        value = getattr(node, name, None)
        if value is not None:
            settings[name] = value if isinstance(value, (str, bool, int, float)) else tuple(value)
    if node.sky_type not in _WITH_SUN:
        settings["sun_disc"] = False
    elevation, turn = settings["sun_elevation"], settings["sun_rotation"]
    # Zero is north, and it goes on to the east.
    settings["direction"] = (cos(elevation) * sin(turn), cos(elevation) * cos(turn), sin(elevation))
    settings["space"] = working_space()
    return _rendered(json.dumps(settings, sort_keys=True), Unseen(poll))


@lru_cache(maxsize=8)
def _rendered(text, poll):
    answer, (cells,) = answered("sky_render.py", text, poll.what)
    settings, irradiance = json.loads(text), np.array(answer["irradiance"], np.float64)
    cells = np.maximum(np.nan_to_num(cells, posinf=0.0), 0)
    return Sky(cells, np.array(settings["direction"]), settings.get("sun_size", 0.0) / 2, np.maximum(irradiance, 0))
