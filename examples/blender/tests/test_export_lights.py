# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported lights: the irradiance that the host's Light means, against what Cycles shows on a white diffuse surface."""

import sys
import unittest
from math import pi, radians, tan
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import scenes_export as scenes  # noqa: E402

from addon.host.scene import LightKind, Rays  # noqa: E402

#: Where the surface is; its front is up.
POINT = np.array([0.4, -0.3, 0.1])


def irradiance(light):
    """[W/m^2] at POINT of a host.scene.Light by the words of its class, with sums over its surface."""
    if light.kind == LightKind.SUN:
        return light.irradiance * -light.axis[2]
    if light.kind == LightKind.WORLD:
        return _of_the_sky(light)
    if light.kind in (LightKind.POINT, LightKind.SPOT):
        # A ball all above the horizon gives what a point would.
        d = light.position - POINT
        distance = np.linalg.norm(d)
        value = light.intensity * (d[2] / distance) / distance**2
        if light.kind == LightKind.SPOT:
            t = np.clip((light.axis @ -d / distance - light.cosine) / light.blend, 0, 1)
            value = value * (t * t * (3 - 2 * t))
        return value
    if light.kind == LightKind.MESH:
        a, b, c = (light.triangles[:, k].astype(np.float64) for k in range(3))
        return sum(_patch((a + b + c) / 3, np.cross(b - a, c - a) / 2, light.radiance, both=True))
    s = (np.arange(300) + 0.5) / 300 - 0.5
    x, y = (m.ravel()[:, None] for m in np.meshgrid(s, s))
    inside = x**2 + y**2 <= 0.25 if light.round else np.full(x.shape, True)
    across = np.cross(light.u, light.v)
    patches = _patch(light.position + x * light.u + y * light.v, across / s.size**2, light.radiance, light.spread)
    return np.sum(patches * inside, axis=0)


def _of_the_sky(light):
    """Sums over directions, finer than the cells."""
    rows, columns, _ = light.sky.shape
    s = (np.arange(480) + 0.5) / 480
    theta, azimuth = (m.ravel() for m in np.meshgrid(pi * s, pi * (1 - 2 * s), indexing="ij"))
    seen = light.sky[(theta / pi * rows).astype(int), ((1 - azimuth / pi) / 2 * columns).astype(int)]
    ways = np.stack([np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth), np.cos(theta)], axis=1)
    up = np.maximum((ways @ light.turn)[:, 2], 0)
    return (up * np.sin(theta)) @ seen * (2 * pi / 480) * (pi / 480)


def _patch(positions, area, radiance, spread=pi / 2, both=False):
    """Irradiance at POINT of small pieces of surface with vectors of area."""
    d = POINT - positions
    square = np.sum(d * d, axis=-1, keepdims=True)
    area = np.broadcast_to(area, d.shape)
    size = np.linalg.norm(area, axis=-1, keepdims=True)
    cosine = np.sum(d * area, axis=-1, keepdims=True) / np.sqrt(square) / size
    cosine = np.abs(cosine) if both else np.maximum(cosine, 0)
    if spread < pi / 2:
        tangent = np.sqrt(1 / np.maximum(cosine, 1e-9) ** 2 - 1)
        radiance = radiance * np.maximum(tan(spread) - tangent, 0) / (tan(spread) - spread)
    return radiance * cosine * size * np.maximum(-d[:, 2:], 0) / square**1.5


class Lights(unittest.TestCase):
    def setUp(self):
        scene = scenes.empty()
        scene.cycles.max_bounces = 0
        white = scenes.material("White", scenes.shader("BsdfDiffuse", {"Color": (1, 1, 1)}))
        scenes.grid(size=0.1, material=white).location = POINT

    def compare(self, tolerance=2e-3, samples=256):
        """The export's irradiance is that of Cycles; the tolerance is for the noise of 16 x `samples` samples."""
        exported, _ = scenes.exported()
        expected = sum(irradiance(light) for light in exported.lights)
        # The surface reflects radiance E / pi.
        shown = scenes.cycles_at(POINT, samples) * pi
        np.testing.assert_allclose(expected, shown, rtol=tolerance)
        self.assertGreater(shown.min(), 0)

    def lamp(self, kind, position=(0.2, 0.1, 2.5), target=(0.3, -0.2, 0), scale=(1, 1, 1), **settings):
        """A lamp whose settings the version at hand has."""
        data = bpy.data.lights.new(kind.title(), kind)
        data.energy, data.color = 7.0, (1.0, 0.5, 0.25)
        for name, value in settings.items():
            setattr(data, name, value)
        thing = scenes.add(data, scale=scale)
        scenes.look(thing, position, target)
        return thing

    def test_a_point_light_without_size_has_the_intensity_of_cycles(self):
        self.lamp("POINT", shadow_soft_size=0.0)
        self.compare(1e-4)

    def test_a_ball_has_the_intensity_of_cycles_whatever_its_scale(self):
        self.lamp("POINT", shadow_soft_size=0.5, use_soft_falloff=False, scale=(2, 2, 2))
        self.compare()

    def test_soft_falloff_is_read(self):
        for kind in ("POINT", "SPOT"):
            for soft in (True, False):
                with self.subTest(kind, soft=soft):
                    self.setUp()
                    self.lamp(kind, shadow_soft_size=0.25, use_soft_falloff=soft)
                    exported, report = scenes.exported()
                    self.assertEqual((exported.lights[0].soft, exported.lights[0].radius), (soft, 0.25))
                    # Cycles contradicts itself inside of such a spot.
                    self.assertEqual(len(report), int(kind == "SPOT" and not soft), str(report))

    def test_a_spot_has_the_cone_and_blend_of_cycles(self):
        for size, blend in ((40, 0.0), (40, 1.0), (60, 0.3), (170, 0.8)):
            with self.subTest(size=size, blend=blend):
                self.setUp()
                # 10 degrees off the axis.
                shape = {"spot_size": radians(size), "spot_blend": blend}
                thing = self.lamp("SPOT", shadow_soft_size=0.0, scale=(3, 3, 3), **shape)
                scenes.look(thing, POINT + (0, 0, 2), POINT + (2 * tan(radians(10)), 0, 0))
                self.compare(1e-3)

    def test_areas_of_all_shapes_have_the_radiance_of_cycles(self):
        for shape in ("SQUARE", "RECTANGLE", "DISK", "ELLIPSE"):
            with self.subTest(shape=shape):
                self.setUp()
                self.lamp("AREA", shape=shape, size=0.7, size_y=1.6, scale=(1.5, 0.5, 1), position=(0.2, 1.1, 1.5))
                self.compare()

    def test_a_mirrored_area_shines_to_the_same_side(self):
        self.lamp("AREA", size=0.7, scale=(-1.5, 1, 1))
        self.compare()

    def test_spread_narrows_an_area_as_in_cycles(self):
        for spread in (15, 60, 150):
            with self.subTest(spread=spread):
                self.setUp()
                self.lamp("AREA", size=0.3, spread=radians(spread), target=POINT + (0, 0.02, 0))
                # Many samples see the light dark, or at the border of its spread.
                self.compare(1e-2, samples=1024)

    def test_a_sun_has_the_irradiance_of_cycles_and_half_its_angle(self):
        for angle in (0.0, 0.5, 40.0):
            with self.subTest(angle=angle):
                self.setUp()
                self.lamp("SUN", angle=radians(angle), position=(1, 1, 3))
                self.compare()
                exported, _ = scenes.exported()
                self.assertAlmostEqual(exported.lights[0].angle, radians(angle) / 2, 6)

    @unittest.skipIf(bpy.app.version < (5, 0), "Blender 4.2 has no such settings")
    def test_exposure_temperature_and_normalize_count(self):
        cases = [
            ("POINT", {"shadow_soft_size": 0.3, "use_soft_falloff": False, "normalize": False}),
            ("POINT", {"shadow_soft_size": 0.0, "normalize": False}),
            ("SPOT", {"shadow_soft_size": 0.2, "use_soft_falloff": False, "normalize": False, "spot_size": 3.0}),
            ("AREA", {"size": 0.5, "shape": "DISK", "normalize": False}),
            ("SUN", {"angle": 0.6, "normalize": False}),
            ("SUN", {"angle": 0.0, "normalize": False}),
            ("AREA", {"size": 0.5, "exposure": -1.5, "use_temperature": True, "temperature": 3000}),
        ]
        for kind, settings in cases:
            with self.subTest(kind=kind, **settings):
                self.setUp()
                self.lamp(kind, **settings)
                self.compare()

    def test_a_background_of_one_colour_is_that_of_cycles(self):
        first, second = (scenes.shader("Background", {"Color": c, "Strength": s}) for c, s in (((1, 0.5, 0.2), 2.0), ((0, 1, 1), 0.5)))
        scenes.world(scenes.joined("AddShader", first, scenes.joined("MixShader", first, second, 0.25)))
        self.compare(1e-2)
        scenes.world(scenes.shader("Background", {"Color": (0, 0, 0)}))
        self.assertEqual(scenes.exported()[0].lights, [])

    def test_a_picture_of_the_sky_is_that_of_cycles_however_it_is_turned(self):
        cells = np.random.default_rng(1).uniform(0, 1, (8, 16, 3)) ** 6

        def picture(tree, kind=None, rotation=(0, 0, 0), scale=(1, 1, 1)):
            image = bpy.data.images.new("Sky", 16, 8, float_buffer=True)
            image.colorspace_settings.name = "Non-Color"
            image.pixels.foreach_set(np.concatenate([cells[::-1], np.ones((8, 16, 1))], axis=2).astype(np.float32).ravel())
            image.update()
            background = scenes.node(tree, "Background", {"Strength": 2.0})
            sky = scenes.node(tree, "TexEnvironment", interpolation="Closest")
            sky.image = image
            tree.links.new(sky.outputs[0], background.inputs["Color"])
            if kind is not None:
                mapping = scenes.node(tree, "Mapping", {"Rotation": rotation, "Scale": scale}, vector_type=kind)
                tree.links.new(scenes.node(tree, "TexCoord").outputs["Generated"], mapping.inputs["Vector"])
                tree.links.new(mapping.outputs["Vector"], sky.inputs["Vector"])
            return background

        turn = (1.1, -0.6, 2.5)
        for kind, rotation in ((None, None), ("POINT", turn), ("TEXTURE", turn), ("VECTOR", turn), ("NORMAL", turn)):
            with self.subTest(kind):
                self.setUp()
                scenes.world(lambda tree: picture(tree, kind, rotation))
                # Of the 16 x 256 samples, a few percent see the brightest cells.
                self.compare(3e-2, samples=1024)
        # Stretched as well.
        self.setUp()
        scenes.world(lambda tree: picture(tree, "POINT", turn, (1, 2, 1)))
        self.compare(3e-2, samples=1024)

    def test_a_sky_that_cannot_be_read_is_left_out_and_named(self):
        def computed(tree):
            background = scenes.node(tree, "Background")
            tree.links.new(scenes.node(tree, "AmbientOcclusion").outputs["Color"], background.inputs["Color"])
            return background

        for surface, words in ((computed, "Ambient Occlusion"), (scenes.shader("Emission"), "Emission as a background")):
            scenes.world(surface)
            made, report = scenes.exported()
            self.assertEqual(made.lights, [])
            (entry,) = report.entries
            self.assertIn(words, entry.what)
            self.assertTrue(entry.in_fog)

    def test_nothing_comes_through_fog_without_end(self):
        scenes.world(scenes.shader("Background"), scenes.shader("VolumeScatter"))
        made, report = scenes.exported()
        self.assertEqual((made.lights, len(report)), ([], 0))

    def test_the_emission_node_of_a_light_multiplies_its_strength(self):
        thing = self.lamp("POINT", shadow_soft_size=0.0)
        tree = scenes.tree_of(thing.data)
        emission = scenes.node(tree, "Emission", {"Color": (0.2, 0.5, 1.0), "Strength": 3.0})
        tree.links.new(emission.outputs[0], scenes.node(tree, "OutputLight").inputs["Surface"])
        self.compare(1e-4)

    def test_emitting_triangles_shine_to_both_sides(self):
        glow = scenes.material("Glow", scenes.shader("Emission", {"Color": (1, 0.5, 0.2), "Strength": 4.0}))
        inputs = {"Emission Color": (0, 1, 1), "Emission Strength": 2.0}
        shine = scenes.material("Shine", scenes.shader("BsdfPrincipled", inputs))
        for material, turn, x in ((glow, 0.3, 0.5), (shine, pi - 0.4, -0.7)):
            # Small against its distance: the sum over whole triangles is then within 1e-3.
            thing = scenes.grid(size=0.05, material=material)
            thing.location, thing.rotation_euler, thing.scale = (x, 0, 1.6), (turn, 0, 0), (1, 2, 1)
        self.compare(3e-3, samples=1024)

    def test_a_blackbody_has_the_colour_of_cycles(self):
        for temperature in (1200, 2700, 6500, 11000):
            with self.subTest(temperature=temperature):
                self.setUp()

                def make(tree, temperature=temperature):
                    emission, heat = scenes.node(tree, "Emission"), scenes.node(tree, "Blackbody")
                    heat.inputs[0].default_value = temperature
                    tree.links.new(heat.outputs[0], emission.inputs["Color"])
                    return emission

                scenes.grid(size=0.05, material=scenes.material("Glow", make)).location = (0.3, 0, 1.5)
                made, _ = scenes.exported()
                colour = scenes.cycles_at((0.3, 0, 1.5), 4)
                # Cycles has a fit of the colours, good to a few thousandths.
                np.testing.assert_allclose(made.lights[0].radiance, colour, atol=5e-3 * colour.max())

    def test_lights_that_shine_nowhere_are_left_out(self):
        self.lamp("POINT").hide_render = True
        self.lamp("POINT", energy=0.0)
        self.assertEqual(scenes.exported()[0].lights, [])

    def test_lights_that_cycles_keeps_out_of_fog_are_kept_out_of_it(self):
        self.lamp("POINT").visible_volume_scatter = False
        thing = scenes.grid(material=scenes.material("Glow", scenes.shader("Emission")))
        thing.visible_volume_scatter = False
        hidden = [light.hidden_from & Rays.VOLUME for light in scenes.exported()[0].lights]
        self.assertEqual(hidden, [Rays.VOLUME, Rays.VOLUME])

    def test_a_ball_shines_along_the_normals_that_are_seen_of_it(self):
        """Of light that goes by 1/2 + n_x / 2 of the normal there, 1/2 + x / 3 goes along a direction: the mean of a ball's normals, as it is seen, is
        2/3 of that."""
        tree = scenes.tree_of(self.lamp("POINT", shadow_soft_size=0.1, use_soft_falloff=False).data)
        place, split, half = scenes.node(tree, "TexCoord"), scenes.node(tree, "SeparateXYZ"), scenes.node(tree, "Math")
        emission, half.operation = scenes.node(tree, "Emission"), "MULTIPLY_ADD"
        half.inputs[1].default_value = half.inputs[2].default_value = 0.5
        tree.links.new(place.outputs["Normal"], split.inputs[0])
        tree.links.new(split.outputs["X"], half.inputs[0])
        tree.links.new(half.outputs[0], emission.inputs["Strength"])
        tree.links.new(emission.outputs[0], scenes.node(tree, "OutputLight").inputs["Surface"])
        (light,), report = scenes.exported()[0].lights, scenes.exported()[1]
        self.assertFalse(any(entry.in_fog for entry in report.entries), str(report))
        cells = light.pattern.cells[..., 0]
        rows, columns = cells.shape
        angle, turn = (np.arange(rows) + 0.5) * pi / rows, (np.arange(columns) + 0.5) * 2 * pi / columns
        expected = 0.5 + np.outer(np.sin(angle), np.cos(turn)) / 3
        # 256 normals, and what lies between coarse cells.
        np.testing.assert_allclose(cells, expected, atol=4e-3)

    def test_instances_of_lights_are_lights(self):
        thing = self.lamp("POINT")
        collection = bpy.data.collections.new("Lamps")
        collection.objects.link(thing)
        bpy.context.scene.collection.objects.unlink(thing)
        for x in (1.0, -2.0):
            scenes.add(None, instance_type="COLLECTION", instance_collection=collection, location=(x, 0, 0))
        positions = [light.position for light in scenes.exported()[0].lights]
        np.testing.assert_allclose(positions, [(1.2, 0.1, 2.5), (-1.8, 0.1, 2.5)], atol=1e-6)


if __name__ == "__main__":
    unittest.main()
