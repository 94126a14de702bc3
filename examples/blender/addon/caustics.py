# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics: whether a scene has what may focus or mirror light into its fog, which is where beams win, from a look at its materials."""

from time import monotonic

#: Roughness up to which surfaces throw light that is seen as shapes in fog.
_SHARP = 0.35

#: How long an answer is good [s]: panels are drawn again and again.
_GOOD = 2.0

#: The latest answer: pointer of its scene, when it was given, and it.
_latest = (0, 0.0, False)


def hint(scene):
    """One line for artists before they render."""
    global _latest
    pointer, when, found = _latest
    if pointer != scene.as_pointer() or monotonic() - when > _GOOD:
        materials = {slot.material for thing in scene.objects if not thing.hide_render for slot in thing.material_slots}
        found = any(_may_focus(material.node_tree) for material in materials if material is not None and material.node_tree is not None)
        _latest = (scene.as_pointer(), monotonic(), found)
    if found:
        return "Glass, water or mirrors throw light into the fog here: beams are far ahead of Cycles."
    return "Nothing here focuses light into the fog: Cycles with its denoiser may be as good."


def _may_focus(tree):
    return any(_focuses(node) for node in tree.nodes if not node.mute)


def _focuses(node):
    if node.type == "GROUP":
        return node.node_tree is not None and _may_focus(node.node_tree)
    if node.type in {"BSDF_GLASS", "BSDF_REFRACTION", "BSDF_GLOSSY"}:
        return _least(node, "Roughness") <= _SHARP
    if node.type == "BSDF_PRINCIPLED":
        return _least(node, "Roughness") <= _SHARP and max(_most(node, "Metallic"), _most(node, "Transmission Weight")) > 0.1
    return False


def _least(node, name):
    """An input's value, or the least that it may be where that comes from other nodes."""
    return 0.0 if node.inputs[name].is_linked else node.inputs[name].default_value


def _most(node, name):
    return 1.0 if node.inputs[name].is_linked else node.inputs[name].default_value
