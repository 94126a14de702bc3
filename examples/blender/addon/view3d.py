# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine in Blender's 3D viewport, with shading Rendered: when the scene is read, what is told, and what is drawn."""

import traceback
from time import perf_counter

import bpy
import numpy as np

from .budget import Budget
from .drawing import Drawing
from .export.report import Untranslatable
from .export.scene import export_view
from .export.view import view
from .host.session import Session
from .settings import session_settings
from .viewport import SLICE, Viewport

#: A scene that takes longer to read [s] is read once nothing has changed for `_QUIET` [s]: what is moved then moves fluently.
_QUICK, _QUIET = 0.2, 0.4


class View3D:
    """What one viewport needs between the calls of Blender's; nothing in it belongs to Blender."""

    def __init__(self):
        self._viewport = Viewport(Session)
        # The exported scene, or why there is none; and what is told of what it lacks.
        self._scene, self._problem, self._lacking = None, "", ""
        # What the viewport has in it, whether it has been read since it changed, when that was, and how long reading takes.
        self._contents, self._is_read, self._changed, self._reading = None, True, 0.0, 0.0
        # Why this view's session has failed, or empty.
        self._failure = ""
        # The latest Shown, and what draws it; None: black.
        self._shown = self._drawing = None

    def update(self, engine, context, depsgraph):
        """Blender's data have changed: reads them, if that matters here."""
        contents = _contents(depsgraph, context.space_data)
        if contents == self._contents and not _matters(depsgraph):
            return
        self._contents, self._is_read, self._changed = contents, False, perf_counter()
        if self._reading <= _QUICK:
            self._read(depsgraph, context.space_data)
        engine.tag_redraw()

    def draw(self, engine, context, depsgraph):
        """Blender draws the viewport: goes on with its picture for a moment, and draws that."""
        if not self._is_read and perf_counter() - self._changed >= _QUIET:
            self._read(depsgraph, context.space_data)
        told = self._render(context, depsgraph)
        region = context.region
        drawing = self._drawing or Drawing(np.zeros((1, 1, 3)), max(region.width, region.height))
        drawing.draw(engine, depsgraph.scene, region.height)
        engine.update_stats("", f"Covbeam: {told}")
        if not (self._is_read and self._viewport.done):
            engine.tag_redraw()

    def _read(self, depsgraph, space):
        start = perf_counter()
        self._scene, self._problem, self._lacking, self._is_read = None, "", "", True
        try:
            scene, report = export_view(depsgraph, space)
        except Exception as error:
            self._problem = _explained(error)
            return
        finally:
            self._reading = perf_counter() - start
        missing = [what for what, given in (("fog", scene.volumes), ("light", scene.shines)) if not given]
        if missing:
            self._problem = f"there is no {' and no '.join(missing)} here that it can render"
            return
        self._scene = scene
        if report.entries:
            self._lacking = f"; not all is as in Cycles, see the Report of a render ({len(report.entries)})"

    def _render(self, context, depsgraph):
        """Goes on with the picture; returns what is to be told."""
        # Settings of ours are not copied to the evaluated scene before that is evaluated for another reason.
        scene, problem = depsgraph.scene, self._problem
        if not problem:
            try:
                camera = view(depsgraph, context.space_data, context.region, context.region_data)
            except Untranslatable as error:
                problem = str(error)
        budget = Budget(scene.covbeam.passes, scene.covbeam.time_limit)
        is_new = self._viewport.update(None if problem else self._scene, session_settings(scene), budget)
        if problem:
            self._drawing = None
            return problem
        pixel = _pixel(scene.render, context.preferences.system)
        if self._viewport.view(camera, pixel) or is_new:
            self._failure = ""
        try:
            shown = self._viewport.step(SLICE)
        except Exception as error:
            self._failure = _explained(error)
        if self._failure:
            self._drawing = None
            return self._failure
        if shown is not None:
            self._shown, self._drawing = shown, Drawing(shown.picture.in_scattered, shown.pixel)
        factor = self._shown.pixel // pixel
        size = f" at 1/{factor} of the resolution" if factor > 1 else ""
        return f"{self._shown.passes} of {budget.passes} passes{size}{self._lacking}"


def _contents(depsgraph, space):
    """What a viewport has in it, to be compared: objects by their numbers, and whether they show."""
    objects = tuple((thing.session_uid, thing.visible_in_viewport_get(space)) for thing in depsgraph.objects)
    return depsgraph.scene.session_uid, depsgraph.view_layer.name, objects


def _matters(depsgraph):
    """Whether any of its updates changes what is read. Selecting has none of the three; and cameras are looked at as they draw."""
    return any(
        (update.is_updated_geometry or update.is_updated_transform or update.is_updated_shading)
        and getattr(update.id, "type", None) != "CAMERA"
        and not isinstance(update.id, bpy.types.Camera)
        for update in depsgraph.updates
    )


def _pixel(render, system):
    """How many pixels along each side Blender's Pixel Size makes one."""
    if render.preview_pixel_size == "AUTO":
        # As Blender does for its other engines, on screens of high resolution.
        return 2 if system.pixel_size > 1.5 else 1
    return int(render.preview_pixel_size)


def _explained(error):
    """What artists are told of an exception."""
    if isinstance(error, Untranslatable):
        return str(error)
    if isinstance(error, MemoryError):
        return "there is not enough memory: choose a smaller grid or larger pixels"
    # Whatever it is, Blender goes on; the console has where it came from.
    traceback.print_exc()
    return str(error) or type(error).__name__
