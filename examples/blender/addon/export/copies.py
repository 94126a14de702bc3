# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of scenes, of which Add Beams renders one: the shape of their pixels. Blender cannot write layers whose pixels are not square."""

#: Custom property of copies: width and height of the scene's pixels.
MARK = "covbeam_copy"


def pixel_aspect(scene):
    """Width and height of the pixels that a scene, evaluated or not, is seen in; of a copy those of what it is a copy of."""
    return tuple(scene[MARK]) if MARK in scene else (scene.render.pixel_aspect_x, scene.render.pixel_aspect_y)
