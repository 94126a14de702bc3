# SPDX-License-Identifier: GPL-3.0-or-later
"""Sky Textures: what they send from all directions, and from their sun, against what Cycles shows and lights."""

import sys
import unittest
from math import pi, radians
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from mathutils import Vector

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402
from scenes_export import node, shader  # noqa: E402

from addon.export import other_blender, sky_texture  # noqa: E402
from addon.host import Cancelled  # noqa: E402
from addon.export.textures import sky_cells  # noqa: E402
from addon.host.scene import LightKind  # noqa: E402

MODELS = [item.identifier for item in bpy.types.ShaderNodeTexSky.bl_rna.properties["sky_type"].enum_items]
WITH_SUN = [model for model in MODELS if model in sky_texture._WITH_SUN]


def under(model, rotation=None, tint=None, **settings):
    """Gives the scene a sky of a Sky Texture, turned by a Mapping node and multiplied by a colour."""

    def make(tree):
        background, sky = node(tree, "Background", {"Strength": 0.5}), node(tree, "TexSky", sky_type=model)
        sky.sun_direction, sky.sun_elevation, sky.sun_rotation = (0.5, 0.3, 0.4), radians(25), radians(70)
        for name, value in settings.items():
            setattr(sky, name, value)
        colour = sky.outputs[0]
        # With a sun its input is switched off.
        if rotation is not None:
            place, mapping = node(tree, "TexCoord"), node(tree, "Mapping", {"Rotation": rotation})
            tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
            tree.links.new(mapping.outputs[0], sky.inputs["Vector"])
        if tint is not None:
            mix = node(tree, "Mix", {"B_Color": tint, "Factor_Float": 1.0}, data_type="RGBA", blend_type="MULTIPLY")
            tree.links.new(colour, next(s for s in mix.inputs if s.identifier == "A_Color"))
            colour = next(s for s in mix.outputs if s.identifier == "Result_Color")
        tree.links.new(colour, background.inputs["Color"])
        return background

    return scenes.world(make)


class SkyTexture(unittest.TestCase):
    def setUp(self):
        scenes.empty()

    def lights(self):
        """The exported sky and sun, or None for the latter; nothing is reported."""
        made, report = scenes.exported()
        self.assertEqual(str(report), "")
        of = {light.kind: light for light in made.lights}
        return of[LightKind.WORLD], of.get(LightKind.SUN)

    def test_radiance_is_that_of_cycles_in_all_directions(self):
        for model in MODELS:
            with self.subTest(model):
                scenes.empty()
                world = under(model, (0.3, -0.4, 0.8), (1.0, 0.6, 0.3), sun_disc=False)
                # It is looked at and lights nothing: Cycles need not find where it is bright, which takes longest.
                world.cycles.sampling_method = "NONE"
                sky, sun = self.lights()
                self.assertIsNone(sun)
                eye = bpy.context.scene.camera
                for direction in ((1, 0.2, 0.3), (-0.3, 0.8, 0.5), (0.1, -0.4, 0.9), (-0.5, -0.5, 0.05)):
                    eye.rotation_euler = Vector(direction).to_track_quat("-Z", "Y").to_euler()
                    eye.data.lens_unit, eye.data.angle = "FOV", radians(4)
                    shown = scenes.cycles(16, 4, 4).mean(axis=(0, 1))
                    # Nine looks across the picture, in a sky whose cells are a third of a degree wide.
                    aside = np.tan(radians(4) / 2) * (np.arange(9) - 4) / 4.5
                    turn = np.array(eye.rotation_euler.to_matrix())
                    looks = np.array([(x, y, -1) for x in aside for y in aside]) @ turn.T
                    looks = looks / np.linalg.norm(looks, axis=1, keepdims=True)
                    found = sky.sky[sky_cells(looks, *sky.sky.shape[:2])].mean(axis=0)
                    # What is darker than a ten thousandth lies below the horizon.
                    np.testing.assert_allclose(found, shown, rtol=0.01, atol=1e-4 * sky.sky.max())

    def test_surfaces_are_lit_as_in_cycles(self):
        """A white plain under sky and sun, of whose light the cosine's share arrives."""
        for model in WITH_SUN:
            for settings in ({"tint": (0.5, 1.0, 0.2)}, {"sun_size": radians(20), "sun_intensity": 0.2}):
                with self.subTest(model, **settings):
                    scenes.empty()
                    bpy.context.scene.cycles.max_bounces = 0
                    under(model, **settings)
                    sky, sun = self.lights()
                    self.assertAlmostEqual(np.linalg.norm(sun.axis), 1)
                    rows, columns, _ = sky.sky.shape
                    angle = np.linspace(0, pi, rows + 1)
                    # Of a row of cells, the integral of the cosine from the zenith.
                    weight = np.where(angle[1:] <= pi / 2, (np.sin(angle[1:]) ** 2 - np.sin(angle[:-1]) ** 2) / 2, 0) * 2 * pi / columns
                    expected = np.einsum("yxc,y->c", sky.sky.astype(np.float64), weight)
                    expected += sun.irradiance * max(-sun.axis[2], 0)
                    scenes.grid(size=2, material=scenes.material("White", shader("BsdfDiffuse", {"Color": (1, 1, 1)})))
                    shown = scenes.cycles_at((0, 0, 0), 4096) * pi
                    # Of what arrives, most is the sun's: it is as bright as in Cycles.
                    self.assertGreater(sun.irradiance[1] * -sun.axis[2], 0.3 * shown[1])
                    np.testing.assert_allclose(expected, shown, rtol=0.01)

    def test_a_sun_below_the_horizon_is_none(self):
        under(WITH_SUN[0], sun_elevation=radians(-20))
        made, report = scenes.exported()
        self.assertEqual(([light for light in made.lights if light.kind == LightKind.SUN], str(report)), ([], ""))

    def test_the_same_sky_is_asked_for_once(self):
        under(MODELS[0], sun_elevation=0.123)
        self.lights()
        with mock.patch.object(other_blender, "_run", side_effect=AssertionError):
            self.lights()

    def test_a_sky_in_a_group_is_found(self):
        world = under(WITH_SUN[0])
        tree = world.node_tree
        group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
        group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
        inside, last = group.nodes.new("ShaderNodeTexSky"), group.nodes.new("NodeGroupOutput")
        sky = next(n for n in tree.nodes if n.type == "TEX_SKY")
        for name in ("sky_type", "sun_elevation", "sun_rotation"):
            setattr(inside, name, getattr(sky, name))
        group.links.new(inside.outputs[0], last.inputs[0])
        tree.links.new(node(tree, "Group", node_tree=group).outputs[0], tree.nodes["Background"].inputs["Color"])
        _, sun = self.lights()
        self.assertGreater(sun.irradiance[0], 1)

    def test_without_a_blender_the_sky_is_named(self):
        for command in (["/there/is/none"], [sys.executable, "-c", "raise SystemExit('no luck')"]):
            sky_texture._rendered.cache_clear()
            under(MODELS[0], sun_elevation=0.5)
            with mock.patch.object(other_blender, "command", return_value=command):
                made, report = scenes.exported()
            self.assertEqual(made.lights, [])
            (entry,) = report.entries
            self.assertTrue(entry.in_fog)
            self.assertRegex(str(entry), r"light of the background, which comes from Sky Texture \(.*(no luck|cannot|can be started).*\)")

    def test_a_blender_that_hangs_is_stopped(self):
        from addon.export.scene import export

        sky_texture._rendered.cache_clear()
        under(MODELS[0], sun_elevation=0.6)
        bpy.context.view_layer.update()
        asked = []
        command = [sys.executable, "-c", "import time; time.sleep(60)"]

        def poll():
            asked.append(None)
            return len(asked) < 20

        with mock.patch.object(other_blender, "command", return_value=command):
            self.assertRaises(Cancelled, export, bpy.context.evaluated_depsgraph_get(), poll)
            with mock.patch.object(other_blender, "PATIENCE", 0.3):
                self.assertIn("more than 0.3 s", str(scenes.exported()[1]))


if __name__ == "__main__":
    harness.main()
