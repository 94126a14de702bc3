# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's materials and world -> rows of host.scene.MATERIAL, emission and fog."""

from dataclasses import dataclass

import bpy
import numpy as np

from .cutting import COARSE, FINE
from .lobes import Lobes
from .nodes import PROBE, Values, follow
from .report import Report
from .surfaces import add_surface
from .trees import nodes_in
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


def has_surface(material):
    """Whether nodes describe the surface of a bpy.types.Material, and not its fog alone."""
    output = material.node_tree.get_output_node("CYCLES") if has_nodes(material) else None
    return output is not None and leads_somewhere(output.inputs["Surface"])


def translate(material, report, facts=()):
    """A bpy.types.Material, or None for what Cycles shows where there is none, as Translated. facts: as nodes.Values has them."""
    lobes = Lobes()
    if material is None:
        lobes.add(diffuse=0.8)
        if bpy.app.version >= (5, 0):
            # A Principled BSDF as it is when it is added; a Diffuse BSDF before.
            lobes.add_specular(1.5, 0.5, coat=1.0)
        return Translated("no material", lobes.row(lambda *_: None), lobes.emission, None)
    values = Values(f'Material "{material.name}"', report, facts=facts)
    if not has_nodes(material):
        lobes.add(diffuse=np.array(material.diffuse_color[:3], np.float64))
        return Translated(material.name, lobes.row(values.note), lobes.emission, None)
    lobes = _lobes(values, material)
    return Translated(material.name, lobes.row(values.note), lobes.emission, filling(material, report, facts))


def _lobes(values, material):
    """The Lobes of a bpy.types.Material that nodes describe."""
    lobes = Lobes()
    output = material.node_tree.get_output_node("CYCLES")
    # Without one there is nothing in it: black.
    if output is None:
        return lobes
    surface = output.inputs["Surface"]
    if not leads_somewhere(surface) and leads_somewhere(output.inputs["Volume"]):
        lobes.add(transparent=1.0)
        return lobes
    add_surface(values, surface, (), 1.0, lobes)
    lobes.shadow = _shadow(values, material, surface, lobes)
    return lobes


def _shadow(values, material, surface, lobes):
    """What a surface lets through of light on its way from a lamp, as Lobes have it."""
    if not material.use_transparent_shadow:
        return np.zeros(3) if lobes.weights["transparent"].any() else None
    if not any(node.type == "LIGHT_PATH" for node in nodes_in(material.node_tree)):
        return None
    seen = Lobes()
    add_surface(values.for_shadows(), surface, (), 1.0, seen)
    shadow, transparent = seen.weights["transparent"], lobes.weights["transparent"]
    return None if np.array_equal(np.broadcast_to(shadow, np.broadcast_shapes(shadow.shape, transparent.shape)), transparent) else shadow


def patterned(material, facts=()):
    """How finely a bpy.types.Material, or None, is cut: a cutting.Detail, by what textures decide of it; None: it is the same all over. facts: as
    nodes.Values has them."""
    if material is None or not has_nodes(material):
        return None
    values = Values("", Report(), places=PROBE, facts=facts)
    with np.errstate(all="ignore"):
        passing = _lobes(values, material).passing
    if passing.ndim > 1 and (passing != passing[0]).any():
        return FINE
    # Whether textures make any difference the places themselves will tell.
    return COARSE if values.varies else None


def looked_at(material, report, facts=()):
    """The surface of such a material: a function of textures.Places and their number that returns MATERIAL and radiance there."""
    values = Values(f'Material "{material.name}"', report, facts=facts)

    def at(places, count):
        with np.errstate(all="ignore"):
            lobes = _lobes(values.at(places), material)
            return lobes.rows(count, values.note), np.broadcast_to(lobes.emission, (count, 3))

    return at


def filling(material, report, facts=()):
    """The Fog that a bpy.types.Material fills a mesh with, or None."""
    if material is None or not has_nodes(material):
        return None
    output = material.node_tree.get_output_node("CYCLES")
    if output is None:
        return None
    return fog(Values(f'Material "{material.name}"', report, facts=facts), output.inputs["Volume"], may_vary=True)


def leads_somewhere(socket):
    """Whether a shader is linked to this input."""
    return follow(socket).node is not None


def world_fog(world, report, facts=()):
    """The Fog that fills the world, or None."""
    if world is None or not has_nodes(world):
        return None
    output = world.node_tree.get_output_node("CYCLES")
    if output is None:
        return None
    return fog(Values(f'World "{world.name}"', report, facts=facts), output.inputs["Volume"])
