# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels in the render properties: settings, adding beams to Cycles, threads and pixels, and the report."""

import bpy

from . import caustics, compositor, latest, requirements, text
from .add_beams import COVBEAM_OT_add_beams, COVBEAM_OT_remove_beams, COVBEAM_OT_replace_fog
from .engine import CovbeamEngine
from .presets import COVBEAM_OT_preset, Preset


class _RenderPanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


def _column(layout):
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout.column()


def _draw_problem(layout):
    """Says what keeps the add-on from working; whether there is anything."""
    problem = requirements.found()
    if problem is not None:
        text.draw(layout, problem, icon="ERROR")
    return problem is not None


def _draw_sampling(layout, settings):
    row = layout.row(align=True)
    for preset in Preset:
        row.operator(COVBEAM_OT_preset.bl_idname, text=preset.label).preset = preset.name
    column = _column(layout)
    column.prop(settings, "passes")
    column.prop(settings, "time_limit")
    column.prop(settings, "photons")
    column.prop(settings, "quality")


def _draw_advanced(layout, settings):
    column = _column(layout)
    column.prop(settings, "grid")
    column.prop(settings, "radius")
    column.prop(settings, "orders")
    column.prop(settings, "bounces")
    column.prop(settings, "beyond")
    column.prop(settings, "seed")
    column.prop(settings, "animate_seed")


class COVBEAM_PT_sampling(_RenderPanel, bpy.types.Panel):
    bl_label = "Light in Fog"
    COMPAT_ENGINES = {CovbeamEngine.bl_idname}

    def draw(self, context):
        if not _draw_problem(self.layout):
            _draw_sampling(self.layout, context.scene.covbeam)


class COVBEAM_PT_beams(_RenderPanel, bpy.types.Panel):
    bl_label = "Light in Fog (Covbeam)"
    bl_options = {"DEFAULT_CLOSED"}
    COMPAT_ENGINES = {"CYCLES"}

    def draw(self, context):
        if _draw_problem(self.layout):
            return
        settings = context.scene.covbeam
        _draw_sampling(self.layout, settings)
        self.layout.prop(settings, "folder")
        text.draw(self.layout, caustics.hint(context.scene), icon="INFO")
        column = self.layout.column(align=True)
        row = column.row(align=True)
        row.operator(COVBEAM_OT_add_beams.bl_idname, text="Add Beams", icon="LIGHT_SUN").animation = False
        row.operator(COVBEAM_OT_add_beams.bl_idname, text="Animation", icon="RENDER_ANIMATION").animation = True
        if COVBEAM_OT_replace_fog.poll(context):
            column.operator(COVBEAM_OT_replace_fog.bl_idname, icon="ERROR")
        column.operator(COVBEAM_OT_remove_beams.bl_idname, icon="X")
        for words in compositor.missing_files(context.scene):
            text.draw(self.layout, words, icon="ERROR")


class COVBEAM_PT_advanced(_RenderPanel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_parent_id = "COVBEAM_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}
    COMPAT_ENGINES = {CovbeamEngine.bl_idname}

    def draw(self, context):
        _draw_advanced(self.layout, context.scene.covbeam)


class COVBEAM_PT_beams_advanced(_RenderPanel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_parent_id = "COVBEAM_PT_beams"
    bl_options = {"DEFAULT_CLOSED"}
    COMPAT_ENGINES = {"CYCLES"}

    def draw(self, context):
        _draw_advanced(self.layout, context.scene.covbeam)


class COVBEAM_PT_performance(_RenderPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_parent_id = "COVBEAM_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}
    COMPAT_ENGINES = {CovbeamEngine.bl_idname}

    def draw(self, context):
        # Blender shows them in panels of its own engines only.
        render = context.scene.render
        column = _column(self.layout)
        column.prop(render, "threads_mode")
        fixed = column.column()
        fixed.enabled = render.threads_mode == "FIXED"
        fixed.prop(render, "threads")
        column.prop(render, "preview_pixel_size", text="Viewport Pixel Size")


def _draw_report(layout):
    record = latest.get()
    layout.label(text=record.outcome.value, icon="ERROR" if record.outcome == latest.Outcome.FAILED else "INFO")
    if record.title:
        layout.label(text=record.title)
    if record.error:
        text.draw(layout, record.error, icon="ERROR")
    for line in record.figures:
        layout.label(text=line)
    if record.untranslated:
        layout.label(text="Not rendered as Cycles would:")
        for line in record.untranslated:
            text.draw(layout, line, icon="DOT")
    for line in record.advice:
        text.draw(layout, line, icon="INFO")


class COVBEAM_PT_report(_RenderPanel, bpy.types.Panel):
    bl_label = "Report"
    bl_parent_id = "COVBEAM_PT_sampling"
    COMPAT_ENGINES = {CovbeamEngine.bl_idname}

    def draw(self, context):
        _draw_report(self.layout)


class COVBEAM_PT_beams_report(_RenderPanel, bpy.types.Panel):
    bl_label = "Report"
    bl_parent_id = "COVBEAM_PT_beams"
    COMPAT_ENGINES = {"CYCLES"}

    def draw(self, context):
        _draw_report(self.layout)


_CLASSES = (
    COVBEAM_PT_sampling,
    COVBEAM_PT_beams,
    COVBEAM_PT_advanced,
    COVBEAM_PT_beams_advanced,
    COVBEAM_PT_performance,
    COVBEAM_PT_report,
    COVBEAM_PT_beams_report,
)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
