# SPDX-License-Identifier: GPL-3.0-or-later
"""Orthographic and panoramic cameras, against the places that Cycles sees through each pixel."""

import sys
import unittest
from math import pi, radians
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import harness  # noqa: E402
import scenes_export as scenes  # noqa: E402
from host_scenes import rays  # noqa: E402
from scenes_export import node  # noqa: E402

from addon.export.camera import camera, frame  # noqa: E402
from addon.export.report import Report, Untranslatable  # noqa: E402
from addon.export.settings import note_settings  # noqa: E402
from addon.host.scene import Projection  # noqa: E402

#: What places are shown as is brighter by this, so that none is negative.
_BRIGHTER = 20.0
#: Across and down.
_SIZE = 24, 16
#: Corners of a room whose walls are at different distances.
_ROOM = (-4.0, -5.0, -3.0), (5.0, 6.0, 4.0)
#: Pixel filters of Cycles' are at least this wide [pixels].
_NARROWEST = 0.01


def _places(tree):
    """A surface that shines as bright as it lies along x, y and z."""
    emission, place = node(tree, "Emission"), node(tree, "NewGeometry")
    sum_ = node(tree, "VectorMath", {"Vector_001": (_BRIGHTER,) * 3})
    tree.links.new(place.outputs["Position"], sum_.inputs[0])
    tree.links.new(sum_.outputs[0], emission.inputs["Color"])
    return emission


class CameraTest(unittest.TestCase):
    def setUp(self):
        self.scene = scenes.empty()
        self.shining = scenes.material("Places", _places)
        scenes.box("Room", *_ROOM, material=self.shining)
        self.eye, self.data = self.scene.camera, self.scene.camera.data
        scenes.look(self.eye, (0.5, -1.0, 0.7), (1.5, 3.0, -0.3))
        self.data.clip_start = 0.5
        self.scene.cycles.pixel_filter_type, self.scene.cycles.filter_width = "GAUSSIAN", _NARROWEST
        self.scene.render.resolution_x, self.scene.render.resolution_y = _SIZE

    def export(self):
        bpy.context.view_layer.update()
        return camera(bpy.context.evaluated_depsgraph_get(), self.eye, *frame(self.scene.render))

    def check(self):
        """The exported camera's eye rays pass through the places that Cycles sees, and see none where Cycles sees none."""
        made, shown = self.export(), scenes.cycles(1, *_SIZE)
        self.assertEqual(shown.shape[:2], (made.height, made.width))
        self.assertEqual(made.near, self.data.clip_start)
        y, x = (k.ravel() + 0.5 for k in np.indices(shown.shape[:2]))
        starts, directions = rays(made, x, y)
        shown = shown.reshape(-1, 3)
        dark = (shown == 0).all(axis=1)
        np.testing.assert_array_equal(dark, np.isnan(directions).any(axis=1))
        away = shown[~dark] - _BRIGHTER - starts[~dark]
        along = (away * directions[~dark]).sum(axis=1)
        missed = np.linalg.norm(away - along[:, None] * directions[~dark], axis=1)
        # As wide as a pixel is there [m], of which the filter takes a share; single precision of places up to _BRIGHTER + 6 m.
        wide = max(made.step) * (1 if made.projection == Projection.ORTHOGRAPHIC else along.max())
        self.assertLess(missed.max(), 2 * _NARROWEST * wide + 1e-5)
        # And through no wall: what is too near is not there.
        depth = along if made.projection != Projection.PERSPECTIVE else away @ made.forward
        self.assertGreater(depth.min(), made.near)
        return made

    def test_parallel_rays_are_those_of_cycles(self):
        self.data.type, self.data.ortho_scale = "ORTHO", 1.7
        for fit in ("AUTO", "HORIZONTAL", "VERTICAL"):
            for aspect in ((1.0, 1.0), (2.0, 1.0), (1.0, 1.7)):
                with self.subTest(fit=fit, aspect=aspect):
                    self.data.sensor_fit, self.data.shift_x, self.data.shift_y = fit, 0.2, -0.35
                    self.scene.render.pixel_aspect_x, self.scene.render.pixel_aspect_y = aspect
                    self.assertEqual(self.check().projection, Projection.ORTHOGRAPHIC)

    def test_maps_of_all_around_and_of_a_part_are_those_of_cycles(self):
        self.data.type, self.data.panorama_type = "PANO", "EQUIRECTANGULAR"
        self.scene.render.pixel_aspect_x = 2.0
        self.assertEqual(self.check().projection, Projection.EQUIRECTANGULAR)
        self.data.longitude_min, self.data.longitude_max = radians(-100), radians(35)
        self.data.latitude_min, self.data.latitude_max = radians(-20), radians(60)
        self.check()
        self.data.shift_x, self.data.shift_y = 0.2, -0.35
        self.check()

    def test_fisheyes_are_those_of_cycles_and_dark_where_these_are(self):
        self.data.type, self.data.panorama_type = "PANO", "FISHEYE_EQUIDISTANT"
        for field in (radians(100), pi, 2 * pi):
            with self.subTest(field=field):
                self.data.fisheye_fov = field
                made = self.check()
                self.assertEqual(made.projection, Projection.FISHEYE)
                self.assertAlmostEqual(made.widest, field / 2, places=6)
        self.data.shift_x, self.data.shift_y = 0.2, -0.35
        self.check()

    def test_borders_and_mirrored_cameras_are_seen_as_cycles_does(self):
        render = self.scene.render
        render.use_border = render.use_crop_to_border = True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.125, 0.8
        self.eye.scale = (-1.0, 1.0, 1.0)
        self.data.type, self.data.ortho_scale = "ORTHO", 3.0
        self.check()
        self.data.type = "PANO"
        for kind in ("EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT"):
            self.data.panorama_type = kind
            self.check()

    def test_what_is_nearer_than_the_clip_start_is_not_there(self):
        # Beside, above and behind the camera, as near as its diagonals are long; and in front, farther than the clip start along the view.
        near = self.eye.location
        scenes.box("Near", near - near.__class__((0.25,) * 3), near + near.__class__((0.25,) * 3), self.shining)
        self.data.type, self.data.ortho_scale = "ORTHO", 0.4
        self.check()
        self.data.type = "PANO"
        for kind in ("EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT"):
            self.data.panorama_type, self.data.fisheye_fov = kind, 2 * pi
            self.check()

    def test_what_is_sharp_is_sharp_in_cycles_and_blurred_as_far(self):
        # A white square before black: of its edge, how wide the ramp is that a lens makes of it.
        self.data.type, self.data.dof.use_dof, self.data.clip_start = "ORTHO", True, 1.0
        self.data.dof.focus_distance, self.data.dof.aperture_fstop, self.data.ortho_scale = 4.0, 2.0, 2.0
        bpy.data.objects.remove(bpy.data.objects["Room"])
        square = scenes.grid(size=4.0, material=scenes.material("White", scenes.shader("Emission")))
        square.location.x = 2.0
        self.eye.rotation_euler = (0, 0, 0)
        for depth in (4.0, 6.0, 3.0):
            self.eye.location = (0, 0, depth)
            lens = self.export().aperture
            self.assertEqual((lens.focus, lens.radius), (4.0, 0.25))
            row = scenes.cycles(256, 64, 4)[..., 0].mean(axis=0)
            x = (np.arange(64) + 0.5) / 32 - 1
            # Through a place of the lens that lies so far to the right the edge is seen (1 - depth / focus) of that aside.
            places = np.linspace(-1, 1, 20001)
            density = np.sqrt(1 - places**2)
            edges = (1 - depth / lens.focus) * lens.radius * places
            order = np.argsort(edges)
            share = np.cumsum(density[order]) / density.sum()
            expected = np.interp(x, edges[order], share) if depth != 4 else (x > 0).astype(float)
            # 1,024 samples are within 4 x 0.5 / 32 of it; the ramp bends within a pixel.
            np.testing.assert_allclose(row, expected, atol=0.07)

    def test_lenses_of_panoramas_have_the_opening_of_a_perspective_and_other_shapes_are_reported(self):
        self.data.type, self.data.panorama_type, self.data.dof.use_dof, self.data.lens = "PANO", "EQUIRECTANGULAR", True, 80
        self.data.dof.focus_distance, self.data.dof.aperture_fstop = 3.5, 1.6
        lens = self.export().aperture
        self.assertAlmostEqual(lens.radius, 0.08 / 1.6 / 2, 6)
        self.assertEqual(lens.focus, 3.5)

        def noted():
            report = Report()
            note_settings(bpy.context.evaluated_depsgraph_get(), self.eye, report)
            return any("shape of a panorama's aperture" in entry.what for entry in report.entries)

        self.assertFalse(noted())
        self.data.dof.aperture_blades = 5
        bpy.context.view_layer.update()
        self.assertTrue(noted())

    def test_what_is_left_is_refused_by_its_name_with_a_remedy(self):
        self.data.type = "PANO"
        kinds = [kind.identifier for kind in self.data.bl_rna.properties["panorama_type"].enum_items]
        left = [kind for kind in kinds if kind not in {"EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT"}]
        self.assertIn("MIRRORBALL", left)
        for kind in left:
            self.data.panorama_type = kind
            with self.assertRaisesRegex(Untranslatable, '"Camera" is a panorama of the type .*Equirectangular'):
                self.export()
        self.data.panorama_type, self.data.fisheye_fov = "FISHEYE_EQUIDISTANT", 7.0
        with self.assertRaisesRegex(Untranslatable, '"Camera" sees more than all around.*360'):
            self.export()
        self.data.panorama_type, self.data.latitude_min, self.data.latitude_max = "EQUIRECTANGULAR", 0.5, 0.5
        with self.assertRaisesRegex(Untranslatable, '"Camera" shows nothing.*Latitude'):
            self.export()
        if "CUSTOM" in self.data.bl_rna.properties["type"].enum_items:
            self.data.type = "CUSTOM"
            with self.assertRaisesRegex(Untranslatable, '"Camera" is custom.*Orthographic'):
                self.export()


if __name__ == "__main__":
    harness.main()
