# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of objects that change how Cycles renders them, and that the host does not honour: all reported."""

_RAYS = {
    "visible_camera": "hidden from the camera",
    "visible_diffuse": "hidden from diffuse rays",
    "visible_glossy": "hidden from glossy rays",
    "visible_transmission": "hidden from transmission rays",
}

#: Types of objects that have no triangles.
_LEFT_OUT = {
    "CURVES": "hair curves",
    "CURVE": None,
    "POINTCLOUD": "point cloud",
    "GPENCIL": "grease pencil",
    "GREASEPENCIL": "grease pencil",
}


def note_left_out(thing, report):
    """Reports an object of a type that has no triangles, if Cycles would render it."""
    name = _LEFT_OUT.get(thing.type)
    if name is not None:
        report.add(f'Object "{thing.name}"', name, "left out")


def note_mesh_flags(thing, view_layer, report):
    """Reports settings of an evaluated object that has triangles, or is a volume."""
    source = f'Object "{thing.name}"'
    _note_common(thing, source, report)
    if not thing.visible_shadow:
        report.add(source, "casts no shadow", "it casts shadows")
    if not thing.visible_volume_scatter:
        report.add(source, "hidden from volume scatter rays", "seen by all rays; its own light does not reach fog")
    if thing.is_shadow_catcher:
        report.add(source, "shadow catcher", "an ordinary surface")
    if thing.is_holdout or thing.holdout_get(view_layer=view_layer):
        report.add(source, "holdout", "an ordinary surface")
    if thing.indirect_only_get(view_layer=view_layer):
        report.add(source, "indirect only", "seen by the camera too")
    if _is_diced(thing):
        report.add(source, "adaptive subdivision", "as subdivided as the levels of the modifier say")
    for system in thing.particle_systems:
        if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
            report.add(source, f"hair of particle system {system.name}", "left out")


def _is_diced(thing):
    # Before Blender 5.0 it was a setting of the object's for Cycles, since then it is one of the modifier's.
    # Instances are Blender's for a moment: settings of Python's asked of one would never be freed.
    settings = [getattr(thing.original, "cycles", None), *thing.modifiers]
    return any(getattr(s, "use_adaptive_subdivision", False) for s in settings)


def note_instancer_flags(thing, view_layer, report):
    """Reports settings of an evaluated object that in Cycles hold for the instances that it makes, too."""
    source = f'Object "{thing.name}"'
    hidden = [name for name in (*_RAYS, "visible_shadow", "visible_volume_scatter") if not getattr(thing, name)]
    if hidden or thing.is_shadow_catcher or _is_held_out(thing, view_layer):
        report.add(source, "visibility of all instances", "only that of the objects themselves counts")


def _is_held_out(thing, view_layer):
    masked = thing.holdout_get(view_layer=view_layer) or thing.indirect_only_get(view_layer=view_layer)
    return thing.is_holdout or masked


def note_light_flags(thing, report):
    """Reports settings of an evaluated light object, and of its light, that have nothing to do with its strength."""
    source = f'Light "{thing.name}"'
    lamp = thing.data
    _note_common(thing, source, report)
    if not lamp.use_shadow:
        report.add(source, "Cast Shadow is off", "it casts shadows")
    # Blender without Cycles has no such settings.
    if hasattr(lamp, "cycles") and lamp.cycles.max_bounces < 1024:
        report.add(source, "Max Bounces", "no limit")
    if not thing.visible_volume_scatter:
        report.add(source, "hidden from volume scatter rays", "left out, and what surfaces reflect of it too")


def _note_common(thing, source, report):
    for name, what in _RAYS.items():
        # The camera sees no lights here anyway, only the fog that they light.
        if not getattr(thing, name) and not (thing.type == "LIGHT" and name == "visible_camera"):
            report.add(source, what, "seen by all rays")
    linking = thing.light_linking
    if linking.receiver_collection is not None or linking.blocker_collection is not None:
        report.add(source, "light or shadow linking", "it lights, and is shadowed by, everything")
