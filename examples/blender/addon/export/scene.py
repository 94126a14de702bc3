# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole evaluated scene -> host.scene.Scene."""

import covbeam_rays
import numpy as np

from ..host import Cancelled
from ..host.scene import Scene
from .camera import camera, frame
from .materials import world_fog
from .objects import Objects
from .report import Report
from .settings import note_clipping, note_settings
from .sky import sky
from .volumes import Filled, volumes


def export(depsgraph, poll=None):
    """Reads what `depsgraph`, evaluated for a render, has for the scene's active camera and picture.

    - poll: called every 50 ms where that is possible; if it returns False, host.Cancelled is raised.

    Returns a host.scene.Scene, whose geometry is built, and a Report. Raises report.Untranslatable.
    """
    report = Report()
    camera_object = depsgraph.scene_eval.camera
    eye = camera(depsgraph, camera_object, *frame(depsgraph.scene_eval.render))
    note_settings(depsgraph, camera_object, report)
    objects = Objects(depsgraph, report, poll)
    world = depsgraph.view_layer_eval.world_override or depsgraph.scene_eval.world
    filled, world_volume = objects.filled, -1
    fog = world_fog(world, report)
    lights = list(objects.lights)
    # Fog without end lets nothing through from infinitely far away.
    background = sky(world, report) if fog is None else None
    if background is not None:
        lights.append(background)
    if fog is not None:
        world_volume = len(filled)
        filled.append(Filled(world.name, fog, np.full(3, -np.inf), np.full(3, np.inf)))
    try:
        objects.geometry.build(poll)
    except covbeam_rays.Cancelled:
        raise Cancelled from None
    note_clipping(depsgraph, camera_object, eye, objects.geometry.bounds, fog, report)
    scene = Scene(
        geometry=objects.geometry,
        materials=objects.materials,
        object_volumes=np.array(objects.object_volumes, np.int32),
        object_closed=np.array(objects.object_closed, bool),
        volumes=volumes(filled, report, poll),
        world_volume=world_volume,
        lights=lights,
        camera=eye,
    )
    return scene, report
