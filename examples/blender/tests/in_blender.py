# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the add-on on the host of fake_host, whose pictures are known exactly."""

import unittest

import bpy
import exr
import fake_host
import harness

import addon

fake_host.install()


class InBlender(unittest.TestCase):
    """Each test begins with Blender's factory settings, a small covbeam scene, and a folder of its own."""

    @classmethod
    def setUpClass(cls):
        bpy.ops.wm.read_factory_settings()
        addon.register()

    @classmethod
    def tearDownClass(cls):
        addon.unregister()

    def setUp(self):
        bpy.ops.wm.read_homefile(use_factory_startup=True)
        self.folder = harness.folder_of(self)
        fake_host.Session.seconds, fake_host.Session.error = 0.0, 0.01
        fake_host.Session.settings.clear()
        self.scene = bpy.context.scene
        render = self.scene.render
        render.engine = "COVBEAM"
        render.resolution_x, render.resolution_y, render.resolution_percentage = 80, 40, 50
        harness.write_exr(render.image_settings)
        self.scene.covbeam.passes, self.scene.covbeam.time_limit = 3, 0.0

    def tearDown(self):
        self.assertEqual(fake_host.Session.open, 0, "a session is still open")

    def resize(self, width, height):
        render = self.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100

    def render(self, name="picture", **options):
        self.scene.render.filepath = str(self.folder / name)
        bpy.ops.render.render(write_still=True, **options)
        return exr.read(self.folder / f"{name}.exr")
