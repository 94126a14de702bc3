# SPDX-License-Identifier: GPL-3.0-or-later
"""Esc stops Add Beams and all of its work at once, whatever it is at: with the real host, whose threads are native."""

import threading
import time
import unittest

import bpy
import harness

from addon import compositor
from addon.engine import CovbeamEngine

#: After this long, artists take it for hung [s].
_PATIENCE = 0.3


class Stopping(unittest.TestCase):
    """A glass ball in fog with lamps of two light groups, which passes take seconds for."""

    def setUp(self):
        bpy.ops.wm.read_factory_settings()
        self.folder = harness.with_addon(self)
        scene = self.scene = bpy.context.scene
        tree = bpy.data.objects["Cube"].data.materials[0].node_tree
        tree.nodes.clear()
        volume, output = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
        volume.inputs["Density"].default_value = 0.3
        tree.links.new(volume.outputs["Volume"], output.inputs["Volume"])
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=0.4)
        material = bpy.data.materials.new("Glass")
        material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Transmission Weight"].default_value, shader.inputs["Roughness"].default_value = 1.0, 0.0
        bpy.context.object.data.materials.append(material)
        rim = bpy.data.objects.new("Rim", bpy.data.lights.new("Rim", "SPOT"))
        rim.location, rim.data.energy, rim.lightgroup = (0, 0, 4), 500, "rim"
        scene.collection.objects.link(rim)
        bpy.context.view_layer.lightgroups.add(name="rim")
        scene.render.engine = "CYCLES"
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 160, 90, 100
        scene.covbeam.passes, scene.covbeam.photons, scene.covbeam.time_limit = 1000, 400_000, 0.0
        scene.covbeam.folder = str(self.folder)

    def stop_after(self, seconds):
        goes_on, self.stopped = CovbeamEngine.goes_on, time.perf_counter() + seconds
        CovbeamEngine.goes_on = lambda engine: time.perf_counter() < self.stopped and goes_on(engine)
        clock = threading.Timer(seconds, lambda: setattr(self, "used", time.process_time()))
        clock.start()
        try:
            self.assertEqual(bpy.ops.covbeam.add_beams(), {"CANCELLED"})
        finally:
            CovbeamEngine.goes_on = goes_on
            clock.join()

    def test_all_work_ends_whenever_it_is_stopped(self):
        # While the scene is read, while light paths learn, and in passes.
        for seconds in (0.0, 0.3, 1.0, 2.5):
            with self.subTest(seconds=seconds):
                self.stop_after(seconds)
                # On a machine that is busy with other things the clock says nothing: then this process's own time does.
                late = min(time.perf_counter() - self.stopped, time.process_time() - self.used)
                print(f"figures: stopped after {seconds} s, ended {late:.2f} s later")
                self.assertLess(late, _PATIENCE)
                before = time.process_time()
                time.sleep(_PATIENCE)
                self.assertLess(time.process_time() - before, 0.05)
                self.assertFalse(compositor.has_beams(self.scene))
                self.assertEqual(len(bpy.data.scenes), 1)


if __name__ == "__main__":
    harness.main()
