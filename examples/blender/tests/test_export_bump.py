# SPDX-License-Identifier: GPL-3.0-or-later
"""Bump, normal maps and displacement: normals, and where surfaces are, against Cycles' pass of normals, closed forms and real waves."""

import sys
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np
from mathutils import Vector

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import exr  # noqa: E402
import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402
from fog_light import blocks, with_covbeam  # noqa: E402
from scenes_export import node  # noqa: E402


def glass(name="Glass", kind="BsdfGlass", **settings):
    return scenes.material(name, scenes.shader(kind, settings))


def noise(tree, scale=2.0, coordinates="Object"):
    """The output of a noise texture."""
    texture = node(tree, "TexNoise", {"Scale": scale, "Detail": 1.0})
    tree.links.new(node(tree, "TexCoord").outputs[coordinates], texture.inputs["Vector"])
    return texture.outputs[0]


def squared(tree):
    """Heights x^2, of where the surface was."""
    parts, product = node(tree, "SeparateXYZ"), node(tree, "Math", operation="MULTIPLY")
    tree.links.new(node(tree, "TexCoord").outputs["Object"], parts.inputs[0])
    for k in range(2):
        tree.links.new(parts.outputs["X"], product.inputs[k])
    return product.outputs[0]


def bump(material, height=noise, strength=1.0, distance=0.1, normal=None, **settings):
    """Bends a material's normals by a Bump node; returns that."""
    tree = material.node_tree
    made = node(tree, "Bump", {"Strength": strength, "Distance": distance}, **settings)
    tree.links.new(height(tree), made.inputs["Height"])
    if normal is not None:
        tree.links.new(normal.outputs[0], made.inputs["Normal"])
    tree.links.new(made.outputs[0], next(n for n in tree.nodes if n.type.startswith("BSDF")).inputs["Normal"])
    return made


def mapped(material, space, strength=1.0, up=0.9):
    """Bends a material's normals by a normal map of noise."""
    tree = material.node_tree
    colour, made = node(tree, "CombineXYZ", {"Z": up}), node(tree, "NormalMap", {"Strength": strength}, space=space)
    for axis, scale in (("X", 3.0), ("Y", 4.0)):
        narrow = node(tree, "MapRange", {"From Min": 0.3, "From Max": 0.7, "To Min": 0.4, "To Max": 0.6})
        tree.links.new(noise(tree, scale, "UV"), narrow.inputs["Value"])
        tree.links.new(narrow.outputs[0], colour.inputs[axis])
    tree.links.new(colour.outputs[0], made.inputs["Color"])
    tree.links.new(made.outputs[0], next(n for n in tree.nodes if n.type.startswith("BSDF")).inputs["Normal"])
    return material


def displace(material, method, kind="Displacement", space="OBJECT", scale=0.2, height=noise):
    """Gives a material's output a displacement."""
    tree = material.node_tree
    made = node(tree, kind, {"Midlevel": 0.5, "Scale": scale}, space=space)
    tree.links.new(height(tree), made.inputs["Height" if kind == "Displacement" else "Vector"])
    tree.links.new(made.outputs[0], tree.nodes["Material Output"].inputs["Displacement"])
    material.displacement_method = method
    return material


def square(material, count=1, smooth=False, **settings):
    """A square of 2 m with texture coordinates, as count x count faces."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=count, y_subdivisions=count, size=2)
    return finished(material, smooth, settings)


def finished(material, smooth, settings):
    thing = bpy.context.object
    thing.data.materials.append(material)
    if smooth:
        thing.data.shade_smooth()
    for name, value in settings.items():
        setattr(thing, name, value)
    return thing


def cube(material, smooth=False, **settings):
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    return finished(material, smooth, settings)


def ball(material, **settings):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.9)
    return finished(material, True, settings)


class Normals(unittest.TestCase):
    """What Cycles shows as normals, from above at a slant. Its slopes are those across a pixel, or a tenth of one since Blender 5.0."""

    size, rays = 56, 3

    def setUp(self):
        scenes.empty()

    def cycles(self, scene):
        scene.view_layers[0].use_pass_normal = True
        scene.cycles.samples = 8
        scene.render.resolution_x = scene.render.resolution_y = self.size
        harness.write_exr(scene.render.image_settings)
        with TemporaryDirectory() as folder:
            scene.render.filepath = str(Path(folder) / "normals.exr")
            bpy.ops.render.render(write_still=True)
            found = exr.read(Path(scene.render.filepath))
        harness.write_exr(scene.render.image_settings, layers=False)
        return np.stack([next(v for k, v in found.items() if k.endswith(f".Normal.{axis}")) for axis in "XYZ"], axis=-1)

    def covbeam(self, camera):
        """Mean normals of pixels."""
        made, _ = scenes.exported()
        count = self.size * self.rays
        y, x = ((np.indices((count, count)) + 0.5) / count - 0.5) * camera.data.ortho_scale
        matrix = np.array(camera.matrix_world)
        places = np.stack([x.ravel(), -y.ravel(), np.zeros(count * count)], axis=1) @ matrix[:3, :3].T + matrix[:3, 3]
        ways = np.broadcast_to(np.float32(-matrix[:3, 2]), places.shape)
        hits = made.geometry.cast(places.astype(np.float32), ways)
        normals = np.where((hits["distance"] < 1e4)[:, None], hits["normal"], 0)
        normals = np.where(((normals * ways).sum(axis=1) > 0)[:, None], -normals, normals)
        return normals.reshape(self.size, self.rays, self.size, self.rays, 3).mean(axis=(1, 3))

    def compare(self, off, spread):
        """off: what normals may differ by on average, and spread: what those of Cycles do at least differ from their mean by, in degrees."""
        scene, camera = bpy.context.scene, bpy.context.scene.camera
        camera.data.type, camera.data.ortho_scale = "ORTHO", 1.8
        scenes.look(camera, Vector((0.2, 0.1, 1)).normalized() * 5, (0, 0, 0))
        bpy.context.view_layer.update()
        expected = self.cycles(scene)
        found = self.covbeam(camera)
        whole = (np.linalg.norm(expected, axis=2) > 0.5) & (np.linalg.norm(found, axis=2) > 0.5)
        self.assertGreater(whole.mean(), 0.2)
        a, b = (of[whole] / np.linalg.norm(of[whole], axis=1, keepdims=True) for of in (found, expected))
        apart = np.degrees(np.arccos(np.clip((a * b).sum(axis=1), -1, 1)))
        mean = b.mean(axis=0) / np.linalg.norm(b.mean(axis=0))
        self.assertGreater(np.degrees(np.arccos(np.clip(b @ mean, -1, 1))).mean(), spread)
        # A shift by a part of a pixel that Cycles' one-sided differences make.
        self.assertLess(apart.mean(), off * (1 if bpy.app.version >= (5, 0) else 8), f"{apart.mean():.2f} degrees")

    def test_bump(self):
        for settings in ({}, {"strength": 0.4, "invert": True}, {"distance": 0.03}):
            with self.subTest(settings=settings):
                scenes.empty()
                square(glass())
                bump(bpy.context.object.data.materials[0], **settings)
                self.compare(0.6, 1.2)

    def test_bump_on_objects_that_are_stretched_turned_and_mirrored(self):
        for scale, rotation in (((0.7, 1.5, 2), (0.3, 0.2, 0.5)), ((-1, 1, 1), (0.1, 0.2, 0.5))):
            with self.subTest(scale=scale):
                scenes.empty()
                bump(square(glass(), scale=scale, rotation_euler=rotation).data.materials[0])
                self.compare(0.8, 3)

    def test_bump_on_round_and_on_flat_things(self):
        for make, off in ((ball, 0.6), (cube, 1.0)):
            with self.subTest(make=make.__name__):
                scenes.empty()
                bump(make(glass(), rotation_euler=(0.3, 0.4, 0.5)).data.materials[0], distance=0.05)
                self.compare(off, 10)

    def test_bump_of_a_bump(self):
        made = glass()
        first = node(made.node_tree, "Bump", {"Strength": 0.7, "Distance": 0.05})
        made.node_tree.links.new(noise(made.node_tree, 5.0), first.inputs["Height"])
        square(made)
        bump(made, normal=first)
        self.compare(0.8, 5)

    def test_normal_maps(self):
        for space, strength, up, rotation in (
            ("TANGENT", 1.0, 0.9, (0.1, 0.2, 0.8)),
            ("TANGENT", 0.5, 0.9, (0.1, 0.2, 0.8)),
            ("OBJECT", 1.0, 0.9, (0.1, 0.2, 0.8)),
            ("WORLD", 0.7, 0.9, (0.1, 0.2, 0.8)),
            ("BLENDER_OBJECT", 1.0, 0.1, (0.1, 0.2, 0.8)),
        ):
            with self.subTest(space=space, strength=strength):
                scenes.empty()
                square(mapped(glass(), space, strength, up), rotation_euler=rotation, scale=(1, 1.3, 1))
                self.compare(0.3, 3)

    def test_a_normal_map_on_faces_of_many_corners(self):
        bpy.ops.mesh.primitive_circle_add(vertices=7, radius=1.2, fill_type="NGON")
        thing = finished(mapped(glass(), "TANGENT"), False, {})
        layer = thing.data.uv_layers.new(name="Places")
        for loop in thing.data.loops:
            layer.data[loop.index].uv = thing.data.vertices[loop.vertex_index].co.xy
        self.compare(0.3, 3)

    def test_a_normal_map_without_texture_coordinates_does_nothing(self):
        thing = square(mapped(glass(), "TANGENT"))
        thing.data.uv_layers.remove(thing.data.uv_layers[0])
        made, report = scenes.exported()
        self.assertEqual(str(report), "")
        self.assertEqual(made.geometry.triangle_count, 2)

    def test_displacement_as_bump(self):
        square(displace(glass(), "BUMP", space="WORLD"), 20, True, scale=(1, 1.2, 1.5))
        self.compare(1.0, 5)

    def test_displacement(self):
        for name, settings, look in (
            ("smooth", {}, {"smooth": True}),
            ("flat", {}, {}),
            ("stretched", {}, {"smooth": True, "scale": (0.8, 1, 2), "rotation_euler": (0.2, 0.3, 0)}),
            ("of the world", {"space": "WORLD"}, {"smooth": True, "scale": (0.8, 1, 2), "rotation_euler": (0.2, 0.3, 0)}),
            ("vectors", {"kind": "VectorDisplacement", "space": "TANGENT"}, {"smooth": True, "rotation_euler": (0.2, 0.3, 0)}),
        ):
            with self.subTest(name):
                scenes.empty()
                square(displace(glass(), "DISPLACEMENT", **settings), 24, **look)
                self.compare(0.8, 5)

    def test_displaced_and_bumped(self):
        square(displace(glass(), "BOTH", height=squared), 10, True, scale=(1, 1, 1.5))
        self.compare(0.6, 5)

    def test_vertices_go_along_their_normals_and_sharp_edges_tear(self):
        cube(displace(glass(), "DISPLACEMENT", scale=0.4), rotation_euler=(0.3, 0.4, 0.5))
        self.compare(0.8, 20)
        scenes.empty()
        thing = cube(displace(glass(), "DISPLACEMENT", scale=0.4), True, rotation_euler=(0.3, 0.4, 0.5))
        for edge in thing.data.edges:
            edge.use_edge_sharp = edge.index % 3 == 0
        modifier = thing.modifiers.new("Finer", "SUBSURF")
        modifier.subdivision_type, modifier.levels, modifier.render_levels = "SIMPLE", 3, 3
        # Pixels at the tears are of several faces. Without tears it would be 3 degrees, with faces torn apart 11.
        self.compare(2.5, 20)

    def test_one_of_two_materials_moves(self):
        thing = square(displace(glass(), "DISPLACEMENT", scale=0.4), 20, True)
        thing.data.materials.append(glass("Plain"))
        for face in thing.data.polygons:
            face.material_index = int(face.center.x > 0)
        self.compare(0.4, 3)


class Meshes(unittest.TestCase):
    def setUp(self):
        scenes.empty()

    def test_objects_that_are_stretched_alike_share_a_mesh(self):
        made = glass()
        bump(made)
        first = square(made)
        pieces = scenes.exported()[0].geometry.triangle_count
        for turn in (1.0, 2.0):
            scenes.add(first.data, f"Turned {turn}", rotation_euler=(0, 0, turn), location=(3 * turn, 0, 0))
        self.assertEqual(scenes.exported()[0].geometry.triangle_count, pieces)
        scenes.add(first.data, "Larger", scale=(2, 2, 2), location=(0, 5, 0))
        self.assertGreater(scenes.exported()[0].geometry.triangle_count, 1.5 * pieces)

    def test_objects_with_other_materials_do_not(self):
        high, low = (displace(glass(name), "DISPLACEMENT", scale=scale, height=self.one) for name, scale in (("High", 2.0), ("Low", -2.0)))
        first = square(high)
        other = scenes.add(first.data, "Other", location=(5, 0, 0))
        other.material_slots[0].link = "OBJECT"
        other.material_slots[0].material = low
        made, _ = scenes.exported()
        down = np.float32([(0, 0, -1), (0, 0, -1)])
        hits = made.geometry.cast(np.float32([(0.1, 0.2, 9), (5.1, 0.2, 9)]), down)
        np.testing.assert_allclose(hits["position"][:, 2], [1, -1], atol=1e-5)

    def one(self, tree):
        made = node(tree, "Value")
        made.outputs[0].default_value = 1.0
        return made.outputs[0]

    def test_what_cycles_dices_is_cut_before_it_moves(self):
        thing = square(displace(glass(), "DISPLACEMENT", scale=0.5, height=squared))
        modifier = thing.modifiers.new("Finer", "SUBSURF")
        modifier.subdivision_type, modifier.levels, modifier.render_levels = "SIMPLE", 1, 1
        places = np.random.default_rng(1).uniform((-0.99, -0.99, 5), (0.99, 0.99, 5), (200, 3)).astype(np.float32)
        down, off = np.broadcast_to(np.float32([0, 0, -1]), places.shape), []
        for diced in (False, True):
            (modifier if bpy.app.version >= (5, 0) else thing.cycles).use_adaptive_subdivision = diced
            hits = scenes.exported()[0].geometry.cast(places, down)
            off.append(np.abs(hits["position"][:, 2] - 0.5 * (places[:, 0].astype(np.float64) ** 2 - 0.5)).max())
        self.assertGreater(off[0], 0.05)
        self.assertLess(off[1], 1e-4)

    def test_pieces_end_where_normals_are_met(self):
        made = glass()
        bump(made, self.one)
        square(made)
        self.assertEqual(scenes.exported()[0].geometry.triangle_count, 2)

    def test_what_is_finer_than_all_pieces_is_reported(self):
        made = glass()
        bump(made, lambda tree: noise(tree, 2000.0), distance=0.001)
        square(made)
        exported, report = scenes.exported()
        self.assertLess(exported.geometry.triangle_count, 700_000)
        self.assertRegex(
            str(report), r'Material "Glass": bump or normal map that varies finely: [\d,]+ pieces, whose normals are \d+\.\d° off on average'
        )
        self.assertTrue(any(entry.in_fog for entry in report.entries))

    def test_matt_surfaces_keep_their_normals(self):
        made = glass(kind="BsdfDiffuse")
        bump(made)
        square(made)
        exported, report = scenes.exported()
        self.assertEqual(exported.geometry.triangle_count, 2)
        self.assertRegex(str(report), 'Material "Glass": bump or normal map of a matt surface: ignored')

    def test_faces_without_area_and_values_that_are_none(self):
        made = displace(glass(), "BOTH", scale=float("inf"))
        bump(made, strength=float("nan"))
        mesh = bpy.data.meshes.new("Slivers")
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 0, 0), (1, 1, 1)], [], [(0, 1, 2), (0, 3, 4), (0, 1, 4)])
        mesh.materials.append(made)
        scenes.add(mesh)
        exported, _ = scenes.exported()
        hits = exported.geometry.cast(np.float32([(0.6, 0.2, 5)]), np.float32([(0, 0, -1)]))
        self.assertTrue(np.isfinite(hits["normal"]).all())

    def test_a_cut_out_that_is_bumped(self):
        """Bumps and holes of one material: half of a square is there, as bumpy as the whole."""

        def half(tree):
            mix, step, parts = node(tree, "MixShader"), node(tree, "Math", {"Value_001": 0.5}, operation="GREATER_THAN"), node(tree, "SeparateXYZ")
            tree.links.new(node(tree, "TexCoord").outputs["UV"], parts.inputs[0])
            tree.links.new(parts.outputs["X"], step.inputs[0])
            tree.links.new(step.outputs[0], mix.inputs[0])
            tree.links.new(node(tree, "BsdfTransparent").outputs[0], mix.inputs[1])
            tree.links.new(node(tree, "BsdfGlass").outputs[0], mix.inputs[2])
            return mix

        whole, cut = glass(), scenes.material("Half", half)
        for made in (whole, cut):
            tree = made.node_tree
            texture = node(tree, "Bump", {"Strength": 1.0, "Distance": 0.1})
            tree.links.new(noise(tree), texture.inputs["Height"])
            tree.links.new(texture.outputs[0], next(n for n in tree.nodes if n.type == "BSDF_GLASS").inputs["Normal"])
        square(whole)
        square(cut, location=(0, 0, 1))
        exported, _ = scenes.exported()
        places = np.random.default_rng(1).uniform((-0.99, -0.99, 5), (0.99, 0.99, 5), (500, 3)).astype(np.float32)
        hits = exported.geometry.cast(places, np.broadcast_to(np.float32([0, 0, -1]), places.shape))
        np.testing.assert_allclose(hits["position"][:, 2], places[:, 0] > 0, atol=1e-5)
        below = exported.geometry.cast(
            places * np.float32([1, 1, 0]) + np.float32([0, 0, 0.5]), np.broadcast_to(np.float32([0, 0, -1]), places.shape)
        )
        # Both are as they are seen: the height's slopes do not depend on where the object is.
        apart = np.degrees(np.arccos(np.clip((hits["normal"] * below["normal"]).sum(axis=1), -1, 1)))
        self.assertLess(apart.mean(), 0.5)
        self.assertGreater(np.degrees(np.arccos(hits["normal"][:, 2])).mean(), 3)


class Waves(unittest.TestCase):
    def test_light_below_bumped_water_is_that_below_waves(self):
        """A spot through a sheet of water: once flat with a bump, once as fine as the waves are."""
        pictures = []
        for real in (False, True):
            scene = scenes.empty()
            scene.render.resolution_x = scene.render.resolution_y = 32
            scene.cycles.samples = 1
            scenes.look(scene.camera, (0, -6, 1.8), (0, 0, 1.5))
            scenes.box("Fog", (-3, -2.5, 0.02), (3, 2.5, 4), scenes.material("Fog", volume=scenes.shader("VolumeScatter", {"Density": 0.15})))
            water = glass("Water", IOR=1.33)
            self.flat(water) if not real else self.fine(water)
            lamp = scenes.add(bpy.data.lights.new("Spot", "SPOT"))
            lamp.data.energy, lamp.data.spot_size, lamp.data.spot_blend, lamp.data.shadow_soft_size = 500, 0.5, 0.2, 0.02
            lamp.data.use_soft_falloff = True
            scenes.look(lamp, (0, 0, 3.8), (0.2, 0, 0))
            bpy.context.view_layer.update()
            run, _ = with_covbeam(1, 12, 2, 0, passes=6)
            pictures.append(run.picture)
        found, expected = (blocks(picture, 8) for picture in pictures)
        bright = expected > 0.2 * expected.mean()
        # Waves of 3 cm are elsewhere by as much; the rest is noise.
        np.testing.assert_allclose(found[bright] / expected[bright], 1, atol=0.12)
        self.assertAlmostEqual(found.mean() / expected.mean(), 1, delta=0.03)

    def flat(self, water):
        def height(tree):
            place, parts, both = node(tree, "TexCoord"), node(tree, "SeparateXYZ"), node(tree, "Math", operation="MULTIPLY")
            tree.links.new(place.outputs["Object"], parts.inputs[0])
            for k, (axis, rate) in enumerate((("X", 12.0), ("Y", 9.0))):
                times, wave = node(tree, "Math", {"Value_001": rate}, operation="MULTIPLY"), node(tree, "Math", operation="SINE")
                tree.links.new(parts.outputs[axis], times.inputs[0])
                tree.links.new(times.outputs[0], wave.inputs[0])
                tree.links.new(wave.outputs[0], both.inputs[k])
            return both.outputs[0]

        bump(water, height, distance=0.03)
        square(water, location=(0, 0, 2.4))

    def fine(self, water):
        thing = square(water, 200, True, location=(0, 0, 2.4))
        for vertex in thing.data.vertices:
            vertex.co.z = 0.03 * np.sin(12 * vertex.co.x) * np.sin(9 * vertex.co.y)


if __name__ == "__main__":
    harness.main()
