# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for a window with a 3D viewport, which neither the bpy package nor Blender in background open: Blender's calls are made with
its own data, but with a small region, and what is drawn goes into a texture. The GPU, or what stands in for one, is Blender's."""

from types import SimpleNamespace

import bpy
import gpu
import harness
import numpy as np
from mathutils import Matrix

from addon.engine import CovbeamEngine


def viewport():
    """The first 3D viewport of Blender's first window: SpaceView3D, its Region, and RegionView3D of that."""
    area = next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")
    return area.spaces[0], next(region for region in area.regions if region.type == "WINDOW"), area.spaces[0].region_3d


class Engine:
    """Stands in for what Blender makes of CovbeamEngine for a viewport. told: texts, in order; redraws: how many were asked for."""

    view3d = None

    def __init__(self):
        self.told, self.redraws, self.bound = [], 0, []

    def update_stats(self, stats, info):
        self.told.append(stats + info)

    def tag_redraw(self):
        self.redraws += 1

    def bind_display_space_shader(self, scene):
        assert isinstance(scene, bpy.types.Scene)
        self.bound.append(True)

    def unbind_display_space_shader(self):
        self.bound.append(False)


class Window:
    """A viewport of that many pixels, open until `close`; seen: what stands in for its RegionView3D."""

    def __init__(self, width, height):
        harness.start_gpu()
        space, _, region_3d = viewport()
        self.seen = SimpleNamespace(
            view_perspective=region_3d.view_perspective,
            window_matrix=region_3d.window_matrix.copy(),
            view_matrix=region_3d.view_matrix.copy(),
        )
        self.region = SimpleNamespace(width=width, height=height)
        self.context = SimpleNamespace(
            space_data=space, region=self.region, region_data=self.seen, preferences=bpy.context.preferences
        )
        self.engine = Engine()
        self._size = width, height
        self._offscreen = gpu.types.GPUOffScreen(width, height, format="RGBA32F")
        bpy.app.handlers.depsgraph_update_post.append(self._updated)
        self._updated(bpy.context.scene, bpy.context.evaluated_depsgraph_get())

    def close(self):
        """As Blender lets go of an engine with its viewport."""
        bpy.app.handlers.depsgraph_update_post.remove(self._updated)
        self.engine = None
        self._offscreen.free()

    def _updated(self, scene, depsgraph):
        CovbeamEngine.view_update(self.engine, self.context, depsgraph)

    def draw(self):
        """What the viewport shows then: (height, width, 4), rows from the top."""
        width, height = self._size
        with self._offscreen.bind():
            framebuffer = gpu.state.active_framebuffer_get()
            framebuffer.clear(color=(0.5, 0.5, 0.5, 0.5))
            with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
                # As Blender does for regions: a unit is a pixel, from the lower left corner.
                gpu.matrix.load_matrix(Matrix.Identity(4))
                gpu.matrix.load_projection_matrix(Matrix(((2 / width, 0, 0, -1), (0, 2 / height, 0, -1), (0, 0, -1, 0), (0, 0, 0, 1))))
                CovbeamEngine.view_draw(self.engine, self.context, bpy.context.evaluated_depsgraph_get())
            assert gpu.state.blend_get() == "NONE"
            pixels = framebuffer.read_color(0, 0, width, height, 4, 0, "FLOAT")
        return np.array(pixels.to_list(), np.float32).reshape(height, width, 4)[::-1]

    def finish(self):
        """Draws as long as it is asked to; the last picture."""
        while True:
            before = self.engine.redraws
            shown = self.draw()
            if self.engine.redraws == before:
                return shown
