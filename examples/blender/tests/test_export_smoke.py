# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoke domains: what they let through against Cycles; voxels against Blender's own."""

import sys
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402
import smoke_scenes  # noqa: E402
from host_scenes import density_at  # noqa: E402
from scenes_export import node, shader  # noqa: E402
from seen_through import SeenThrough  # noqa: E402

PRINCIPLED = shader("VolumePrincipled", {"Density": 3.0, "Color": (0.8, 0.5, 0.3)})


def of_attributes(tree):
    """Absorption by the smoke's own colour, and scattering by its fire."""
    absorb, scatter, both = node(tree, "VolumeAbsorption"), node(tree, "VolumeScatter", {"Color": (1, 1, 1)}), node(tree, "AddShader")
    smoke, info = node(tree, "Attribute", attribute_name="color"), node(tree, "VolumeInfo")
    thick = node(tree, "Math", {"Value_001": 3.0}, operation="MULTIPLY")
    tree.links.new(node(tree, "Attribute", attribute_name="density").outputs["Fac"], thick.inputs[0])
    tree.links.new(thick.outputs[0], absorb.inputs["Density"])
    tree.links.new(smoke.outputs["Color"], absorb.inputs["Color"])
    tree.links.new(info.outputs["Flame"], scatter.inputs["Density"])
    tree.links.new(absorb.outputs[0], both.inputs[0])
    tree.links.new(scatter.outputs[0], both.inputs[1])
    return both


def of_nothing(tree):
    """What a domain does not hold is 0, and no factor."""
    principled = node(tree, "VolumePrincipled", {"Density Attribute": "nothing", "Color Attribute": "nothing"})
    tree.links.new(node(tree, "Attribute", attribute_name="nothing").outputs["Fac"], principled.inputs["Anisotropy"])
    return principled


class Smoke(SeenThrough):
    def setUp(self):
        super().setUp()
        scenes.march_volumes()

    def test_smoke_is_as_dense_as_in_cycles(self):
        smoke_scenes.domain(material=scenes.material("Smoke", volume=PRINCIPLED))
        self.compare(self.baked())

    def test_noise_makes_smoke_finer(self):
        smoke_scenes.domain(material=scenes.material("Smoke", volume=PRINCIPLED), use_noise=True, noise_scale=2)
        self.compare(self.baked())

    def test_a_domain_that_follows_the_smoke_moves(self):
        smoke_scenes.domain(24, 4, scenes.material("Smoke", volume=PRINCIPLED), use_adaptive_domain=True)
        (volume,) = scenes.exported()[0].volumes
        self.assertLess(volume.max[2], 0.7)
        self.compare(self.baked())

    def test_smoke_turns_and_stretches_with_its_object(self):
        # No voxels are those of the smoke here: it is looked up where it is.
        box = smoke_scenes.domain(material=scenes.material("Smoke", volume=PRINCIPLED))
        around = scenes.add(None, "Around", rotation_euler=(0.3, 0.5, 0.2), scale=(1.2, 0.8, 1.0))
        box.parent = around
        bpy.context.view_layer.update()
        self.compare(self.looked_up())
        off = r'Material "Smoke": density that varies finely: .* voxels, which are \d+\.\d% off on average'
        self.compare(self.baked(off), within=6e-3)

    def test_nodes_read_what_the_domain_holds(self):
        smoke_scenes.domain(material=scenes.material("Smoke", volume=of_attributes))
        made, report = scenes.exported()
        self.assertIn("colour that varies in a volume", str(report))
        self.compare(self.looked_up())

    def test_what_a_domain_does_not_hold_is_nothing(self):
        smoke_scenes.domain(material=scenes.material("Smoke", volume=of_nothing))
        (volume,) = scenes.exported()[0].volumes
        self.assertFalse((volume.scattering + volume.absorption).any())
        self.see_through()

    def test_smoke_without_a_material_is_not_seen(self):
        smoke_scenes.domain()
        self.assertEqual(scenes.exported()[0].volumes, [])
        self.see_through()

    def test_voxels_are_those_of_the_domain(self):
        box = smoke_scenes.domain(material=scenes.material("Smoke", volume=PRINCIPLED))
        (volume,) = scenes.exported()[0].volumes
        held = box.evaluated_get(bpy.context.evaluated_depsgraph_get()).modifiers[0].domain_settings
        z, y, x = (2 * (np.indices((17, 17, 17)) + 0.5) / 17 - 1).reshape(3, -1)
        found = density_at(volume.density, np.stack([x, y, z], axis=1)) * volume.scattering[0]
        # Bounds are drawn in by a hair.
        np.testing.assert_allclose(found, 2.4 * np.array(held.density_grid), atol=2e-3)

    def test_a_domain_without_smoke_is_named(self):
        box = scenes.box("Domain", material=scenes.material("Smoke", volume=PRINCIPLED))
        modifier = box.modifiers.new("Fluid", "FLUID")
        modifier.fluid_type = "DOMAIN"
        modifier.show_viewport = modifier.show_render = False
        made, report = scenes.exported()
        self.assertEqual(made.volumes, [])
        self.assertIn('Object "Domain": smoke domain without smoke', str(report))

    def test_instances_of_smoke_are_smoke(self):
        box = smoke_scenes.domain(material=scenes.material("Smoke", volume=PRINCIPLED))
        kept = bpy.data.collections.new("Kept")
        kept.objects.link(box)
        scenes.add(None, "Again", instance_type="COLLECTION", instance_collection=kept, location=(5, 0, 0))
        first, second = scenes.exported()[0].volumes
        np.testing.assert_allclose(second.min - first.min, (5, 0, 0), atol=1e-3)
        places = np.random.default_rng(1).uniform(-1, 1, (500, 3)).astype(np.float32)
        found = density_at(second.density, places + np.float32((5, 0, 0)))
        np.testing.assert_allclose(found, density_at(first.density, places), atol=2e-3)


if __name__ == "__main__":
    harness.main()
