# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine inside Blender, on pictures that are known exactly: what is in the files that Blender writes."""

import time
from dataclasses import astuple, dataclass
from types import SimpleNamespace

import bpy
import exr
import fake_host
import harness
import numpy as np
from in_blender import InBlender

import addon
from addon import budget, caustics, first_look, latest, panels, passes, requirements, text
from addon.engine import CovbeamEngine
from addon.presets import Preset


class Pictures(InBlender):
    def test_every_pass_is_in_the_multilayer_exr_upright_and_exact(self):
        channels = self.render()
        expected = fake_host.picture(40, 20, passes=3)
        layer = self.scene.view_layers[0].name
        for index, letter in enumerate("RGB"):
            np.testing.assert_array_equal(channels[f"{layer}.Combined.{letter}"], expected.in_scattered[..., index])
            np.testing.assert_array_equal(channels[f"{layer}.In-Scattered.{letter}"], expected.first[..., index])
        np.testing.assert_array_equal(channels[f"{layer}.Combined.A"], np.ones((20, 40), np.float32))
        np.testing.assert_array_equal(channels[f"{layer}.Radius.X"], expected.radius)
        np.testing.assert_array_equal(channels[f"{layer}.Bandwidth.X"], expected.bandwidth)

    def test_a_border_is_rendered_in_its_place_and_black_around(self):
        render = self.scene.render
        render.use_border = True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.1, 0.4
        x, y, width, height = fake_host.border(render)
        full = self.render()[f"{self.scene.view_layers[0].name}.Radius.X"]
        expected = np.zeros((20, 40), np.float32)
        # The border is counted from the bottom, rows of the file from the top.
        expected[20 - y - height : 20 - y, x : x + width] = fake_host.picture(width, height).radius
        np.testing.assert_array_equal(full, expected)
        render.use_crop_to_border = True
        cropped = self.render("cropped")[f"{self.scene.view_layers[0].name}.Radius.X"]
        np.testing.assert_array_equal(cropped, fake_host.picture(width, height).radius)

    def test_a_large_picture_is_seen_in_large_pixels_before_its_first_pass_begins(self):
        shown = []
        put = passes.put
        self.addCleanup(setattr, passes, "put", put)
        passes.put = lambda engine, result, picture: shown.append((len(made), picture)) or put(engine, result, picture)
        made = fake_host.Session.settings
        self.resize(702, 301)
        channels = self.render()
        (sessions, look), (_, first) = shown[:2]
        self.assertEqual(sessions, 1)
        coarse = fake_host.picture(176, 76)
        for name in ("in_scattered", "first", "radius", "bandwidth", "error"):
            found, expected = getattr(look, name), getattr(coarse, name)
            self.assertEqual(found.shape[:2], (301, 702))
            for y, x in ((0, 0), (3, 3), (4, 3), (150, 399), (300, 701)):
                np.testing.assert_array_equal(found[y, x], expected[y // 4, x // 4])
        np.testing.assert_array_equal(first.radius, fake_host.picture(702, 301).radius)
        expected = fake_host.picture(702, 301, passes=3).in_scattered
        np.testing.assert_array_equal(channels[f"{self.scene.view_layers[0].name}.Combined.R"], expected[..., 0])
        self.assertEqual(fake_host.Session.open, 0)
        self.assertTrue(any(line.startswith("First look, in pixels of 4 x 4: after") for line in latest.get().figures))

    def test_small_pictures_have_no_first_look_and_large_ones_no_more_pixels_in_it(self):
        for size, pixel in (((440, 450), 1), ((640, 360), 4), ((1920, 1080), 8), ((16384, 16384), 128), ((1, 250_000), 4)):
            self.assertEqual(first_look.pixel_size(*size), pixel, size)

    def test_each_view_layer_that_is_in_use_is_rendered(self):
        self.scene.view_layers.new("Second")
        self.scene.view_layers.new("Unused").use = False
        channels = self.render()
        self.assertEqual(len(fake_host.Session.settings), 2)
        self.assertIn("Second.In-Scattered.R", channels)
        self.assertNotIn("Unused.In-Scattered.R", channels)

    def test_an_animation_writes_a_file_a_frame(self):
        self.scene.frame_start, self.scene.frame_end = 4, 6
        self.scene.render.filepath = str(self.folder / "frame_##")
        bpy.ops.render.render(animation=True)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), [f"frame_0{n}.exr" for n in (4, 5, 6)])

    def test_the_compositor_runs_on_the_engines_passes(self):
        self.assertTrue(CovbeamEngine.bl_use_postprocess)
        if bpy.app.version >= (5, 0, 0):
            tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
            self.scene.compositing_node_group = tree
            output = tree.nodes.new("NodeGroupOutput")
        else:
            self.scene.use_nodes = True
            tree = self.scene.node_tree
            output = next(node for node in tree.nodes if node.bl_idname == "CompositorNodeComposite")
        layers = tree.nodes.new("CompositorNodeRLayers")
        tree.links.new(layers.outputs["In-Scattered"], output.inputs[0])
        harness.write_exr(self.scene.render.image_settings, layers=False)
        np.testing.assert_array_equal(self.render()["R"], fake_host.picture(40, 20).first[..., 0])


@dataclass
class Glowing:
    """Fog that sends out light."""

    glow: object = "fire"


class LightGroups(InBlender):
    """Lamps of groups: what each adds to the picture is a pass of its own."""

    def setUp(self):
        super().setUp()
        lamps = (("key", 1), ("key", 2), ("rim", 4), ("", 8), ("not a group of the view layer", 16))
        self.fog = SimpleNamespace(glow=None)
        self.lights = tuple(SimpleNamespace(group=group, power=power) for group, power in lamps)
        export, picture = fake_host.export, fake_host.Session.picture
        self.addCleanup(setattr, fake_host, "export", export)
        self.addCleanup(setattr, fake_host.Session, "picture", picture)

        def lit(depsgraph, poll):
            scene, report = export(depsgraph, poll)
            scene.lights, scene.volumes = self.lights, (self.fog,)
            return scene, report

        def of_lights(session, poll=None):
            found = picture(session, poll)
            power = np.float32(sum(light.power for light in session.scene.lights) + sum(32 for each in session.scene.volumes if each.glow))
            found.first[:], found.in_scattered[:], found.radius[:], found.error[:] = power, 2 * power, power, power
            return found

        fake_host.export, fake_host.Session.picture = lit, of_lights
        for name in ("key", "rim", "dark"):
            self.scene.view_layers[0].lightgroups.add(name=name)

    def layer(self, channels, name):
        return channels[f"{self.scene.view_layers[0].name}.{name}"][3, 4]

    def test_each_has_a_pass_and_their_sum_with_the_rest_is_all(self):
        channels = self.render()
        for name, power in (("_key", 3), ("_rim", 4), ("_dark", 0), ("", 31)):
            self.assertEqual(self.layer(channels, f"In-Scattered{name}.G"), power, name)
        self.assertEqual(self.layer(channels, "Combined.G"), 62)
        # The radius is weighted by light, errors of pictures that have nothing in common add as squares.
        self.assertAlmostEqual(self.layer(channels, "Radius.X"), (3 * 3 + 4 * 4 + 24 * 24) / 31, places=4)
        self.assertAlmostEqual(self.layer(channels, "Standard Error.X"), (9 + 16 + 24**2) ** 0.5, places=4)

    def test_what_glows_is_in_the_rest(self):
        self.lights = self.lights[:3]
        self.fog = Glowing()
        channels = self.render()
        for name, power in (("_key", 3), ("_rim", 4), ("", 7 + 32)):
            self.assertEqual(self.layer(channels, f"In-Scattered{name}.G"), power, name)

    def test_the_budget_is_that_of_all(self):
        fake_host.Session.seconds = 0.05
        self.scene.covbeam.passes, self.scene.covbeam.photons, self.scene.covbeam.time_limit = 1000, 9000, 2.0
        start = time.perf_counter()
        self.render()
        # A pass of each group fits into what is left of the 2 s; half a second is for all that is not the engine's on a busy machine.
        self.assertLess(time.perf_counter() - start, 2.5)
        self.assertEqual([settings.photons for settings in fake_host.Session.settings], [3000, 3000, 3000])

    def test_a_name_of_any_length_has_its_pass(self):
        # Blender 4.2 cuts off channels of files after 63 letters, the view layer's among them.
        name = "k" * (63 if bpy.app.version >= (5, 0, 0) else 30)
        self.scene.view_layers[0].lightgroups.add(name=name)
        self.lights[0].group = name
        channels = self.render()
        (name,) = (name for name in channels if "kkk" in name and name.endswith(".G"))
        self.assertEqual(channels[name][3, 4], 1)
        self.assertEqual(self.layer(channels, "In-Scattered_key.G"), 2)


class Settings(InBlender):
    def test_settings_reach_the_session(self):
        chosen = self.scene.covbeam
        chosen.seed, chosen.animate_seed = 7, False
        chosen.photons, chosen.grid, chosen.radius, chosen.quality, chosen.bounces = 1234, 9, 0.5, 0.25, 3
        chosen.beyond, chosen.orders = False, "ALL"
        self.scene.unit_settings.scale_length = 0.1
        self.scene.render.threads_mode, self.scene.render.threads = "FIXED", 3
        self.render()
        (settings,) = fake_host.Session.settings
        # A unit of Blender is a metre for Cycles, whatever it is shown as.
        self.assertEqual(settings, fake_host.Settings(7, 1234, 9, 0.5, 0.25, 3, None, False, 3))

    def test_limits_of_bounces_are_those_of_cycles_unless_all_orders_are_asked_for(self):
        cycles = self.scene.cycles
        cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces, cycles.transmission_bounces, cycles.volume_bounces = 9, 1, 2, 3, 5
        cycles.caustics_reflective = False
        self.render()
        self.scene.covbeam.orders = "ALL"
        self.render()
        limited, every = fake_host.Session.settings
        self.assertEqual(astuple(limited.limits), (9, 1, 2, 3, 5, False, True))
        self.assertIsNone(every.limits)

    def test_presets_set_three_settings_and_good_is_what_a_new_scene_has(self):
        def three(scene):
            return scene.covbeam.passes, scene.covbeam.time_limit, round(scene.covbeam.quality, 6)

        self.scene.covbeam.photons = 1234
        for name, expected in (("DRAFT", (1024, 5.0, 0.03)), ("FINAL", (256, 0.0, 0.01)), ("GOOD", (1024, 30.0, 0.01))):
            self.assertEqual(bpy.ops.covbeam.preset(preset=name), {"FINISHED"})
            self.assertEqual(three(self.scene), expected)
            self.assertEqual(self.scene.covbeam.photons, 1234)
        self.assertEqual(three(bpy.data.scenes.new("New")), three(self.scene))

    def test_animated_settings_and_seeds_are_those_of_the_frame(self):
        chosen = self.scene.covbeam
        for frame in (1, 2):
            chosen.photons = 1000 * frame
            self.scene.keyframe_insert("covbeam.photons", frame=frame)
        self.scene.frame_start, self.scene.frame_end = 1, 2
        self.scene.render.filepath = str(self.folder / "frame")
        bpy.ops.render.render(animation=True)
        first, second = fake_host.Session.settings
        self.assertEqual((first.photons, second.photons), (1000, 2000))
        self.assertEqual((first.seed, second.seed), (chosen.seed_of(1), chosen.seed_of(2)))

    def test_no_bound_on_bounces_is_none(self):
        self.render()
        self.assertIsNone(fake_host.Session.settings[0].bounces)

    def test_the_seed_changes_with_the_frame_only_if_it_is_animated(self):
        chosen = self.scene.covbeam
        animated = {chosen.seed_of(frame) for frame in range(1000)}
        self.assertEqual(len(animated), 1000)
        self.assertTrue(all(0 <= seed < 2**31 for seed in animated))
        chosen.animate_seed = False
        self.assertEqual({chosen.seed_of(frame) for frame in range(10)}, {chosen.seed})

    def test_a_time_limit_is_kept_with_the_picture_whatever_a_pass_costs(self):
        picture = fake_host.Session.picture
        self.addCleanup(setattr, fake_host.Session, "picture", picture)
        self.addCleanup(setattr, fake_host.Session, "seconds", 0.0)

        def slow(session, poll=None):
            time.sleep(0.3)
            return picture(session, poll)

        fake_host.Session.picture = slow
        # Passes that are short, that do not fit, and that get slower all the time.
        for seconds, growth in ((0.1, 1), (1.7, 1), (0.1, 2)):
            fake_host.Session.seconds = seconds
            render_pass = fake_host.Session.render_pass

            def growing(session, poll):
                render_pass(session, poll)
                session.seconds *= growth

            fake_host.Session.render_pass = growing
            self.scene.covbeam.passes, self.scene.covbeam.time_limit = 1000, 3.0
            start = time.perf_counter()
            try:
                passes = self.render()[f"{self.scene.view_layers[0].name}.Combined.B"][0, 0]
            finally:
                fake_host.Session.render_pass = render_pass
            # A second late at most, half of which is for all that is not the engine's on a busy machine.
            self.assertLess(time.perf_counter() - start, 4.0)
            self.assertGreaterEqual(passes, 1)
            self.assertEqual(latest.get().outcome, latest.Outcome.DONE)

    def paths_of_passes(self, path, pair, other, most=50_000):
        """Light paths of the passes of a render of 2 s with at most `most` a pass.

        - path, pair, other: seconds that one of the paths takes, that its pairs take in the gather, and that a pass takes without any.
        """

        class Paths(fake_host.Session):
            def render_pass(self, poll):
                spent = {"photons": path * self.photons, "gather": pair * self.photons + other}
                time.sleep(sum(spent.values()))
                self.times = {name: seconds + spent.get(name, 0.0) for name, seconds in self.times.items()}
                # Of as many cores as there are.
                self.pairs += int(pair * self.photons * self.settings[-1].threads / 6e-8)
                self.passes += 1
                counts.append(self.photons)

        counts = []
        import addon.host.session as module

        self.addCleanup(setattr, module, "Session", module.Session)
        module.Session = Paths
        self.scene.covbeam.photons, self.scene.covbeam.time_limit = most, 2.0
        self.render()
        # A sixteenth would be 3125 of 50,000: fewer than are worth the pass.
        self.assertEqual(counts[0], min(5000, most))
        self.assertEqual(len(set(counts[1:])), 1)
        return counts[1]

    def test_a_time_limit_makes_passes_shorter(self):
        # 20 us a light path: 1 s for a pass of 50,000. 0.15 of 2 s, less what the trial and the overhead took.
        for path, pair in ((2e-5, 0.0), (1e-5, 1e-5)):
            self.assertTrue(8000 < self.paths_of_passes(path, pair, 0.0) < 16000)

    def test_few_light_paths_are_not_tried_out_with_fewer(self):
        self.assertEqual(self.paths_of_passes(2e-5, 0.0, 0.1, most=4000), 4000)

    def test_a_time_limit_leaves_light_paths_as_much_time_as_the_rest_of_a_pass_takes(self):
        # 0.4 s whatever the paths: so few that they take next to nothing would be noise for no gain.
        self.assertTrue(15_000 < self.paths_of_passes(1e-5, 1e-5, 0.4) < 22_000)
        self.assertEqual(self.paths_of_passes(1e-6, 0.0, 0.4), 50_000)

    def test_a_budget_has_no_pass_that_would_end_too_late(self):
        limit = budget.Budget(100, 10.0)
        self.assertFalse(limit.enough(4, 8.0, 1.0, 0.9))
        self.assertTrue(limit.enough(4, 8.0, 1.0, 1.1))
        self.assertTrue(budget.Budget(3, 0.0).enough(3, 0.1, 0, 0))
        self.assertFalse(budget.Budget(3, 1.0).enough(0, 5.0, 9, 9))
        self.assertFalse(limit.late(1, 9.0, 1.4))
        self.assertTrue(limit.late(1, 9.0, 1.6))
        self.assertFalse(limit.late(0, 99.0, 1.0) or budget.Budget(3, 0.0).late(1, 99.0, 1.0))
        self.assertEqual(budget.Budget(10, 0.0).left(5, 20.0), 20.0)
        self.assertEqual(budget.Budget(10, 25.0).left(5, 20.0), 5.0)
        self.assertEqual(budget.Budget(10, 25.0).progress(5, 20.0), 0.8)

    def test_durations_read_as_people_write_them(self):
        for seconds, words in (
            (0.42, "0.4 s"),
            (9.96, "10 s"),
            (59.7, "1:00 min"),
            (185, "3:05 min"),
            (7800, "2:10 h"),
        ):
            self.assertEqual(text.duration(seconds), words)


class Stopping(InBlender):
    def stop_after(self, seconds):
        """Lets the artist press Esc; the time that Blender needs from then on is asserted by the caller."""
        self.stopped = time.perf_counter() + seconds
        goes_on = CovbeamEngine.goes_on
        self.addCleanup(setattr, CovbeamEngine, "goes_on", goes_on)
        CovbeamEngine.goes_on = lambda engine: time.perf_counter() < self.stopped and goes_on(engine)

    def test_esc_ends_a_render_within_0_3_s_and_keeps_what_was_rendered(self):
        fake_host.Session.seconds = 0.1
        self.scene.covbeam.passes = 1000
        self.stop_after(0.55)
        passes = self.render()[f"{self.scene.view_layers[0].name}.Combined.B"][0, 0]
        self.assertLess(time.perf_counter() - self.stopped, 0.3)
        self.assertGreaterEqual(passes, 2)
        self.assertEqual(latest.get().outcome, latest.Outcome.CANCELLED)

    def test_esc_in_the_first_pass_of_a_large_picture_keeps_its_first_look(self):
        self.resize(640, 360)
        fake_host.Session.seconds = 0.5
        self.stop_after(0.8)
        green = self.render()[f"{self.scene.view_layers[0].name}.Combined.G"]
        self.assertLess(time.perf_counter() - self.stopped, 0.3)
        column = np.repeat(fake_host.picture(160, 90).in_scattered[:, 0, 1], 4)
        np.testing.assert_array_equal(green, np.broadcast_to(column[:, None], (360, 640)))
        self.assertEqual(latest.get().outcome, latest.Outcome.CANCELLED)

    def test_esc_while_the_scene_is_read_ends_the_render(self):
        self.stop_after(0.0)
        from addon.host import ask

        export = fake_host.export
        self.addCleanup(setattr, fake_host, "export", export)
        fake_host.export = lambda depsgraph, poll: ask(poll) or export(depsgraph, poll)
        self.render()
        self.assertEqual(latest.get().outcome, latest.Outcome.CANCELLED)
        self.assertEqual(fake_host.Session.settings, [])

    def test_showing_pictures_takes_less_than_a_tenth_of_the_time(self):
        fake_host.Session.seconds = 0.02
        self.scene.covbeam.passes = 60
        picture = fake_host.Session.picture
        self.addCleanup(setattr, fake_host.Session, "picture", picture)
        shown = []

        def slow(session, poll=None):
            shown.append(session.passes)
            time.sleep(0.03)
            return picture(session, poll)

        fake_host.Session.picture = slow
        self.render()
        self.assertEqual((shown[0], shown[-1]), (1, 60))
        # 60 passes of 0.02 s are 1.2 s: 0.12 s are four pictures of 0.03 s; the first and the last are always shown.
        self.assertGreaterEqual(len(shown), 4)
        self.assertLessEqual(len(shown), 6)


class Messages(InBlender):
    def assert_told(self, words):
        with self.assertRaisesRegex(RuntimeError, words):
            self.render()
        self.assertRegex(latest.get().error, words)
        self.assertEqual(latest.get().outcome, latest.Outcome.FAILED)

    def test_an_export_that_makes_no_sense_is_told_in_its_own_words(self):
        from addon.export.report import Untranslatable

        def export(depsgraph, poll):
            raise Untranslatable("The scene has no camera: add one with Add > Camera.")

        self.addCleanup(setattr, fake_host, "export", fake_host.export)
        fake_host.export = export
        self.assert_told("no camera: add one")

    def test_no_memory_is_told_with_what_to_lower(self):
        def render_pass(session, poll):
            raise MemoryError

        self.addCleanup(setattr, fake_host.Session, "render_pass", fake_host.Session.render_pass)
        fake_host.Session.render_pass = render_pass
        self.assert_told("fewer photons")

    def test_a_scene_without_fog_is_black_and_that_is_told(self):
        export = fake_host.export
        self.addCleanup(setattr, fake_host, "export", export)

        def without_fog(depsgraph, poll):
            scene, report = export(depsgraph, poll)
            scene.volumes = ()
            return scene, report

        fake_host.export = without_fog
        self.assertEqual(self.render()[f"{self.scene.view_layers[0].name}.Combined.R"].max(), 0)
        self.assertEqual(latest.get().outcome, latest.Outcome.DONE)
        self.assertIn("no fog", latest.get().advice[0])

    def test_a_defect_is_told_and_blender_goes_on(self):
        def render_pass(session, poll):
            raise ZeroDivisionError("a defect")

        original = fake_host.Session.render_pass
        fake_host.Session.render_pass = render_pass
        try:
            self.assert_told("a defect")
        finally:
            fake_host.Session.render_pass = original
        self.render()
        self.assertEqual(latest.get().outcome, latest.Outcome.DONE)

    def test_the_report_has_what_was_left_out_and_the_figures(self):
        self.render()
        record = latest.get()
        self.assertEqual(record.untranslated, ['Object "Cube": hair: left out'])
        self.assertRegex(record.title, "^Scene, ViewLayer, frame 1$")
        self.assertIn("Geometry: 12 triangles, 0.0 MB", record.figures)
        self.assertTrue(any(line.startswith("Passes: 3 of 3 in ") for line in record.figures))
        self.assertIn("Of the time: photons 0 %, light fields 0 %, grid 0 %, beams 0 %, plan 0 %, gather 0 %, picture 0 %", record.figures)
        self.assertIn("Memory of light and image: 7.0 MB", record.figures)

    def test_each_frame_keeps_its_report_in_its_file(self):
        self.scene.covbeam.animate_seed = False
        self.scene.frame_start, self.scene.frame_end = 4, 5
        for frame in (4, 5):
            self.scene.covbeam.seed = 10 * frame
            self.scene.keyframe_insert("covbeam.seed", frame=frame)
        self.scene.render.filepath = str(self.folder / "frame_##")
        bpy.ops.render.render(animation=True)
        for frame in (4, 5):
            header = exr.header(self.folder / f"frame_0{frame}.exr")
            begin = f"covbeam.{self.scene.view_layers[0].name}."
            kept = {name.removeprefix(begin): text.decode() for name, text in header.items() if name.startswith(begin)}
            self.assertEqual(kept.keys(), {"outcome", "settings", "figures", "not_as_cycles"})
            self.assertEqual(kept["outcome"], "Done")
            self.assertIn(f"seed={10 * frame}", kept["settings"])
            self.assertIn("passes=3, seconds=0.0", kept["settings"])
            self.assertIn("Passes: 3 of 3 in ", kept["figures"])
            self.assertEqual(kept["not_as_cycles"], 'Object "Cube": hair: left out')


class Layout:
    """Stands in for Blender's layout, which needs a window: refuses what Blender would refuse."""

    icons = set(bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys())

    def __init__(self):
        self.drawn = []

    def column(self, align=False):
        return self

    row = column

    def label(self, text="", icon="NONE"):
        assert icon in self.icons, icon
        self.drawn.append(text)

    def prop(self, data, name, text=None):
        self.drawn.append(text or data.bl_rna.properties[name].name)

    def operator(self, name, text="", icon="NONE"):
        assert icon in self.icons, icon
        group, operator = name.split(".")
        self.drawn.append(text)
        known = getattr(getattr(bpy.ops, group), operator).get_rna_type().properties.keys()
        return type("Properties", (), dict.fromkeys(known) | {"__slots__": ()})


class Panels(InBlender):
    def draw(self, engine):
        """All that our panels draw for a scene of an engine."""
        self.scene.render.engine = engine
        layout = Layout()
        for panel in panels._CLASSES:
            if panel.poll(bpy.context):
                panel.draw(type("Panel", (), {"layout": layout}), bpy.context)
        return layout.drawn

    def test_every_setting_has_its_place_and_a_tool_tip(self):
        names = {p.name for p in self.scene.covbeam.bl_rna.properties if p.identifier not in ("rna_type", "name")}
        drawn = self.draw("COVBEAM")
        # Where images go matters for Add Beams only.
        self.assertEqual(names - set(drawn), {"Folder"})
        self.assertEqual(names - set(self.draw("CYCLES")), set())
        for preset in Preset:
            self.assertIn(preset.label, drawn)
            self.assertGreater(len(preset.description), 20)
        for setting in self.scene.covbeam.bl_rna.properties:
            if setting.identifier not in ("rna_type", "name"):
                self.assertGreater(len(setting.description), 20, setting.identifier)

    def test_threads_and_pixels_have_their_place_where_no_panel_of_blenders_shows_them(self):
        self.assertLessEqual({"Threads Mode", "Threads", "Viewport Pixel Size"}, set(self.draw("COVBEAM")))
        self.assertNotIn("Threads", self.draw("CYCLES"))

    def test_the_report_is_drawn_for_both_ways_to_use_it(self):
        self.render()
        for engine in ("COVBEAM", "CYCLES"):
            drawn = self.draw(engine)
            self.assertIn('Object "Cube": hair: left out', drawn)
            self.assertIn("Geometry: 12 triangles, 0.0 MB", drawn)

    def test_artists_are_told_beforehand_whether_beams_are_worth_their_time(self):
        def hint():
            # What was found is good for two seconds.
            caustics._latest = (0, 0.0, False)
            return " ".join(self.draw("CYCLES"))

        material = bpy.data.objects["Cube"].data.materials[0]
        tree = material.node_tree
        shader = tree.nodes["Principled BSDF"]
        self.assertIn("Nothing here focuses light", hint())
        for name in ("Metallic", "Transmission Weight"):
            shader.inputs[name].default_value, shader.inputs["Roughness"].default_value = 1.0, 0.1
            self.assertIn("throw light into the fog", hint())
            shader.inputs["Roughness"].default_value = 0.6
            self.assertIn("Nothing here focuses light", hint())
            shader.inputs[name].default_value = 0.0
        # Also within groups; not where it is not rendered.
        group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
        group.nodes.new("ShaderNodeBsdfGlass")
        tree.nodes.new("ShaderNodeGroup").node_tree = group
        self.assertIn("throw light into the fog", hint())
        bpy.data.objects["Cube"].hide_render = True
        self.assertIn("Nothing here focuses light", hint())

    def test_a_problem_takes_the_place_of_settings(self):
        self.addCleanup(setattr, requirements, "_found", None)
        requirements._found = "The library is missing."
        for engine in ("COVBEAM", "CYCLES"):
            drawn = self.draw(engine)
            self.assertIn("The library is missing.", drawn)
            self.assertNotIn("Photons", drawn)
            self.assertNotIn("Draft", drawn)
            self.assertNotIn("Add Beams", drawn)

    def test_cycles_material_panels_show_with_this_engine_and_only_they_do(self):
        self.assertIn("COVBEAM", bpy.types.CYCLES_MATERIAL_PT_volume.COMPAT_ENGINES)
        self.assertIn("COVBEAM", bpy.types.DATA_PT_lens.COMPAT_ENGINES)
        self.assertNotIn("COVBEAM", bpy.types.CYCLES_RENDER_PT_sampling.COMPAT_ENGINES)

    def test_unregistering_leaves_no_trace_in_other_panels(self):
        addon.unregister()
        try:
            left = [p for p in bpy.types.Panel.__subclasses__() if "COVBEAM" in getattr(p, "COMPAT_ENGINES", ())]
            # Our own classes still exist, unregistered.
            self.assertEqual([panel for panel in left if not panel.__name__.startswith("COVBEAM")], [])
            self.assertFalse(hasattr(bpy.types.Scene, "covbeam"))
        finally:
            addon.register()


if __name__ == "__main__":
    harness.main()
