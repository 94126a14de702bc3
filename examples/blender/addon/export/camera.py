# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's camera -> host.scene.Camera."""

import numpy as np

from ..host.scene import Aperture, Camera
from .report import Untranslatable


def frame(render):
    """The pixels that `render`, a scene's RenderSettings, asks for.

    Returns width and height of the whole picture, and the part of it to render: (left, top, right, bottom) in pixels
    from the upper left corner, the last two exclusive. That is the render border, cropped to it or not, or all of it.
    """
    width = max(render.resolution_x * render.resolution_percentage // 100, 1)
    height = max(render.resolution_y * render.resolution_percentage // 100, 1)
    if not render.use_border:
        return width, height, (0, 0, width, height)
    # In single precision and cut off, as Blender does it.
    left, right = (int(np.float32(x) * np.float32(width)) for x in (render.border_min_x, render.border_max_x))
    low, high = (int(np.float32(y) * np.float32(height)) for y in (render.border_min_y, render.border_max_y))
    return width, height, (left, height - high, max(right, left + 1), max(height - low, height - high + 1))


def camera(depsgraph, camera_object, width, height, border):
    """The host's camera for the part `border` (as `frame` gives it) of a picture of width x height pixels.

    Raises Untranslatable if there is no camera, or none with a perspective.
    """
    if camera_object is None:
        raise Untranslatable("The scene has no camera. Add one, and make it the active camera of the scene.")
    if camera_object.type != "CAMERA":
        raise Untranslatable(f'Object "{camera_object.name}" is no camera. Make a camera the active one of the scene.')
    evaluated = camera_object.evaluated_get(depsgraph)
    if evaluated.data.type != "PERSP":
        kind = {"ORTHO": "orthographic", "PANO": "panoramic"}.get(evaluated.data.type, evaluated.data.type.lower())
        raise Untranslatable(
            f'Camera "{camera_object.name}" is {kind}, which covbeam cannot render. Set its Type to Perspective in the '
            "camera's Lens panel."
        )
    render = depsgraph.scene_eval.render
    projection = np.array(
        evaluated.calc_matrix_camera(
            depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y
        ),
        np.float64,
    )
    corner, step = tangents(projection, width, height)
    position, right, up, forward = axes(np.array(evaluated.matrix_world, np.float64))
    left, top, right_end, bottom = border
    return Camera(
        position=position,
        right=right,
        up=up,
        forward=forward,
        left=corner[0] + left * step[0],
        top=corner[1] - top * step[1],
        step=step,
        width=right_end - left,
        height=bottom - top,
        # Cycles' rays begin here too: without, fog is 1 % darker at the default of 0.1 m.
        near=evaluated.data.clip_start,
        aperture=aperture(evaluated.data, depsgraph, position, forward),
    )


def tangents(projection, width, height):
    """Of a perspective projection (4, 4) of Blender's, as host.scene.Camera has them: those at the upper left corner of its picture, and a
    pixel's if that has so many."""
    # A direction (x, y, -1) of camera space appears at projection[:2, :2] @ (x, y) - projection[:2, 2], where -1 to 1
    # spans the picture.
    scale, shift = np.diag(projection)[:2], projection[:2, 2]
    low, high = (shift - 1) / scale, (shift + 1) / scale
    step = (high - low) / (width, height)
    return (float(low[0]), float(high[1])), (float(step[0]), float(step[1]))


def axes(matrix):
    """Position, and unit vectors to the right, up and forward, of a camera with that transform (4, 4)."""
    x_axis, y_axis, z_axis, position = matrix[:3].T
    forward = -z_axis / np.linalg.norm(z_axis)
    right = _unit_across(x_axis, forward)
    # Scale does not change a camera, but a mirrored one stays mirrored.
    up = np.cross(right, forward)
    up *= 1.0 if up @ y_axis > 0 else -1.0
    return position, right, up, forward


def aperture(data, depsgraph, position, forward):
    """The opening of the lens that Cycles has for a camera's evaluated data, or None without depth of field."""
    dof = data.dof
    if not dof.use_dof:
        return None
    focus = dof.focus_distance
    if dof.focus_object is not None:
        matrix = dof.focus_object.evaluated_get(depsgraph).matrix_world
        bone = dof.focus_object.pose and dof.focus_object.pose.bones.get(dof.focus_subtarget)
        if bone:
            matrix = matrix @ bone.matrix
        focus = abs((np.array(matrix.translation, np.float64) - position) @ forward)
    radius = data.lens * 1e-3 / (2 * max(dof.aperture_fstop, 1e-5))
    if not (radius > 0 and focus > 0):
        return None
    return Aperture(radius, float(focus), dof.aperture_blades, dof.aperture_rotation, max(dof.aperture_ratio, 1e-3))


def _unit_across(vector, axis):
    """The unit vector along what of `vector` is orthogonal to `axis`."""
    across = vector - (vector @ axis) * axis
    return across / np.linalg.norm(across)
