# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes ask of the object, instance or view layer that they are used by, rather than of places."""

import re

import bpy
import numpy as np

from .noise import hash_words
from .trees import nodes_in

#: The question where a thing is placed. Its answer is the transform, row by row.
PLACED = "PLACED", ""

#: Words of hashes are up to this.
_WORD = 0xFFFFFFFF


def wanted(tree):
    """What the nodes of a tree, and of groups in it, ask: set of (kind, name), where kind is that of an Attribute node, "INFO" for an
    output of Object Info, or that of PLACED."""
    asked = set()
    for node in nodes_in(tree):
        if node.type == "OBJECT_INFO":
            asked |= {("INFO", output.identifier) for output in node.outputs if output.is_linked}
        elif node.type == "ATTRIBUTE" and node.attribute_type != "GEOMETRY":
            asked.add((node.attribute_type, node.attribute_name))
        elif (node.type == "NEW_GEOMETRY" and node.outputs["Position"].is_linked) or (node.type == "TEX_COORD" and node.object is not None):
            asked.add(PLACED)
    return asked


def found(asked, instance, depsgraph, material=None):
    """What has been asked of a bpy.types.DepsgraphObjectInstance, and of a bpy.types.Material of it: (question, answer) in order.

    instance: None for the world's nodes. Answers are tuples of four floats, red, green, blue and alpha, or (x, y, z, 1), or four times a number,
    but for PLACED; None: it is not known.
    """
    return tuple((question, _answer(*question, instance, depsgraph, material)) for question in sorted(asked))


def _answer(kind, name, instance, depsgraph, material):
    if instance is None and kind != "VIEW_LAYER":
        return None
    if kind == "PLACED":
        return tuple(value for row in instance.matrix_world for value in row)
    if kind == "INFO":
        if instance.object.type == "LIGHT" and bpy.app.version < (5, 0):
            # Cycles has zeros there for lamps, and another random number.
            return None
        return _INFO[name](instance, material)
    if kind == "VIEW_LAYER":
        scene = depsgraph.scene_eval
        owners = [depsgraph.view_layer_eval, scene, *([scene.world] if scene.world is not None else [])]
    else:
        owners = [instance.object, *([instance.object.data] if instance.object.data is not None else [])]
    if kind == "INSTANCER" and instance.is_instance:
        system = instance.particle_system
        owners = [*([system.settings] if system is not None else []), instance.parent, *owners]
    values = next((value for owner in owners if (value := _property(owner, name)) is not None), None)
    if values is None and kind == "INSTANCER" and instance.is_instance:
        # Geometry nodes may have given it to the instance, which Python does not tell.
        return None
    return values or (0.0, 0.0, 0.0, 0.0)


def _property(owner, name):
    """A custom property, or what a path of RNA leads to, as four floats; None if it is no number."""
    paths = [f'["{bpy.utils.escape_identifier(name)}"]']
    # Cycles follows no path to one number of several.
    if not re.search(r"\[\d+\]$", name):
        paths.append(name)
    for path in paths:
        try:
            value = owner.path_resolve(path)
            # Text is no number, also where it looks like one.
            value = np.array(None if isinstance(value, str) else value, np.float64)
        except (ValueError, TypeError):
            continue
        value = np.nan_to_num(value, nan=0.0, posinf=0.0, neginf=0.0)
        if value.ndim == 0:
            return (*[float(value)] * 3, 1.0)
        if value.ndim == 1 and 1 <= len(value) <= 4:
            return (*value.tolist(), *(0.0, 0.0, 0.0, 1.0)[len(value) :])
    return None


def _random(instance, material):
    identity = instance.random_id & _WORD
    if not instance.is_instance:
        # As Cycles hashes names.
        identity = 0
        for byte in instance.object.name.encode():
            identity = (identity * 37 + byte) & _WORD
        identity = int(hash_words([np.array([word], np.uint32) for word in (identity, 0)])[0])
    return (identity / _WORD,) * 4


_INFO = {
    "Location": lambda instance, material: (*instance.matrix_world.translation, 1.0),
    "Color": lambda instance, material: tuple(instance.object.color),
    "Alpha": lambda instance, material: (instance.object.color[3],) * 4,
    "Object Index": lambda instance, material: (float(instance.object.pass_index),) * 4,
    "Material Index": lambda instance, material: (float(material.pass_index) if material is not None else 0.0,) * 4,
    "Random": _random,
}


def told(node, output, facts):
    """The value of an output of an Object Info or Attribute node, as arithmetic has them, or None; facts: as `found` has made them."""
    question = ("INFO", output.identifier) if node.type == "OBJECT_INFO" else (node.attribute_type, node.attribute_name)
    answer = dict(facts).get(question)
    if answer is None:
        return None
    if output.identifier == "Alpha":
        return answer[3]
    if output.type == "VALUE":
        return float(np.mean(answer[:3]))
    return np.array(answer[:3], np.float64)


def in_world(places, facts):
    """Places of an object, float64 (n, 3), in the world, or None if nodes have not asked for it; facts: as `found` has made them."""
    matrix = dict(facts).get(PLACED)
    if matrix is None:
        return None
    matrix = np.array(matrix, np.float64).reshape(4, 4)
    return places @ matrix[:3, :3].T + matrix[:3, 3]
