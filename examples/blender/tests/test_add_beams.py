# SPDX-License-Identifier: GPL-3.0-or-later
"""Add Beams to Cycles: what Blender's compositor makes of Cycles' picture and a picture that is known exactly."""

from types import SimpleNamespace
from unittest import mock

import bpy
import exr
import fake_host
import harness
import numpy as np
from in_blender import InBlender

from addon import beam_render, compositor, latest
from addon.add_beams import COVBEAM_OT_add_beams, COVBEAM_OT_replace_fog


def volume_material(density):
    material = bpy.data.materials.new("Fog")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    volume, output = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
    volume.inputs["Density"].default_value = density
    tree.links.new(volume.outputs["Volume"], output.inputs["Volume"])
    return material


class AddBeams(InBlender):
    """The factory's scene, its cube filled with fog, black around: all light that reaches the camera is the fog's."""

    def setUp(self):
        super().setUp()
        scene = self.scene
        scene.render.engine = "CYCLES"
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.volume_bounces = 4, False, 4
        scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
        cube = bpy.data.objects["Cube"].data
        cube.materials.clear()
        cube.materials.append(volume_material(0.5))
        scene.covbeam.folder = str(self.folder / "beams")
        self.layer = scene.view_layers[0]
        self.file = self.folder / "beams" / f"beams_{self.layer.name}_0001.exr"

    def final(self):
        """The composited picture: (height, width, 4)."""
        harness.write_exr(self.scene.render.image_settings, layers=False)
        self.scene.render.image_settings.color_mode = "RGBA"
        channels = self.render()
        return np.stack([channels[letter] for letter in "RGBA"], axis=-1)

    def tree(self):
        return compositor._tree(self.scene)

    def names(self):
        return sorted(node.bl_idname for node in self.tree().nodes)


class Composite(AddBeams):
    def test_cycles_fog_light_is_replaced_by_covbeams(self):
        before = self.final()
        # There is fog light to be replaced.
        self.assertGreater(before[..., :3].max(), 0.01)
        bpy.ops.covbeam.add_beams()
        after = self.final()
        expected = fake_host.picture(40, 20, passes=3).first
        # Sums and differences of numbers near 1 and below, in float32.
        np.testing.assert_allclose(after[..., :3], expected, rtol=0, atol=1e-5)
        np.testing.assert_array_equal(after[..., 3], before[..., 3])
        # No time goes into what Cycles shows anyway; and that is no setting of the artist's scene.
        self.assertFalse(fake_host.Session.settings[-1].beyond)
        self.assertTrue(self.scene.covbeam.beyond)

    def test_what_is_not_fog_light_stays(self):
        bpy.ops.mesh.primitive_plane_add(size=40, location=(0, 0, -1.5))
        bpy.ops.covbeam.add_beams()
        self.scene.render.use_compositing = False
        harness.write_exr(self.scene.render.image_settings)
        layers = self.render("layers")
        names = ("VolumeDir", "VolumeInd") if bpy.app.version < (5, 0, 0) else ("Volume Direct", "Volume Indirect")
        first = fake_host.picture(40, 20, passes=3).first
        self.scene.render.use_compositing = True
        final = self.final()
        for index, letter in enumerate("RGB"):
            fogs = [layers[f"{self.layer.name}.{name}.{letter}"] for name in names]
            # All three kinds of light are there.
            for light in fogs:
                self.assertGreater(light.max(), 0.001)
            fog = sum(fogs)
            surfaces = layers[f"{self.layer.name}.Combined.{letter}"] - fog
            self.assertGreater(surfaces.max(), 0.01)
            np.testing.assert_allclose(final[..., index], surfaces + first[..., index], rtol=1e-5, atol=1e-5)

    def test_a_denoised_scene_is_denoised_without_its_fog_light(self):
        self.scene.cycles.use_denoising = True
        bpy.ops.covbeam.add_beams()
        self.assertIn("CompositorNodeDenoise", self.names())
        self.assertTrue(any("noisy image" in line for line in latest.get().advice))
        # Cycles' own denoiser is guided by the same.
        (denoise,) = (node for node in self.tree().nodes if node.bl_idname == "CompositorNodeDenoise")
        guides = {name: denoise.inputs[name].links[0].from_socket.name for name in ("Albedo", "Normal")}
        self.assertEqual(guides, {"Albedo": "Denoising Albedo", "Normal": "Denoising Normal"})
        expected = fake_host.picture(40, 20, passes=3).first
        # The denoiser gets a black picture, to rounding, and may leave as much.
        np.testing.assert_allclose(self.final()[..., :3], expected, rtol=0, atol=1e-3)

    def denoisers_of_beams(self):
        nodes = [node for node in self.tree().nodes if node.bl_idname == "CompositorNodeDenoise"]
        return [node for node in nodes if node.inputs["Image"].links[0].from_socket.name == "In-Scattered"]

    def test_noisy_beams_of_a_denoised_scene_have_a_denoiser_of_their_own(self):
        # A tenth of the light, of which red has .3.
        fake_host.Session.error = 0.3
        bpy.ops.covbeam.add_beams()
        # Nothing is denoised that Cycles does not denoise.
        self.assertEqual(self.denoisers_of_beams(), [])
        self.scene.cycles.use_denoising = True
        bpy.ops.covbeam.add_beams()
        (denoise,) = self.denoisers_of_beams()
        self.assertEqual(self.names().count("CompositorNodeDenoise"), 2)
        guides = {name: denoise.inputs[name].links[0].from_socket.name for name in ("Albedo", "Normal")}
        self.assertEqual(guides, {"Albedo": "Denoising Albedo", "Normal": "Denoising Normal"})
        self.assertEqual(denoise.outputs["Image"].links[0].to_node.label, "Add Light in Fog")
        self.assertTrue(any(f'"{self.layer.name}" is noisy' in line for line in latest.get().advice))
        # What is smooth stays, but for what a denoiser takes of saturated light, and at borders.
        found, expected = self.final()[..., :3], fake_host.picture(40, 20, passes=3).first
        self.assertLess(np.sqrt(np.mean((found - expected) ** 2)), 0.05 * np.sqrt(np.mean(expected**2)))
        # With more passes they are no longer noisy.
        fake_host.Session.error = 0.01
        bpy.ops.covbeam.add_beams()
        self.assertEqual((self.denoisers_of_beams(), self.names().count("CompositorNodeDenoise")), ([], 1))
        bpy.ops.covbeam.remove_beams()
        self.assertNotIn("CompositorNodeDenoise", self.names())

    def test_half_of_an_animations_frames_say_whether_it_is_noisy(self):
        self.scene.cycles.use_denoising = True
        self.scene.frame_start, self.scene.frame_end = 1, 3
        for errors, count in (((0.01, 0.01, 0.9), 0), ((0.01, 0.9, 0.9), 1)):
            session_init, left = fake_host.Session.__init__, iter(errors)

            def init(session, *given):
                session_init(session, *given)
                session.error = next(left)

            with mock.patch.object(fake_host.Session, "__init__", init):
                bpy.ops.covbeam.add_beams(animation=True)
            self.assertEqual((list(left), len(self.denoisers_of_beams())), ([], count))

    def test_noise_is_the_error_over_the_light(self):
        from addon.passes import noise_of

        grey = np.full((2, 3, 3), 0.5, np.float32)
        picture = fake_host.Picture(grey, grey, grey[..., 0], grey[..., 0], np.float32([[0.3, 0.0, 0.0], [0.4, 0.0, 0.0]]))
        self.assertAlmostEqual(noise_of(picture, 2), np.sqrt(0.25 / 6) / 0.5, places=6)
        # One pass tells of no error.
        self.assertEqual(noise_of(picture, 1), np.inf)
        picture.in_scattered = np.zeros_like(grey)
        self.assertEqual([noise_of(picture, passes) for passes in (1, 2)], [0, 0])

    def test_denoising_data_is_switched_off_again_if_it_was_off(self):
        self.scene.cycles.use_denoising = True
        for was_on in (False, True):
            self.layer.cycles.denoising_store_passes = was_on
            bpy.ops.covbeam.add_beams()
            self.assertTrue(self.layer.cycles.denoising_store_passes)
            bpy.ops.covbeam.remove_beams()
            self.assertEqual(self.layer.cycles.denoising_store_passes, was_on)

    def test_nodes_of_the_artist_stay_behind_the_sum(self):
        bpy.ops.covbeam.add_beams()
        bpy.ops.covbeam.remove_beams()
        tree = self.tree()
        output = compositor._output_input(tree)
        invert = tree.nodes.new("CompositorNodeInvert")
        layers = next(node for node in tree.nodes if node.bl_idname == "CompositorNodeRLayers")
        tree.links.new(layers.outputs["Image"], invert.inputs["Color"])
        tree.links.new(invert.outputs["Color"], output)
        bpy.ops.covbeam.add_beams()
        expected = 1 - fake_host.picture(40, 20, passes=3).first
        np.testing.assert_allclose(self.final()[..., :3], expected, rtol=0, atol=1e-5)


class Nodes(AddBeams):
    def test_a_second_time_replaces_the_nodes_and_the_picture(self):
        bpy.ops.covbeam.add_beams()
        names, images = self.names(), len(bpy.data.images)
        self.scene.covbeam.passes = 5
        bpy.ops.covbeam.add_beams()
        self.assertEqual(self.names(), names)
        self.assertEqual(len(bpy.data.images), images)
        # Blue counts the passes.
        np.testing.assert_allclose(self.final()[..., 2], 2.5, rtol=0, atol=1e-5)

    def test_a_picture_that_is_used_elsewhere_shows_the_new_one_too(self):
        bpy.ops.covbeam.add_beams()
        image = next(image for image in bpy.data.images if image.filepath)
        image.use_fake_user = True
        self.final()
        self.scene.covbeam.passes = 5
        bpy.ops.covbeam.add_beams()
        np.testing.assert_allclose(self.final()[..., 2], 2.5, rtol=0, atol=1e-5)
        self.assertEqual([image.name for image in bpy.data.images if image.filepath], [image.name])

    def test_removing_them_leaves_the_picture_and_the_scene_as_they_were(self):
        before = self.final()
        bpy.ops.covbeam.add_beams()
        self.assertTrue(self.layer.cycles.use_pass_volume_direct and self.layer.cycles.use_pass_volume_indirect)
        bpy.ops.covbeam.remove_beams()
        self.assertFalse(self.layer.cycles.use_pass_volume_direct or self.layer.cycles.use_pass_volume_indirect)
        self.assertFalse(bpy.ops.covbeam.remove_beams.poll())
        self.assertEqual(len(self.tree().nodes), 2)
        self.assertEqual([image.name for image in bpy.data.images if image.filepath], [])
        np.testing.assert_array_equal(self.final(), before)

    def test_a_pass_that_was_on_before_stays_on(self):
        self.layer.cycles.use_pass_volume_direct = True
        bpy.ops.covbeam.add_beams()
        bpy.ops.covbeam.add_beams()
        bpy.ops.covbeam.remove_beams()
        self.assertTrue(self.layer.cycles.use_pass_volume_direct)
        self.assertFalse(self.layer.cycles.use_pass_volume_indirect)

    def test_an_artists_own_denoiser_gets_the_sum(self):
        self.scene.cycles.use_denoising = True
        tree = compositor._make_tree(self.scene)
        tree.nodes.clear()
        (layers,) = compositor._render_layers(tree, self.scene, self.layer)
        denoise = tree.nodes.new("CompositorNodeDenoise")
        tree.links.new(layers.outputs["Noisy Image"], denoise.inputs["Image"])
        tree.links.new(denoise.outputs["Image"], compositor._output_input(tree))
        bpy.ops.covbeam.add_beams()
        self.assertEqual(self.names().count("CompositorNodeDenoise"), 1)
        self.assertEqual(denoise.inputs["Image"].links[0].from_node.label, "Light in Fog: frame 1")
        bpy.ops.covbeam.remove_beams()
        self.assertEqual(denoise.inputs["Image"].links[0].from_socket.name, "Noisy Image")

    def test_undo_takes_the_nodes_away(self):
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.covbeam.add_beams()
        bpy.ops.ed.undo_push(message="Add Beams")
        self.assertTrue(compositor.has_beams(bpy.context.scene))
        bpy.ops.ed.undo()
        self.assertFalse(compositor.has_beams(bpy.context.scene))
        bpy.ops.ed.redo()
        self.assertTrue(compositor.has_beams(bpy.context.scene))
        self.scene = bpy.context.scene


class InTheInterface(AddBeams):
    """With a window, Blender renders in a job of its own: what the operator does while that runs, and at its end."""

    def setUp(self):
        super().setUp()
        bpy.ops.covbeam.add_beams()
        bpy.ops.covbeam.remove_beams()
        self.running = True
        # The operator itself, but for what only a window has.
        self.operator = SimpleNamespace(report=lambda *said: self.said.append(said), _timer=None, replace=False)
        self.operator._end = lambda: COVBEAM_OT_add_beams._end(self.operator)
        self.operator._render = beam_render.begin(self.scene, self.layer, False)
        self.said = []

    def event(self, kind):
        app = SimpleNamespace(version=bpy.app.version, is_job_running=lambda job: self.running)
        context = SimpleNamespace(window_manager=SimpleNamespace(event_timer_remove=lambda timer: None))
        with mock.patch.object(bpy, "app", app):
            return COVBEAM_OT_add_beams.modal(self.operator, context, SimpleNamespace(type=kind))

    def test_it_waits_for_the_job_and_sets_up_the_nodes_at_its_end(self):
        self.assertEqual(self.event("TIMER"), {"PASS_THROUGH"})
        self.running = False
        self.assertEqual(self.event("MOUSEMOVE"), {"PASS_THROUGH"})
        self.assertFalse(compositor.has_beams(self.scene))
        self.assertEqual(self.event("TIMER"), {"FINISHED"})
        self.assertTrue(compositor.has_beams(self.scene))
        self.assertEqual(len(bpy.data.scenes), 1)

    def test_a_job_that_was_stopped_leaves_nothing(self):
        self.running = False
        latest.begin("stopped").outcome = latest.Outcome.CANCELLED
        self.assertEqual(self.event("TIMER"), {"CANCELLED"})
        self.assertFalse(compositor.has_beams(self.scene))
        self.assertEqual(len(bpy.data.scenes), 1)

    def test_a_job_that_has_failed_is_told(self):
        self.running = False
        latest.fail(latest.begin("failed"), "There is not enough memory")
        self.assertEqual(self.event("TIMER"), {"CANCELLED"})
        self.assertEqual(self.said, [({"ERROR"}, "There is not enough memory")])

    def test_the_first_failure_is_told_whatever_came_after_it(self):
        self.running = False
        failed = latest.begin("first view layer")
        latest.fail(failed, "There is not enough memory")
        latest.fail(latest.begin("second view layer"), "Something else")
        latest.begin("third view layer").outcome = latest.Outcome.DONE
        self.assertEqual(self.event("TIMER"), {"CANCELLED"})
        self.assertEqual(self.said, [({"ERROR"}, "There is not enough memory")])
        self.assertFalse(compositor.has_beams(self.scene))
        # The report panel tells the same.
        self.assertIs(latest.get(), failed)

    def test_a_job_that_never_began_is_not_taken_for_the_one_before(self):
        with mock.patch.object(beam_render, "render"):
            self.assertEqual(bpy.ops.covbeam.add_beams(), {"CANCELLED"})

    def test_a_scene_that_was_renamed_meanwhile_is_told(self):
        self.running = False
        self.scene.name = "Another"
        self.assertEqual(self.event("TIMER"), {"CANCELLED"})
        self.assertIn("renamed", self.said[0][1])

    def test_a_frame_that_was_not_written_is_told(self):
        self.running = False
        self.file.unlink()
        self.assertEqual(self.event("TIMER"), {"CANCELLED"})
        self.assertIn("has not been written", self.said[0][1])
        self.assertFalse(compositor.has_beams(self.scene))


class Lacking(AddBeams):
    """Cycles' fog light is taken away only where covbeam gives all of it back."""

    def lack(self, *missing, volumes=("fog",)):
        """From now on the export reports that light in fog is missing."""
        export = fake_host.export
        self.addCleanup(setattr, fake_host, "export", export)

        def lacking(depsgraph, poll):
            scene, report = export(depsgraph, poll)
            scene.volumes = volumes
            for what in missing:
                report.add('World "World"', what, "it does not light the fog", in_fog=True)
            return scene, report

        fake_host.export = lacking

    def test_cycles_keeps_its_fog_light_until_the_artist_gives_it_up(self):
        before = self.final()
        self.lack("light from the background")
        self.assertEqual(bpy.ops.covbeam.add_beams(), {"CANCELLED"})
        self.assertTrue(self.file.is_file())
        self.assertFalse(compositor.has_beams(self.scene))
        self.assertFalse(self.layer.cycles.use_pass_volume_direct)
        np.testing.assert_array_equal(self.final(), before)
        (advice,) = (line for line in latest.get().advice if "light from the background" in line)
        self.assertIn("stays", advice)
        self.assertTrue(bpy.ops.covbeam.replace_fog.poll())
        self.assertEqual(bpy.ops.covbeam.replace_fog(), {"FINISHED"})
        expected = fake_host.picture(40, 20, passes=3).first
        np.testing.assert_allclose(self.final()[..., :3], expected, rtol=0, atol=1e-5)
        self.assertFalse(bpy.ops.covbeam.replace_fog.poll())

    def test_scripts_give_it_up_beforehand(self):
        self.lack("light from the background")
        self.assertEqual(bpy.ops.covbeam.add_beams(replace=True), {"FINISHED"})
        self.assertTrue(compositor.has_beams(self.scene))

    def test_nodes_of_a_picture_that_had_all_of_it_are_taken_out(self):
        before = self.final()
        bpy.ops.covbeam.add_beams()
        self.lack("light from the background")
        bpy.ops.covbeam.add_beams()
        np.testing.assert_array_equal(self.final(), before)

    def test_what_many_things_lack_is_told_briefly_and_the_report_has_all_of_it(self):
        entries = [f"light of lamp {number:02}" for number in range(60)]
        self.lack(*entries)
        said = []
        operator = SimpleNamespace(report=lambda *given: said.append(given), replace=False)
        operator._render = beam_render.begin(self.scene, self.layer, False)
        latest.clear()
        beam_render.render(operator._render)
        self.assertEqual(COVBEAM_OT_add_beams._end(operator), {"CANCELLED"})
        shown = []
        manager = SimpleNamespace(invoke_confirm=lambda *given, **named: shown.append(named["message"]))
        COVBEAM_OT_replace_fog.invoke(operator, SimpleNamespace(window_manager=manager), None)
        for words in (said[0][1], *shown):
            self.assertLess(len(words), 300)
            self.assertIn(entries[0], words)
            self.assertIn("more", words)
        for entry in entries:
            self.assertTrue(any(entry in line for line in latest.get().untranslated), entry)

    def test_any_frame_may_lack_it(self):
        export, frames = fake_host.export, iter((1, 2, 3))
        self.addCleanup(setattr, fake_host, "export", export)

        def lacking(depsgraph, poll):
            scene, report = export(depsgraph, poll)
            if next(frames) == 2:
                report.add('World "World"', "light from the background", "it does not light the fog", in_fog=True)
            return scene, report

        fake_host.export = lacking
        self.scene.frame_start, self.scene.frame_end = 1, 3
        self.assertEqual(bpy.ops.covbeam.add_beams(animation=True), {"CANCELLED"})
        self.assertFalse(compositor.has_beams(self.scene))

    def test_a_picture_that_was_deleted_meanwhile_is_told(self):
        self.lack("light from the background")
        bpy.ops.covbeam.add_beams()
        self.file.unlink()
        with self.assertRaisesRegex(RuntimeError, "is not there any more"):
            bpy.ops.covbeam.replace_fog()
        self.assertFalse(compositor.has_beams(self.scene))

    def test_without_fog_nothing_is_changed(self):
        before = self.final()
        self.lack(volumes=())
        self.assertEqual(bpy.ops.covbeam.add_beams(), {"CANCELLED"})
        self.assertIn("no fog", latest.get().advice[-1])
        self.assertFalse(compositor.has_beams(self.scene))
        np.testing.assert_array_equal(self.final(), before)

    def test_what_surfaces_lack_keeps_nothing(self):
        # The export of the tests always reports hair.
        self.assertEqual(bpy.ops.covbeam.add_beams(), {"FINISHED"})


class LayersAndFrames(AddBeams):
    """Blue tells which view layer and frame a picture is of."""

    def setUp(self):
        super().setUp()
        self.layer.name = "Near"
        self.far = self.scene.view_layers.new("Far")
        self.scene.view_layers.new("Unused").use = False
        self.addCleanup(setattr, fake_host.Session, "picture", fake_host.Session.picture)
        self.export = fake_host.export

        def picture(session, poll=None):
            _, layer, frame = latest.get().title.split(", ")
            return fake_host.picture(40, 20, self.number(layer, int(frame.split()[1])))

        fake_host.Session.picture = picture

    @staticmethod
    def number(layer, frame):
        return 100 * (1 + ("Near", "Far").index(layer)) + frame

    def wire(self):
        """An artist's nodes: Near - Far / 2, both with their fog."""
        tree = compositor._make_tree(self.scene)
        node, factor, a, b, result = compositor._mix(tree, "", "SUBTRACT", "artist")
        del node["covbeam"]
        factor.default_value = 0.5
        for layer, socket in ((self.layer, a), (self.far, b)):
            (layers,) = compositor._render_layers(tree, self.scene, layer)
            tree.links.new(layers.outputs["Image"], socket)
        tree.links.new(result, compositor._output_input(tree))
        return a, b

    def animation(self, first, last):
        """Means of blue in frames of the composited animation, as it is rendered from the command line: {frame: mean}."""
        self.scene.frame_start, self.scene.frame_end, self.scene.frame_step = first, last, 1
        harness.write_exr(self.scene.render.image_settings, layers=False)
        self.scene.render.filepath = str(self.folder / "frame_####")
        bpy.ops.render.render(animation=True)
        frames = range(first, last + 1)
        return {frame: exr.read(self.folder / f"frame_{frame:04}.exr")["B"].mean() for frame in frames}

    def expected(self, frame):
        return (self.number("Near", frame) - self.number("Far", frame) / 2) / 2

    def test_all_view_layers_that_are_rendered_have_their_own_beams_in_one_file(self):
        a, b = self.wire()
        bpy.ops.covbeam.add_beams()
        self.assertEqual([path.name for path in (self.folder / "beams").iterdir()], ["beams_Near_Far_0001.exr"])
        np.testing.assert_allclose(self.final()[..., 2], self.expected(1), rtol=0, atol=1e-4)
        names = self.names()
        bpy.ops.covbeam.add_beams()
        self.assertEqual(self.names(), names)
        np.testing.assert_allclose(self.final()[..., 2], self.expected(1), rtol=0, atol=1e-4)

    def fogless(self, name):
        """From now on the view layer of this name has no fog."""
        export = fake_host.export
        self.addCleanup(setattr, fake_host, "export", export)

        def fogless(depsgraph, poll):
            scene, report = export(depsgraph, poll)
            scene.volumes = () if depsgraph.view_layer.name == name else scene.volumes
            return scene, report

        fake_host.export = fogless

    def test_a_view_layer_without_fog_stays_as_it_is(self):
        for name, foggy in (("Far", self.layer), ("Near", self.far)):
            with self.subTest(name):
                self.fogless(name)
                # The active view layer, Near, is what F12 shows without a compositor.
                before = self.final()
                self.assertEqual(bpy.ops.covbeam.add_beams(), {"FINISHED"})
                for layer in (self.layer, self.far):
                    self.assertEqual(layer.cycles.use_pass_volume_direct, layer == foggy)
                    self.assertEqual(layer.cycles.use_pass_volume_indirect, layer == foggy)
                self.assertEqual({node["covbeam_layer"] for node in compositor._ours(self.tree())}, {foggy.name})
                self.assertTrue(any(f'"{name}"' in line and "no light in fog" in line for line in latest.get().advice))
                if foggy == self.far:
                    np.testing.assert_array_equal(self.final(), before)
                bpy.ops.covbeam.remove_beams()
                fake_host.export = self.export

    def test_a_view_layer_that_fails_is_told_though_a_later_one_succeeds(self):
        export = fake_host.export
        self.addCleanup(setattr, fake_host, "export", export)

        def failing(depsgraph, poll):
            if depsgraph.view_layer.name == "Near":
                raise MemoryError
            return export(depsgraph, poll)

        fake_host.export = failing
        said = []
        operator = SimpleNamespace(report=lambda *given: said.append(given), replace=False)
        operator._render = beam_render.begin(self.scene, self.layer, False)
        latest.clear()
        # Scripts get what the engine reports; in the interface a job has it, and only the record is left.
        with self.assertRaisesRegex(RuntimeError, "fewer photons"):
            beam_render.render(operator._render)
        self.assertEqual(COVBEAM_OT_add_beams._end(operator), {"CANCELLED"})
        self.assertIn("fewer photons", said[0][1])
        self.assertFalse(compositor.has_beams(self.scene))

    def test_removing_them_restores_each_view_layer(self):
        a, b = self.wire()
        before = self.final()
        self.far.cycles.use_pass_volume_indirect = True
        bpy.ops.covbeam.add_beams()
        bpy.ops.covbeam.remove_beams()
        for layer, socket in ((self.layer, a), (self.far, b)):
            (link,) = socket.links
            self.assertEqual((link.from_node.bl_idname, link.from_node.layer), ("CompositorNodeRLayers", layer.name))
            self.assertFalse(layer.cycles.use_pass_volume_direct)
        self.assertFalse(self.layer.cycles.use_pass_volume_indirect)
        self.assertTrue(self.far.cycles.use_pass_volume_indirect)
        np.testing.assert_array_equal(self.final(), before)

    def test_without_nodes_the_active_view_layer_goes_to_the_output(self):
        bpy.ops.covbeam.add_beams()
        np.testing.assert_allclose(self.final()[..., 2], self.number("Near", 1) / 2, rtol=0, atol=1e-4)
        (advice,) = (line for line in latest.get().advice if "goes nowhere" in line)
        self.assertIn('"Far"', advice)

    def test_no_view_layer_in_use_is_told(self):
        for layer in self.scene.view_layers:
            layer.use = False
        with self.assertRaisesRegex(RuntimeError, "No view layer is rendered"):
            bpy.ops.covbeam.add_beams()

    def test_an_animation_has_beams_in_its_frames_and_cycles_fog_in_all_others(self):
        self.wire()
        cycles = self.animation(1, 24)
        # No view layer of Cycles' has as much light as beams here, and there is some.
        self.assertTrue(all(0 < blue < 10 for blue in cycles.values()))
        self.scene.frame_start, self.scene.frame_end, self.scene.frame_step = 5, 20, 3
        bpy.ops.covbeam.add_beams(animation=True)
        self.assertEqual(len(list((self.folder / "beams").iterdir())), 6)
        (label,) = {node.label for node in self.tree().nodes if node.get("covbeam") == "switch"}
        self.assertEqual(label, "Light in Fog: frames 5 to 20, every 3")
        found = self.animation(1, 24)
        for frame, blue in found.items():
            if frame in (5, 8, 11, 14, 17, 20):
                self.assertAlmostEqual(blue, self.expected(frame), delta=1e-3, msg=str(frame))
            else:
                self.assertEqual(blue, cycles[frame], frame)

    def test_a_frame_whose_file_is_deleted_is_cycles_own_and_is_told(self):
        self.wire()
        cycles = self.animation(1, 4)
        self.scene.frame_start, self.scene.frame_end = 1, 4
        bpy.ops.covbeam.add_beams(animation=True)
        file = self.folder / "beams" / "beams_Near_Far_0003.exr"
        moved = file.rename(self.folder / "moved.exr")

        def check(without):
            found = self.animation(1, 4)
            for frame, blue in found.items():
                if frame in without:
                    self.assertEqual(blue, cycles[frame], frame)
                else:
                    self.assertAlmostEqual(blue, self.expected(frame), delta=1e-3, msg=str(frame))

        check({3})
        (words,) = compositor.missing_files(self.scene)
        self.assertIn("in 1 of 4 frames", words)
        self.assertIn(str(file), words)
        # A still, too.
        self.scene.frame_set(3)
        self.assertAlmostEqual(self.final()[..., 2].mean(), cycles[3], delta=1e-6)
        moved.rename(file)
        check(set())
        self.assertEqual(compositor.missing_files(self.scene), [])
        for path in (self.folder / "beams").iterdir():
            path.unlink()
        check({1, 2, 3, 4})
        self.assertIn("in 4 of 4 frames", compositor.missing_files(self.scene)[0])

    def test_a_denoised_frame_without_beams_is_cycles_own(self):
        self.scene.cycles.use_denoising = True
        self.wire()
        before = self.animation(2, 2)
        bpy.ops.covbeam.add_beams()
        self.assertEqual(self.animation(2, 2), before)

    def test_removing_them_leaves_no_driver(self):
        bpy.ops.covbeam.add_beams()
        self.assertEqual(len(self.tree().animation_data.drivers), 2)
        bpy.ops.covbeam.remove_beams()
        self.assertEqual(len(self.tree().animation_data.drivers), 0)


class Files(AddBeams):
    def test_the_scene_is_left_alone(self):
        self.scene.render.filepath = "kept"
        scenes = len(bpy.data.scenes)
        bpy.ops.covbeam.add_beams()
        self.assertEqual(len(bpy.data.scenes), scenes)
        self.assertEqual((self.scene.render.engine, self.scene.render.filepath), ("CYCLES", "kept"))

    def test_an_animation_shows_each_frame_its_own_file(self):
        self.scene.frame_start, self.scene.frame_end = 3, 5
        self.scene.covbeam.animate_seed = False
        session_init = fake_host.Session.__init__
        frames = iter((3, 4, 5))

        def init(session, *given):
            session_init(session, *given)
            # Blue counts passes, and so tells the frame.
            session.passes = next(frames) - 3

        fake_host.Session.__init__ = init
        try:
            bpy.ops.covbeam.add_beams(animation=True)
        finally:
            fake_host.Session.__init__ = session_init
        self.assertEqual(len(list((self.folder / "beams").iterdir())), 3)
        self.scene.covbeam.passes = 3
        for frame in (4, 5, 3):
            channels = exr.read(self.folder / "beams" / f"beams_{self.layer.name}_{frame:04}.exr")
            self.scene.frame_set(frame)
            final = self.final()
            np.testing.assert_allclose(
                final[..., 0], channels[f"{self.layer.name}.In-Scattered.R"], rtol=0, atol=1e-5, err_msg=str(frame)
            )

    def test_an_unsaved_file_and_an_unwritable_folder_are_told_before_anything_is_rendered(self):
        for folder, words in (
            ("//covbeam/", "has not been saved"),
            ("", "set Folder"),
            ("/proc/nowhere", "Nothing can be written into"),
        ):
            self.scene.covbeam.folder = folder
            with self.assertRaisesRegex(RuntimeError, words):
                bpy.ops.covbeam.add_beams()
        self.assertEqual(fake_host.Session.settings, [])
        self.assertFalse(compositor.has_beams(self.scene))

    def test_other_engines_and_missing_cameras_are_told(self):
        self.scene.render.engine = "BLENDER_WORKBENCH"
        with self.assertRaisesRegex(RuntimeError, "choose Cycles"):
            bpy.ops.covbeam.add_beams()
        self.scene.render.engine = "CYCLES"
        self.scene.camera = None
        with self.assertRaisesRegex(RuntimeError, "no camera"):
            bpy.ops.covbeam.add_beams()

    def test_a_render_that_fails_is_told_and_leaves_nothing(self):
        def render_pass(session, poll):
            raise MemoryError

        original = fake_host.Session.render_pass
        fake_host.Session.render_pass = render_pass
        try:
            with self.assertRaisesRegex(RuntimeError, "fewer photons"):
                bpy.ops.covbeam.add_beams()
        finally:
            fake_host.Session.render_pass = original
        self.assertFalse(compositor.has_beams(self.scene))
        self.assertEqual(len(bpy.data.scenes), 1)

    def test_a_copy_left_by_an_undo_is_removed(self):
        beam_render.begin(self.scene, self.layer, False)
        self.assertEqual(len(bpy.data.scenes), 2)
        bpy.ops.covbeam.add_beams()
        self.assertEqual(len(bpy.data.scenes), 1)


if __name__ == "__main__":
    harness.main()
