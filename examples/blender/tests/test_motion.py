# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: when the shutter is open, what is read at its instants, and what pictures of several instants are."""

import sys
import unittest
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import addon_utils  # noqa: E402  bpy brings it
import cycles_scenes  # noqa: E402
import harness  # noqa: E402
import host_scenes  # noqa: E402
import scenes_export as scenes  # noqa: E402
from cycles_scenes import moves  # noqa: E402

from addon.export.motion import INSTANTS, exposures, moments  # noqa: E402
from addon.export.scene import export  # noqa: E402
from addon.host.scene import Light, LightKind, Projection  # noqa: E402
from addon.host.session import Session, Settings  # noqa: E402


def exposed():
    """What `exposures` reads of the scene, which it evaluates at other frames as a render engine does."""
    scene = bpy.context.scene
    bpy.context.view_layer.update()
    return exposures(bpy.context.evaluated_depsgraph_get(), lambda frame, part: scene.frame_set(frame, subframe=part))


def rendered(made, *others, passes, photons=20_000, seed=0, **settings):
    """The light in fog that so many passes of scenes have: float64 (h, w, 3)."""
    session = Session(made, Settings(photons=photons, seed=seed, **settings), instants=others)
    try:
        for _ in range(passes):
            session.render_pass()
        return session.picture().in_scattered.astype(np.float64)
    finally:
        session.close()


class ShutterTest(unittest.TestCase):
    """A black world with a white square that runs along x: how far it has come."""

    def setUp(self):
        self.scene = scenes.empty()
        self.square = scenes.grid(size=4.0, material=scenes.material("White", scenes.shader("Emission")))
        # Its left edge is in the middle of the picture at frame 2.
        moves(self.square, "location", 1.0, 2.0, 3.0)
        eye = self.scene.camera
        eye.location, eye.data.type, eye.data.ortho_scale = (0.0, 0.0, 3.0), "ORTHO", 2.0
        self.scene.render.use_motion_blur = True
        self.scene.frame_set(2)

    def check(self):
        """Where Cycles' square has been longest is where it is at our moments: the share of them at which it covers each column."""
        row = scenes.cycles(256, 64, 4)[..., 0].mean(axis=0)
        x = (np.arange(64) + 0.5) / 32 - 1
        edges = moments(self.scene.render, 1024)
        expected = (x[:, None] > edges).mean(axis=1)
        # 1,024 samples are within 4 x 0.5 / 32 of it.
        np.testing.assert_allclose(row, expected, atol=0.07)
        self.assertGreater(np.count_nonzero((row > 0.1) & (row < 0.9)), 5)

    def test_it_is_open_when_that_of_cycles_is(self):
        for position, shutter in (("CENTER", 0.5), ("START", 0.8), ("END", 1.2)):
            self.scene.render.motion_blur_position, self.scene.render.motion_blur_shutter = position, shutter
            with self.subTest(position=position):
                self.check()

    def test_it_opens_as_its_curve_says(self):
        points = self.scene.render.motion_blur_shutter_curve.curves[0].points
        for point, height in zip(points, (0.0, 0.2, 1.0)):
            point.location[1] = height
            point.handle_type = "VECTOR"
        self.scene.render.motion_blur_shutter_curve.update()
        self.scene.render.motion_blur_shutter = 1.0
        self.check()

    def test_instants_have_equal_shares_of_the_light(self):
        render = self.scene.render
        render.motion_blur_position, render.motion_blur_shutter = "START", 0.5
        np.testing.assert_allclose(moments(render, 4), np.array([0.125, 0.375, 0.625, 0.875]) / 2, atol=1e-6)


class ExportTest(unittest.TestCase):
    def setUp(self):
        self.scene = scenes.empty()
        scenes.look(self.scene.camera, (0, -5, 0), (0, 0, 0))
        fog = scenes.material("Fog", volume=scenes.shader("VolumeScatter"))
        scenes.box("Fog", material=fog)
        black = scenes.material("Black", scenes.shader("BsdfDiffuse", {"Color": (0, 0, 0)}))
        self.bar = scenes.box("Bar", (-0.1, -0.1, -2), (0.1, 0.1, 2), black)
        self.lamp = scenes.add(bpy.data.lights.new("Lamp", "POINT"), location=(0, 0, 3))
        self.lamp.data.use_soft_falloff = False
        self.scene.render.use_motion_blur, self.scene.render.motion_blur_shutter = True, 0.5
        self.scene.frame_set(2, subframe=0.25)

    def test_where_nothing_moves_there_is_one_instant_and_it_is_the_frame(self):
        # Keyed, but to the same place.
        moves(self.bar, "location", 0.3, 0.3)
        (made,), report = exposed()
        expected, _ = export(bpy.context.evaluated_depsgraph_get())
        self.assertEqual(made.geometry.digest, expected.geometry.digest)
        self.assertFalse(len(report), str(report))
        kept = {"passes": 2, "photons": 2000}
        still = rendered(replace(made, camera=self.small(made)), **kept)
        np.testing.assert_array_equal(still, rendered(replace(expected, camera=self.small(expected)), **kept))

    def small(self, made):
        camera = made.camera
        return replace(camera, width=16, height=16, step=(camera.step[0] * camera.width / 16, camera.step[1] * camera.height / 16))

    def test_without_motion_blur_nothing_is_evaluated_anew(self):
        self.scene.render.use_motion_blur = False
        moves(self.bar, "location", 0.0, 1.0)

        def never(frame, part):
            raise AssertionError("evaluated")

        made, _ = exposures(bpy.context.evaluated_depsgraph_get(), never)
        self.assertEqual(len(made), 1)

    def test_what_moves_is_where_it_is_at_each_moment(self):
        moves(self.bar, "location", 0.0, 8.0)
        moves(self.lamp, "location", 1.0, 3.0, axis=2)
        moves(self.scene.camera, "location", 0.0, 1.0)
        made, report = exposed()
        times = 1.25 + moments(self.scene.render, INSTANTS)
        self.assertEqual(len(made), INSTANTS)
        for scene, time in zip(made, times):
            np.testing.assert_allclose(scene.lights[0].position, (0, 0, 1 + 2 * time), atol=1e-5)
            np.testing.assert_allclose(scene.camera.position, (time, -5, 0), atol=1e-5)
            hit = scene.geometry.cast(np.array([[8 * time, -5, 1.5]], np.float32), np.array([[0, 1, 0]], np.float32))
            self.assertAlmostEqual(float(hit["distance"][0]), 4.9, places=4)
        self.assertEqual([entry.what for entry in report.entries], ["lamps that move while the shutter is open"])
        # And Blender is where it was.
        self.assertEqual((self.scene.frame_current, self.scene.frame_subframe), (2, 0.25))

    def test_geometry_that_stands_still_is_there_once(self):
        moves(self.lamp, "location", 0.0, 1.0)
        made, _ = exposed()
        self.assertEqual(len(made), INSTANTS)
        self.assertTrue(all(scene.geometry is made[0].geometry for scene in made))

    def test_light_that_goes_out_within_is_reported_and_stands_still(self):
        moves(self.bar, "location", 0.0, 8.0)
        for frame, hidden in ((1, False), (2, True)):
            self.lamp.hide_render = hidden
            self.lamp.keyframe_insert("hide_render", frame=frame)
        self.scene.frame_set(2, subframe=0.0)
        made, report = exposed()
        self.assertEqual(len(made), 1)
        self.assertIn("stands still", str(report))

    def test_what_cycles_blurs_otherwise_is_reported(self):
        moves(self.bar, "location", 0.0, 8.0)
        self.scene.cycles.rolling_shutter_type, self.bar.cycles.use_motion_blur = "TOP", False
        _, report = exposed()
        self.assertEqual({entry.what for entry in report.entries}, {"rolling shutter", "Motion Blur is off"})

    def test_what_moves_is_read_without_cycles_too(self):
        moves(self.bar, "location", 0.0, 8.0)
        addon_utils.disable("cycles")
        try:
            self.assertFalse(hasattr(self.scene, "cycles"))
            made, report = exposed()
        finally:
            addon_utils.enable("cycles")
        self.assertEqual(len(made), INSTANTS)
        self.assertFalse(len(report), str(report))


class BlurTest(unittest.TestCase):
    """Pictures of several instants."""

    def test_a_bar_that_passes_over_even_fog_leaves_a_ramp(self):
        # A sun from above lights it alike from left to right; the bar is far in front of it.
        fog, sun = host_scenes.volume("fog", 0.3, 0, low=-2, high=2), np.ones(3)
        lamp = Light("sun", LightKind.SUN, axis=np.array([0.0, -1.0, 0.0]), angle=0.02, irradiance=sun)
        pixel = 1 / 32
        view = host_scenes.camera((0, 0, -60), (0, 0, 0), 1, 32, 8)
        view = replace(view, projection=Projection.ORTHOGRAPHIC, left=-0.5, top=4 * pixel, step=(pixel, pixel))

        def at(column):
            # Right is -x.
            right = 0.5 - column * pixel
            bar = host_scenes.box((right - 8 * pixel, -1, -50), (right, 1, -49.9))
            meshes = [(host_scenes.box((-2, -2, -2), (2, 2, 2)), host_scenes.BOUND, 0), (bar, host_scenes.BLACK, -1)]
            return host_scenes.scene(meshes, [lamp], [fog], view)

        # 8 pixels wide, it goes on by 8 pixels.
        found = rendered(*(at(4 + number) for number in range(8)), passes=16, photons=3000, bounces=0).mean(axis=(0, 2))
        columns = np.arange(32)
        uncovered = 1 - np.clip(1 - np.abs(columns - 11) / 8, 0, 1)
        light = found[24:].mean()
        print(f"figures: a bar's blur differs from a ramp by up to {100 * np.abs(found / light - uncovered).max():.1f} % of the light around")
        # Filters may err by 1 % in the first pass; and noise.
        np.testing.assert_allclose(found / light, uncovered, atol=0.02)
        np.testing.assert_allclose(found[11], 0, atol=1e-6)

    def test_a_lamp_that_moves_is_the_mean_of_lamps_that_stand(self):
        def at(x):
            view = host_scenes.camera((0, 0.5, -5), (0, 0, 0), 35, 16, 16)
            lamp, fog = host_scenes.point((x, 2.8, 0), 25), host_scenes.volume("fog", 0.2, 0.02)
            return host_scenes.scene([(host_scenes.icosphere(0.5, levels=3), host_scenes.BLACK, -1)], [lamp], [fog], view, world=0)

        instants = [at(x) for x in (-2.0, 2.0)]

        def blocks(picture):
            return picture[..., 0].reshape(4, 4, 4, 4).mean(axis=(1, 3))

        seeds = range(3)
        blurred = np.array([blocks(rendered(*instants, passes=8, seed=seed, photons=6000, bounces=0)) for seed in seeds])
        still = np.array([[blocks(rendered(made, passes=4, seed=10 + seed, photons=6000, bounces=0)) for made in instants] for seed in seeds])
        error = np.sqrt((blurred.var(axis=0, ddof=1) + still.mean(axis=1).var(axis=0, ddof=1)) / len(seeds))
        difference = np.abs(blurred.mean(axis=0) - still.mean(axis=(0, 1)))
        # The instants differ by far more.
        self.assertGreater(np.abs(still[:, 0] - still[:, 1]).max(), 0.3 * still.mean())
        print("figures: a lamp's blur differs from the mean of two by", (difference / still.mean(axis=(0, 1))).max().round(4))
        # Filters and kernels may each blur by 1 %; and noise.
        self.assertTrue((difference <= 0.02 * still.mean(axis=(0, 1)) + 4 * error).all())


class CyclesTest(unittest.TestCase):
    def test_a_camera_and_a_ball_that_move_are_blurred_as_cycles_blurs_them(self):
        scene = cycles_scenes.empty_scene(32, 256)
        eye = cycles_scenes.look((0, -5, 0.5), (0, 0, 0))
        cycles_scenes.wire(scene.world, cycles_scenes.fog((1.0, 0.8, 0.5), 0.2, 0.3))
        ball = cycles_scenes.ball("Ball", (0, 0, 0), 0.5, cycles_scenes.material("Black", cycles_scenes.BLACK), 4)
        lamp = cycles_scenes.lamp("POINT", (0.3, 0, 2.5), energy=300.0, shadow_soft_size=0.0)
        lamp.data.use_soft_falloff = False
        scene.cycles.max_bounces = scene.cycles.volume_bounces = 0
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
        moves(ball, "location", -2.4, 0.0, 2.4)
        moves(eye, "location", 0.1, 0.5, 0.9, axis=2)
        scene.frame_set(2)
        made, report = exposed()
        self.assertFalse(len(report), str(report))

        def blocks(picture):
            return cycles_scenes.region_means(picture, 8).mean(axis=1)

        runs = []
        for seed in range(3):
            scene.cycles.seed = seed
            ours = rendered(*made, passes=16, seed=seed, photons=10_000, bounces=0)
            runs.append([blocks(ours), blocks(cycles_scenes.cycles_picture(scene))])
        scene.render.use_motion_blur = False
        still = blocks(cycles_scenes.cycles_picture(scene))
        ours, cycles = np.array(runs).swapaxes(0, 1)
        error = np.sqrt((ours.var(axis=0, ddof=1) + cycles.var(axis=0, ddof=1)) / 3)
        difference = np.abs(ours.mean(axis=0) / cycles.mean(axis=0) - 1)
        of_still = np.abs(still / cycles.mean(axis=0) - 1).max()
        print(f"figures: blocks differ from Cycles' by up to {100 * difference.max():.2f} %, and still ones by {100 * of_still:.1f} %")
        # As in test_calibration.py.
        self.assertTrue((difference <= 0.015 + 5 * error / cycles.mean(axis=0)).all(), difference)
        self.assertGreater(of_still, 0.1)


if __name__ == "__main__":
    harness.main()
