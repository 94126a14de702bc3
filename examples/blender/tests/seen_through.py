# SPDX-License-Identifier: GPL-3.0-or-later
"""What volumes let through, pixel by pixel, against Cycles."""

import unittest

import bpy
import numpy as np
import scenes_export as scenes
from host_scenes import density_at
from scenes_export import shader

from addon.export.objects import Objects
from addon.export.report import Report


class SeenThrough(unittest.TestCase):
    """Tests of scenes with one volume between -2 and 2 along Z."""

    def setUp(self):
        scene = scenes.empty()
        scene.cycles.max_bounces = 0

    def compare(self, coefficients, width=2.8, pixels=24, within=3e-3, steps=300):
        """What Cycles lets through along Z is what a function of places has between -2 and 2: extinction (n, 3) [1/m]."""
        shown = self.shown(width, pixels)
        looks = 4
        across = ((np.arange(pixels * looks) + 0.5) / (pixels * looks) - 0.5) * width
        x, y = np.meshgrid(across, -across)
        depth = 0
        for z in (np.arange(steps) + 0.5) / steps * 4 - 2:
            depth = depth + coefficients(np.stack([x, y, np.full_like(x, z)], axis=-1).reshape(-1, 3)) * (4 / steps)
        expected = np.exp(-depth).reshape(pixels, looks, pixels, looks, 3).mean(axis=(1, 3))
        self.assertLess(expected.min(), 0.5)
        # Cycles lets a sample through or not: 256 samples in each of 576 pixels, of which a fourth have smoke.
        np.testing.assert_allclose(shown.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), atol=within)
        self.assertLess(np.abs(shown - expected).mean(), 4 * within)

    def shown(self, width, pixels):
        """What Cycles shows of a white background behind it all, (pixels, pixels, 3)."""
        background = scenes.world(shader("Background", {"Color": (1, 1, 1)}))
        background.cycles_visibility.scatter = False
        eye = bpy.context.scene.camera
        eye.data.type, eye.data.ortho_scale = "ORTHO", width
        eye.location, eye.rotation_euler = (0, 0, 4), (0, 0, 0)
        try:
            return scenes.cycles(256, pixels, pixels)
        finally:
            bpy.context.scene.world = None

    def see_through(self):
        """Cycles shows no smoke."""
        np.testing.assert_array_equal(self.shown(2.8, 8), 1)

    def baked(self, reported=""):
        """Extinction of the exported volume, as a function for `compare`."""
        made, report = scenes.exported()
        self.assertRegex(str(report), f"^{reported}$")
        (volume,) = made.volumes
        extinction = volume.scattering + volume.absorption
        return lambda world: density_at(volume.density, world)[:, None] * extinction

    def looked_up(self):
        """Extinction by the nodes where it is asked for."""
        (filled,) = Objects(bpy.context.evaluated_depsgraph_get(), lambda thing: not thing.hide_render, Report(), None, np.zeros(3)).filled

        def coefficients(world):
            total = filled.fog.at(filled.frame.places(world))
            return total.scattering + total.absorption

        return coefficients
