# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of what shader nodes compute: our arithmetic against Cycles' own, by the Blender that is asked, and that against plain renders."""

import sys
import unittest
from itertools import product
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from addon.export.arithmetic import Elsewhere, as_colour  # noqa: E402
from addon.export.asked_nodes import asked, stop  # noqa: E402
from addon.export.nodes import COMPUTED_NODES  # noqa: E402

#: Values that nodes have been seen to fail at: 0, ends of ranges, halves, and what is large, small, or negative.
_HOSTILE = np.array([0.0, 1.0, -1.0, 0.5, -0.5, 2.0, 3.0, 0.25, 64.0, -64.0, 2.0**-10, -(2.0**-10)])

#: Types of nodes that we compute from any input, by name in bpy.types.
_FUNCTIONS = (
    *("Math", "VectorMath", "Mix", "MixRGB", "MapRange", "Clamp", "VectorRotate", "Normal", "SeparateColor", "CombineColor", "HueSaturation"),
    *("Gamma", "Invert", "BrightContrast", "RGBToBW", "ValToRGB", "RGBCurve", "VectorCurve", "FloatCurve"),
    *("SeparateRGB", "CombineRGB", "SeparateHSV", "CombineHSV"),
)


def tearDownModule():
    stop()


def _node(name):
    """A new node, or None if this Blender has none of that name."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    material = bpy.data.materials.new("Material")
    if material.node_tree is None:
        material.use_nodes = True
    try:
        return material.node_tree.nodes.new(f"ShaderNode{name}")
    except RuntimeError:
        return None


def _variations(node):
    """Sets a node to all combinations of its enumerations, and then of its switches; yields what it has set."""
    common = {prop.identifier for prop in bpy.types.ShaderNode.bl_rna.properties}
    own = [prop for prop in node.bl_rna.properties if prop.identifier not in common and not prop.is_readonly]
    choices = [[(prop.identifier, item.identifier) for item in prop.enum_items] for prop in own if prop.type == "ENUM"]
    switches = [[(prop.identifier, value) for value in (False, True)] for prop in own if prop.type == "BOOLEAN"]
    for chosen in (*product(*choices), *product(*switches)):
        try:
            for key, value in chosen:
                setattr(node, key, value)
        except TypeError:
            # Of geometry nodes only.
            continue
        yield dict(chosen)


def _arguments(node, random):
    """Values of a node's inputs by identifier: tame ones, and then hostile ones in all rows."""
    found = {}
    for socket in node.inputs:
        channels = 1 if socket.type in ("VALUE", "INT", "BOOLEAN") else 3
        tame = random.uniform(-1.5, 2.5, (64, channels))
        found[socket.identifier] = np.concatenate([tame, random.choice(_HOSTILE, (64, channels))]).astype(np.float32).astype(np.float64)
    return found


class TestArithmetic(unittest.TestCase):
    def test_functions_are_those_of_cycles(self):
        for name in _FUNCTIONS:
            node, random = _node(name), np.random.default_rng(1)
            for settings in _variations(node) if node is not None else ():
                arguments = _arguments(node, random)
                for output in node.outputs:
                    if output.enabled:
                        with self.subTest(node=name, output=output.identifier, **settings):
                            self._check(node, output, arguments)

    def _check(self, node, output, arguments):
        with np.errstate(all="ignore"):
            try:
                found = COMPUTED_NODES[node.type](node, output, arguments.__getitem__, None)
            except Elsewhere:
                # It is not ours: Blender is asked.
                return
        expected = asked(node, output, arguments.__getitem__)
        found, expected = (np.nan_to_num(np.broadcast_to(as_colour(of), (128, 3)), posinf=0.0, neginf=0.0) for of in (found, expected))
        # Cycles computes in single precision, and what it subtracts may be as large as all there is in a row.
        used = [arguments[s.identifier] for s in node.inputs if s.enabled]
        largest = np.abs(np.concatenate([*used, expected], axis=1)).max(axis=1, keepdims=True)
        near = np.abs(found - expected) <= 1e-4 * np.maximum(1, np.abs(expected)) + 1.6e-5 * largest
        rows = np.flatnonzero(~near.all(axis=1))
        self.assertFalse(rows.size, f"rows {rows}: {found[rows[:1]]}, Cycles: {expected[rows[:1]]}, of {[of[rows[:1]].tolist() for of in used]}")


if __name__ == "__main__":
    unittest.main()
