# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of what shader nodes compute: our arithmetic against Cycles' own, by the Blender that is asked, and that against plain renders."""

import sys
import unittest
from itertools import product
from pathlib import Path
from unittest import mock

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402

from addon.export.arithmetic import Elsewhere, as_colour  # noqa: E402
from addon.export.asked_nodes import asked, stop  # noqa: E402
from addon.export.facts import found, wanted  # noqa: E402
from addon.export.nodes import COMPUTED_NODES, Values  # noqa: E402
from addon.export.other_blender import polling  # noqa: E402
from addon.export.report import Report  # noqa: E402
from addon.export.textures import Places  # noqa: E402
from addon.host import Cancelled  # noqa: E402

#: Values that nodes have been seen to fail at: 0, ends of ranges, halves, and what is large, small, or negative.
_HOSTILE = np.array([0.0, 1.0, -1.0, 0.5, -0.5, 2.0, 3.0, 0.25, 64.0, -64.0, 2.0**-10, -(2.0**-10)])

#: Types of nodes that we compute from any input, by name in bpy.types.
_FUNCTIONS = (
    *("Math", "VectorMath", "Mix", "MixRGB", "MapRange", "Clamp", "VectorRotate", "Normal", "SeparateColor", "CombineColor", "HueSaturation"),
    *("Gamma", "Invert", "BrightContrast", "RGBToBW", "ValToRGB", "RGBCurve", "VectorCurve", "FloatCurve"),
    *("SeparateXYZ", "CombineXYZ", "SeparateRGB", "CombineRGB", "SeparateHSV", "CombineHSV"),
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
                values = COMPUTED_NODES[node.type](node, output, arguments.__getitem__, None)
            except Elsewhere:
                # It is not ours: Blender is asked.
                return
        expected = asked(node, output, arguments.__getitem__)
        # What is too large for single precision is no number.
        with np.errstate(all="ignore"):
            single = [np.broadcast_to(as_colour(of), (128, 3)).astype(np.float32) for of in (values, expected)]
        ours, expected = (np.nan_to_num(of, posinf=0.0, neginf=0.0).astype(np.float64) for of in single)
        # Cycles computes in single precision, and what it subtracts may be as large as all there is in a row.
        used = [arguments[s.identifier] for s in node.inputs if s.enabled]
        largest = np.abs(np.concatenate([*used, expected], axis=1)).max(axis=1, keepdims=True)
        near = np.abs(ours - expected) <= 1e-4 * np.maximum(1, np.abs(expected)) + 1.6e-5 * largest
        rows = np.flatnonzero(~near.all(axis=1))
        self.assertFalse(rows.size, f"rows {rows}: {ours[rows[:1]]}, Cycles: {expected[rows[:1]]}, of {[of[rows[:1]].tolist() for of in used]}")


def _image(space, is_float=False):
    """A picture of 4 x 4 pixels in a colour space."""
    image = bpy.data.images.new("Image", 4, 4, alpha=True, float_buffer=is_float)
    image.colorspace_settings.name = space
    image.pixels.foreach_set(np.random.default_rng(2).uniform(0.1, 0.9, 64).astype(np.float32))
    image.update()
    image.pack()
    return image


class TestPlainRenders(unittest.TestCase):
    """Squares of a plane whose colour is that of a node at one place each."""

    def _squares(self, make):
        """Colours by Cycles, and by us, (16, 3) both; make: function of a tree and an output of places that returns one of colours."""
        scenes.empty()

        def surface(tree):
            emission = scenes.node(tree, "Emission")
            snapped, moved = scenes.node(tree, "VectorMath", operation="SNAP"), scenes.node(tree, "VectorMath", operation="MULTIPLY_ADD")
            snapped.inputs[1].default_value = (1, 1, 1)
            moved.inputs[1].default_value, moved.inputs[2].default_value = (0.23, 0.31, 0), (0.11, 0.13, 0.4)
            tree.links.new(scenes.node(tree, "TexCoord").outputs["Object"], snapped.inputs[0])
            tree.links.new(snapped.outputs[0], moved.inputs[0])
            tree.links.new(make(tree, moved.outputs[0]), emission.inputs["Color"])
            return emission

        material = scenes.material("Squares", surface)
        thing = scenes.grid(size=4.0, material=material)
        thing.color, thing["haze"] = (0.2, 0.5, 0.8, 0.3), 0.35
        eye = bpy.context.scene.camera
        eye.location, eye.rotation_euler = (0, 0, 2), (0, 0, 0)
        eye.data.type, eye.data.ortho_scale = "ORTHO", 4.0
        shown = scenes.cycles(1)
        x, y = np.meshgrid(np.arange(-2, 2), np.arange(1, -3, -1))
        at = np.stack([x.ravel() + 0.5, y.ravel() + 0.5, np.full(16, 0.25)], axis=1)
        depsgraph, report = bpy.context.evaluated_depsgraph_get(), Report()
        (told,) = [
            found(wanted(material.node_tree), instance, depsgraph, material)
            for instance in depsgraph.object_instances
            if instance.object.type == "MESH"
        ]
        emission = next(node for node in material.node_tree.nodes if node.type == "EMISSION")
        ours = as_colour(Values("Squares", report, Places(at, at, at), facts=told).colour(emission, "Color", ()))
        self.assertEqual(str(report), "")
        return np.array(shown)[..., :3].reshape(16, 3), np.broadcast_to(ours, (16, 3))

    def _check(self, make, tolerance=2e-4):
        shown, ours = self._squares(make)
        self.assertGreater(shown.max(), 0.01)
        np.testing.assert_allclose(ours, shown, rtol=tolerance, atol=tolerance)

    def test_textures(self):
        for kind, settings in (
            ("TexVoronoi", {"voronoi_dimensions": "4D", "feature": "SMOOTH_F1"}),
            ("TexNoise", {"noise_dimensions": "2D"}),
            ("TexWhiteNoise", {"noise_dimensions": "3D"}),
            ("TexBrick", {"offset_frequency": 3, "squash": 1.7}),
            ("TexWave", {"wave_profile": "TRI"}),
            ("TexChecker", {}),
            ("TexMagic", {"turbulence_depth": 4}),
            ("TexGradient", {}),
        ):

            def make(tree, place):
                node = scenes.node(tree, kind, **settings)
                # Files of old have such mappings, which no panel shows.
                if kind == "TexGradient":
                    node.texture_mapping.scale = (1.5, 1, 1)
                tree.links.new(place, node.inputs["Vector"])
                return node.outputs["Color"]

            with self.subTest(kind=kind):
                self._check(make)

    def test_images_in_any_colour_space(self):
        for space in ("sRGB", "Non-Color", "ACEScg", "Linear Rec.2020", "Linear Rec.709"):
            for is_float in (False, True):
                for extension in ("REPEAT", "MIRROR"):

                    def make(tree, place):
                        node = scenes.node(tree, "TexImage", extension=extension)
                        node.image = _image(space, is_float)
                        tree.links.new(place, node.inputs["Vector"])
                        return node.outputs["Color"]

                    with self.subTest(space=space, is_float=is_float, extension=extension):
                        # Cycles keeps some pixels as half floats.
                        self._check(make, 3e-3)

    def test_working_spaces(self):
        if bpy.app.version < (5, 0):
            self.skipTest("there is one only")
        plain = scenes.empty

        def in_acescg():
            scene = plain()
            bpy.ops.wm.set_working_color_space(working_space="ACEScg")
            return scene

        with mock.patch.object(scenes, "empty", in_acescg):
            for kind, inputs in (
                ("Blackbody", {"Temperature": 2200.0}),
                ("Wavelength", {"Wavelength": 480.0}),
                ("RGBToBW", {"Color": (0.2, 0.9, 0.4, 1)}),
            ):
                with self.subTest(kind=kind):
                    self._check(lambda tree, place: scenes.node(tree, kind, inputs).outputs[0], 3e-3)

    def test_what_nodes_ask_of_objects(self):
        for output in ("Color", "Alpha", "Random"):
            with self.subTest(output=output):
                self._check(lambda tree, place: scenes.node(tree, "ObjectInfo").outputs[output])
        self._check(lambda tree, place: scenes.node(tree, "Attribute", attribute_type="OBJECT", attribute_name="haze").outputs["Fac"])


class TestHelper(unittest.TestCase):
    def test_it_is_asked_once_for_the_same_and_ends_when_it_is_told_to_stop(self):
        node = _node("TexVoronoi")
        at = np.random.default_rng(3).normal(size=(5, 3))
        values = {socket.identifier: at if socket.type == "VECTOR" else socket.default_value for socket in node.inputs}
        with polling(lambda: False):
            self.assertRaises(Cancelled, asked, node, node.outputs["Distance"], values.__getitem__)
        first = asked(node, node.outputs["Distance"], values.__getitem__)
        with polling(lambda: False):
            # It would be cancelled if it asked again.
            np.testing.assert_array_equal(asked(node, node.outputs["Distance"], values.__getitem__), first)
        stop()
        self.assertEqual(asked(node, node.outputs["Color"], values.__getitem__).shape, (5, 3))


if __name__ == "__main__":
    harness.main()
