# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's page in Blender's preferences: whether it can work, and which versions it uses."""

import bpy

from . import requirements, text


class CovbeamPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    def draw(self, context):
        problem = requirements.check()
        if problem is not None:
            text.draw(self.layout, problem, icon="ERROR", width=90)
            return
        import covbeam

        text.draw(self.layout, f"Ready: covbeam {covbeam.__version__}.", icon="CHECKMARK", width=90)
        text.draw(
            self.layout,
            "Choose Covbeam as the render engine, or keep Cycles and open Light in Fog in the render properties.",
            width=90,
        )
