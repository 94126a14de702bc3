# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine in a viewport, on a host whose pictures are known exactly: what is drawn, told, and read again when."""

import time
from types import SimpleNamespace
from unittest import mock

import bpy
import fake_host
import harness
import numpy as np
from in_blender import InBlender
from mathutils import Matrix
from window import Engine, Window

from addon import requirements
from addon.engine import CovbeamEngine

#: No multiple of a pixel's size.
WIDTH, HEIGHT = 42, 31


class View3DTest(InBlender):
    def setUp(self):
        super().setUp()
        self.reads = 0
        self.patch(fake_host, "export_view", self.export_view)
        self.window = Window(WIDTH, HEIGHT)
        self.engine, self.seen, self.draw, self.finish = self.window.engine, self.window.seen, self.window.draw, self.window.finish

    def tearDown(self):
        self.engine = None
        self.window.close()
        super().tearDown()

    def patch(self, where, name, value):
        patched = mock.patch.object(where, name, value)
        patched.start()
        self.addCleanup(patched.stop)

    def export_view(self, depsgraph, space, _export=fake_host.export_view):
        self.reads += 1
        return _export(depsgraph, space)

    def test_the_last_picture_is_drawn_exactly_upright_and_opaque(self):
        shown = self.finish()
        expected = fake_host.picture(WIDTH, HEIGHT, passes=3).in_scattered
        # Linear between pixels, of which each falls on one.
        np.testing.assert_allclose(shown[..., :3], expected, atol=1e-5)
        np.testing.assert_array_equal(shown[..., 3], np.ones((HEIGHT, WIDTH)))
        self.assertEqual(self.engine.told[-1], "Covbeam: 3 of 3 passes")
        self.assertEqual(self.engine.bound, [True, False] * len(self.engine.told))
        # Afterwards nothing is made any more, and it is drawn all the same.
        count = len(fake_host.Session.settings)
        np.testing.assert_array_equal(self.draw(), shown)
        self.assertEqual(len(fake_host.Session.settings), count)

    def test_the_first_picture_covers_the_region_from_its_upper_left_corner(self):
        fake_host.Session.seconds = 0.2
        shown = self.draw()
        self.assertEqual(self.engine.told[-1], "Covbeam: 1 of 3 passes at 1/4 of the resolution")
        wide, high = -(-WIDTH // 4), -(-HEIGHT // 4)
        expected = fake_host.picture(wide, high).in_scattered
        # At the middles of its pixels, which lie between four of the region: the mean of these.
        cut = shown[: HEIGHT // 4 * 4, : WIDTH // 4 * 4, :3]
        middles = [cut[j::4, i::4] for j in (1, 2) for i in (1, 2)]
        np.testing.assert_allclose(np.mean(middles, axis=0), expected[: HEIGHT // 4, : WIDTH // 4], atol=0.02)
        np.testing.assert_array_equal(shown[..., 3], 1)

    def test_a_redraw_is_asked_for_as_long_as_passes_remain(self):
        fake_host.Session.seconds = 0.06
        self.scene.covbeam.passes = 8
        self.finish()
        told = list(dict.fromkeys(self.engine.told))
        self.assertGreaterEqual(len(told), 4)
        self.assertEqual(told[-1], "Covbeam: 8 of 8 passes")

    def test_only_what_matters_is_read_again(self):
        cube, lamp, eye, scene = (*(bpy.data.objects[name] for name in ("Cube", "Light", "Camera")), self.scene)
        other = bpy.data.worlds.new("Other")
        changes = (
            ("a selection", lambda: cube.select_set(not cube.select_get()), 0),
            ("a camera's place", lambda: setattr(eye, "location", (1, 2, 3)), 0),
            ("a camera's lens", lambda: setattr(eye.data, "lens", 33), 0),
            ("a picture's size", lambda: setattr(scene.render, "resolution_x", 300), 0),
            ("a setting", lambda: setattr(scene.covbeam, "photons", 3000), 0),
            ("nothing", lambda: None, 0),
            ("an object's place", lambda: setattr(cube, "location", (1, 0, 0)), 1),
            ("a lamp's strength", lambda: setattr(lamp.data, "energy", 3), 1),
            ("a material", lambda: setattr(cube.data.materials[0].node_tree.nodes["Principled BSDF"].inputs[1], "default_value", 1), 1),
            ("the world's color", lambda: setattr(scene.world.node_tree.nodes["Background"].inputs[1], "default_value", 2), 1),
            ("another world", lambda: setattr(scene, "world", other), 1),
            ("hiding", lambda: cube.hide_set(True), 1),
            ("showing", lambda: cube.hide_set(False), 1),
            ("leaving out", lambda: setattr(bpy.context.view_layer.layer_collection.children[0], "exclude", True), 1),
            ("taking in", lambda: setattr(bpy.context.view_layer.layer_collection.children[0], "exclude", False), 1),
            ("a modifier", lambda: cube.modifiers.new("Subdivided", "SUBSURF"), 1),
            ("a new object", lambda: scene.collection.objects.link(bpy.data.objects.new("New", cube.data)), 1),
            ("one fewer", lambda: bpy.data.objects.remove(bpy.data.objects["New"]), 1),
        )
        bpy.context.view_layer.update()
        for name, change, expected in changes:
            before = self.reads
            change()
            bpy.context.view_layer.update()
            self.assertEqual(self.reads - before, expected, name)

    def test_a_change_of_view_of_size_or_of_settings_begins_anew_without_reading(self):
        self.finish()
        reads = self.reads

        def begun():
            """Whether a session is made, of what size of pixels, and with what settings."""
            count = len(fake_host.Session.settings)
            self.finish()
            return len(fake_host.Session.settings) > count

        self.assertFalse(begun())
        self.seen.view_matrix = Matrix.Translation((0, 0, -1)) @ self.seen.view_matrix
        self.assertTrue(begun())
        self.scene.covbeam.photons = 4321
        self.assertTrue(begun())
        self.assertEqual(fake_host.Session.settings[-1].photons, 4321)
        self.window.region.width -= 1
        self.assertTrue(begun())
        self.scene.render.preview_pixel_size = "2"
        self.assertTrue(begun())
        self.scene.frame_set(2)
        self.assertTrue(begun())
        self.assertEqual(fake_host.Session.settings[-1].seed, self.scene.covbeam.seed_of(2))
        self.assertFalse(begun())
        self.assertEqual(self.reads, reads)

    def test_pixel_size_is_that_of_blenders_performance_panel(self):
        self.scene.render.preview_pixel_size = "8"
        shown = self.finish()
        self.assertEqual(self.engine.told[-1], "Covbeam: 3 of 3 passes")
        expected = fake_host.picture(-(-WIDTH // 8), -(-HEIGHT // 8)).in_scattered
        self.assertLess(np.abs(shown[::8, ::8, :2] - expected[..., :2]).max(), 0.3)
        self.scene.render.preview_pixel_size = "AUTO"
        self.finish()
        usual = self.engine.view3d._shown.pixel
        self.window.context.preferences = SimpleNamespace(system=SimpleNamespace(pixel_size=2.0))
        self.finish()
        self.assertEqual((usual, self.engine.view3d._shown.pixel), (1, 2))

    def test_a_scene_that_is_slow_to_read_is_read_when_it_stands_still(self):
        export_view = fake_host.export_view
        self.patch(fake_host, "export_view", lambda *given: time.sleep(0.25) or export_view(*given))
        cube = bpy.data.objects["Cube"]
        cube.location.x += 1
        bpy.context.view_layer.update()
        self.assertEqual(self.reads, 2)
        for _ in range(3):
            cube.location.x += 1
            bpy.context.view_layer.update()
            self.draw()
        self.assertEqual(self.reads, 2)
        self.finish()
        self.assertEqual(self.reads, 3)

    def assert_black(self, words):
        shown = self.finish()
        np.testing.assert_array_equal(shown, np.broadcast_to(np.float32([0, 0, 0, 1]), shown.shape))
        self.assertRegex(self.engine.told[-1], words)

    def move(self):
        bpy.data.objects["Cube"].location.x += 1
        bpy.context.view_layer.update()

    def test_a_view_without_perspective_is_drawn(self):
        self.finish()
        self.seen.window_matrix = Matrix(((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, -0.01, 0), (0, 0, 0, 1)))
        self.assertGreater(self.finish()[..., 2].max(), 0)
        self.assertEqual(self.engine.told[-1], "Covbeam: 3 of 3 passes")

    def test_a_view_through_a_camera_that_cannot_be_rendered_is_black_and_that_is_told(self):
        self.finish()
        data, self.seen.view_perspective = bpy.data.objects["Camera"].data, "CAMERA"
        data.type, data.panorama_type = "PANO", "MIRRORBALL"
        bpy.context.view_layer.update()
        self.assert_black("panorama of the type Mirror Ball")
        data.type = "PERSP"
        bpy.context.view_layer.update()
        self.assertGreater(self.finish()[..., 2].max(), 0)

    def test_without_fog_or_light_it_is_black_and_that_is_told(self):
        export_view = fake_host.export_view
        for names, words in ((("volumes",), "no fog here"), (("lights",), "no light here"), (("volumes", "lights"), "no fog and no light")):

            def without(depsgraph, space, names=names):
                scene, report = export_view(depsgraph, space)
                for name in names:
                    setattr(scene, name, ())
                return scene, report

            self.patch(fake_host, "export_view", without)
            self.move()
            self.assert_black(words)
        self.patch(fake_host, "export_view", export_view)
        self.move()
        self.assertGreater(self.finish()[..., 2].max(), 0)

    def test_what_the_picture_lacks_is_told(self):
        def lacking(depsgraph, space, _export=fake_host.export_view):
            scene, report = _export(depsgraph, space)
            report.add('Object "Cube"', "hair", "left out")
            return scene, report

        self.patch(fake_host, "export_view", lacking)
        self.move()
        self.finish()
        self.assertEqual(
            self.engine.told[-1], "Covbeam: 3 of 3 passes; not all is as in Cycles, see the Report of a render (1)"
        )

    def test_failures_are_told_until_something_changes_and_blender_goes_on(self):
        def broken(session, poll):
            raise failure

        goes = fake_host.Session.render_pass
        for failure, words in ((MemoryError(), "not enough memory"), (ZeroDivisionError("a defect"), "a defect")):
            fake_host.Session.render_pass = broken
            self.addCleanup(setattr, fake_host.Session, "render_pass", goes)
            self.move()
            with mock.patch("traceback.print_exc"):
                self.assert_black(words)
            fake_host.Session.render_pass = goes
            self.assert_black(words)
            self.move()
            self.assertGreater(self.finish()[..., 2].max(), 0)

        def unreadable(depsgraph, space):
            raise ValueError("unreadable")

        self.patch(fake_host, "export_view", unreadable)
        with mock.patch("traceback.print_exc"):
            self.move()
        self.assert_black("unreadable")

    def test_what_keeps_the_extension_from_working_is_told_in_viewports(self):
        self.patch(requirements, "check", lambda: "The library is missing.")
        engine = Engine()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        CovbeamEngine.view_update(engine, self.window.context, depsgraph)
        CovbeamEngine.view_draw(engine, self.window.context, depsgraph)
        self.assertEqual((engine.told, engine.view3d), (["Covbeam: The library is missing."], None))

    def test_a_viewport_that_goes_closes_its_session(self):
        fake_host.Session.seconds = 0.2
        self.draw()
        self.assertEqual(fake_host.Session.open, 1)
        self.window.engine = self.engine = None
        self.assertEqual(fake_host.Session.open, 0)
        self.window.engine = Engine()


if __name__ == "__main__":
    harness.main()
