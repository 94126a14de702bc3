# SPDX-License-Identifier: GPL-3.0-or-later
"""What a viewport renders when: on a clock and on sessions whose costs are known, and with real sessions."""

import gc
import sys
import tempfile
import unittest
import weakref
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import exr  # noqa: E402
import harness  # noqa: E402
import host_scenes  # noqa: E402
from host_scenes import directions  # noqa: E402
from window import Window, viewport  # noqa: E402

import addon  # noqa: E402
from addon.budget import Budget  # noqa: E402
from addon.host import ask  # noqa: E402
from addon.host.scene import Aperture  # noqa: E402
from addon.host.session import Session, Settings  # noqa: E402
from addon.viewport import PATIENCE, SLICE, Viewport  # noqa: E402

WIDTH, HEIGHT = 400, 300

CAMERA = host_scenes.camera((0, 0, -4), (0, 0, 0), 40, WIDTH, HEIGHT)


@dataclass
class Computer:
    """Seconds that things take, on a clock of its own: of each pixel in making a session (setup), in a pass (ray) and in a picture, and
    of each light path. Polls are asked every 10 ms of it."""

    setup: float = 1e-7
    ray: float = 1e-7
    picture: float = 1e-7
    path: float = 1e-6
    now: float = 0.0

    def clock(self):
        return self.now

    def work(self, seconds, poll):
        end = self.now + seconds
        ask(poll)
        while self.now + 0.01 < end:
            self.now += 0.01
            ask(poll)
        self.now = end


class Fake:
    """A session on a Computer. Its picture is (width, passes, photons)."""

    def __init__(self, computer, scene, settings, poll=None):
        self.computer, self.camera, self.settings = computer, scene.camera, settings
        self.pixels, self.passes, self.photons, self.longest = scene.camera.width * scene.camera.height, 0, settings.photons, 0.0
        self.seed, self.lost, self.is_closed = settings.seed, 0, False
        computer.work(computer.setup * self.pixels, poll)

    def restart(self, photons, plain=False):
        self.lost += self.passes
        self.passes, self.photons = 0, min(photons, self.settings.photons)

    def render_pass(self, poll=None):
        self.computer.work(self.computer.ray * self.pixels + self.computer.path * self.photons, poll)
        self.passes += 1

    def picture(self, poll=None):
        self.computer.work(self.computer.picture * self.pixels, poll)
        return self.camera.width, self.passes, self.photons

    def close(self):
        self.is_closed = True


class OnAClock(unittest.TestCase):
    def setUp(self):
        self.begin()

    def begin(self, **costs):
        """A viewport of a computer that takes so long."""
        self.computer, self.sessions, self.steps = Computer(**costs), [], []
        self.viewport = Viewport(self.session, self.computer.clock)
        self.update()

    def session(self, scene, settings, poll=None):
        self.sessions.append(made := Fake(self.computer, scene, settings, poll))
        return made

    def update(self, passes=64, seconds=0.0, **settings):
        self.scene = replace(host_scenes.black_ball(8))
        return self.viewport.update(self.scene, Settings(**({"photons": 50_000} | settings)), Budget(passes, seconds))

    def step(self):
        """A slice; what it shows."""
        start = self.computer.now
        shown = self.viewport.step(SLICE)
        self.steps.append(self.computer.now - start)
        return shown

    def run_out(self):
        """Slices until nothing is left; what they have shown."""
        shown = []
        while not self.viewport.done:
            shown += filter(None, [self.step()])
            self.assertLess(len(self.steps), 10_000)
        return shown

    def alive(self):
        return [session for session in self.sessions if not session.is_closed]

    def test_the_first_slice_shows_a_quarter_of_the_resolution_and_the_last_all_of_it(self):
        self.viewport.view(CAMERA)
        first = self.step()
        self.assertEqual((first.pixel, first.picture[0]), (4, WIDTH // 4))
        self.assertLess(self.steps[0], 0.3)
        shown = self.run_out()
        self.assertEqual((shown[-1].pixel, shown[-1].picture[0], shown[-1].passes), (1, WIDTH, 64))
        pixels = [each.pixel for each in shown]
        self.assertEqual(pixels, sorted(pixels, reverse=True))

    def test_no_picture_has_less_light_than_the_one_before_once_the_first_is_there(self):
        self.viewport.view(CAMERA)
        self.step()
        light = [shown.passes * shown.photons for shown in self.run_out()]
        self.assertGreater(len(light), 10)
        self.assertEqual(light, sorted(light))

    def test_slices_take_as_long_as_asked_for(self):
        for path in (1e-7, 1e-6, 1e-5, 1e-4):
            self.begin(path=path)
            self.viewport.view(CAMERA)
            self.run_out()
            # The first has to show something, the next few learn what a light path takes; a pass may be half as long again.
            self.assertLess(max(self.steps[6:]), 1.6 * SLICE, path)
            self.assertGreater(np.mean(self.steps[6:-1]), 0.3 * SLICE, path)

    def test_passes_have_as_many_light_paths_as_there_is_time_for(self):
        for path, least, most in ((1e-7, 50_000, 50_000), (1e-6, 50_000, 50_000), (1e-5, 5_000, 12_000), (1e-4, 1_000, 1_100)):
            self.begin(path=path)
            self.viewport.view(CAMERA)
            photons = self.run_out()[-1].photons
            self.assertTrue(least <= photons <= most, (path, photons))

    def test_what_takes_too_long_is_given_up_and_pixels_stay_larger(self):
        # All pixels take 0.96 s a pass, a quarter of them 0.24 s.
        for costs in ({"ray": 8e-6}, {"setup": 8e-6}, {"picture": 8e-6}):
            self.begin(**costs)
            self.viewport.view(CAMERA)
            shown = self.run_out()
            self.assertEqual((shown[-1].pixel, shown[-1].passes), (2, 64), costs)
            # What is given up may come after something short.
            self.assertLess(max(self.steps), PATIENCE + SLICE)
            # Another view knows.
            count = len(self.sessions)
            self.viewport.view(replace(CAMERA, near=0.5))
            self.run_out()
            self.assertEqual({session.camera.width for session in self.sessions[count:]}, {WIDTH // 4, WIDTH // 2})

    def test_a_slow_computer_begins_with_larger_pixels_the_next_time(self):
        self.begin(ray=2e-4)
        widths = []
        for near in (0.1, 0.2, 0.3, 0.4):
            self.viewport.view(replace(CAMERA, near=near))
            widths.append(self.step().picture[0])
        self.assertEqual(widths, [100, 50, 25, 25])
        self.computer.ray = 1e-7
        for near in (0.5, 0.6, 0.7):
            self.viewport.view(replace(CAMERA, near=near))
            widths.append(self.step().picture[0])
        self.assertEqual(widths[4:], [25, 50, 100])

    def test_however_slow_passes_go_on(self):
        self.begin(ray=1e-3)
        self.update(passes=5)
        self.viewport.view(CAMERA)
        self.assertEqual(self.run_out()[-1].passes, 5)

    def test_each_new_view_has_a_picture_at_once_while_the_artist_turns_around(self):
        for k in range(20):
            self.viewport.view(replace(CAMERA, near=0.1 + 0.01 * k))
            self.assertIsNotNone(self.step())
        self.assertEqual({session.camera.width for session in self.sessions}, {WIDTH // 4})
        self.assertEqual([len(self.sessions), len(self.alive())], [20, 1])

    def test_only_what_changes_begins_anew(self):
        blurred = replace(CAMERA, aperture=Aperture(0.1, 2.0))
        self.assertTrue(self.viewport.view(CAMERA))
        self.run_out()
        self.assertFalse(self.viewport.view(host_scenes.camera((0, 0, -4), (0, 0, 0), 40, WIDTH, HEIGHT)))
        budget = Budget(64, 0.0)
        self.assertFalse(self.viewport.update(self.scene, Settings(photons=50_000), budget))
        self.assertTrue(self.viewport.done)
        for change in (
            lambda: self.viewport.view(replace(CAMERA, width=WIDTH + 1)),
            lambda: self.viewport.view(CAMERA),
            lambda: self.viewport.view(CAMERA, 2),
            lambda: self.viewport.view(blurred, 2),
            lambda: self.viewport.view(replace(blurred, aperture=Aperture(0.1, 2.1)), 2),
            lambda: self.viewport.update(self.scene, Settings(photons=50_000, seed=1), budget),
            lambda: self.viewport.update(self.scene, Settings(photons=50_000, seed=1), Budget(65, 0.0)),
            lambda: self.viewport.update(replace(self.scene), Settings(photons=50_000, seed=1), Budget(65, 0.0)),
        ):
            self.assertTrue(change())
            self.assertFalse(self.viewport.done)
            self.run_out()
        self.assertEqual(self.sessions[-1].seed, 1)

    def test_pixel_size_is_that_of_the_finest_pixels(self):
        self.viewport.view(CAMERA, 2)
        shown = [self.step(), *self.run_out()]
        self.assertEqual((shown[0].pixel, shown[-1].pixel, shown[-1].picture[0]), (8, 2, WIDTH // 2))

    def test_a_view_ends_with_its_time_or_its_passes_and_shows_them_all(self):
        for passes, seconds in ((3, 0.0), (1000, 2.0), (7, 100.0)):
            self.update(passes=passes, seconds=seconds)
            start = self.computer.now
            self.viewport.view(replace(CAMERA, near=0.001 * passes))
            shown = self.run_out()[-1]
            self.assertEqual(shown.pixel, 1)
            if seconds == 2.0:
                self.assertTrue(2.0 <= self.computer.now - start < 2.3)
                self.assertEqual((shown.passes, shown.photons), (self.sessions[-1].passes, self.sessions[-1].photons))
            else:
                self.assertEqual(shown.passes, passes)
            self.assertIsNone(self.viewport.step(SLICE))

    def test_pictures_take_a_quarter_of_the_time_at_most(self):
        self.begin(picture=1e-6, path=1e-5)
        self.viewport.view(CAMERA)
        shown = self.run_out()
        finest = [each for each in shown if each.pixel == 1]
        # Each takes 0.12 s, as long as a pass.
        self.assertTrue(64 / 4 - 4 <= len(finest) <= 64 / 3 + 2, len(finest))

    def test_nothing_is_rendered_without_a_scene_or_a_view(self):
        viewport = Viewport(self.session, self.computer.clock)
        self.assertTrue(viewport.done)
        viewport.view(CAMERA)
        viewport.update(None, Settings(), Budget(3, 0.0))
        self.assertTrue(viewport.done)
        self.assertIsNone(viewport.step(SLICE))
        self.assertEqual(self.sessions, [])

    def test_sessions_are_closed_with_their_view_with_the_viewport_and_at_the_end(self):
        self.viewport.view(CAMERA)
        self.step()
        self.assertEqual(len(self.alive()), 1)
        self.viewport.update(None, Settings(), Budget(64, 0.0))
        self.assertEqual(self.alive(), [])
        self.update()
        self.run_out()
        self.assertEqual(self.alive(), [])
        self.update()
        self.step()
        self.assertEqual(len(self.alive()), 1)
        self.viewport.close()
        self.assertEqual(self.alive(), [])
        self.assertIsNone(self.viewport.step(SLICE))
        self.update()
        self.viewport.view(CAMERA)
        self.step()
        # Blender lets go of an engine without a word; garbage need not be collected for that.
        gc.disable()
        self.addCleanup(gc.enable)
        self.viewport = None
        self.assertEqual(self.alive(), [])

    def test_a_session_that_fails_is_told_once_and_forgotten(self):
        class Broken(Fake):
            def render_pass(self, poll=None):
                if self.camera.width == WIDTH:
                    raise MemoryError
                super().render_pass(poll)

        def session(*given):
            self.sessions.append(made := Broken(self.computer, *given))
            return made

        self.viewport = Viewport(session, self.computer.clock)
        self.update()
        self.viewport.view(CAMERA)
        with self.assertRaises(MemoryError):
            self.run_out()
        self.assertEqual((self.viewport.done, self.alive()), (True, []))
        self.assertIsNone(self.viewport.step(SLICE))
        self.viewport.view(replace(CAMERA, near=1.0))
        self.assertIsNotNone(self.step())


class Cameras(unittest.TestCase):
    def test_a_large_pixel_looks_where_the_middle_of_those_it_covers_does(self):
        camera = host_scenes.camera((1, 2, 3), (0.1, 0, 0), 50, 37, 23)
        for pixel in (1, 2, 4, 8):
            large = camera.coarser(pixel)
            self.assertEqual((large.width, large.height), (int(np.ceil(37 / pixel)), int(np.ceil(23 / pixel))))
            y, x = (k.ravel() + 0.5 for k in np.indices((large.height, large.width)))
            np.testing.assert_allclose(directions(large, x, y), directions(camera, pixel * x, pixel * y), atol=1e-6)


class WithSessions(unittest.TestCase):
    def test_a_real_scene_gets_to_the_same_picture_as_a_render(self):
        scene, settings = host_scenes.black_ball(48), Settings(photons=20_000, seed=3)
        viewport = Viewport(Session)
        viewport.update(replace(scene, camera=None), settings, Budget(24, 0.0))
        viewport.view(scene.camera)
        start, shown, first = perf_counter(), None, None
        while not viewport.done:
            shown = viewport.step(SLICE) or shown
            first = first or (perf_counter() - start, shown)
        print(f"figures: first picture after {first[0]:.2f} s, {shown.passes} passes of {shown.photons} after {perf_counter() - start:.1f} s")
        self.assertEqual(first[1].picture.in_scattered.shape[:2], (12, 12))
        self.assertEqual((shown.pixel, shown.passes), (1, 24))
        session = Session(scene, settings)
        session.restart(shown.photons)
        for _ in range(24):
            session.render_pass()
        np.testing.assert_array_equal(shown.picture.in_scattered, session.picture().in_scattered)
        session.close()
        # Blocks of the first picture show the same scene: means of a thousand light paths here vary by 15 % (four seeds), shapes less.
        rough, fine = first[1].picture.in_scattered, shown.picture.in_scattered.reshape(12, 4, 12, 4, 3).mean(axis=(1, 3))
        self.assertLess(abs(rough.mean() / fine.mean() - 1), 0.45)
        self.assertGreater(np.corrcoef(rough.ravel(), fine.ravel())[0, 1], 0.7)

    def test_nothing_of_a_viewport_is_left(self):
        viewport = Viewport(Session)
        scene = host_scenes.black_ball(48)
        viewport.update(scene, Settings(photons=2000), Budget(24, 0.0))
        viewport.view(scene.camera)
        viewport.step(SLICE)
        viewport.close()
        left = weakref.ref(scene)
        del viewport, scene
        gc.collect()
        self.assertIsNone(left())
        self.assertEqual([thing for thing in gc.get_objects() if isinstance(thing, Session)], [])


class InBlender(unittest.TestCase):
    def test_a_camera_view_shows_what_a_render_does(self):
        bpy.ops.wm.read_factory_settings()
        addon.register()
        self.addCleanup(addon.unregister)
        scene = bpy.context.scene
        tree = bpy.data.objects["Cube"].data.materials[0].node_tree
        tree.nodes.clear()
        volume, output = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(volume.outputs["Volume"], output.inputs["Volume"])
        space, region, region_3d = viewport()
        render = scene.render
        render.engine = "COVBEAM"
        width, height = render.resolution_x, render.resolution_y = 98, 59
        # The frame fills the region.
        render.pixel_aspect_x, render.pixel_aspect_y = region.width / width, region.height / height
        scene.covbeam.passes, scene.covbeam.photons, scene.covbeam.time_limit = 24, 4000, 0.0
        with tempfile.TemporaryDirectory() as folder:
            # Blender 5.0 writes no layers of pixels that are not square.
            harness.write_exr(render.image_settings, layers=False)
            render.filepath = str(Path(folder) / "picture.exr")
            bpy.ops.render.render(write_still=True)
            channels = exr.read(Path(render.filepath))
        rendered = np.stack([channels[letter] for letter in "RGB"], axis=-1)
        harness.start_gpu()
        region_3d.view_perspective, region_3d.view_camera_zoom = "CAMERA", 50 * (2 - np.sqrt(2))
        region_3d.update()
        window = Window(width, height)
        self.addCleanup(window.close)
        shown = window.finish()[..., :3]
        # The viewport has chosen its own number of light paths. Blocks of 7 x 7 pixels; what is dark has more noise than light.
        self.assertTrue(window.engine.told[-1].startswith("Covbeam: 24 of 24 passes"), window.engine.told[-1])
        one, other = (picture[:56].reshape(8, 7, 14, 7, 3).mean(axis=(1, 3, 4)) for picture in (shown, rendered))
        print(f"figures: viewport over render {one.mean() / other.mean():.4f}")
        self.assertLess(abs(one.mean() / other.mean() - 1), 0.03)
        lit = other > 0.1 * other.max()
        self.assertGreater(lit.sum(), 10)
        self.assertLess(np.abs(one / np.maximum(other, 1e-9) - 1)[lit].max(), 0.25)


if __name__ == "__main__":
    harness.main()
