# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole way of Add Beams, with the real host: the composited picture has Cycles' light, where Cycles has it."""

import unittest

import bpy
import exr
import harness
import numpy as np



class BeamsAgainstCycles(unittest.TestCase):
    """A cube of fog with a lamp above its right side, in a black world, over a grey floor that both see."""

    def setUp(self):
        bpy.ops.wm.read_factory_settings()
        self.folder = harness.with_addon(self)
        scene = self.scene = bpy.context.scene
        scene.world.color = (0, 0, 0)
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
        tree = bpy.data.objects["Cube"].data.materials[0].node_tree
        tree.nodes.clear()
        volume, output = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
        volume.inputs["Density"].default_value, volume.inputs["Color"].default_value = 0.3, (0.9, 0.6, 0.3, 1)
        tree.links.new(volume.outputs["Volume"], output.inputs["Volume"])
        light = bpy.data.objects["Light"]
        light.location, light.data.energy, light.data.shadow_soft_size = (0.5, 0.8, 2.0), 200, 0.1
        light.data.use_soft_falloff = False
        bpy.ops.mesh.primitive_plane_add(size=4, location=(0, 0, -1.2))
        render = scene.render
        render.engine = "CYCLES"
        render.resolution_x, render.resolution_y, render.resolution_percentage = 48, 32, 100
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.sample_clamp_indirect = 1024, False, 0
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.max_bounces, scene.cycles.volume_bounces = 32, 32
        scene.covbeam.passes, scene.covbeam.photons, scene.covbeam.time_limit = 64, 20000, 0.0
        scene.covbeam.folder = str(self.folder)

    def quarters(self, name):
        """Means of each channel in each quarter of the composited picture: (4, 3)."""
        harness.write_exr(self.scene.render.image_settings, layers=False)
        self.scene.render.filepath = str(self.folder / name)
        bpy.ops.render.render(write_still=True)
        channels = exr.read(self.folder / f"{name}.exr")
        picture = np.stack([channels[letter] for letter in "RGB"], axis=-1)
        return np.array([half.mean(axis=(0, 1)) for row in np.split(picture, 2) for half in np.split(row, 2, axis=1)])

    def test_every_quarter_has_the_same_light(self):
        self.compare()

    def test_what_fog_sends_out_stays_cycles_and_what_it_scatters_of_that_is_replaced(self):
        tree = bpy.data.objects["Cube"].data.materials[0].node_tree
        scatter, fire = next(node for node in tree.nodes if node.type == "VOLUME_SCATTER"), tree.nodes.new("ShaderNodeEmission")
        both, output = tree.nodes.new("ShaderNodeAddShader"), next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
        fire.inputs["Strength"].default_value, fire.inputs["Color"].default_value = 0.3, (0.3, 0.6, 1, 1)
        tree.links.new(scatter.outputs[0], both.inputs[0])
        tree.links.new(fire.outputs[0], both.inputs[1])
        tree.links.new(both.outputs[0], output.inputs["Volume"])
        self.scene.cycles.samples = 256
        # Of the film, which light in fog has as all other light.
        self.scene.cycles.film_exposure = 1.7
        self.compare()

    def test_each_light_group_has_the_light_that_cycles_has_of_it(self):
        scene, layer = self.scene, bpy.context.view_layer
        # Without surfaces and a background all of Cycles' light is the fog's.
        bpy.data.objects.remove(bpy.data.objects["Plane"])
        bpy.ops.mesh.primitive_plane_add(size=1, location=(-0.5, 0.2, -1.6))
        screen, lamp = bpy.context.object, bpy.data.objects["Light"]
        screen.visible_camera = False
        material = bpy.data.materials.new("Screen")
        material.use_nodes = True
        material.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 30
        material.node_tree.nodes["Principled BSDF"].inputs["Emission Color"].default_value = (1, 0.8, 0.5, 1)
        screen.data.materials.append(material)
        for name, thing in (("key", lamp), ("screen", screen)):
            layer.lightgroups.add(name=name)
            thing.lightgroup = name
        scene.render.resolution_x, scene.render.resolution_y, scene.cycles.samples = 24, 16, 512
        scene.covbeam.passes, scene.covbeam.photons = 24, 40000
        harness.write_exr(scene.render.image_settings)
        scene.render.filepath = str(self.folder / "groups")
        bpy.ops.render.render(write_still=True)
        bpy.ops.covbeam.add_beams()
        cycles, beams = exr.read(self.folder / "groups.exr"), exr.read(self.folder / f"beams_{layer.name}_0001.exr")
        total = 0
        for name in ("key", "screen"):
            expected, found = (
                np.array([channels[f"{layer.name}.{kind}_{name}.{letter}"].mean() for letter in "RGB"])
                for kind, channels in (("Combined", cycles), ("In-Scattered", beams))
            )
            print(f"figures: {name} over Cycles: {found / expected}")
            # Noise of Cycles' mean is 1 %.
            np.testing.assert_allclose(found, expected, rtol=0.03)
            total = total + beams[f"{layer.name}.In-Scattered_{name}.G"]
        np.testing.assert_array_equal(total, beams[f"{layer.name}.In-Scattered.G"])

    def compare(self):
        cycles = self.quarters("cycles")
        bpy.ops.covbeam.add_beams()
        composited = self.quarters("composited")
        difference = np.abs(composited / cycles - 1)
        print(f"figures: largest difference of a quarter of the picture from Cycles {100 * difference.max():.2f} %")
        # Quarters differ among themselves: a flipped picture would not pass.
        self.assertGreater(np.ptp(cycles.mean(axis=1)) / cycles.mean(), 0.2)
        # Over six seeds the difference of the darkest quarter has a standard deviation of 0.5 %: four times that.
        self.assertLess(difference.max(), 0.02)


if __name__ == "__main__":
    harness.main()
