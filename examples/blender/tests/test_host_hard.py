# SPDX-License-Identifier: GPL-3.0-or-later
"""Hard cases of the host: places, scales and lights that are hard on single precision, parts of pictures, and light that is scattered many
times. Insides of every kind are tested by covbeam-tests (placed)."""

import sys
import unittest
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import bpy  # noqa: F401  the add-on is a package of Blender's
import host_scenes as scenes
from addon.host.scene import Light, LightKind
from addon.host.session import Session, Settings


def setUpModule():
    # A division by zero or an overflow is a defect, whatever comes of it.
    warnings.simplefilter("error", RuntimeWarning)


def rendered(scene, passes=2, **settings):
    """`in_scattered` after some passes of few photons, float64; finite and not negative."""
    session = Session(scene, Settings(**{"photons": 3000, **settings}))
    try:
        for _ in range(passes):
            session.render_pass()
        picture = session.picture().in_scattered.astype(np.float64)
    finally:
        session.close()
    assert np.isfinite(picture).all() and (picture >= 0).all()
    return picture


def seeds(scene, count=4, **settings):
    """Mean radiance of the picture for some seeds, (count,)."""
    return np.array([rendered(scene, seed=seed, **settings).mean() for seed in range(count)])


def standard_error(*samples):
    """Of the difference of the means of some samples."""
    return np.sqrt(sum(np.var(sample, ddof=1) / len(sample) for sample in samples))


def difference(found, expected):
    """Of the means of two samples, relative, and what noise may make of it: four standard errors."""
    return found.mean() / expected.mean() - 1, 4 * standard_error(found, expected) / expected.mean()


def cube(half, center=(0, 0, 0)):
    """A box around a place."""
    center = np.asarray(center, float)
    return scenes.box(center - half, center + half)


def inverted(mesh):
    """With its triangles turned round."""
    return mesh[0], np.ascontiguousarray(mesh[1][:, ::-1]), None


def light(kind, **values):
    """A Light; vectors as tuples, radiometric values as one number."""
    grey = ("intensity", "radiance", "irradiance")
    values = {n: np.full(3, float(v)) if n in grey else v for n, v in values.items()}
    return Light("lamp", kind, **{n: np.asarray(v, float) if isinstance(v, tuple) else v for n, v in values.items()})


VIEW = scenes.camera((0, 0, -4), (0, 0, 0), 40, 16, 16)
LAMP = scenes.point((1.3, 1.1, 0.9), 10)
SUN = light(LightKind.SUN, axis=(-0.48, -0.6, 0.64), irradiance=1)
FOG = scenes.volume("fog", 0.3, 0.1, low=-1, high=1)


def fog_box(lamps, fog=FOG, view=VIEW):
    """A cube of fog from -1 to 1."""
    return scenes.scene([(cube(1), scenes.BOUND, 0)], lamps, [fog], view)


class Scales(unittest.TestCase):
    """The unit of length, the unit of power and the origin mean nothing."""

    def test_a_scene_of_any_size_gives_the_same_picture(self):
        expected = rendered(scenes.mixed())
        for scale in (2.0**-10, 2.0**13):
            np.testing.assert_allclose(rendered(scenes.mixed(scale=scale)), expected, rtol=1e-4, err_msg=str(scale))
        # Where a rounding decides, a path turns off or one of five lamps is drawn for another: noise, less than that of other seeds.
        others = [rendered(scenes.mixed(), seed=seed) for seed in range(1, 5)]
        error = np.std([other.mean() for other in others], ddof=1)
        strays = np.median([np.median(np.abs(other - expected)) for other in others])
        for scale in (1e-3, 1e4):
            found = rendered(scenes.mixed(scale=scale))
            self.assertLess(abs(found.mean() - expected.mean()), 4 * error, scale)
            self.assertLess(np.median(np.abs(found - expected)), 0.5 * strays, scale)

    def test_powers_from_microwatts_to_terawatts_scale_the_picture(self):
        expected = rendered(scenes.mixed())
        for power in (2.0**-20, 2.0**40):
            np.testing.assert_array_equal(rendered(scenes.mixed(power=power)) / power, expected)

    def test_a_scene_far_from_the_origin_gives_the_same_picture(self):
        # 1e3 m away single precision knows places to 6e-5 m, of a scene of 2 m: other paths, and noise. (At 1e4 m it knows them to
        # 1e-3 m, and a tenth of the light is lost.)
        near, far = (seeds(scenes.mixed(at=at), 16, passes=1, photons=4000) for at in ((0, 0, 0), (1e3, -1e3, 1e3)))
        change, noise = difference(far, near)
        print(f"figures: a scene far from the origin: {change:+.4f}, noise {noise:.4f}")
        self.assertLess(abs(change), 0.01 + noise)
        self.assertLess(noise, 0.08, "noise hides nothing")


class Lights(unittest.TestCase):
    """Lights that hardly are one, and lights where nobody puts them."""

    def test_odd_lights_make_finite_pictures(self):
        flat = np.array([[[0, 0, 2], [1, 0, 2], [2, 0, 2]]], np.float32)
        sliver = np.array([[[0, 0, 2], [1, 1e-9, 2], [2, 0, 2]]], np.float32)
        dark = [
            light(LightKind.AREA, u=(0, 0, 0), v=(0, 1, 0), radiance=1),
            light(LightKind.MESH, triangles=flat, radiance=1),
            scenes.point((0, 0, 2), 0),
        ]
        for odd in dark:
            with self.subTest(odd.kind):
                self.assertEqual(rendered(fog_box([odd])).max(), 0)
        expected = seeds(fog_box([LAMP])).mean()
        # Means of 16 x 16 pixels of 2 passes: 3 % of noise.
        self.assertAlmostEqual(seeds(fog_box([*dark, LAMP, *dark])).mean() / expected, 1, delta=0.05)
        bright = [
            light(LightKind.MESH, triangles=sliver, radiance=1),
            light(LightKind.SPOT, position=(0, 0, 2), cosine=0.9, blend=1e-6, intensity=1),
            light(LightKind.SPOT, position=(0, 0, 2), cosine=-1.0, blend=1e-6, intensity=1),
            light(LightKind.SPOT, position=(0, 0, 2), cosine=1 - 1e-6, blend=1e-7, intensity=1),
            light(LightKind.SUN, irradiance=1),
            light(LightKind.SUN, irradiance=1, angle=np.pi / 2),
        ]
        for odd in bright:
            with self.subTest(odd.kind, blend=odd.blend, angle=odd.angle):
                self.assertGreater(rendered(fog_box([odd])).max(), 0)

    def test_a_lamp_or_a_camera_on_the_bound_of_fog_is_as_one_beside_it(self):
        def picture(place, eye):
            view = scenes.camera(eye, (0.2, 0.1, 8), 40, 16, 16)
            return rendered(fog_box([scenes.point(place, 10)], view=view)).mean()

        for lamp, eye in (((1, 0.3, 0.2), (0, 0, -4)), ((-1, 0, 0), (0, 0, -4)), ((0.5, 1.2, 0.3), (0.3, 0.2, -1))):
            expected = picture(np.array(lamp) * 1.0005, np.array(eye) * 1.0005)
            self.assertGreater(expected, 0)
            # 5e-4 m of 2 m, near a lamp that kernels see to a few per cent.
            self.assertAlmostEqual(picture(lamp, eye) / expected, 1, delta=0.05)


class Fog(unittest.TestCase):
    """Media and their bounds."""

    def test_fog_that_does_not_scatter_is_black_and_any_other_ends(self):
        self.assertEqual(rendered(fog_box([LAMP], scenes.volume("fog", 0, 0.3, low=-1, high=1))).max(), 0)
        for scattering in (1e4, 1e-9):
            fog = scenes.volume("fog", scattering, 0, low=-1, high=1)
            self.assertGreater(rendered(fog_box([scenes.point((0.3, 0.2, -1.5), 1)], fog), 1, photons=300).max(), 0)
            endless = scenes.scene([], [LAMP], [scenes.volume("fog", scattering, 0)], VIEW, world=0)
            rendered(endless, 1, photons=300)

    def test_thin_fog_is_as_bright_as_it_is_thin(self):
        thin, thick = (seeds(fog_box([LAMP], scenes.volume("fog", s, 0, low=-1, high=1))).mean() for s in (1e-9, 1e-3))
        # 1e-3 a metre: 0.3 % is lost; the same paths but for that.
        self.assertAlmostEqual(thin / thick * 1e6, 1, delta=0.01)

    def test_a_pane_without_thickness_leaves_the_fog_behind_it_lit(self):
        corners = np.array([[-9, -9, 0.5], [9, -9, 0.5], [9, 9, 0.5], [-9, 9, 0.5]], np.float32)
        pane = (corners, np.array([[0, 2, 1], [0, 3, 2]], np.int32), None)
        air = scenes.material(glass_reflection=1, glass_transmission=1, ior=1.0001)
        fog, lamp = scenes.volume("fog", 0.3, 0.1), scenes.point((0.3, 0.4, 2.5), 10)
        expected = seeds(scenes.scene([], [lamp], [fog], VIEW, world=0), passes=3)
        scene = scenes.scene([(pane, air, -1)], [lamp], [fog], VIEW, world=0)
        found = seeds(replace(scene, object_closed=np.zeros(1, bool)), passes=3)
        change, noise = difference(found, expected)
        # Taken for solid it would cost half of the light. Kernels end at the pane, near a lamp.
        self.assertLess(abs(change), 0.03 + noise)
        self.assertLess(noise, 0.2, "noise hides nothing")

    def test_more_than_64_volumes_are_refused_with_a_remedy(self):
        for count in (64, 65):
            meshes = [(cube(0.1, (i, 0, 0)), scenes.BOUND, i) for i in range(count)]
            corners = [((i - 0.1, -0.1, -0.1), (i + 0.1, 0.1, 0.1)) for i in range(count)]
            volumes = [scenes.volume(str(i), 0.3, 0, 0.0, *ends) for i, ends in enumerate(corners)]
            scene = scenes.scene(meshes, [LAMP], volumes, VIEW)
            if count == 64:
                rendered(scene, 1, photons=300)
            else:
                with self.assertRaisesRegex(ValueError, "65 volumes.*64.*join"):
                    Session(scene, Settings())


class Pictures(unittest.TestCase):
    """Sizes and parts."""

    def test_pictures_of_few_pixels_show_the_mean_of_what_is_there(self):
        for width, height in ((1, 1), (37, 1), (1, 37)):
            few = scenes.camera((0, 0, -4), (0, 0, 0), 40, width, height)
            fine = scenes.camera((0, 0, -4), (0, 0, 0), 40, 8 * width, 8 * height)
            found, expected = (seeds(fog_box([SUN], view=v), 2, passes=20, photons=500) for v in (few, fine))
            # One eye ray a pixel and pass: 40 places of one that holds all of the fog, about half of it; spread evenly.
            self.assertAlmostEqual(found.mean() / expected.mean(), 1, delta=0.25, msg=f"{width} x {height}")

    def test_a_part_of_a_picture_is_that_part(self):
        whole = scenes.camera((0, 0, -4), (0, 0, 0), 40, 40, 40)
        x, y, width, height = 13, 3, 11, 29
        part = replace(
            whole, left=whole.left + x * whole.step[0], top=whole.top - y * whole.step[1], width=width, height=height
        )
        full = rendered(fog_box([SUN], view=whole), 8)[y : y + height, x : x + width]
        cut = rendered(fog_box([SUN], view=part), 8)
        # The same photons; filters and choices of eye rays differ, one in ten pixels has one a pass.
        self.assertAlmostEqual(cut.mean() / full.mean(), 1, delta=0.04)
        self.assertLess(np.abs(cut - full).mean(), 0.15 * full.mean())

    def test_a_large_odd_picture_is_as_bright_as_a_small_one(self):
        small, large = (scenes.camera((0, 0, -4), (0, 0, 0), 40, *size) for size in ((51, 27), (257, 135)))
        # Nearly an eye ray a pixel: the mean has little noise.
        found = [seeds(fog_box([SUN], view=v), 3, passes=3, quality=1e-5) for v in (small, large)]
        change, noise = difference(*found)
        # Pixels of two sizes on the rim of the fog.
        self.assertLess(abs(change), 0.02 + noise)
        self.assertLess(noise, 0.1, "noise hides nothing")


class ManyTimes(unittest.TestCase):
    """Light that is scattered many times, against Chandrasekhar's H function of isotropic scattering."""

    ALBEDO = 0.9

    @staticmethod
    def h(mu, albedo, nodes=64):
        """1/H(mu) = sqrt(1 - a) + a/2 int_0^1 t H(t)/(mu + t) dt, by iteration (Radiative Transfer, 1950)."""
        t, weight = np.polynomial.legendre.leggauss(nodes)
        t, weight = 0.5 * (t + 1), 0.5 * weight
        value = np.ones(nodes)

        def inverse(x):
            return np.sqrt(1 - albedo) + 0.5 * albedo * (weight * value * t / (np.reshape(x, (-1, 1)) + t)).sum(axis=1)

        for _ in range(200):
            value = 0.5 * (value + 1 / inverse(t))
        return 1 / inverse(mu)[0]

    def ground(self, extinction, half, lamp, view):
        """Fog that reaches so far down and aside that it might have no end."""
        low, high = (-half, -half, -half), (half, 0, half)
        fog = scenes.volume("fog", extinction * self.ALBEDO, extinction * (1 - self.ALBEDO), low=low, high=high)
        return scenes.scene([(scenes.box(low, high), scenes.BOUND, 0)], [lamp], [fog], view)

    def test_the_h_function_is_that_of_the_tables(self):
        # Chandrasekhar, table XI: H(1) of a = 0.9 and a = 1.
        self.assertAlmostEqual(self.h(1, 0.9), 1.8501, delta=2e-4)
        self.assertAlmostEqual(self.h(1, 1.0), 2.9078, delta=2e-3)

    def test_half_of_space_in_the_sun_is_as_bright_as_the_h_function_says(self):
        sun = light(LightKind.SUN, axis=(0, -1, 0), irradiance=np.pi)
        # Not from where the sun is: rays along beams are noisy.
        mu = 0.5
        eye = 8 * np.array([np.sqrt(1 - mu * mu), mu, 0])
        scene = self.ground(10.0, 1.0, sun, scenes.camera(eye, (0, 0, 0), 3, 16, 16, up=(0, 0, 1)))
        # a/4 F mu0/(mu0 + mu) H(mu) H(mu0), of an irradiance of pi F, F = 1 and mu0 = 1.
        expected = self.ALBEDO / 4 / (1 + mu) * self.h(mu, self.ALBEDO) * self.h(1, self.ALBEDO)
        found = seeds(scene, 6, passes=2, photons=5000, quality=1e-3)
        error = standard_error(found)
        print(f"figures: half of space in the sun: {found.mean() / expected:.4f} +- {error / expected:.4f}")
        self.assertLess(abs(found.mean() - expected), 0.02 * expected + 4 * error)
        self.assertLess(error, 0.03 * expected, "noise hides nothing")


if __name__ == "__main__":
    unittest.main()
