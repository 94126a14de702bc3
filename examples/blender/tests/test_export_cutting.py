# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that textures make let light through in places: their pieces against closed forms and against what Cycles shows behind them."""

import sys
import unittest
from math import pi
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402
from scenes_export import node, shader  # noqa: E402

from addon.export.meshes import is_closed, triangles  # noqa: E402
from addon.export.quarters import Pieces, corners, mesh_of, middles, piece_at  # noqa: E402


def image(pixels, name="Pattern", colours="Non-Color"):
    """A new image of floats of pixels (h, w, 4), the bottom row first."""
    height, width, _ = pixels.shape
    made = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
    made.colorspace_settings.name = colours
    made.pixels.foreach_set(pixels.astype(np.float32).ravel())
    made.update()
    return made


def disc(size=256, radius=0.35):
    """White, and opaque within a disc in the middle."""
    y, x = (np.indices((size, size)) + 0.5) / size - 0.5
    pixels = np.ones((size, size, 4))
    pixels[..., 3] = x * x + y * y < radius * radius
    return image(pixels)


def panes(count=8):
    """Squares of random colours."""
    pixels = np.ones((count, count, 4))
    pixels[..., :3] = np.random.default_rng(1).random((count, count, 3))
    return image(pixels)


def held_out(of, interpolation="Linear"):
    """A wall where an image is opaque."""

    def make(tree):
        mix, texture = node(tree, "MixShader"), node(tree, "TexImage", image=of, interpolation=interpolation)
        tree.links.new(texture.outputs["Alpha"], mix.inputs[0])
        tree.links.new(node(tree, "BsdfTransparent").outputs[0], mix.inputs[1])
        tree.links.new(node(tree, "BsdfDiffuse").outputs[0], mix.inputs[2])
        return mix

    return make


def coloured(kind, of, socket="Color", **settings):
    """A closure whose colour is an image."""

    def make(tree):
        closure, texture = node(tree, kind), node(tree, "TexImage", image=of, interpolation="Closest", **settings)
        tree.links.new(texture.outputs["Color"], next(s for s in closure.inputs if s.identifier == socket))
        return closure

    return make


def card(material, size=2.0, count=1):
    """A square whose texture coordinates fill it, as count x count faces."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=count, y_subdivisions=count, size=size)
    thing = bpy.context.object
    thing.name = "Card"
    thing.data.materials.append(material)
    return thing


def areas(made, positions):
    """Areas of triangles of a mesh."""
    a, b, c = (positions[made.corners[:, k]].astype(np.float64) for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


class Quarters(unittest.TestCase):
    def test_pieces_are_where_they_are_looked_for(self):
        for level in range(5):
            found = piece_at(middles(level), level)
            np.testing.assert_array_equal(found, np.arange(4**level))
        # A part in the middle is turned; all run around the same way and have the same area.
        u, v = (corners(3)[:, k] - corners(3)[:, 0] for k in (1, 2))
        np.testing.assert_array_equal(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], 1)

    def random(self, mesh, deepest=4):
        """Pieces of all triangles of a mesh, cut at random."""
        rng, parts = np.random.default_rng(2), []
        triangle, number = np.arange(len(mesh.corners)), np.zeros(len(mesh.corners), np.int64)
        for level in range(deepest + 1):
            ends = (rng.random(len(number)) < 0.5) | (level == deepest)
            parts.append(Pieces(triangle[ends], np.full(ends.sum(), level), number[ends], rng.integers(0, 3, ends.sum())))
            triangle, number = np.repeat(triangle[~ends], 4), (4 * number[~ends, None] + np.arange(4)).ravel()
        return Pieces.together(parts)

    def test_a_closed_mesh_stays_closed_whatever_its_pieces(self):
        scenes.empty()
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
        bpy.context.object.data.shade_smooth()
        mesh = triangles(bpy.context.object.data)
        pieces = self.random(mesh)
        made, of = mesh_of(mesh, pieces)
        self.assertGreater(len(made.corners), 5 * len(mesh.corners))
        self.assertTrue(is_closed(made))
        # A negative control: without one piece there is a hole.
        self.assertFalse(is_closed(mesh_of(mesh, pieces[1:])[0]))
        self.assertAlmostEqual(areas(made, made.positions).sum(), areas(mesh, mesh.positions).sum(), delta=1e-4)
        np.testing.assert_array_equal(made.slots, pieces.kind[of])
        # As much of each kind as its pieces are, and corners and normals where those of the sphere's triangles put them.
        each = areas(mesh, mesh.positions)[pieces.triangle] / 4.0**pieces.level
        expected = np.bincount(pieces.kind, each)
        np.testing.assert_allclose(np.bincount(made.slots, areas(made, made.positions)), expected, rtol=1e-5)
        volume = [np.linalg.det(m.positions[m.corners].astype(np.float64)).sum() for m in (mesh, made)]
        self.assertAlmostEqual(volume[0], volume[1], delta=1e-5)
        np.testing.assert_allclose(np.linalg.norm(made.normals, axis=2), 1, atol=1e-6)
        outward = made.positions[made.corners] / np.linalg.norm(made.positions[made.corners], axis=2, keepdims=True)
        self.assertGreater((made.normals * outward).sum(axis=2).min(), 0.99)


class CutOuts(unittest.TestCase):
    def setUp(self):
        scenes.empty()

    def test_a_disc_has_the_area_of_a_disc(self):
        card(scenes.material("Leaf", held_out(disc())))
        made, report = scenes.exported()
        self.assertEqual(str(report), "")
        # Steps of an image of 256 pixels are on both sides of the circle.
        self.assertAlmostEqual(1 - self.through(made, 400).mean(), pi * 0.35**2, delta=1e-3)
        # What is not there has been left out.
        hits = self.looked_at(made, 400)
        self.assertLess((hits["distance"] < 2).mean(), 0.4)
        self.assertLess(made.geometry.triangle_count, 8000)

    def test_panes_have_the_colours_of_the_image(self):
        of = panes()
        card(scenes.material("Window", coloured("BsdfTransparent", of)))
        made, report = scenes.exported()
        hits = self.looked_at(made, 256)
        found = made.materials["transparent"][hits["material"]].reshape(8, 32, 8, 32, 3).mean(axis=(1, 3))
        expected = np.array(of.pixels).reshape(8, 8, 4)[..., :3]
        # 64 colours have become 32.
        np.testing.assert_allclose(found.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), atol=2e-3)
        self.assertLess(np.abs(found - expected).mean(), 0.1)
        self.assertLessEqual(len(np.unique(hits["material"])), 32)
        self.assertRegex(str(report), r"varies finely in what it lets through, or shines: [\d,]+ pieces, which are \d\.\d% off on average")

    def test_few_colours_are_exact(self):
        of = panes(4)
        card(scenes.material("Window", coloured("BsdfTransparent", of)))
        made, report = scenes.exported()
        self.assertEqual(str(report), "")
        hits = self.looked_at(made, 256)
        found = made.materials["transparent"][hits["material"]].reshape(4, 64, 4, 64, 3)[:, 32, :, 32]
        np.testing.assert_allclose(found, np.array(of.pixels).reshape(4, 4, 4)[..., :3], atol=0.02)
        self.assertEqual(made.geometry.triangle_count, len(np.unique(hits["material"])) * 2)

    def looked_at(self, made, count, reach=1.0):
        """Hits of count x count even rays down, the row of the smallest y first."""
        y, x = ((np.indices((count, count)) + 0.5) / count * 2 * reach - reach).reshape(2, -1)
        origins = np.stack([x, y, np.ones_like(x)], axis=1).astype(np.float32)
        return made.geometry.cast(origins, np.broadcast_to(np.float32([0, 0, -1]), origins.shape))

    def through(self, made, count):
        """What goes on straight where `looked_at` looks: (count^2, 3)."""
        hits = self.looked_at(made, count)
        found = made.materials["transparent"][np.maximum(hits["material"], 0)]
        return np.where((hits["distance"] < 2)[:, None], found, 1)

    def test_behind_it_is_what_cycles_shows(self):
        rng = np.random.default_rng(3)
        pixels = rng.random((6, 5, 4))
        pixels[..., 3] = np.round(pixels[..., 3] * 2) / 2
        of = image(pixels, colours="Linear Rec.709")
        small = bpy.data.images.new("Bytes", 6, 5, alpha=True)
        small.pixels.foreach_set(rng.random(120).astype(np.float32))
        small.update()

        def principled(tree):
            made, texture = node(tree, "BsdfPrincipled", {"Specular IOR Level": 0.0}), node(tree, "TexImage", image=small)
            tree.links.new(texture.outputs["Color"], made.inputs["Base Color"])
            tree.links.new(texture.outputs["Alpha"], made.inputs["Alpha"])
            return made

        def both(tree):
            """Colours where alpha is asked for too."""
            clear, texture = node(tree, "BsdfTransparent"), node(tree, "TexImage", image=small)
            one, mix = node(tree, "Math", {"Value_001": 1e-9, "Value_002": 1.0}, operation="MULTIPLY_ADD"), node(tree, "MixShader")
            tree.links.new(texture.outputs["Color"], clear.inputs["Color"])
            tree.links.new(texture.outputs["Alpha"], one.inputs[0])
            tree.links.new(one.outputs[0], mix.inputs[0])
            tree.links.new(clear.outputs[0], mix.inputs[2])
            return mix

        def moved(tree):
            clear, texture = node(tree, "BsdfTransparent"), node(tree, "TexImage", image=of)
            place, mapping = node(tree, "UVMap"), node(tree, "Mapping", {"Scale": (1.7, -2.2, 1), "Rotation": (0, 0, 0.4)})
            tree.links.new(place.outputs[0], mapping.inputs["Vector"])
            tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
            tree.links.new(texture.outputs["Color"], clear.inputs["Color"])
            return clear

        def faded(tree):
            clear, fade = node(tree, "BsdfTransparent"), node(tree, "TexGradient", gradient_type="SPHERICAL")
            tree.links.new(node(tree, "TexCoord").outputs["Object"], fade.inputs["Vector"])
            tree.links.new(next(s for s in fade.outputs if s.identifier == "Fac"), clear.inputs["Color"])
            return clear

        def painted(name):
            def make(tree):
                clear = node(tree, "BsdfTransparent")
                paint = node(tree, "VertexColor") if name is None else node(tree, "Attribute", attribute_name=name)
                tree.links.new(paint.outputs["Color"], clear.inputs["Color"])
                return clear

            return make

        cases = {
            "alpha": held_out(of),
            "closest": held_out(of, "Closest"),
            "principled": principled,
            "colours": coloured("BsdfTransparent", small),
            "colours with alpha": both,
            "moved": moved,
            "faded": faded,
            "painted": painted(None),
            "attribute": painted("Paint"),
            "faces": painted("Faces"),
        }
        for name, make in cases.items():
            with self.subTest(name):
                self.compare(make)

    def compare(self, make, pixels=24, looks=8):
        """What shines through, pixel by pixel, against an unlit surface in front of white."""
        for thing in list(bpy.data.objects):
            if thing.type == "MESH":
                bpy.data.objects.remove(thing)
        thing = card(scenes.material("Card", make), count=3)
        for name, domain in (("Paint", "CORNER"), ("Faces", "FACE")):
            kind = "FLOAT_COLOR" if domain == "CORNER" else "FLOAT_VECTOR"
            made = thing.data.attributes.new(name, kind, domain)
            values = np.random.default_rng(5).random(len(made.data) * (4 if domain == "CORNER" else 3)).astype(np.float32)
            made.data.foreach_set("color" if domain == "CORNER" else "vector", values)
        thing.data.color_attributes.render_color_index = 0
        bpy.context.view_layer.update()
        made, report = scenes.exported()
        self.assertNotIn("mean", str(report))
        through = self.through(made, pixels * looks).reshape(pixels, looks, pixels, looks, 3).mean(axis=(1, 3))[::-1]
        # White behind it, and black in front.
        white = scenes.grid(size=8, material=bpy.data.materials.get("White") or scenes.material("White", shader("Emission")))
        white.location = (0, 0, -1)
        white.visible_diffuse = False
        bpy.context.scene.cycles.max_bounces = 0
        eye = bpy.context.scene.camera
        eye.data.type, eye.data.ortho_scale, eye.location, eye.rotation_euler = "ORTHO", 2.0, (0, 0, 3), (0, 0, 0)
        white.visible_volume_scatter = False
        for light in (True, False):
            bpy.data.materials["White"].node_tree.nodes["Emission"].inputs["Strength"].default_value = float(light)
            shown = scenes.cycles(256, pixels, pixels)
            # What the surface reflects of white is no part of it: there is none in the dark, and none with diffuse rays off.
            lit = shown if light else lit - shown
        self.assertGreater(np.ptp(lit), 0.2)
        np.testing.assert_allclose(through.mean(axis=(0, 1)), lit.mean(axis=(0, 1)), atol=5e-3)
        # 32 colours of a whole cube of them.
        self.assertLess(np.abs(through - lit).mean(), 0.04)

    def test_a_picture_that_shines_sends_out_what_it_has(self):
        of = panes(4)
        card(scenes.material("Screen", coloured("Emission", of)))
        made, report = scenes.exported()
        self.assertEqual(str(report), "")
        power = sum(
            light.radiance * 0.5 * np.linalg.norm(np.cross(*np.diff(light.triangles, axis=1).transpose(1, 0, 2)), axis=1).sum()
            for light in made.lights
        )
        expected = np.array(of.pixels).reshape(16, 4)[:, :3].mean(axis=0)
        np.testing.assert_allclose(power / 4, expected, rtol=1e-3)
        self.assertEqual(len(made.lights), 16)

    def test_a_wall_of_many_colours_reflects_each_where_it_is(self):
        """Few pieces: what lights fog from there has no edges."""
        of = panes(4)
        card(scenes.material("Wall", coloured("BsdfDiffuse", of)))
        made, report = scenes.exported()
        self.assertEqual(str(report), "")
        self.assertLess(made.geometry.triangle_count, 5000)
        wanted = np.unique(np.round(np.array(of.pixels).reshape(16, 4)[:, :3], 2), axis=0)
        found = np.unique(np.round(made.materials["diffuse"], 2), axis=0)
        # Each of its colours is a material's, and there is the one of what is not there.
        far = np.abs(wanted[:, None] - found[None]).max(axis=2).min(axis=1)
        self.assertLess(far.max(), 0.02)

    def test_a_floor_is_as_rough_as_its_texture_where_it_is(self):
        of = panes(4)
        card(scenes.material("Floor", coloured("BsdfPrincipled", of, "Roughness")))
        made, report = scenes.exported()
        self.assertEqual(str(report), "")
        self.assertLess(made.geometry.triangle_count, 5000)
        alpha = made.materials["alpha"][self.looked_at(made, 4)["material"]].reshape(4, 4)
        # A number is a colour's luminance.
        rough = np.array(of.pixels).reshape(4, 4, 4)[..., :3] @ np.array([0.2126, 0.7152, 0.0722])
        np.testing.assert_allclose(alpha, rough**2, atol=0.03)

    def test_textures_that_make_no_difference_are_none(self):
        def mixed(tree):
            made, mix = node(tree, "BsdfDiffuse"), node(tree, "Mix", data_type="RGBA")
            tree.links.new(node(tree, "TexNoise").outputs[0], mix.inputs[0])
            tree.links.new(next(s for s in mix.outputs if s.enabled), made.inputs["Color"])
            return made

        card(scenes.material("Wall", mixed))
        made, report = scenes.exported()
        self.assertEqual(str(report), "")
        np.testing.assert_allclose(made.materials["diffuse"][self.looked_at(made, 4)["material"]], 0.5, atol=1e-6)

    def test_places_in_the_world_are_those_of_each_object(self):
        def bright(tree):
            made, place, size = node(tree, "Emission"), node(tree, "NewGeometry"), node(tree, "VectorMath", operation="ABSOLUTE")
            tree.links.new(place.outputs["Position"], size.inputs[0])
            tree.links.new(size.outputs[0], made.inputs["Color"])
            return made

        first = card(scenes.material("Screen", bright))
        scenes.add(first.data, location=(4, 5, 6))
        made, report = scenes.exported()
        self.assertNotIn("comes from", str(report))
        for middle in (np.zeros(3), np.array([4.0, 5.0, 6.0])):
            near = [light for light in made.lights if np.linalg.norm(light.triangles.mean(axis=(0, 1)) - middle) < 2]
            areas = [0.5 * np.linalg.norm(np.cross(*np.diff(light.triangles, axis=1).transpose(1, 0, 2)), axis=1).sum() for light in near]
            mean = np.average([light.radiance for light in near], axis=0, weights=areas)
            # Around the first it is the mean of |x| between -1 and 1.
            expected = np.where(middle == 0, [0.5, 0.5, 0.0], middle)
            np.testing.assert_allclose(mean, expected, atol=0.02)

    def test_closed_glass_of_many_colours_stays_closed(self):
        bpy.ops.mesh.primitive_cube_add(size=2)
        bpy.context.object.data.materials.append(scenes.material("Glass", coloured("BsdfGlass", panes(4))))
        made, _ = scenes.exported()
        self.assertEqual(made.object_closed.tolist(), [True])
        self.assertGreater(len(np.unique(made.materials["glass_transmission"], axis=0)), 10)

    def test_what_holds_fog_has_no_holes(self):
        material = scenes.material("Veil", held_out(disc()), shader("VolumeScatter"))
        bpy.ops.mesh.primitive_cube_add(size=2)
        bpy.context.object.data.materials.append(material)
        made, _ = scenes.exported()
        self.assertEqual(len(made.volumes), 1)
        hits = self.looked_at(made, 50, 0.99)
        self.assertTrue((hits["distance"] < 2.5).all())
        found = made.materials["transparent"][hits["material"]]
        self.assertEqual((found.min(), found.max()), (0, 1))
        self.assertEqual(made.object_volumes.tolist(), [0])

    def test_copies_share_their_pieces(self):
        first = card(scenes.material("Leaf", held_out(disc())))
        for k in range(20):
            scenes.add(first.data, location=(3 * k, 0, 0))
        made, _ = scenes.exported()
        self.assertLess(made.geometry.triangle_count, 8000)
        self.assertEqual(len(made.object_volumes), 21)

    def test_patterns_as_fine_as_sand_are_their_mean_and_named(self):
        grains = np.ones((1024, 1024, 4))
        grains[..., 3] = np.random.default_rng(7).random((1024, 1024)) < 0.3
        card(scenes.material("Sand", held_out(image(grains), "Closest")), count=20)
        made, report = scenes.exported()
        self.assertLess(made.geometry.triangle_count, 600_000)
        # A prime number of places: 300 and the 320 pieces across would fall into step.
        self.assertAlmostEqual(self.through(made, 401).mean(), 0.7, delta=0.005)
        self.assertIn("varies finely in what it lets through", str(report))


if __name__ == "__main__":
    harness.main()
