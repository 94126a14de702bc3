# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported materials: what their lobes reflect and let through, against what Cycles shows in white surroundings."""

import sys
import unittest
from math import acos, pi
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import scenes_export as scenes  # noqa: E402
from scenes_export import joined, node, shader  # noqa: E402

from addon.export.materials import translate  # noqa: E402
from addon.export.report import Report  # noqa: E402


def leaves(row, cosine):
    """Share of the light that leaves a smooth surface, of both sides together, by the words of MATERIAL: (3,)."""
    sine = np.sqrt(1 - cosine**2) / row["ior"]
    inside = np.sqrt(1 - sine**2)
    s = (cosine - row["ior"] * inside) / (cosine + row["ior"] * inside)
    p = (row["ior"] * cosine - inside) / (row["ior"] * cosine + inside)
    fresnel = (s * s + p * p) / 2
    coat = row["coat"] * fresnel
    metal = row["metal"] + (row["edge"] - row["metal"]) * (1 - cosine) ** 5
    glass = row["glass_reflection"] * fresnel + row["glass_transmission"] * (1 - fresnel)
    return coat + row["diffuse"] * (1 - coat) + metal + glass + row["translucent"] + row["transparent"]


class Materials(unittest.TestCase):
    def setUp(self):
        scene = scenes.empty()
        scene.cycles.blur_glossy = 0
        scene.cycles.max_bounces = 2

    def show(self, surface, turn=0.0):
        """The exported row and emission of a material, and the report; the square with it is turned by `turn` [rad]."""
        thing = scenes.grid(size=1.0, material=scenes.material("Thing", surface))
        thing.rotation_euler = (turn, 0, 0)
        made, report = scenes.exported()
        self.assertEqual(len(made.materials), 1)
        emission = sum((light.radiance for light in made.lights), np.zeros(3))
        return made.materials[0], emission, report

    def compare(self, surface, tolerance=2e-3, cosine=1.0, reported=()):
        """In white surroundings Cycles shows what leaves the surface and what it emits.

        It is a mean of 8192 samples, which differ by less than a tenth.
        """
        self.setUp()
        row, emission, report = self.show(surface, acos(cosine))
        self.assertEqual([entry.what for entry in report.entries], list(reported))
        scenes.world(shader("Background", {"Color": (1, 1, 1)}))
        shown = scenes.cycles_at((0, 0, 0), 512)
        np.testing.assert_allclose(leaves(row, cosine) + emission, shown, rtol=tolerance)
        return row

    def test_closures_have_the_albedo_of_cycles(self):
        colour = (0.2, 0.5, 0.9)
        for kind in ("BsdfDiffuse", "BsdfTranslucent", "BsdfTransparent"):
            with self.subTest(kind):
                self.compare(shader(kind, {"Color": colour}))
        with self.subTest("Glossy"):
            self.compare(shader("BsdfAnisotropic", {"Color": colour, "Roughness": 0.0}))
        for cosine in (1.0, 0.5):
            with self.subTest("Glass", cosine=cosine):
                self.compare(shader("BsdfGlass", {"Color": colour, "IOR": 1.7}), cosine=cosine)
        with self.subTest("Emission"):
            row = self.compare(shader("Emission", {"Color": colour, "Strength": 2.5}))
            self.assertEqual(leaves(row, 1.0).tolist(), [0, 0, 0])

    def test_mixed_and_added_closures_have_the_albedo_of_cycles(self):
        a = shader("BsdfDiffuse", {"Color": (0.3, 0.6, 0.1)})
        b = shader("BsdfTransparent", {"Color": (0.2, 0.3, 0.9)})
        self.compare(joined("MixShader", a, b, 0.3))
        self.compare(joined("AddShader", a, joined("MixShader", b, shader("Emission"), 0.5)))

    def test_principled_has_the_albedo_of_cycles(self):
        base = {"Base Color": (0.2, 0.5, 0.9), "Roughness": 0.0, "IOR": 1.6}
        whole = {
            "plastic": {},
            "no specular": {"Specular IOR Level": 0.0},
            "more specular": {"Specular IOR Level": 0.9},
            "metal": {"Metallic": 1.0},
            "glass": {"Transmission Weight": 1.0},
            "emission": {"Emission Color": (1, 0.5, 0.2), "Emission Strength": 3.0},
        }
        parts = {
            "half metal": {"Metallic": 0.5},
            "half glass": {"Transmission Weight": 0.5},
            "alpha": {"Alpha": 0.3},
            "half emission": {"Emission Color": (1, 0.5, 0.2), "Emission Strength": 3.0, "Alpha": 0.5},
        }
        # Cycles' specular layer leaves to what is below the share that its tables say, to a few thousandths. A coat of
        # weight w leaves 1 - w F of all that is diffuse, where it should be 1 - F of a share w: F is below 0.1 here.
        for cases, tolerance in ((whole, 5e-3), (parts, 3e-2)):
            for name, inputs in cases.items():
                for cosine in (1.0, 0.5):
                    with self.subTest(name, cosine=cosine):
                        self.compare(shader("BsdfPrincipled", base | inputs), tolerance, cosine)

    def test_edge_tint_is_met_where_it_is_meant(self):
        inputs = {"Base Color": (0.6, 0.4, 0.2), "Roughness": 0.0, "Metallic": 1.0, "Specular Tint": (0.8, 0.9, 1.0)}
        self.compare(shader("BsdfPrincipled", inputs), 5e-3, 1 / 7, ["edge tint of metal"])

    def test_roughness_is_the_square_root_of_alpha_as_in_cycles(self):
        sun = bpy.data.lights.new("Sun", "SUN")
        sun.energy, sun.angle = 5.0, 0.0
        scenes.add(sun)
        inputs = {"Color": (0.9, 0.9, 0.9), "Roughness": 0.6}
        row, _, _ = self.show(shader("BsdfAnisotropic", inputs, distribution="GGX"))
        # Lit and seen along the normal GGX reflects 1 / (4 pi alpha^2): no masking, and Fresnel's term is the colour.
        expected = 5.0 * row["metal"] / (4 * pi * row["alpha"] ** 2)
        np.testing.assert_allclose(scenes.cycles_at((0, 0, 0)), expected, rtol=1e-3)

    def test_values_come_through_groups_reroutes_and_arithmetic(self):
        def make(tree):
            group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
            group.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketFloat")
            group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
            first, last = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
            mix = node(group, "Mix", {"A_Color": (0, 0.2, 0.4), "B_Color": (1, 0.6, 0.4)}, data_type="RGBA")
            group.links.new(first.outputs[0], mix.inputs[0])
            group.links.new(mix.outputs[2], last.inputs[0])
            value = node(tree, "Value")
            value.outputs[0].default_value = 0.6
            halved = node(tree, "Math", {"Value_001": 0.5}, operation="MULTIPLY")
            through = tree.nodes.new("NodeReroute")
            inside = node(tree, "Group", node_tree=group)
            diffuse = node(tree, "BsdfDiffuse")
            tree.links.new(value.outputs[0], halved.inputs[0])
            tree.links.new(halved.outputs[0], through.inputs[0])
            tree.links.new(through.outputs[0], inside.inputs[0])
            tree.links.new(inside.outputs[0], diffuse.inputs["Color"])
            return diffuse

        row = self.compare(make)
        # 0.3 of the way from the first to the second.
        np.testing.assert_allclose(row["diffuse"], (0.3, 0.32, 0.4), rtol=1e-6)

    def test_a_muted_node_lets_through_what_blender_lets_through(self):
        def make(tree):
            diffuse, invert, colour = node(tree, "BsdfDiffuse"), node(tree, "Invert"), node(tree, "RGB")
            colour.outputs[0].default_value = (0.1, 0.2, 0.3, 1)
            invert.mute = True
            tree.links.new(colour.outputs[0], invert.inputs["Color"])
            tree.links.new(invert.outputs[0], diffuse.inputs["Color"])
            return diffuse

        self.compare(make)

    def test_an_image_without_places_is_its_mean_in_linear_light(self):
        """Of hair, say, which is not cut."""
        for name, is_float in (("Bytes", False), ("Floats", True)):
            self.setUp()
            image = bpy.data.images.new(name, 2, 1, float_buffer=is_float)
            image.pixels = [0.5, 0.5, 0.5, 1.0, 0.2, 0.2, 0.2, 1.0]

            def make(tree, image=image):
                texture, metal = node(tree, "TexImage", image=image), node(tree, "BsdfAnisotropic")
                tree.links.new(texture.outputs[0], metal.inputs["Roughness"])
                return metal

            report = Report()
            row = translate(scenes.material("Thing", make), report).row
            # sRGB 0.5 and 0.2 are 0.2140 and 0.0331; bytes hold them to 1/255. Rows have the square of a roughness.
            expected = 0.35 if is_float else 0.1236
            np.testing.assert_allclose(row["alpha"], expected**2, rtol=0.04)
            self.assertIn(name, str(report))

    def test_glass_that_is_transparent_for_shadow_rays_is_glass_with_a_clear_shadow(self):
        def make(tree):
            glass, clear = node(tree, "BsdfGlass"), node(tree, "BsdfTransparent")
            path, mix = node(tree, "LightPath"), node(tree, "MixShader")
            tree.links.new(path.outputs["Is Shadow Ray"], mix.inputs[0])
            tree.links.new(glass.outputs[0], mix.inputs[1])
            tree.links.new(clear.outputs[0], mix.inputs[2])
            return mix

        row, _, report = self.show(make)
        self.assertEqual((row["glass_transmission"].tolist(), row["transparent"].tolist()), ([1, 1, 1], [0, 0, 0]))
        self.assertEqual((int(row["has_shadow"]), row["shadow"].tolist()), (1, [1, 1, 1]))
        self.assertEqual(str(report), "")

    def test_more_light_than_arrives_is_scaled_down_and_named(self):
        white = shader("BsdfDiffuse", {"Color": (1, 1, 0.5)})
        row, _, report = self.show(joined("AddShader", white, white))
        np.testing.assert_allclose(row["diffuse"], (1, 1, 0.5))
        self.assertIn("reflects more light than it receives", str(report))

    def test_what_has_no_material_looks_as_in_cycles(self):
        scenes.world(shader("Background", {"Color": (1, 1, 1)}))
        scenes.grid()
        made, _ = scenes.exported()
        # Rough, where `leaves` is for smooth ones: F is a little less.
        np.testing.assert_allclose(leaves(made.materials[0], 1.0), scenes.cycles_at((0, 0, 0), 1024), rtol=3e-3)

    def test_a_material_without_shaders_is_black_as_in_cycles(self):
        scenes.world(shader("Background", {"Color": (1, 1, 1)}))
        row, _, _ = self.show(None)
        np.testing.assert_array_equal(leaves(row, 1.0), scenes.cycles_at((0, 0, 0), 4))

    def test_several_roughnesses_become_that_of_the_strongest(self):
        a = shader("BsdfAnisotropic", {"Color": (0.9, 0.9, 0.9), "Roughness": 0.5})
        b = shader("BsdfAnisotropic", {"Color": (0.2, 0.2, 0.2), "Roughness": 0.1})
        row, _, report = self.show(joined("MixShader", b, a, 0.5))
        self.assertAlmostEqual(float(row["alpha"]), 0.25, 6)
        self.assertIn("several roughnesses", str(report))


if __name__ == "__main__":
    unittest.main()
