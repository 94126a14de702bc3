# SPDX-License-Identifier: GPL-3.0-or-later
"""Sessions of the native renderer: their pictures of what the extension makes of a scene against closed forms, and what they promise. Closed
forms of lamps, lenses, filters and shadows are tested by covbeam-tests: it is the same renderer."""

import sys
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import bpy  # noqa: F401  the add-on is a package of Blender's
import host_scenes as scenes
from addon.host.scene import Glow, Light, LightKind, Projection
from addon.host.session import Session, Settings


def session(scene, poll=None, **settings):
    """A Session with few photons."""
    return Session(scene, Settings(**{"photons": 4000, **settings}), poll)


def rendered(scene, passes=2, **settings):
    """The Picture of some passes."""
    made = session(scene, **settings)
    try:
        for _ in range(passes):
            made.render_pass()
        return made.picture()
    finally:
        made.close()


def places_in_cloud(view, steps=120):
    """Places along the rays through the middles of a camera's pixels where they may be in the cloud of host_scenes, (steps, h, w, 3), the
    rays' directions, and the length of a step."""
    y, x = np.mgrid[0 : view.height, 0 : view.width] + 0.5
    direction = scenes.directions(view, x.ravel(), y.ravel()).reshape(view.height, view.width, 3)
    middle, step = np.linalg.norm(view.position), 3.6 / steps
    at = middle - 1.8 + (np.arange(steps) + 0.5) * step
    return view.position + at[:, None, None, None] * direction, direction, step


class Fisheye(unittest.TestCase):
    """A picture that is dark beyond a circle."""

    def test_even_light_is_as_bright_up_to_the_edge_and_there_is_none_beyond(self):
        # In the middle of a ball of even fog under an even sky all directions are alike.
        fog, sky = scenes.volume("fog", 0.6, 0, low=-1, high=1), Light("", LightKind.WORLD, sky=np.full((1, 1, 3), 2, np.float32))
        view = replace(scenes.camera((0, 0, 0), (0, 0, 1), 90, 32, 32), projection=Projection.FISHEYE, widest=2.0)
        view = replace(view, left=-2.0, top=2.0, step=(4 / 32, 4 / 32))
        made = scenes.scene([(scenes.icosphere(1.0), scenes.BOUND, 0)], [sky], [fog], view)
        found = np.mean([rendered(made, 3, seed=seed, photons=20000).in_scattered[..., 0] for seed in range(3)], axis=0)
        fine = np.mgrid[0:320, 0:320] / 10 + 0.05 - 16
        inside = (np.hypot(*fine) <= 16).reshape(32, 10, 32, 10).mean(axis=(1, 3))
        np.testing.assert_array_equal(found[inside == 0], 0)
        for part in (inside == 1, (inside > 0) & (inside < 1)):
            expected = 2 * -np.expm1(-0.6) * inside[part].mean()
            # Noise, and kernels that lose some of the light beside the ball's border. Three passes meet the circle at places of their own.
            self.assertAlmostEqual(found[part].mean() / expected, 1, delta=0.015 if inside[part].min() == 1 else 0.05)


class Sessions(unittest.TestCase):
    """Whole pictures."""

    def test_an_exposure_is_a_factor_on_light_and_on_nothing_else(self):
        sky = Light("", LightKind.WORLD, sky=np.full((1, 1, 3), 2, np.float32))
        fog = scenes.volume("fog", 0.6, 0, low=-1, high=1)
        made = scenes.scene([(scenes.icosphere(1.0), scenes.BOUND, 0)], [sky], [fog], scenes.camera((0, 0, 3), (0, 0, 0), 40, 8, 8))
        plain, exposed = rendered(made), rendered(replace(made, exposure=1.7))
        for name in ("in_scattered", "first", "error"):
            self.assertGreater(getattr(plain, name).max(), 0)
            np.testing.assert_array_equal(getattr(exposed, name), np.float32(1.7) * getattr(plain, name))
        for name in ("radius", "bandwidth"):
            np.testing.assert_array_equal(getattr(exposed, name), getattr(plain, name))

    def test_a_cloud_under_an_even_sky_is_as_bright_as_an_even_sky_but_for_what_is_seen_through_it(self):
        # Of any density and with any number of scatterings, as long as nothing is absorbed.
        sky = Light("", LightKind.WORLD, sky=np.full((1, 1, 3), 2, np.float32))
        fog = scenes.volume("cloud", 2.0, 0, low=-1, high=1, density=scenes.cloud())
        view = scenes.camera((0, 0, -6), (0, 0, 0), 18, 32, 32)
        made = scenes.scene([(scenes.box((-1, -1, -1), (1, 1, 1)), scenes.BOUND, 0)], [sky], [fog], view)
        found = np.mean([rendered(made, 4, seed=seed, photons=20000).in_scattered[..., 0] for seed in range(4)], axis=0)
        places, _, step = places_in_cloud(view)
        depth = 2.0 * step * scenes.density(places).sum(axis=0)
        expected = 2 * -np.expm1(-depth)
        self.assertGreater(np.ptp(expected), 1, "a cloud has thick and thin places")
        for name, of in (("thick", depth > 1), ("thin", (depth > 0.1) & (depth <= 1))):
            ratio = found[of].mean() / expected[of].mean()
            print(f"figures: {name} places of a cloud under an even sky: {ratio:.4f}")
            self.assertAlmostEqual(ratio, 1, delta=0.015)

    def test_light_that_a_cloud_scatters_once_is_that_of_a_closed_form(self):
        # A sun from above; what it and the camera see of each place is integrated apart from the code under test.
        s, a, g = 1.5, 0.5, 0.5
        sun = Light("", LightKind.SUN, axis=np.array([0.0, -1, 0]), irradiance=np.full(3, 3.0), angle=0.0)
        fog = scenes.volume("cloud", s, a, g, low=-1, high=1, density=scenes.cloud())
        view = scenes.camera((0, 0.5, -6), (0, 0, 0), 18, 32, 32)
        made = scenes.scene([(scenes.box((-1, -1, -1), (1, 1, 1)), scenes.BOUND, 0)], [sun], [fog], view)
        found = np.mean([rendered(made, 6, seed=k, photons=10_000, bounces=0).in_scattered[..., 0] for k in range(4)], axis=0)

        places, direction, step = places_in_cloud(view)
        density = scenes.density(places)
        heights = (np.arange(40) + 0.5) * 0.05
        above = 0.05 * sum(scenes.density(places + np.array([0, height, 0])) for height in heights)
        before = step * (np.cumsum(density, axis=0) - 0.5 * density)
        phase = (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * direction[..., 1]) ** 1.5)
        expected = step * (3 * s * density * phase * np.exp(-(s + a) * (above + before))).sum(axis=0)
        for of in (expected > 0.3 * expected.max(), (expected > 0.03 * expected.max()) & (expected <= 0.3 * expected.max())):
            ratio = found[of].mean() / expected[of].mean()
            print(f"figures: light that a cloud scatters once: {ratio:.4f}")
            self.assertAlmostEqual(ratio, 1, delta=0.015)

    def test_a_seed_gives_the_same_picture_and_another_another(self):
        scene = scenes.open_glass_ball(32)
        first = rendered(scene, seed=5).in_scattered
        np.testing.assert_array_equal(first, rendered(scene, seed=5).in_scattered)
        self.assertGreater(np.abs(first - rendered(scene, seed=6).in_scattered).max(), 0)

    def test_a_mirrored_camera_shows_what_another_one_does_from_right_to_left(self):
        made = scenes.open_glass_ball(32)
        view = made.camera
        turned = rendered(made, 3).in_scattered[:, ::-1]
        part = replace(view, right=-view.right, left=view.left + 4 * view.step[0], width=10)
        found = rendered(replace(made, camera=part), 3).in_scattered
        off = [np.abs(found - turned[:, first : first + 10]).mean() for first in range(23)]
        self.assertEqual(np.argmin(off), 4, off)

    def test_radius_and_bandwidth_are_those_of_the_gather(self):
        made = session(scenes.open_glass_ball(50), radius=0.03)
        for _ in range(3):
            made.render_pass()
        picture = made.picture()
        made.close()
        lit = picture.radius > 0
        self.assertGreater(lit.mean(), 0.9)
        # From the progressive radius of the last pass to twice that of the first.
        self.assertGreaterEqual(picture.radius[lit].min(), 0.99 * 0.03 * 3**-0.5)
        self.assertLessEqual(picture.radius.max(), 0.0601)
        self.assertTrue((picture.bandwidth[lit] > 0).all())

    def test_the_stated_error_is_that_of_pictures_of_other_seeds(self):
        scene = scenes.black_ball(32)
        weights = np.array([0.2126, 0.7152, 0.0722])
        # Straight light's places fill pixels and beams evenly over the passes, whose errors make up for each other: of it the stated error, which
        # takes passes for independent, is the most that it may be.
        for bounces, least in ((3, 0.6), (0, 0)):
            runs = [rendered(scene, 6, seed=seed, bounces=bounces) for seed in range(8)]
            spread = np.array([run.in_scattered @ weights for run in runs]).var(axis=0, ddof=1)
            stated = np.mean([run.error**2 for run in runs], axis=0)
            # Variances over all pixels: filters leave some twenty independent ones in each of eight pictures.
            ratio = float(np.sqrt(spread.mean() / stated.mean()))
            self.assertTrue(least < ratio < 1.6, ratio)

    def test_a_box_of_gas_is_as_bright_as_the_closed_form_has_it_and_not_in_scattered(self):
        """Of two layers, of which one glows as what it lies beside fades; no lamp is there, and nothing scatters."""
        values = np.zeros((2, 1, 1, 3), np.float32)
        values[0, 0, 0] = (4, 2, 0)
        values[1, 0, 0] = (0, 2, 1)
        glow, absorption = Glow(np.full(3, -1.0), np.full(3, 1.0), values), np.array([0.5, 1.0, 1e-6])
        gas = scenes.volume("gas", 0, absorption, low=-1, high=1, glow=glow)
        view = scenes.camera((0, 0, -4), (0, 0, 0), 2, 4, 4)
        made = scenes.scene([(scenes.box((-1, -1, -1), (1, 1, 1)), scenes.BOUND, 0)], [], [gas], view)
        at = (np.arange(4000) + 0.5) / 4000 * 2
        share = np.clip(at - 0.5, 0, 1)[:, None]
        emission = (1 - share) * values[0, 0, 0] + share * values[1, 0, 0]
        expected = (emission * np.exp(-absorption * at[:, None])).mean(axis=0) * 2
        for beyond in (True, False):
            picture = rendered(made, beyond=beyond)
            np.testing.assert_allclose(picture.in_scattered, np.broadcast_to(expected, (4, 4, 3)), rtol=2e-3)
            self.assertFalse(picture.first.any())

    def test_scenes_without_light_fog_or_geometry_are_dark_or_plain(self):
        view = scenes.camera((0, 0, -4), (0, 0, 0), 40, 16, 16)
        fog, lamp = scenes.volume("fog", 0.1, 0.1), scenes.point((1, 1, 1), 10)
        for lights, volumes, world, dark in (([], [fog], 0, True), ([lamp], [], -1, True), ([lamp], [fog], 0, False)):
            picture = rendered(scenes.scene([], lights, volumes, view, world), 1)
            self.assertEqual(bool((picture.in_scattered == 0).all()), dark)
            self.assertTrue(np.isfinite(picture.in_scattered).all())


if __name__ == "__main__":
    unittest.main()
