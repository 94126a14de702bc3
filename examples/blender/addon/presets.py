# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings for a look while one works, for a picture, and for the last one."""

from enum import Enum

import bpy


class Preset(Enum):
    """Name on the button, tool tip, and what is set: passes, time limit [s], accepted blur."""

    DRAFT = ("Draft", "5 s a frame, and rather blurred than noisy", 1024, 5.0, 0.03)
    GOOD = ("Good", "30 s a frame; what a new scene has", 1024, 30.0, 0.01)
    # Of a film, on many computers: each frame has to be the same wherever it is rendered, whatever that takes.
    FINAL = ("Final", "256 passes however long they take, so that the image is the same on each computer", 256, 0.0, 0.01)

    def __init__(self, label, description, passes, time_limit, quality):
        self.label, self.description = label, description
        self.passes, self.time_limit, self.quality = passes, time_limit, quality

    def apply(self, settings):
        """Sets what it stands for, and leaves all else alone."""
        settings.passes, settings.time_limit, settings.quality = self.passes, self.time_limit, self.quality


class COVBEAM_OT_preset(bpy.types.Operator):
    """Set Passes, Time Limit and Accepted Blur"""

    bl_idname = "covbeam.preset"
    bl_label = "Preset"
    bl_options = {"REGISTER", "UNDO"}

    preset: bpy.props.EnumProperty(
        name="Preset",
        description="What the image is for",
        items=[(preset.name, preset.label, preset.description) for preset in Preset],
        default=Preset.GOOD.name,
    )

    @classmethod
    def description(cls, context, properties):
        return Preset[properties.preset].description

    def execute(self, context):
        Preset[self.preset].apply(context.scene.covbeam)
        return {"FINISHED"}


def register():
    bpy.utils.register_class(COVBEAM_OT_preset)


def unregister():
    bpy.utils.unregister_class(COVBEAM_OT_preset)
