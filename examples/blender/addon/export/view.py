# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's 3D viewport looks through -> host.scene.Camera."""

import numpy as np

from ..host.scene import Projection
from .camera import aperture, axes, flat, frame, frame_matrix, panorama


def view(depsgraph, space, region, region_3d):
    """The host's camera for all pixels of a viewport.

    - space, region, region_3d: SpaceView3D, its Region, and RegionView3D of that: `context.space_data`, `region`, `region_data`.

    Raises Untranslatable if it looks through a camera that cannot be rendered.
    """
    looks_through = region_3d.view_perspective == "CAMERA"
    camera_object = (space.camera if space.use_local_camera else depsgraph.scene_eval.camera) if looks_through else None
    # Through lamps and other objects one can look too.
    evaluated = None
    if camera_object is not None and camera_object.type == "CAMERA":
        evaluated = camera_object.evaluated_get(depsgraph)
    # Zoom and offset of a camera view, its shift, and its pixels' shape are in the projection.
    projection = np.array(region_3d.window_matrix, np.float64)
    plane = flat(projection)
    place = position, right, up, forward = axes(np.linalg.inv(np.array(region_3d.view_matrix, np.float64)))
    if evaluated is not None:
        if evaluated.data.type not in {"PERSP", "ORTHO"}:
            plane = _in_frame(plane, depsgraph, evaluated)
        near, lens = evaluated.data.clip_start, aperture(evaluated.data, depsgraph, place)
        return plane.camera(place, region.width, region.height, near=near, aperture=lens)
    # What is at the near plane appears at the depth -1.
    if plane.projection == Projection.PERSPECTIVE:
        near = projection[2, 3] / (projection[2, 2] - 1)
        return plane.camera(place, region.width, region.height, near=float(near))
    # Parallel rays begin as far behind the place that they look from.
    near = (projection[2, 3] + 1) / projection[2, 2]
    return plane.camera((position + near * forward, right, up, forward), region.width, region.height)


def _in_frame(shown, depsgraph, evaluated):
    """The Plane of a panoramic camera for a viewport that shows that perspective: Cycles fills the camera's frame there with its picture."""
    framed = flat(frame_matrix(depsgraph, evaluated, *frame(depsgraph.scene_eval.render)[:2]))
    size = framed.high - framed.low
    return panorama(evaluated).part((shown.low - framed.low) / size, (shown.high - framed.low) / size)
