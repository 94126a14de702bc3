# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of objects that change how Cycles renders them: what the host honours, and what it does not, which is reported."""

import bpy
from covbeam.session import Rays

#: By a setting of objects that is off: what does not see them, and how a person says that.
_RAYS = {
    "visible_camera": (Rays.CAMERA, "hidden from the camera"),
    "visible_diffuse": (Rays.DIFFUSE, "hidden from diffuse rays"),
    "visible_glossy": (Rays.GLOSSY, "hidden from glossy rays"),
    "visible_transmission": (Rays.TRANSMISSION, "hidden from transmission rays"),
    "visible_volume_scatter": (Rays.VOLUME, "hidden from volume scatter rays"),
    "visible_shadow": (Rays.SHADOW, "casts no shadow"),
}

#: Rays from which Cycles hides lamps and what shines only. Before Blender 5.0 volume scatter rays see all else.
_LAMPS_ONLY = Rays(0) if bpy.app.version >= (5, 0) else Rays.VOLUME

#: Rays from which the host hides fog as Cycles does. Before Blender 5.0 shadow rays that start in it see it all the same.
_FOG = Rays.CAMERA | Rays.SHADOW if bpy.app.version >= (5, 0) else Rays.CAMERA

#: Types of objects that have no triangles.
_LEFT_OUT = {
    "CURVE": None,
    "GPENCIL": "grease pencil",
    "GREASEPENCIL": "grease pencil",
}


def note_left_out(thing, report):
    """Reports an object of a type that has no triangles, if Cycles would render it."""
    name = _LEFT_OUT.get(thing.type)
    if name is not None:
        report.add(f'Object "{thing.name}"', name, "left out", in_fog=True)


def hidden_from(thing, maker, view_layer):
    """The Rays that do not see an evaluated object. maker: what makes it, if it is an instance: what that is hidden from, it is hidden from."""
    each = [thing] if maker is None else [thing, maker]
    rays = sum({rays for name, (rays, _) in _RAYS.items() if not all(getattr(one, name) for one in each)})
    return rays | Rays.CAMERA if each[-1].indirect_only_get(view_layer=view_layer) else Rays(rays)


def of_objects(hidden):
    """Of the Rays that do not see something those that do not see it as an object, whatever it shines."""
    return hidden & ~_LAMPS_ONLY


def note_fog_flags(name, hidden, is_catcher, report):
    """Reports of a filled object what it is hidden from, of which the host heeds some only, and that it is a shadow catcher. hidden: Rays."""
    if is_catcher:
        report.add(f'Object "{name}"', "fog that is a shadow catcher", "seen as any other fog", in_fog=True)
    for rays, what in _RAYS.values():
        if rays & of_objects(hidden) & ~_FOG:
            report.add(f'Object "{name}"', "fog that " + what.replace("hidden", "is hidden"), "they see it", in_fog=True)


def note_mesh_flags(thing, report):
    """Reports settings of an evaluated object that has triangles, or is a volume."""
    source = f'Object "{thing.name}"'
    if is_diced(thing):
        report.add(source, "adaptive subdivision", "as subdivided as the levels of the modifier say", in_fog=True)


def is_diced(thing):
    """Whether Cycles cuts an evaluated object's mesh as finely as the picture shows."""
    # Before Blender 5.0 it was a setting of the object's for Cycles, since then it is one of the modifier's.
    # Instances are Blender's for a moment: settings of Python's asked of one would never be freed.
    settings = [getattr(thing.original, "cycles", None), *thing.modifiers]
    return any(getattr(s, "use_adaptive_subdivision", False) for s in settings)


def note_light_flags(thing, report):
    """Reports settings of an evaluated light object, and of its light, that have nothing to do with its strength."""
    source = f'Light "{thing.name}"'
    lamp = thing.data
    if not lamp.use_shadow:
        report.add(source, "Cast Shadow is off", "it casts shadows, and fog dims it", in_fog=True)


#: Max Bounces of lamps and worlds that limit nothing.
_ANY = 1024


def bounces_of(owner):
    """Max Bounces of an evaluated light or world; None: any, as without Cycles."""
    most = owner.cycles.max_bounces if hasattr(owner, "cycles") else _ANY
    return most if most < _ANY else None
