# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole evaluated scene -> host.scene.Scene."""

from dataclasses import replace

import numpy as np

from ..host.scene import Scene
from .camera import camera, frame
from .facts import found, wanted
from .flags import bounces_of
from .materials import world_fog
from .objects import Objects
from .other_blender import polling
from .report import Report
from .settings import exposure, note_clipping, note_settings
from .sky import sky
from .volumes import Filled, volumes


#: A camera farther from the world's origin than this [m] has the scene moved to it: single precision is a centimetre off at a hundred kilometres.
_FAR = 1024.0


def home_of(depsgraph):
    """The place that the scene of a render is moved by, so that it is near the origin, float64 (3,) [m]: 0 unless it is far away."""
    camera_object = depsgraph.scene_eval.camera
    if camera_object is None:
        return np.zeros(3)
    place = np.array(camera_object.matrix_world.translation, np.float64)
    is_far = np.isfinite(place).all() and np.abs(place).max() > _FAR
    return np.round(place) if is_far else np.zeros(3)


def export(depsgraph, poll=None, home=None):
    """Reads what `depsgraph`, evaluated for a render, has for the scene's active camera and picture.

    - poll: called every 50 ms where that is possible; if it returns False, host.Cancelled is raised.
    - home: as of home_of, which is the default; all instants of a picture must have the same.

    Returns a host.scene.Scene, whose geometry is built, and a Report. Raises report.Untranslatable.
    """
    report = Report()
    camera_object = depsgraph.scene_eval.camera
    eye = camera(depsgraph, camera_object, *frame(depsgraph.scene_eval.render))
    home = home_of(depsgraph) if home is None else home
    eye = replace(eye, position=eye.position - home)
    note_settings(depsgraph, camera_object, report)
    with polling(poll):
        scene, fog = _read(depsgraph, lambda thing: not thing.hide_render, report, poll, home)
    note_clipping(depsgraph, camera_object, replace(scene, camera=eye), fog, report)
    return replace(scene, camera=eye), report


def export_view(depsgraph, space):
    """Reads what `depsgraph`, evaluated for a viewport, has for `space`, its SpaceView3D.

    Returns a host.scene.Scene without a camera, whose geometry is built, and a Report.
    """
    report = Report()
    note_settings(depsgraph, None, report)
    scene, _ = _read(depsgraph, lambda thing: thing.visible_in_viewport_get(space), report, None, np.zeros(3))
    return scene, report


def _read(depsgraph, shows, report, poll, home):
    """A host.scene.Scene without a camera, and the world's volumes.Fog or None. shows: whether an evaluated object is there."""
    objects = Objects(depsgraph, shows, report, poll, home)
    world = depsgraph.view_layer_eval.world_override or depsgraph.scene_eval.world
    filled, world_volume = objects.filled, -1
    facts = found(wanted(world.node_tree), None, depsgraph) if world is not None else ()
    fog = world_fog(world, report, facts)
    lights = list(objects.lights)
    # Fog without end lets nothing through from infinitely far away.
    if fog is None:
        # Without a world there is no sky.
        lights += [replace(light, group=world.lightgroup, bounces=bounces_of(world)) for light in sky(world, report, poll, facts)]
    if fog is not None:
        world_volume = len(filled)
        filled.append(Filled(world.name, fog, np.full(3, -np.inf), np.full(3, np.inf)))
    objects.geometry.build(poll)
    scene = Scene(
        geometry=objects.geometry,
        materials=objects.materials,
        object_volumes=np.array(objects.object_volumes, np.int32),
        object_closed=np.array(objects.object_closed, bool),
        object_rules=objects.object_rules,
        volumes=objects.heeded(volumes(filled, report, poll)),
        world_volume=world_volume,
        lights=lights,
        camera=None,
        exposure=exposure(depsgraph.scene_eval),
    )
    return scene, fog
