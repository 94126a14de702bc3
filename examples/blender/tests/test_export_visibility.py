# SPDX-License-Identifier: GPL-3.0-or-later
"""Light linking, shadows that are not those of what is seen, Ray Visibility and falloffs: Add Beams' light in fog is Cycles' own."""

import sys
import unittest
from pathlib import Path

import bpy
import cycles_scenes as cycles
import exr
import harness
import numpy as np

from addon import latest
from addon.export.scene import export
from addon.host.scene import Rays

#: Pixels across and down; of Cycles a pixel.
SIZE, SAMPLES = 32, 640


def linked(thing, kind, members, state="INCLUDE"):
    """Links an emitter to a new collection of objects."""
    collection = bpy.data.collections.new(kind)
    for number, member in enumerate(members):
        collection.objects.link(member)
        collection.collection_objects[number].light_linking.link_state = state
    setattr(thing.light_linking, kind, collection)
    return collection


def falloff(light, kind, smooth=0.0):
    """Half of a Light Falloff node's output in a light's strength."""
    light.use_nodes = True
    tree = light.node_tree
    emission = next(node for node in tree.nodes if node.type == "EMISSION")
    made, half = tree.nodes.new("ShaderNodeLightFalloff"), tree.nodes.new("ShaderNodeMath")
    half.operation, half.inputs[1].default_value, made.inputs["Strength"].default_value = "MULTIPLY", 0.5, 1.0
    made.inputs["Smooth"].default_value = smooth
    tree.links.new(made.outputs[kind], half.inputs[0])
    tree.links.new(half.outputs[0], emission.inputs["Strength"])


def fake_glass():
    """Tinted glass that is transparent for shadow rays."""
    made = bpy.data.materials.new("Fake")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    glass, clear, mix, path, output = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfGlass", "BsdfTransparent", "MixShader", "LightPath", "OutputMaterial")
    )
    for node in (glass, clear):
        node.inputs["Color"].default_value = 0.2, 0.6, 1.0, 1.0
    tree.links.new(path.outputs["Is Shadow Ray"], mix.inputs[0])
    for place, node in enumerate((glass, clear, mix)):
        tree.links.new(node.outputs[0], mix.inputs[place + 1] if node != mix else output.inputs["Surface"])
    return made


class VisibilityTest(unittest.TestCase):
    """A spot in a box of fog above a grey floor, and a ball in its beam."""

    def setUp(self):
        scene = self.scene = cycles.empty_scene(SIZE, SAMPLES)
        self.folder = harness.with_addon(self)
        cycles.look((0, -6, 1.8), (0, 0, 1.5), 32)
        grey = cycles.material("Grey", ("ShaderNodeBsdfDiffuse", {"Color": (0.4, 0.4, 0.4, 1)}, "Surface"))
        bpy.ops.mesh.primitive_plane_add(size=14)
        self.floor = self.named("Floor", grey)
        bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 2), scale=(6, 5, 3.96))
        self.fog = self.named("Fog", cycles.material("Fog", ("ShaderNodeVolumeScatter", {"Density": 0.15}, "Volume")))
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.3, location=(-0.75, 0, 2.6))
        self.ball = self.named("Ball", grey)
        # Of lamps with a size Cycles counts light twice in fog once shadows are linked.
        self.spot = cycles.lamp("SPOT", (-1, 0, 3.8), (-0.3, 0, 0), energy=500, spot_size=0.7, spot_blend=0.2, shadow_soft_size=0)
        scene.view_layers[0].cycles.use_pass_volume_direct = scene.view_layers[0].cycles.use_pass_volume_indirect = True
        scene.covbeam.passes, scene.covbeam.photons, scene.covbeam.time_limit = 16, 5000, 0.0
        scene.covbeam.folder = str(self.folder)

    def named(self, name, material):
        thing = bpy.context.object
        thing.name = name
        thing.data.materials.append(material)
        return thing

    def compare(self, error=0.01):
        """Compares means, by channel and by half of the picture, to three times Cycles' own standard error, which is twice as large in the darker half.

        - error: of all of the picture, by five seeds.
        """
        harness.write_exr(self.scene.render.image_settings)
        bpy.ops.covbeam.add_beams()
        self.assertEqual((latest.missing_in_fog(), latest.get().untranslated), ([], []))
        (path,) = self.folder.glob("beams_*.exr")
        bpy.ops.covbeam.remove_beams()
        self.scene.render.filepath = str(self.folder / "cycles.exr")
        bpy.ops.render.render(write_still=True)
        ours, theirs = exr.read(path), exr.read(self.folder / "cycles.exr")

        def of(channels, *layers):
            names = [[name for name in channels if layer in name and name.endswith("." + letter)] for layer in layers for letter in "RGB"]
            picture = np.array([channels[name] for (name,) in names], np.float64).reshape(len(layers), 3, SIZE, SIZE).sum(axis=0)
            return np.append(picture.mean(axis=(1, 2)), [half.mean() for half in np.split(picture, 2, axis=2)])

        # Blender 4.2 names its passes otherwise.
        layers = ("VolumeDir", "VolumeInd") if bpy.app.version < (5, 0) else ("Volume Direct", "Volume Indirect")
        expected = of(theirs, *layers)
        found = of(ours, "In-Scattered")
        np.testing.assert_allclose(found[:3], expected[:3], rtol=3 * error)
        np.testing.assert_allclose(found[3:], expected[3:], rtol=6 * error)

    def test_lamps_light_what_they_are_linked_to(self):
        linked(self.spot, "receiver_collection", [self.floor, self.ball])
        blue = cycles.lamp("POINT", (1.3, 0, 2.5), energy=20, shadow_soft_size=0, color=(0.2, 0.3, 1))
        linked(blue, "receiver_collection", [self.ball], "EXCLUDE")
        self.compare()

    def test_lamps_are_shadowed_by_what_they_are_linked_to(self):
        # Fog that casts no shadow does not dim what reaches the floor below it.
        linked(self.spot, "blocker_collection", [self.floor])
        red = cycles.lamp("POINT", (0.8, 0, 2.6), energy=20, shadow_soft_size=0, color=(1, 0.2, 0.2))
        linked(red, "blocker_collection", [self.ball], "EXCLUDE")
        self.compare()

    def test_what_casts_no_shadow_is_lit(self):
        self.ball.visible_shadow = False
        self.compare()

    def test_fog_that_casts_no_shadow_is_lit_all_the_way(self):
        self.fog.visible_shadow = False
        if bpy.app.version < (5, 0):
            # There shadow rays see it if they start in it.
            _, report = export(bpy.context.evaluated_depsgraph_get())
            self.assertEqual([(entry.what, entry.in_fog) for entry in report.entries], [("fog that casts no shadow", True)])
        else:
            self.compare()

    def test_glass_with_a_shadow_of_its_own_colours_the_light(self):
        self.ball.data.materials[0] = fake_glass()
        self.compare()

    def test_what_is_hidden_from_the_camera_hides_nothing(self):
        self.ball.location = (-0.6, -1.2, 2.2)
        self.ball.visible_camera = False
        self.compare()

    def test_what_is_hidden_from_fog_sends_it_nothing(self):
        self.floor.visible_volume_scatter = self.ball.visible_volume_scatter = False
        self.compare()

    def test_lamps_hidden_from_fog_light_it_by_way_of_surfaces(self):
        self.spot.visible_volume_scatter = False
        # All of it has been scattered twice at least.
        self.compare(0.025)

    def test_a_strength_that_grows_with_distance(self):
        falloff(self.spot.data, "Constant")
        self.spot.data.energy = 100
        self.compare()

    def test_a_strength_that_is_smoothed(self):
        falloff(self.spot.data, "Linear", 2.0)
        self.compare()

    def test_instances_are_hidden_with_what_makes_them(self):
        collection = bpy.data.collections.new("Balls")
        collection.objects.link(self.ball)
        self.scene.collection.objects.unlink(self.ball)
        for number, setting in enumerate(("visible_shadow", "visible_camera", "visible_glossy")):
            maker = bpy.data.objects.new("Maker", None)
            maker.instance_type, maker.instance_collection = "COLLECTION", collection
            maker.location = (0, 0, 0.1 * number)
            setattr(maker, setting, False)
            self.scene.collection.objects.link(maker)
        made, report = export(bpy.context.evaluated_depsgraph_get())
        self.assertEqual(str(report), "")
        found = sorted(made.object_rules["hidden_from"].tolist())
        self.assertEqual(found, sorted([0, 0, Rays.SHADOW, Rays.CAMERA, Rays.GLOSSY]))

    def test_overlapping_fog_that_lamps_tell_apart_is_named(self):
        bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 2), scale=(3, 5.2, 3.5))
        self.named("More", self.fog.data.materials[0])
        linked(self.spot, "receiver_collection", [self.fog])
        _, report = export(bpy.context.evaluated_depsgraph_get())
        self.assertEqual([(entry.what, entry.in_fog) for entry in report.entries], [("overlaps fog that other lamps light, or other rays see", True)])

    def test_more_sets_than_are_told_apart_are_named(self):
        for number in range(70):
            thing = bpy.data.objects.new("Part", self.ball.data)
            self.scene.collection.objects.link(thing)
            lamp = cycles.lamp("POINT", (0, 0, 3), energy=1.0, shadow_soft_size=0)
            linked(lamp, "receiver_collection", [thing])
        made, report = export(bpy.context.evaluated_depsgraph_get())
        self.assertTrue(any(entry.what == "more than 64 sets of objects" and entry.in_fog for entry in report.entries))
        self.assertFalse(made.object_rules["light_set"].any())


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent))
    harness.main()
