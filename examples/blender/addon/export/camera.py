# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's camera -> host.scene.Camera."""

from dataclasses import dataclass

import numpy as np

from ..host.scene import Aperture, Camera, Projection
from .copies import pixel_aspect
from .report import Untranslatable


@dataclass(frozen=True)
class Plane:
    """The plane of a picture, see host.scene.Projection, and what of it the picture shows."""

    projection: Projection
    #: (h, v) of its lower left and its upper right corner: float64 (2,).
    low: np.ndarray
    high: np.ndarray
    #: FISHEYE, see host.scene.Camera.
    widest: float = 0.0

    def part(self, low, high):
        """That of the part between two places (2,), which are 0 and 1 at its corners."""
        size = self.high - self.low
        return Plane(self.projection, self.low + low * size, self.low + high * size, self.widest)

    def camera(self, place, width, height, border=None, **others):
        """A host.scene.Camera with that plane.

        - place: position, right, up and forward, as `axes` gives them; others: more of its fields.
        - width, height: pixels of the picture; border: its part that is rendered, as `frame` gives it, or None for all of it.
        """
        step = (self.high - self.low) / (width, height)
        left, top, right, bottom = border or (0, 0, width, height)
        return Camera(
            *place,
            left=float(self.low[0] + left * step[0]),
            top=float(self.high[1] - top * step[1]),
            step=(float(step[0]), float(step[1])),
            width=right - left,
            height=bottom - top,
            projection=self.projection,
            widest=self.widest,
            **others,
        )


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

    Raises Untranslatable if there is no camera, or none that can be rendered.
    """
    if camera_object is None:
        raise Untranslatable("The scene has no camera. Add one, and make it the active camera of the scene.")
    if camera_object.type != "CAMERA":
        raise Untranslatable(f'Object "{camera_object.name}" is no camera. Make a camera the active one of the scene.')
    evaluated = camera_object.evaluated_get(depsgraph)
    data = evaluated.data
    plane = flat(frame_matrix(depsgraph, evaluated, width, height)) if data.type in {"PERSP", "ORTHO"} else panorama(evaluated)
    place = axes(np.array(evaluated.matrix_world, np.float64))
    lens = aperture(data, depsgraph, place)
    # Cycles' rays begin there too: without, fog is 1 % darker at the default of 0.1 m.
    return plane.camera(place, width, height, border, near=data.clip_start, aperture=lens)


def frame_matrix(depsgraph, evaluated, width, height):
    """Blender's projection (4, 4) of a camera for pictures of width x height pixels; of a panorama that of its frame in the viewport."""
    scale_x, scale_y = pixel_aspect(depsgraph.scene_eval)
    return np.array(evaluated.calc_matrix_camera(depsgraph, x=width, y=height, scale_x=scale_x, scale_y=scale_y), np.float64)


def flat(projection):
    """The Plane of a perspective or an orthographic projection (4, 4) of Blender's."""
    # What is at (x, y, z) of camera space appears at the first two of projection @ (x, y, z, 1) over the last, where -1 to 1 spans the
    # picture: over -z in perspective, which forward is at -1 of; over 1 in an orthographic one.
    is_orthographic = projection[3, 3] != 0
    scale, shift = np.diag(projection)[:2], -projection[:2, 3] if is_orthographic else projection[:2, 2]
    kind = Projection.ORTHOGRAPHIC if is_orthographic else Projection.PERSPECTIVE
    return Plane(kind, (shift - 1) / scale, (shift + 1) / scale)


def panorama(camera_object):
    """The Plane of a panoramic camera of Cycles'. Raises Untranslatable if it is of another kind than those of `Projection`."""
    data, name = camera_object.data, camera_object.name
    if data.type != "PANO":
        raise Untranslatable(
            f'Camera "{name}" is {data.type.lower()}, which covbeam cannot render. Set its Type to Perspective, Orthographic or Panoramic '
            "in the camera's Lens panel."
        )
    # Cycles shifts panoramas by shares of both sides.
    shift = np.array([data.shift_x, data.shift_y])
    if data.panorama_type == "EQUIRECTANGULAR":
        low, high = ((data.longitude_min, data.latitude_min), (data.longitude_max, data.latitude_max))
        plane = Plane(Projection.EQUIRECTANGULAR, np.array(low), np.array(high))
        if (plane.high <= plane.low).any():
            raise Untranslatable(f'Camera "{name}" shows nothing: raise the Max of its Latitude and Longitude above the Min.')
        return plane.part(shift, 1 + shift)
    if data.panorama_type == "FISHEYE_EQUIDISTANT":
        widest = data.fisheye_fov / 2
        # One of a full turn is a little wider in single precision.
        if widest > np.pi * (1 + 1e-6):
            raise Untranslatable(f'Camera "{name}" sees more than all around: set its Field of View to 360 degrees or less.')
        return Plane(Projection.FISHEYE, np.full(2, -widest), np.full(2, widest), min(widest, np.pi)).part(shift, 1 + shift)
    kind = data.bl_rna.properties["panorama_type"].enum_items[data.panorama_type].name
    raise Untranslatable(
        f'Camera "{name}" is a panorama of the type {kind}, which covbeam cannot render. Set its Panorama Type to Equirectangular or '
        "Fisheye Equidistant in the camera's Lens panel."
    )


def axes(matrix):
    """Position, and unit vectors to the right, up and forward, of a camera with that transform (4, 4)."""
    x_axis, y_axis, z_axis, position = matrix[:3].T
    forward = -z_axis / np.linalg.norm(z_axis)
    right = _unit_across(x_axis, forward)
    # Scale does not change a camera, but a mirrored one stays mirrored.
    up = np.cross(right, forward)
    up *= 1.0 if up @ y_axis > 0 else -1.0
    return position, right, up, forward


def aperture(data, depsgraph, place):
    """The opening of the lens that Cycles has for a camera's evaluated data, or None without depth of field. place: as `axes` gives it."""
    dof = data.dof
    if not dof.use_dof:
        return None
    position, _, _, forward = place
    focus = dof.focus_distance
    if dof.focus_object is not None:
        matrix = np.array(dof.focus_object.evaluated_get(depsgraph).matrix_world, np.float64)
        bone = dof.focus_object.pose and dof.focus_object.pose.bones.get(dof.focus_subtarget)
        if bone:
            matrix = matrix @ np.array(bone.matrix, np.float64)
        focus = abs((matrix[:3, 3] - position) @ forward)
    # Parallel rays have no focal length; there Cycles counts with 1 m.
    length = 1.0 if data.type == "ORTHO" else data.lens * 1e-3
    radius = length / (2 * max(dof.aperture_fstop, 1e-5))
    if not (radius > 0 and focus > 0):
        return None
    return Aperture(radius, float(focus), dof.aperture_blades, dof.aperture_rotation, max(dof.aperture_ratio, 1e-3))


def _unit_across(vector, axis):
    """The unit vector along what of `vector` is orthogonal to `axis`."""
    across = vector - (vector @ axis) * axis
    return across / np.linalg.norm(across)
