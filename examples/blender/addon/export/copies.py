# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of scenes, of which Add Beams renders one: what a copy lacks of its scene, the shape of pixels and simulated rigid bodies.

Blender cannot write layers whose pixels are not square, so that a copy's are. And simulations of rigid bodies belong to one scene: where
these are is read from the scene itself, before its copy is rendered.
"""

import numpy as np

#: Custom property of copies: width and height of the scene's pixels.
MARK = "covbeam_copy"

#: The scene that is copied, frame by frame: {time [frames]: {pointer of an object: its transform, float64 (4, 4)}}.
_places = {}


def pixel_aspect(scene):
    """Width and height of the pixels that a scene, evaluated or not, is seen in; of a copy those of what it is a copy of."""
    return tuple(scene[MARK]) if MARK in scene else (scene.render.pixel_aspect_x, scene.render.pixel_aspect_y)


def note_places(scene, view_layers, times):
    """Keeps where all objects of a scene are at `times` [frames], for its copy; the scene is played if these are others than the current one.

    Rigid bodies are where the scene's simulation, baked, played or just run, has them.
    """
    forget_places()
    now = scene.frame_current, scene.frame_subframe
    for view_layer in view_layers:
        # So that there is something evaluated of those that no window shows.
        view_layer.update()
    is_still = list(times) == [sum(now)]
    for time in times:
        # What the artist has changed at the current frame stays so.
        if not is_still:
            scene.frame_set(int(np.floor(time)), subframe=time - np.floor(time))
        things = [thing for view_layer in view_layers for thing in view_layer.depsgraph.objects]
        _places[_key(time)] = {thing.original.as_pointer(): np.array(thing.matrix_world, np.float64) for thing in things}
    if not is_still:
        scene.frame_set(now[0], subframe=now[1])


def forget_places():
    _places.clear()


def transform(depsgraph, thing):
    """The transform of an evaluated object in the world, float64 (4, 4), also where it is a rigid body."""
    own = np.array(thing.matrix_world, np.float64)
    return _noted(depsgraph).get(thing.original.as_pointer(), own)


def instance_transform(depsgraph, instance):
    """The same of an instance of a depsgraph, which moves with the object that makes it."""
    own = np.array(instance.matrix_world, np.float64)
    noted = _noted(depsgraph)
    if not noted:
        return own
    if not instance.is_instance:
        return transform(depsgraph, instance.object)
    maker = instance.parent
    copied = np.array(maker.matrix_world, np.float64)
    there = noted.get(maker.original.as_pointer(), copied)
    if np.array_equal(there, copied) or np.linalg.det(copied) == 0:
        return own
    return there @ np.linalg.inv(copied) @ own


def _noted(depsgraph):
    scene = depsgraph.scene_eval
    return _places.get(_key(scene.frame_current + scene.frame_subframe), {}) if MARK in scene else {}


def _key(time):
    """Times that Blender has in single precision, made equal."""
    return round(time, 3)
