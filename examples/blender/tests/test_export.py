# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported cameras and geometry, against what Blender itself projects, casts and crops; the report; time."""

import sys
import time
import unittest
from math import radians
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from covbeam.session import Geometry
from mathutils import Matrix, Vector

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import scenes_export as scenes  # noqa: E402
from host_scenes import directions as eye_rays  # noqa: E402

from addon.export.camera import camera, frame  # noqa: E402
from addon.export.report import Untranslatable  # noqa: E402
from addon.export.scene import export  # noqa: E402
from addon.host import Cancelled  # noqa: E402


class CameraTest(unittest.TestCase):
    def setUp(self):
        self.scene = scenes.empty()
        self.eye = self.scene.camera
        scenes.look(self.eye, (3.0, -4.0, 2.0), (0.1, 0.2, -0.3))
        self.scene.render.resolution_x, self.scene.render.resolution_y = 321, 200

    def export(self):
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return camera(depsgraph, self.eye, *frame(self.scene.render))

    def check(self):
        """Points in front of the camera are met by the eye rays of the pixels that Blender projects them to."""
        made = self.export()
        width, height, (left, top, right, bottom) = frame(self.scene.render)
        self.assertEqual((made.width, made.height), (right - left, bottom - top))
        rng = np.random.default_rng(1)
        matrix = np.array(self.eye.matrix_world)
        points = rng.uniform((-2, -2, -6), (2, 2, -3), (50, 3)) @ matrix[:3, :3].T + matrix[:3, 3]
        seen = np.array([world_to_camera_view(self.scene, self.eye, Vector(p)) for p in points])
        directions = eye_rays(made, seen[:, 0] * width - left, (1 - seen[:, 1]) * height - top)
        expected = points - made.position
        expected /= np.linalg.norm(expected, axis=1, keepdims=True)
        # Single precision, of positions 5 m away.
        np.testing.assert_allclose(directions, expected, atol=3e-6)
        np.testing.assert_allclose(made.position, self.eye.matrix_world.translation, atol=1e-6)
        axes = np.array([made.right, made.up, made.forward])
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)

    def test_sensor_fit_lens_and_shift_are_those_of_blender(self):
        for fit in ("AUTO", "HORIZONTAL", "VERTICAL"):
            for size in ((321, 200), (200, 321)):
                with self.subTest(fit=fit, size=size):
                    self.scene.render.resolution_x, self.scene.render.resolution_y = size
                    data = self.eye.data
                    data.sensor_fit, data.sensor_width, data.sensor_height, data.lens = fit, 30, 40, 27
                    data.shift_x, data.shift_y = 0.2, -0.35
                    self.check()

    def test_a_field_of_view_is_that_of_blender(self):
        self.eye.data.lens_unit, self.eye.data.angle = "FOV", radians(100)
        self.check()

    def test_pixels_need_not_be_square(self):
        for aspect in ((2.0, 1.0), (1.0, 1.7)):
            self.scene.render.pixel_aspect_x, self.scene.render.pixel_aspect_y = aspect
            self.eye.data.shift_x = 0.1
            self.check()

    def test_resolution_percentage_and_border_choose_the_pixels_of_blender(self):
        render = self.scene.render
        # 99 x 66 pixels: the same shape, which Blender's projection takes from the whole resolution.
        render.resolution_x, render.resolution_y, render.resolution_percentage = 300, 200, 33
        render.use_border, render.use_crop_to_border = True, True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.1, 0.7, 0.25, 0.9
        self.check()
        render.resolution_percentage = 100
        made, shown = self.export(), scenes.cycles(1, render.resolution_x, render.resolution_y)
        self.assertEqual(shown.shape[:2], (made.height, made.width))

    def test_the_border_shows_the_part_of_the_picture_that_it_covers(self):
        # The corner of a white square on black, at a known pixel of the whole picture.
        white = scenes.material("White", scenes.shader("Emission"))
        scenes.grid(size=2.0, material=white).location = (1, 1, 0)
        self.eye.location, self.eye.rotation_euler = (0.2, 0.1, 3), (0, 0, 0)
        self.scene.render.use_border = self.scene.render.use_crop_to_border = True
        self.scene.render.border_min_x, self.scene.render.border_max_x = 0.3, 0.8
        self.scene.render.border_min_y, self.scene.render.border_max_y = 0.2, 0.6
        shown = scenes.cycles(1, 300, 200)[..., 0] > 0.5
        made = self.export()
        self.assertEqual(shown.shape, (made.height, made.width))
        y, x = (k.ravel() + 0.5 for k in np.indices(shown.shape))
        directions = eye_rays(made, x, y)
        hit = made.position + directions * (-made.position[2] / directions[:, 2:])
        expected = ((hit[:, 0] > 0) & (hit[:, 1] > 0)).reshape(shown.shape)
        # Cycles' sample lies anywhere in the pixel: the square's two borders may be a pixel off.
        self.assertLess(np.count_nonzero(expected != shown), 1.1 * sum(shown.shape))
        self.assertGreater(np.count_nonzero(shown), 1000)

    def test_scale_does_not_change_a_camera(self):
        self.eye.scale = (2.0, 0.5, 3.0)
        self.check()

    def test_depth_of_field_has_the_opening_and_the_distance_of_blender(self):
        self.assertIsNone(self.export().aperture)
        data = self.eye.data
        data.lens, data.dof.use_dof, data.dof.focus_distance, data.dof.aperture_fstop = 80, True, 3.5, 1.6
        data.dof.aperture_blades, data.dof.aperture_rotation, data.dof.aperture_ratio = 6, 0.3, 2.0
        made = self.export().aperture
        # Focal length over f-number is the diameter.
        self.assertAlmostEqual(made.radius, 0.08 / 1.6 / 2, 6)
        self.assertEqual((made.focus, made.blades), (3.5, 6))
        np.testing.assert_allclose((made.rotation, made.ratio), (0.3, 2.0), rtol=1e-6)
        # Of an object what counts is how far it is along the view.
        data.dof.focus_object = scenes.add(None, location=(0.1, 0.2, 1.0))
        away = np.array((0.1, 0.2, 1.0)) - (3.0, -4.0, 2.0)
        along = np.array((0.1, 0.2, -0.3)) - (3.0, -4.0, 2.0)
        self.assertAlmostEqual(self.export().aperture.focus, float(away @ along / np.linalg.norm(along)), 5)

    def test_a_scene_without_a_camera_is_refused(self):
        self.scene.camera = None
        with self.assertRaisesRegex(Untranslatable, "no camera"):
            export(bpy.context.evaluated_depsgraph_get())


def _normal(depsgraph, hit):
    """Unit normal of the face that Scene.ray_cast has met. What it returns itself is wrong if the scale is uneven."""
    _, _, _, face, thing, matrix = hit
    normal = thing.evaluated_get(depsgraph).data.polygons[face].normal
    return (matrix.to_3x3().inverted().transposed() @ normal).normalized()


class GeometryTest(unittest.TestCase):
    def setUp(self):
        self.scene = scenes.empty()

    def check(self, smooth=False, rays=300, made=None):
        """Rays into the exported geometry, or that of `made`, hit what they hit in Blender. Returns hits and scene."""
        made = made or scenes.exported()[0]
        depsgraph = bpy.context.evaluated_depsgraph_get()
        rng = np.random.default_rng(2)
        origins = rng.normal(size=(rays, 3))
        origins *= 12 / np.linalg.norm(origins, axis=1, keepdims=True)
        directions = rng.uniform(-2.5, 2.5, (rays, 3)) - origins
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        hits = made.geometry.cast(origins.astype(np.float32), directions.astype(np.float32))
        expected = [self.scene.ray_cast(depsgraph, o, d) for o, d in zip(origins, directions)]
        met = np.array([e[0] for e in expected])
        # Rays along borders may differ; there are few.
        agree = np.isfinite(hits["distance"]) == met
        self.assertGreater(np.mean(agree), 0.99)
        met &= agree
        self.assertGreater(np.count_nonzero(met), rays // 20)
        error = np.linalg.norm(hits["position"][met] - [e[1] for e, m in zip(expected, met) if m], axis=1)
        # Single precision at 12 m; a ray at a crease may take the other face.
        self.assertGreater(np.mean(error < 2e-5), 0.99)
        if not smooth:
            normals = np.array([_normal(depsgraph, e) for e, m in zip(expected, met) if m])
            cosines = np.sum(hits["geometric_normal"][met] * normals, axis=1)
            self.assertGreater(np.mean(cosines > 0.9999), 0.99)
            np.testing.assert_allclose(np.sum(hits["normal"][met] * normals, axis=1)[cosines > 0.9999], 1, atol=1e-3)
        return hits, made

    def test_modifiers_and_transforms_are_in_the_geometry(self):
        thing = scenes.box()
        thing.modifiers.new("Array", "ARRAY").count = 3
        thing.modifiers.new("Bevel", "BEVEL").width = 0.3
        turn = Matrix.Translation((-2, 0.5, 0)) @ Matrix.Rotation(0.7, 4, "X")
        thing.matrix_world = turn @ Matrix.Diagonal((0.7, 0.4, 1, 1))
        self.check()

    def test_a_mirrored_object_keeps_its_front(self):
        scenes.box().matrix_world = Matrix.Rotation(0.5, 4, "Y") @ Matrix.Diagonal((-1, 1.4, 0.6, 1))
        self.check()

    def test_an_object_that_its_scale_makes_flat_is_still_there(self):
        # Blender's own ray cast needs an inverse too: the answer here is that of a rectangle.
        turn = Matrix.Rotation(0.5, 4, "Y")
        thing = scenes.box(low=(-1, -0.5, -1), high=(2, 2, 1))
        thing.rotation_euler, thing.scale = (0, 0.5, 0), (1, 1, 0)
        made, _ = scenes.exported()
        rng = np.random.default_rng(3)
        origins = rng.uniform((-3, -3, 5), (3, 3, 6), (200, 3))
        directions = rng.uniform((-0.2, -0.2, -1), (0.2, 0.2, -1), (200, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        hits = made.geometry.cast(origins.astype(np.float32), directions.astype(np.float32))
        o, d = origins @ np.array(turn.to_3x3()), directions @ np.array(turn.to_3x3())
        distance = -o[:, 2] / d[:, 2]
        x, y = (o + distance[:, None] * d)[:, :2].T
        expected = (x > -1) & (x < 2) & (y > -0.5) & (y < 2)
        np.testing.assert_array_equal(np.isfinite(hits["distance"]), expected)
        np.testing.assert_allclose(hits["distance"][expected], distance[expected], rtol=1e-5)
        self.assertGreater(np.count_nonzero(expected), 20)

    def test_collection_instances_and_vertex_instances_stand_where_blender_puts_them(self):
        collection = bpy.data.collections.new("Things")
        thing = scenes.box(low=(0, 0, 0), high=(0.6, 0.3, 0.9))
        thing.rotation_euler = (0.2, 0.4, 0.1)
        collection.objects.link(thing)
        self.scene.collection.objects.unlink(thing)
        empty = scenes.add(None, instance_type="COLLECTION", instance_collection=collection)
        empty.matrix_world = Matrix.Translation((1, 1, -1)) @ Matrix.Rotation(1.0, 4, "Z") @ Matrix.Scale(1.7, 4)
        parent = scenes.grid(size=3.0)
        parent.instance_type = "VERTS"
        child = scenes.box(low=(-0.2, -0.4, -0.3), high=(0.4, 0.1, 0.5))
        child.parent = parent
        _, made = self.check()
        # One of the collection, four of the vertices, the mesh that has these, and what stands there.
        self.assertEqual(len(made.object_volumes), 7)
        parent.show_instancer_for_viewport = False
        self.assertEqual(len(scenes.exported()[0].object_volumes), 6)

    def test_a_mesh_of_many_objects_is_exported_once(self):
        first = scenes.box(low=(0, 0, 0), high=(0.5, 0.5, 0.5))
        colours = [scenes.material(f"M{k}", scenes.shader("BsdfDiffuse", {"Color": (k / 9, 0, 0)})) for k in range(9)]
        for k in range(9):
            thing = first if k == 0 else scenes.add(first.data)
            thing.location = (k - 4, (k * 2) % 5 - 2, 0)
            # Each has its own material, linked to the object.
            if k == 0:
                first.data.materials.append(None)
            thing.material_slots[0].link = "OBJECT"
            thing.material_slots[0].material = colours[k]
        add_mesh = Geometry.add_mesh
        with mock.patch.object(Geometry, "add_mesh", autospec=True, side_effect=add_mesh) as added:
            hits, made = self.check(rays=1500)
        self.assertEqual(added.call_count, 1)
        seen = hits[np.isfinite(hits["distance"])]
        red = made.materials["diffuse"][seen["material"], 0]
        # Object k is between k - 4 and k - 3.5.
        expected = np.floor(seen["position"][:, 0] + 4 + 0.01) / 9
        self.assertGreater(np.mean(np.abs(red - expected) < 1e-6), 0.99)

    def test_each_face_has_the_material_of_its_slot(self):
        colours = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
        materials = [scenes.material(str(c), scenes.shader("BsdfDiffuse", {"Color": c})) for c in colours]
        thing = scenes.box(material=materials[0])
        for material in materials[1:]:
            thing.data.materials.append(material)
        # Along x, y, z; index 7 does not exist and means the last.
        for face, index in zip(thing.data.polygons, (2, 7, 1, 1, 0, 0)):
            face.material_index = index
        hits, made = self.check()
        seen = hits[np.isfinite(hits["distance"])]
        colours = made.materials["diffuse"][seen["material"]]
        np.testing.assert_allclose(colours, np.abs(seen["geometric_normal"]), atol=1e-5)

    def test_smooth_spheres_have_the_normals_of_spheres(self):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.5)
        bpy.ops.object.shade_smooth()
        bpy.context.object.matrix_world = Matrix.Diagonal((1, 1, 2, 1))
        hits, _ = self.check(smooth=True)
        seen = hits[np.isfinite(hits["distance"])]
        expected = seen["position"] / (1, 1, 4)
        expected /= np.linalg.norm(expected, axis=1, keepdims=True)
        # Facets of 1/32 pi: interpolated normals are off by less than the square of half of it, stretched by 2.
        np.testing.assert_allclose(np.sum(seen["normal"] * expected, axis=1), 1, atol=2e-4)

    def test_curves_texts_surfaces_and_metaballs_have_triangles(self):
        bpy.ops.curve.primitive_bezier_circle_add(radius=2, location=(0, 0, 0))
        bpy.context.object.data.bevel_depth = 0.4
        bpy.ops.object.text_add(location=(-1, 0, 2), radius=2)
        bpy.context.object.data.extrude = 0.2
        bpy.ops.object.metaball_add(radius=2, location=(2, 2, -2))
        bpy.ops.surface.primitive_nurbs_surface_sphere_add(radius=1, location=(-2, -2, -1))
        made, _ = scenes.exported()
        self.assertEqual(len(made.object_volumes), 4)
        # Blender's ray cast sees them all only as meshes.
        depsgraph = bpy.context.evaluated_depsgraph_get()
        for thing in [t for t in self.scene.objects if t.type != "CAMERA"]:
            mesh = bpy.data.meshes.new_from_object(thing.evaluated_get(depsgraph))
            scenes.add(mesh, matrix_world=thing.matrix_world.copy())
            bpy.data.objects.remove(thing)
        bpy.context.view_layer.update()
        self.check(smooth=True, rays=200, made=made)

    def test_what_is_hidden_from_renders_is_left_out(self):
        scenes.box()
        scenes.box(low=(-2, -2, -2), high=(2, 2, 2)).hide_render = True
        emitter = scenes.box(low=(-3, -3, -3), high=(3, 3, 3))
        emitter.modifiers.new("Particles", "PARTICLE_SYSTEM")
        emitter.show_instancer_for_viewport = False
        made, _ = scenes.exported()
        np.testing.assert_allclose(made.geometry.bounds, [(-1, -1, -1), (1, 1, 1)], atol=1e-6)

    def test_coordinates_that_are_no_numbers_or_too_large_are_left_out_by_name(self):
        scenes.box("Broken").data.vertices[3].co.x = float("nan")
        scenes.box("Far").location = (1e30, 0, 0)
        made, report = scenes.exported()
        self.assertEqual(made.object_volumes.tolist(), [])
        (entry,) = (e for e in report.entries if "too large" in e.what)
        self.assertEqual(entry.sources, ('Object "Broken"', 'Object "Far"'))

    def test_a_caller_that_says_no_ends_the_export(self):
        scenes.box()
        bpy.context.view_layer.update()
        with self.assertRaises(Cancelled):
            export(bpy.context.evaluated_depsgraph_get(), lambda: False)


class RenderTest(unittest.TestCase):
    def test_a_render_engine_gets_what_is_set_for_renders(self):
        class Engine(bpy.types.RenderEngine):
            bl_idname = "TEST_EXPORT"
            bl_label = "Test"
            made = None

            def render(self, depsgraph):
                Engine.made = export(depsgraph)[0]

        scene = scenes.empty()
        bpy.utils.register_class(Engine)
        self.addCleanup(bpy.utils.unregister_class, Engine)
        scene.render.engine = "TEST_EXPORT"
        scene.render.resolution_x, scene.render.resolution_y = 8, 6
        subdivision = scenes.box().modifiers.new("Subdivision", "SUBSURF")
        subdivision.levels, subdivision.render_levels = 0, 2
        hidden = bpy.data.collections.new("Hidden")
        hidden.hide_render = True
        scene.collection.children.link(hidden)
        hidden.objects.link(bpy.data.objects.new("Other", bpy.data.objects["Box"].data))
        bpy.ops.render.render()
        # 6 faces, each into 4 twice.
        self.assertEqual(Engine.made.geometry.triangle_count, 6 * 16 * 2)
        self.assertEqual((Engine.made.camera.width, Engine.made.camera.height), (8, 6))


class TimeTest(unittest.TestCase):
    def test_half_a_million_triangles_are_exported_with_all_instances(self):
        scenes.empty()
        # 196,608 triangles of a smooth subdivided mesh, 320,000 of a displaced grid, 1,057 instances of 128 triangles.
        bpy.ops.mesh.primitive_cube_add()
        bpy.context.object.modifiers.new("Subdivision", "SUBSURF").levels = 7
        bpy.ops.object.shade_smooth()
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=400, y_subdivisions=400, size=20)
        bpy.context.object.modifiers.new("Wave", "WAVE")
        bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=9, radius=0.1)
        ball = bpy.context.object
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=32, y_subdivisions=31, size=20)
        points = bpy.context.object
        points.instance_type, ball.parent = "VERTS", points
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        start = time.perf_counter()
        made, _ = export(depsgraph)
        taken = time.perf_counter() - start
        count, instances = made.geometry.triangle_count, len(made.object_volumes)
        print(f"export of {count:,} triangles of meshes and {instances:,} instances, with the hierarchy: {taken:.2f} s")
        # The instances have 128 triangles together here.
        self.assertGreater(count, 500_000)
        self.assertEqual(instances, 1060)


if __name__ == "__main__":
    unittest.main()
