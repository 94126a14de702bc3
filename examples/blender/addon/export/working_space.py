# SPDX-License-Identifier: GPL-3.0-or-later
"""The working space of the file: the colours that Blender and Cycles compute with, linear Rec. 709 unless the artist has chosen another."""

import bpy
import numpy as np
from mathutils import Color


def working_space():
    """Its name, which is one of the colour spaces that images have too."""
    return bpy.data.colorspace.working_space if bpy.app.version >= (5, 0) else "Linear Rec.709"


def _of_unit_colours(convert):
    return np.array([convert(Color(unit)) for unit in np.eye(3)], np.float64)


def from_rec709(colours):
    """Linear Rec. 709 in the working space, (3,) or (n, 3)."""
    return colours @ _of_unit_colours(Color.from_rec709_linear_to_scene_linear)


def luminance():
    """What a colour of the working space is as a number is the sum of its channels times these: float64 (3,)."""
    return _of_unit_colours(Color.from_scene_linear_to_xyz_d65)[:, 1]
