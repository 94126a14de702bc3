# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of bounces: fog is as bright as by Cycles, whatever its Light Paths are; caustics are there all the same."""

import unittest

import bpy
import harness
import numpy as np
from walk_stage import Answer, by_cycles, differs, stage

import addon


class Bounces(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        addon.register()

    def setUp(self):
        self.folder = harness.folder_of(self)

    def thick(self, **limits):
        """Fog of four free paths over a bright floor, most of whose light has been scattered before."""
        scene = stage()
        mist = next(node for node in bpy.data.materials["Mist"].node_tree.nodes if node.type == "VOLUME_SCATTER")
        mist.inputs["Density"].default_value, mist.inputs["Color"].default_value = 0.9, (0.95, 0.8, 0.6, 1)
        floor = next(node for node in bpy.data.materials["Grey"].node_tree.nodes if node.type == "BSDF_DIFFUSE")
        floor.inputs["Color"].default_value = (0.9, 0.9, 0.9, 1)
        for name, value in limits.items():
            setattr(scene.cycles, name, value)
        return scene

    def test_fog_is_as_bright_as_by_cycles(self):
        found = {}
        for total, diffuse, volume in ((12, 4, 0), (12, 4, 1), (12, 0, 2), (12, 4, 4), (1, 4, 4), (0, 4, 4), (12, 1, 1)):
            with self.subTest(total=total, diffuse=diffuse, volume=volume):
                scene = self.thick(max_bounces=total, diffuse_bounces=diffuse, volume_bounces=volume)
                cycles, error = by_cycles(scene, self.folder)
                answer = Answer(scene, self.folder)
                self.assertEqual((answer.asks, answer.refused), ([], ""))
                found[total, diffuse, volume] = cycles.mean()
                print(f"figures: bounces {total}, {diffuse} diffuse, {volume} in fog: {answer.picture.mean() / cycles.mean():.3f} of Cycles' light")
                self.assertEqual(differs(cycles, error, answer.picture, answer.error), "")
        # The limits matter: without, a test of them tells nothing.
        self.assertGreater(found[12, 4, 4] / found[12, 4, 0], 1.8)
        self.assertGreater(found[12, 4, 1] / found[12, 4, 0], 1.2)

    def test_fog_over_rough_floors_is_as_bright_as_by_cycles(self):
        """Of plastic without a colour, and of metal: light that facets hide from each other is lost or kept as in Cycles."""
        light = {}
        for kind, values in (
            ("BsdfDiffuse", {"Color": (0, 0, 0, 1)}),
            ("BsdfPrincipled", {"Base Color": (0, 0, 0, 1), "Roughness": 0.5}),
            ("BsdfPrincipled", {"Base Color": (0, 0, 0, 1), "Roughness": 1.0}),
            ("BsdfAnisotropic", {"Color": (0.9, 0.7, 0.5, 1), "Roughness": 1.0}),
        ):
            with self.subTest(kind, **values):
                scene = stage("SUN")
                tree = bpy.data.materials["Grey"].node_tree
                floor, end = tree.nodes.new(f"ShaderNode{kind}"), next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
                for name, value in values.items():
                    floor.inputs[name].default_value = value
                tree.links.new(floor.outputs[0], end.inputs["Surface"])
                cycles, error = by_cycles(scene, self.folder)
                answer = Answer(scene, self.folder)
                light[kind] = cycles.mean()
                print(f"figures: over {kind} {values}: {answer.picture.mean() / cycles.mean():.3f} of Cycles' light")
                self.assertEqual(differs(cycles, error, answer.picture, answer.error), "")
        # What the floor sends back is seen.
        self.assertGreater(light["BsdfAnisotropic"] / light["BsdfDiffuse"], 1.1)

    def test_caustics_are_there_whatever_the_limits_unless_they_are_off(self):
        """Below a ball of glass, with Cycles' default of no bounces in fog."""
        light = {}
        for caustics in (True, False):
            scene = stage()
            scene.cycles.volume_bounces = 0
            scene.cycles.caustics_refractive = scene.cycles.caustics_reflective = caustics
            tree = bpy.data.materials["Skin"].node_tree
            end = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
            glass = tree.nodes.new("ShaderNodeBsdfGlass")
            glass.inputs["Roughness"].default_value = 0.0
            tree.links.new(glass.outputs[0], end.inputs["Surface"])
            light[caustics] = Answer(scene, self.folder)
            if not caustics:
                cycles, error = by_cycles(scene, self.folder)
        # Cycles has none with these limits, on or off.
        self.assertEqual(differs(cycles, error, light[False].picture, light[False].error), "")
        more = light[True].picture - light[False].picture
        self.assertGreater(more.sum() / cycles.sum(), 0.05)
        # Below the ball, where its focus is, and nowhere less than without.
        self.assertIn(np.unravel_index(more.mean(-1).argmax(), more.shape[:2])[1], (1, 2))
        self.assertGreater(more.min(), -0.02 * cycles.mean())

    def test_all_orders_are_brighter_and_say_so(self):
        scene = self.thick(volume_bounces=0)
        as_cycles = Answer(scene, self.folder)
        scene.covbeam.orders = "ALL"
        every = Answer(scene, self.folder)
        self.assertGreater(every.picture.mean() / as_cycles.picture.mean(), 1.8)
        self.assertTrue(any("limits of Cycles' Light Paths" in entry for entry in every.entries))
        self.assertFalse(any("limits of Cycles' Light Paths" in entry for entry in as_cycles.entries))


if __name__ == "__main__":
    harness.main()
