# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of Blender and of Cycles that show with this engine too: what they set is what it renders."""

import bpy

from .engine import CovbeamEngine

#: Of passes and filters that this engine does not have.
_EXCLUDED = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes"}

#: Panels of Cycles for materials, lights and worlds, whose nodes this engine reads, and for motion blur.
_CYCLES = {
    "CYCLES_PT_context_material",
    "CYCLES_MATERIAL_PT_surface",
    "CYCLES_MATERIAL_PT_volume",
    "CYCLES_WORLD_PT_surface",
    "CYCLES_WORLD_PT_volume",
    "CYCLES_LIGHT_PT_light",
    "CYCLES_LIGHT_PT_nodes",
    "CYCLES_LIGHT_PT_beam_shape",
    "CYCLES_RENDER_PT_motion_blur",
    "CYCLES_RENDER_PT_motion_blur_curve",
}

#: Panels whose set of engines we have added to, and those that we have given one of their own.
_joined = []
_replaced = []


def register():
    ours = CovbeamEngine.bl_idname
    for panel in bpy.types.Panel.__subclasses__():
        if panel.__name__ in _CYCLES:
            # Cycles' panels share one set, also with panels that mean nothing here.
            panel.COMPAT_ENGINES = {*panel.COMPAT_ENGINES, ours}
            _replaced.append(panel)
        elif "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()) and panel.__name__ not in _EXCLUDED:
            panel.COMPAT_ENGINES.add(ours)
            _joined.append(panel)


def unregister():
    for panel in _joined:
        panel.COMPAT_ENGINES.discard(CovbeamEngine.bl_idname)
    for panel in _replaced:
        # What it had inherited shows again.
        del panel.COMPAT_ENGINES
    _joined.clear()
    _replaced.clear()
