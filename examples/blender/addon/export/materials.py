# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's materials and world -> rows of host.scene.MATERIAL, emission and fog."""

from dataclasses import dataclass

import bpy
import numpy as np

from .lobes import Lobes
from .nodes import Values, follow
from .surfaces import add_surface
from .volumes import Fog, fog


@dataclass(frozen=True)
class Translated:
    """A material."""

    name: str
    #: One element of host.scene.MATERIAL.
    row: np.ndarray
    #: Radiance of both sides [W/(m^2 sr)], float64 (3,).
    emission: np.ndarray
    fog: Fog | None


def has_nodes(block):
    """Whether a material or world is described by nodes. From Blender 5.0 on they all are."""
    return block.node_tree is not None and (bpy.app.version >= (5, 0) or block.use_nodes)


def translate(material, report):
    """A bpy.types.Material, or None for what Cycles shows where there is none, as Translated."""
    lobes = Lobes()
    if material is None:
        lobes.add(diffuse=0.8)
        if bpy.app.version >= (5, 0):
            # A Principled BSDF as it is when it is added; a Diffuse BSDF before.
            lobes.add_specular(1.5, 0.5, coat=1.0)
        return Translated("no material", lobes.row(lambda *_: None), lobes.emission, None)
    values = Values(f'Material "{material.name}"', report)
    if not has_nodes(material):
        lobes.add(diffuse=np.array(material.diffuse_color[:3], np.float64))
        return Translated(material.name, lobes.row(values.note), lobes.emission, None)
    # None: nothing in it, black.
    output = material.node_tree.get_output_node("CYCLES")
    inside = None
    if output is not None:
        inside = fog(values, output.inputs["Volume"], may_vary=True)
        if not leads_somewhere(output.inputs["Surface"]) and leads_somewhere(output.inputs["Volume"]):
            lobes.add(transparent=1.0)
        add_surface(values, output.inputs["Surface"], (), 1.0, lobes)
        _note_displacement(values, material, output)
        if lobes.weights["transparent"].any() and not material.use_transparent_shadow:
            values.note("Transparent Shadows is off", "light passes what is transparent")
    return Translated(material.name, lobes.row(values.note), lobes.emission, inside)


def leads_somewhere(socket):
    """Whether a shader is linked to this input."""
    return follow(socket).node is not None


def _note_displacement(values, material, output):
    if not leads_somewhere(output.inputs["Displacement"]):
        return
    if material.displacement_method == "BUMP":
        values.note("bump or normal map", "ignored")
    else:
        values.note("displacement", "the surface stays where it is; use a Displace modifier instead")


def world_fog(world, report):
    """The Fog that fills the world, or None."""
    if world is None or not has_nodes(world):
        return None
    output = world.node_tree.get_output_node("CYCLES")
    if output is None:
        return None
    return fog(Values(f'World "{world.name}"', report), output.inputs["Volume"])
