# SPDX-License-Identifier: GPL-3.0-or-later
"""What the copy of a scene that Add Beams renders has of the scene itself: rigid bodies stand where F12 has them, with all that hangs on them
(a lamp, the camera, instances), and pixels have their shape."""

import unittest
from unittest import mock

import bpy
import harness
import numpy as np
from mathutils import Vector

from addon.engine import CovbeamEngine
from addon.export import motion


class _Look(bpy.types.RenderEngine):
    """What F12 has."""

    bl_idname = "LOOK"
    bl_label = "Look"
    seen = []

    def update(self, data, depsgraph):
        render, frame = depsgraph.scene.render, depsgraph.scene.frame_current
        self.seen.append([])
        # As Cycles does, it asks Blender for the scene at instants of its own choice while the shutter is open.
        for time in frame + motion.moments(render, motion.INSTANTS) if render.use_motion_blur else (frame,):
            self.frame_set(int(np.floor(time)), time - np.floor(time))
            self.note(depsgraph)
        self.frame_set(frame, 0.0)

    def note(self, depsgraph):
        camera = depsgraph.scene.camera.evaluated_get(depsgraph)
        lamps = [tuple(instance.matrix_world.translation) for instance in depsgraph.object_instances if instance.object.type == "LIGHT"]
        self.seen[-1].append((np.array(camera.matrix_world.translation), sorted(lamps)))

    def render(self, depsgraph):
        self.end_result(self.begin_result(0, 0, 8, 8))


class RigidBodies(unittest.TestCase):
    """A cube that falls with the camera, a lamp and an instance of another lamp on it, in fog of the world."""

    def setUp(self):
        bpy.ops.wm.read_factory_settings()
        self.folder = harness.with_addon(self)
        bpy.utils.register_class(_Look)
        self.addCleanup(bpy.utils.unregister_class, _Look)
        _Look.seen.clear()
        scene = self.scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.render.resolution_x = scene.render.resolution_y = 8
        tree = scene.world.node_tree
        fog = tree.nodes.new("ShaderNodeVolumeScatter")
        fog.inputs["Density"].default_value = 0.1
        tree.links.new(fog.outputs["Volume"], tree.nodes["World Output"].inputs["Volume"])
        self.cube = bpy.data.objects["Cube"]
        self.cube.rotation_euler = (0.3, 0.2, 0.1)
        bpy.context.view_layer.objects.active = self.cube
        bpy.ops.rigidbody.object_add()
        # Falls, and turns as it hits what lies below.
        bpy.ops.mesh.primitive_plane_add(size=20, location=(0.5, 0, -1.8))
        bpy.ops.rigidbody.object_add()
        bpy.context.object.rigid_body.type = "PASSIVE"
        group = bpy.data.collections.new("Lamps")
        inner = bpy.data.objects.new("Inner", bpy.data.lights.new("Inner", "POINT"))
        inner.location = (0, 0, 2)
        group.objects.link(inner)
        maker = bpy.data.objects.new("Maker", None)
        maker.instance_type, maker.instance_collection = "COLLECTION", group
        scene.collection.objects.link(maker)
        for thing in (scene.camera, bpy.data.objects["Light"], maker):
            thing.parent = self.cube
        scene.covbeam.folder = str(self.folder)

    def play(self, last):
        for frame in range(1, last + 1):
            self.scene.frame_set(frame)

    def compare(self, first, last=None):
        """Camera and lamps of frames (of the current one if there is no last), for F12 and for Add Beams.

        Returns the camera's places at the instants of each frame, frame by frame, as Add Beams has them.
        """
        self.scene.frame_start, self.scene.frame_end = first, last or first
        found = []
        exposures = motion.exposures

        def noted(*given):
            scenes, report = exposures(*given)
            found.append([(made.camera.position, sorted(tuple(light.position) for light in made.lights)) for made in scenes])
            return scenes, report

        before = Vector(self.cube.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world.translation)
        # Where things are is all that matters here.
        with mock.patch.object(motion, "exposures", noted), mock.patch.object(CovbeamEngine, "_render", lambda engine, job: None):
            bpy.ops.covbeam.add_beams(animation=last is not None)
        self.scene.render.filepath = str(self.folder / "look")
        self.scene.render.engine = "LOOK"
        bpy.ops.render.render(animation=last is not None)
        self.scene.render.engine = "CYCLES"
        self.assertEqual(len(found), len(_Look.seen))
        for instants, expected_instants in zip(found, _Look.seen):
            # Of a frame in which nothing moves there is a single one.
            self.assertIn(len(instants), (1, len(expected_instants)))
            for number, (expected, expected_lamps) in enumerate(expected_instants):
                place, lamps = instants[number % len(instants)]
                # Single precision of lengths of 10 m.
                np.testing.assert_allclose(place, expected, rtol=0, atol=1e-5)
                np.testing.assert_allclose(lamps, expected_lamps, rtol=0, atol=1e-5)
        after = self.cube.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world.translation
        self.assertEqual((self.scene.frame_current, after), (self.frame, before))
        return [[place for place, _ in instants] for instants in found]

    def at(self, frame):
        self.frame = frame
        self.scene.frame_set(frame)

    def test_a_simulation_that_was_played(self):
        start = np.array(self.scene.camera.matrix_world.translation)
        self.play(20)
        self.at(20)
        ((place,),) = self.compare(20)
        self.assertGreater(np.abs(place - start).max(), 0.3)

    def test_an_animation_from_its_middle_while_its_last_frame_is_shown(self):
        self.play(20)
        self.at(20)
        places = self.compare(18, 20)
        self.assertGreater(np.abs(places[0][0] - places[2][0]).max(), 1e-3)

    def test_an_animation_from_its_beginning(self):
        self.at(1)
        self.compare(1, 8)

    def test_a_baked_simulation(self):
        self.scene.rigidbody_world.point_cache.frame_end = 20
        with bpy.context.temp_override(point_cache=self.scene.rigidbody_world.point_cache):
            bpy.ops.ptcache.bake(bake=True)
        self.at(3)
        self.compare(9, 11)

    def test_a_simulation_that_was_played_in_part(self):
        """And the artist's cache has then what it had."""
        self.play(3)
        self.at(3)
        cache = self.scene.rigidbody_world.point_cache
        before = cache.info
        self.scene.frame_start, self.scene.frame_end = 2, 5
        with mock.patch.object(CovbeamEngine, "_render", lambda engine, job: None):
            bpy.ops.covbeam.add_beams(animation=True)
        self.assertEqual((cache.info, cache.is_baked), (before, False))
        self.compare(2, 5)

    def test_a_simulation_that_was_played_in_part_and_is_rendered_later(self):
        self.play(3)
        self.at(3)
        self.compare(7, 9)

    def blur(self, played, first, last, baked=False):
        """Compares frames with motion blur after frames up to `played` were played, and returns what `compare` does."""
        self.scene.render.use_motion_blur = True
        self.scene.render.motion_blur_shutter = 0.8
        self.play(played)
        cache = self.scene.rigidbody_world.point_cache
        if baked:
            with bpy.context.temp_override(point_cache=cache):
                bpy.ops.ptcache.bake_from_cache()
        self.at(max(played, 1))
        places = self.compare(first, last)
        self.assertEqual(cache.is_baked, baked)
        return places

    def test_motion_blur_of_what_was_played_in_part(self):
        places = self.blur(3, 2, 5)
        # The shutter sees it move.
        self.assertGreater(np.abs(places[0][0] - places[0][-1]).max(), 1e-4)

    def test_motion_blur_of_what_was_never_played(self):
        self.blur(0, 2, 4)

    def test_motion_blur_of_what_was_played_wholly(self):
        places = self.blur(8, 4, 6)
        self.assertGreater(np.abs(places[0][0] - places[0][-1]).max(), 1e-4)

    def test_motion_blur_of_what_was_baked(self):
        places = self.blur(8, 4, 6, baked=True)
        self.assertGreater(np.abs(places[0][0] - places[0][-1]).max(), 1e-4)

    def test_again_from_the_beginning(self):
        """The scene's own simulation goes on: where its bodies are gone, Blender crashes."""
        for played, first, last in ((3, 2, 5), (5, 2, 4), (8, 4, 6)):
            self.at(1)
            _Look.seen.clear()
            self.blur(played, first, last)

    def test_what_was_not_simulated(self):
        self.at(11)
        self.compare(11)
        _Look.seen.clear()
        self.compare(9, 11)


class Pixels(unittest.TestCase):
    def test_the_camera_sees_pixels_that_are_not_square(self):
        bpy.ops.wm.read_factory_settings()
        folder = harness.with_addon(self)
        scene = bpy.context.scene
        render = scene.render
        render.engine = "CYCLES"
        render.resolution_x, render.resolution_y, render.resolution_percentage = 24, 16, 100
        render.pixel_aspect_x, scene.camera.data.shift_y = 1.7, 0.1
        scene.covbeam.folder = str(folder)
        found = []
        exposures = motion.exposures

        def noted(*given):
            scenes, report = exposures(*given)
            found.append(scenes[0].camera)
            return scenes, report

        with mock.patch.object(motion, "exposures", noted), mock.patch.object(CovbeamEngine, "_render", lambda engine, job: None):
            bpy.ops.covbeam.add_beams()
        # A file is there: Blender 5.0.1 writes no layers of other pixels than square ones.
        self.assertEqual(len(list(folder.iterdir())), 1)
        (camera,) = found
        depsgraph = bpy.context.evaluated_depsgraph_get()
        matrix = np.array(scene.camera.calc_matrix_camera(depsgraph, x=24, y=16, scale_x=1.7, scale_y=1.0))
        for x, y, corner in ((0, 0, (-1, 1)), (24, 16, (1, -1))):
            x, y, _, w = matrix @ (camera.left + x * camera.step[0], camera.top - y * camera.step[1], -1, 1)
            np.testing.assert_allclose((x / w, y / w), corner, rtol=0, atol=1e-6)
        self.assertAlmostEqual(render.pixel_aspect_x, 1.7, places=6)


if __name__ == "__main__":
    harness.main()
