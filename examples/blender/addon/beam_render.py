# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a scene's fog light with covbeam into EXR files, while the scene itself stays one for Cycles.

A copy of the scene shares all objects, but has covbeam as its engine and its own output settings. Blender renders it
as it renders anything: modifiers and visibility are those for rendering, and in its interface the progress, Esc and the
render window are the usual ones.
"""

import os
import tempfile
from dataclasses import dataclass
from time import time

import bpy

from .engine import CovbeamEngine
from .export import copies


@dataclass(frozen=True)
class BeamRender:
    """A render of every step-th frame from first to last of a scene's view layers into a file a frame, by way of a copy.

    view_layers: as `rendered` gives them. begun: in the time of files [s].
    """

    copy: str
    scene: str
    view_layers: tuple[str, ...]
    first: int
    last: int
    step: int
    folder: str
    begun: float

    def path(self, frame):
        return os.path.join(self.folder, f"{_stem(self.view_layers)}_{frame:04}.exr")

    @property
    def frames(self):
        return range(self.first, self.last + 1, self.step)

    def missing(self):
        """Paths of frames that have not been written since the render has begun."""
        paths = map(self.path, self.frames)
        # File systems keep times to 2 s at worst.
        return [path for path in paths if not os.path.isfile(path) or os.path.getmtime(path) < self.begun - 2]


def _stem(view_layers):
    """How names of files begin: with all view layers, as far as names of files are that long."""
    return f"beams_{bpy.path.clean_name('_'.join(view_layers))[:100]}"


def _folder(scene):
    return os.path.abspath(bpy.path.abspath(scene.covbeam.folder))


def folder_problem(scene):
    """Why files cannot be written into the scene's folder, as text for artists, or None. Creates the folder."""
    given = scene.covbeam.folder
    if given.startswith("//") and not bpy.data.filepath:
        return f"The folder {given} is relative to the .blend file, which has not been saved: save it, or set Folder."
    if not given:
        return "There is no folder to write to: set Folder in the panel Light in Fog."
    folder = _folder(scene)
    try:
        os.makedirs(folder, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        return f"Nothing can be written into {folder} ({error.strerror}): set another Folder in the panel Light in Fog."
    return None


def rendered(scene, active):
    """Names of the scene's view layers that F12 renders, the artist's active one first if it is among them: tuple."""
    if scene.render.use_single_layer and not bpy.app.background:
        return (active.name,)
    names = [layer.name for layer in scene.view_layers if layer.use]
    return tuple(sorted(names, key=lambda name: name != active.name))


def begin(scene, active, animation):
    """Makes the copy that is rendered. active: the artist's ViewLayer."""
    discard()
    first, last = (scene.frame_start, scene.frame_end) if animation else (scene.frame_current, scene.frame_current)
    folder = _folder(scene)
    view_layers = rendered(scene, active)
    step = scene.frame_step if animation else 1
    copy = scene.copy()
    if copy.rigidbody_world is not None:
        # Of the simulation it has what was played, which as its own cache Blender would throw away.
        with bpy.context.temp_override(scene=copy, point_cache=copy.rigidbody_world.point_cache):
            bpy.ops.ptcache.bake_from_cache()
        # In the frame after its first one a simulation is built. Bodies are shared: the copy would take them away from the scene's own
        # simulation, and Blender crash when that goes on.
        copy.rigidbody_world.point_cache.frame_start -= 10_000
    copy.name = f"{scene.name} (beams)"
    copy[copies.MARK] = scene.render.pixel_aspect_x, scene.render.pixel_aspect_y
    copy.render.pixel_aspect_x = copy.render.pixel_aspect_y = 1.0
    copy.covbeam.beyond = False
    copy.frame_start, copy.frame_end = first, last
    copy.frame_step = step
    for layer in copy.view_layers:
        layer.use = layer.name in view_layers
    render = copy.render
    render.engine = CovbeamEngine.bl_idname
    render.use_single_layer = False
    render.use_compositing = False
    render.use_sequencer = False
    render.use_freestyle = False
    render.use_overwrite = True
    render.use_placeholder = False
    render.use_file_extension = True
    render.filepath = os.path.join(folder, f"{_stem(view_layers)}_####")
    output = render.image_settings
    if bpy.app.version >= (5, 0, 0):
        output.media_type = "MULTI_LAYER_IMAGE"
    output.file_format = "OPEN_EXR_MULTILAYER"
    output.color_depth = "32"
    return BeamRender(copy.name, scene.name, view_layers, first, last, step, folder, time())


def render(beams, *context):
    """Renders the copy; `context` as of Blender's operators. Raises RuntimeError with what Blender reports."""
    # A still is an animation of one frame: Blender then puts the frame's number into the name.
    bpy.ops.render.render(*context, animation=True, scene=beams.copy)


def discard():
    """Removes the copy, and any that an undo has left behind."""
    for scene in [scene for scene in bpy.data.scenes if copies.MARK in scene]:
        bpy.data.scenes.remove(scene)
