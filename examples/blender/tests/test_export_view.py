# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D viewport looks through, and what it has in it, against Blender's own projections and visibility."""

import dataclasses
import sys
import unittest
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Quaternion, Vector

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402
from host_scenes import directions, rays  # noqa: E402

from window import viewport  # noqa: E402

from addon.export.camera import camera, frame  # noqa: E402
from addon.export.report import Untranslatable  # noqa: E402
from addon.export.scene import export_view  # noqa: E402
from addon.export.view import view  # noqa: E402
from addon.host.scene import Projection  # noqa: E402


class ViewTest(unittest.TestCase):
    """A new scene's camera, and the viewport of Blender's first window: the bpy package has windows, though nobody sees them."""

    @classmethod
    def setUpClass(cls):
        # Blender computes its matrices with it.
        harness.start_gpu()

    def setUp(self):
        self.scene = scenes.empty()
        self.eye = self.scene.camera
        scenes.look(self.eye, (3.0, -4.0, 2.0), (0.1, 0.2, -0.3))
        self.scene.render.resolution_x, self.scene.render.resolution_y = 320, 200
        self.space, self.region, self.region_3d = viewport()

    def made(self):
        """The exported camera."""
        bpy.context.view_layer.update()
        self.region_3d.update()
        return view(bpy.context.evaluated_depsgraph_get(), self.space, self.region, self.region_3d)

    def check(self):
        """Points that Blender's matrix projects to pixels are met by the eye rays of these; returns the exported camera."""
        made = self.made()
        self.assertEqual((made.width, made.height), (self.region.width, self.region.height))
        matrix = np.array(self.region_3d.perspective_matrix, np.float64)
        rng = np.random.default_rng(1)
        pixels = rng.uniform(0, (made.width, made.height), (50, 2))
        starts, seen = rays(made, *pixels.T)
        self.assertGreater((seen @ made.forward).min(), 0)
        far = rng.uniform(2 * made.near + 1, 30, (50, 1))
        points = np.concatenate([starts + far * seen, np.ones((50, 1))], axis=1) @ matrix.T
        seen = points[:, :2] / points[:, 3:]
        self.assertGreater(points[:, 3].min(), 0)
        # Blender counts from the bottom. Its matrix is in single precision: 6e-8 of coordinates up to 30, at 1 m and beyond.
        expected = np.stack([2 * pixels[:, 0] / made.width - 1, 1 - 2 * pixels[:, 1] / made.height], axis=1)
        np.testing.assert_allclose(seen, expected, atol=3e-5)
        # What is at the near plane is at Blender's, too.
        at = np.append(made.position + made.near * made.forward, 1.0) @ matrix.T
        self.assertAlmostEqual(at[2] / at[3], -1, delta=2e-3)
        axes = np.array([made.right, made.up, made.forward])
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
        return made

    def look_through(self, camera=True):
        self.region_3d.view_perspective = "CAMERA" if camera else "PERSP"

    def test_a_free_view_is_that_of_blender(self):
        region_3d, rng = self.region_3d, np.random.default_rng(3)
        self.look_through(False)
        for lens, near in ((50, 0.01), (18, 0.5), (120, 0.1)):
            self.space.lens, self.space.clip_start, self.space.clip_end = lens, near, 100
            region_3d.view_rotation = Quaternion(rng.normal(size=4)).normalized()
            region_3d.view_location, region_3d.view_distance = rng.normal(size=3), 7.5
            made = self.check()
            self.assertAlmostEqual(made.near, near, delta=1e-4 * near + 2e-7 * 100)
            self.assertIsNone(made.aperture)
            # Blender's viewports have sensors of 72 mm.
            self.assertAlmostEqual(made.step[0] * max(made.width, made.height), 72 / lens, places=5)
            eye = region_3d.view_rotation @ Vector((0, 0, region_3d.view_distance)) + region_3d.view_location
            np.testing.assert_allclose(made.position, eye, atol=1e-5)

    def test_a_free_view_without_perspective_is_that_of_blender_and_begins_as_far_behind(self):
        region_3d, rng = self.region_3d, np.random.default_rng(4)
        region_3d.view_perspective = "ORTHO"
        for distance, end in ((7.5, 100.0), (1.3, 30.0)):
            self.space.clip_end, region_3d.view_distance = end, distance
            region_3d.view_rotation = Quaternion(rng.normal(size=4)).normalized()
            region_3d.view_location = rng.normal(size=3)
            made = self.check()
            self.assertEqual(made.projection, Projection.ORTHOGRAPHIC)
            self.assertEqual((made.near, made.aperture), (0.0, None))
            # As far as Blender draws anything.
            behind = (made.position - np.array(region_3d.view_matrix.inverted().translation)) @ made.forward
            self.assertAlmostEqual(behind, -end / 2, delta=1e-4 * end)

    def test_a_camera_view_is_that_of_blender_with_its_zoom_offset_and_shift(self):
        self.look_through()
        data, render = self.eye.data, self.scene.render
        data.clip_start, data.clip_end = 0.25, 200
        for zoom, offset in ((0, (0, 0)), (29, (0.2, -0.1)), (-20, (-0.4, 0.3))):
            for fit, aspect in (("AUTO", 1.0), ("HORIZONTAL", 1.5), ("VERTICAL", 1.0)):
                with self.subTest(zoom=zoom, fit=fit):
                    self.region_3d.view_camera_zoom, self.region_3d.view_camera_offset = zoom, offset
                    data.sensor_fit, data.shift_x, data.shift_y, data.lens = fit, 0.1, -0.2, 35
                    render.pixel_aspect_x = aspect
                    made = self.check()
                    self.assertAlmostEqual(made.near, 0.25, delta=1e-4)
                    np.testing.assert_allclose(made.position, self.eye.matrix_world.translation, atol=1e-5)
                    self.check_frame(made, zoom)

    def test_the_view_of_an_orthographic_camera_is_that_of_blender(self):
        self.look_through()
        data, render = self.eye.data, self.scene.render
        data.type, data.ortho_scale, data.clip_start, data.clip_end = "ORTHO", 5.0, 0.25, 200
        for zoom, offset, fit, aspect in ((0, (0, 0), "AUTO", 1.0), (29, (0.2, -0.1), "VERTICAL", 1.5)):
            self.region_3d.view_camera_zoom, self.region_3d.view_camera_offset = zoom, offset
            data.sensor_fit, data.shift_x, data.shift_y, render.pixel_aspect_x = fit, 0.1, -0.2, aspect
            made = self.check()
            self.assertEqual(made.projection, Projection.ORTHOGRAPHIC)
            self.assertAlmostEqual(made.near, 0.25, delta=1e-4)
            np.testing.assert_allclose(made.position, self.eye.matrix_world.translation, atol=1e-5)

    def check_frame(self, made, zoom):
        """What a render shows at its corners lies on the corners of a rectangle of the region, as large as Blender draws the frame."""
        corners = [self.eye.matrix_world @ corner for corner in self.eye.data.view_frame(scene=self.scene)]
        for corner in corners:
            in_frame = world_to_camera_view(self.scene, self.eye, corner)
            np.testing.assert_allclose(np.abs(np.array(in_frame[:2]) - 0.5), 0.5, atol=1e-5)
        places = np.array([location_3d_to_region_2d(self.region, self.region_3d, corner) for corner in corners])
        size = np.ptp(places, axis=0)
        render = self.scene.render
        shape = np.array([render.resolution_x * render.pixel_aspect_x, render.resolution_y * render.pixel_aspect_y])
        np.testing.assert_allclose(size[0] / size[1], shape[0] / shape[1], rtol=1e-4)
        # With zoom 0 the longer side of the frame takes half of the longer side of the region.
        factor = (np.sqrt(2) + zoom / 50) ** 2 / 4
        if self.eye.data.sensor_fit == "AUTO":
            np.testing.assert_allclose(size.max(), factor * max(made.width, made.height), rtol=1e-4)
        # And there the exported camera's rays pass.
        away = np.array(corners) - made.position
        seen = directions(made, places[:, 0], made.height - places[:, 1])
        np.testing.assert_allclose(seen, away / np.linalg.norm(away, axis=1, keepdims=True), atol=1e-5)

    def test_a_frame_that_fills_the_region_is_what_a_render_shows(self):
        self.look_through()
        render, data = self.scene.render, self.eye.data
        width, height = render.resolution_x, render.resolution_y = 98, 59
        # As wide and as high as the region; and twice the size of zoom 0.
        render.pixel_aspect_x, render.pixel_aspect_y = self.region.width / width, self.region.height / height
        self.region_3d.view_camera_zoom, self.region_3d.view_camera_offset = 50 * (2 - np.sqrt(2)), (0, 0)
        data.shift_x, data.lens, data.clip_start = 0.1, 40, 0.3
        data.dof.use_dof, data.dof.focus_distance = True, 2.5
        for kind, panorama in (("PERSP", None), ("ORTHO", None), ("PANO", "EQUIRECTANGULAR"), ("PANO", "FISHEYE_EQUIDISTANT")):
            data.type = kind
            if panorama is not None:
                data.panorama_type, data.longitude_max = panorama, 1.0
            self.made()
            depsgraph = bpy.context.evaluated_depsgraph_get()
            seen = view(depsgraph, self.space, SimpleNamespace(width=width, height=height), self.region_3d)
            rendered = camera(depsgraph, self.eye, *frame(render))
            for field in dataclasses.fields(rendered):
                with self.subTest(kind=kind, panorama=panorama, field=field.name):
                    one, other = (getattr(made, field.name) for made in (seen, rendered))
                    if field.name == "aperture":
                        one, other = dataclasses.astuple(one), dataclasses.astuple(other)
                    np.testing.assert_allclose(one, other, rtol=1e-5, atol=1e-5)

    def test_a_panorama_fills_the_frame_of_its_camera(self):
        self.look_through()
        data, render = self.eye.data, self.scene.render
        data.type, data.panorama_type, data.longitude_max = "PANO", "EQUIRECTANGULAR", 1.0
        data.shift_x, data.sensor_fit, render.pixel_aspect_x = 0.1, "VERTICAL", 1.5
        self.region_3d.view_camera_zoom, self.region_3d.view_camera_offset = 12, (0.1, -0.05)
        made = self.made()
        corners = [self.eye.matrix_world @ corner for corner in data.view_frame(scene=self.scene)]
        places = np.array([location_3d_to_region_2d(self.region, self.region_3d, corner) for corner in corners])
        rendered = camera(bpy.context.evaluated_depsgraph_get(), self.eye, *frame(render))
        of_frame = np.array([world_to_camera_view(self.scene, self.eye, corner)[:2] for corner in corners]).round()
        _, expected = rays(rendered, of_frame[:, 0] * rendered.width, (1 - of_frame[:, 1]) * rendered.height)
        _, found = rays(made, places[:, 0], made.height - places[:, 1])
        np.testing.assert_allclose(found, expected, atol=1e-4)

    def test_scaled_and_mirrored_cameras_are_seen_through_as_blender_does(self):
        self.look_through()
        for scale in ((2.0, 0.5, 3.0), (-1.0, 1.0, 1.0)):
            self.eye.scale = scale
            self.check()

    def test_depth_of_field_is_that_of_the_camera_in_its_view_only(self):
        dof = self.eye.data.dof
        dof.use_dof, dof.focus_distance, dof.aperture_fstop, self.eye.data.lens = True, 3.5, 1.6, 80
        self.look_through(False)
        self.assertIsNone(self.made().aperture)
        self.look_through()
        made = self.made().aperture
        self.assertAlmostEqual(made.radius, 0.08 / 1.6 / 2, 6)
        self.assertEqual(made.focus, 3.5)

    def test_a_viewport_may_have_a_camera_of_its_own_or_look_through_a_lamp(self):
        self.look_through()
        other = scenes.add(bpy.data.cameras.new("Other"))
        scenes.look(other, (-2.0, 1.0, 5.0), (0, 0, 0))
        self.space.use_local_camera, self.space.camera = True, other
        np.testing.assert_allclose(self.check().position, (-2, 1, 5), atol=1e-5)
        lamp = scenes.add(bpy.data.lights.new("Spot", "SPOT"))
        scenes.look(lamp, (1.0, 1.0, 4.0), (0, 0, 0))
        self.space.camera = lamp
        np.testing.assert_allclose(self.check().position, (1, 1, 4), atol=1e-5)
        self.space.use_local_camera = False

    def test_a_view_through_a_camera_that_cannot_be_rendered_is_refused_with_a_remedy(self):
        self.look_through()
        self.eye.data.type, self.eye.data.panorama_type = "PANO", "MIRRORBALL"
        with self.assertRaisesRegex(Untranslatable, 'Camera "Camera" is a panorama of the type Mirror Ball.*Equirectangular'):
            self.made()
        self.look_through(False)
        self.check()

    def test_objects_are_those_that_show_in_the_viewport(self):
        for name in ("Plain", "Not rendered", "Hidden", "Out of the view layer"):
            scenes.grid(name)
        bpy.data.objects["Not rendered"].hide_render = True
        bpy.data.objects["Hidden"].hide_set(True)
        bpy.data.objects["Out of the view layer"].hide_viewport = True
        scenes.add(bpy.data.lights.new("Lamp", "POINT"))

        def shown():
            bpy.context.view_layer.update()
            scene, _ = export_view(bpy.context.evaluated_depsgraph_get(), self.space)
            self.assertIsNone(scene.camera)
            return scene.geometry.triangle_count, len(scene.lights)

        self.assertEqual(shown(), (4, 1))
        self.space.show_object_viewport_light = False
        self.assertEqual(shown(), (4, 0))
        self.space.show_object_viewport_light = True


if __name__ == "__main__":
    harness.main()
