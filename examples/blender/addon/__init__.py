# SPDX-License-Identifier: GPL-3.0-or-later
"""Covbeam in Blender: the light that fog scatters, as a render engine and as a pass for Cycles.

Nothing here imports numpy or covbeam when the add-on is enabled: what is missing is told where an artist looks.
"""

import bpy

from . import add_beams, engine, foreign_panels, missing_files, panels, preferences, presets, requirements, settings

# Blender before 4.2 knows no extensions: this is how it lists the add-on, and with it the message that it is too old.
bl_info = {
    "name": "Covbeam: Light in Fog",
    "blender": (4, 2, 0),
    "category": "Render",
    "description": "Volumetric caustics and light shafts as a pass for Cycles scenes",
}

_MODULES = (settings, presets, engine, add_beams, missing_files, panels, foreign_panels)


def register():
    problem = requirements.check()
    if problem is not None:
        print(f"covbeam: {problem}")
    bpy.utils.register_class(preferences.CovbeamPreferences)
    if not requirements.too_old():
        for module in _MODULES:
            module.register()


def unregister():
    # What an earlier check has kept from being registered is not there; a class says so itself.
    if settings.CovbeamSettings.is_registered:
        for module in reversed(_MODULES):
            module.unregister()
    bpy.utils.unregister_class(preferences.CovbeamPreferences)
    if requirements.check() is None:
        # It is imported with the first render, if there was one.
        from .export import asked_nodes

        asked_nodes.stop()
