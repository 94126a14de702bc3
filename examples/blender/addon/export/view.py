# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's 3D viewport looks through -> host.scene.Camera."""

import numpy as np

from ..host.scene import Camera
from .camera import aperture, axes, tangents
from .report import Untranslatable


def view(depsgraph, space, region, region_3d):
    """The host's camera for all pixels of a viewport.

    - space, region, region_3d: SpaceView3D, its Region, and RegionView3D of that: `context.space_data`, `region`, `region_data`.

    Raises Untranslatable if there is no perspective.
    """
    looks_through = region_3d.view_perspective == "CAMERA"
    camera_object = (space.camera if space.use_local_camera else depsgraph.scene_eval.camera) if looks_through else None
    # Through lamps and other objects one can look too.
    data = None
    if camera_object is not None and camera_object.type == "CAMERA":
        data = camera_object.evaluated_get(depsgraph).data
    if data is not None and data.type == "PANO":
        raise Untranslatable(f'Camera "{camera_object.name}" is panoramic, which covbeam cannot render.')
    projection = np.array(region_3d.window_matrix, np.float64)
    if projection[3, 3] != 0:
        remedy = "set the camera's Type to Perspective" if data is not None else "press Numpad 5 for a perspective one"
        raise Untranslatable(f"This is an orthographic view, which covbeam cannot render: {remedy}.")
    # Zoom and offset of a camera view, its shift, and its pixels' shape are in the projection.
    corner, step = tangents(projection, region.width, region.height)
    position, right, up, forward = axes(np.linalg.inv(np.array(region_3d.view_matrix, np.float64)))
    return Camera(
        position=position,
        right=right,
        up=up,
        forward=forward,
        left=corner[0],
        top=corner[1],
        step=step,
        width=region.width,
        height=region.height,
        near=float(projection[2, 3] / (projection[2, 2] - 1)),
        aperture=None if data is None else aperture(data, depsgraph, position, forward),
    )
