# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported media: what a slab of them lets through and scatters once, against Cycles."""

import sys
import unittest
from math import cos, pi, radians
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import scenes_export as scenes  # noqa: E402
from host_scenes import density_at  # noqa: E402
from scenes_export import joined, node, shader  # noqa: E402

from addon.export import phases  # noqa: E402
from addon.host.scene import Phase  # noqa: E402

SUN = 7.0


def phase(volume, cosine):
    """The phase function [1/sr] that the fields of a host.scene.Volume describe."""
    g = volume.asymmetry
    return (1 - g * g) / (4 * pi * (1 + g * g - 2 * g * cosine) ** 1.5)


def slab(volume):
    """A medium between z = 0 and 1, as wide as it needs to be."""
    return scenes.box("Slab", (-20, -20, 0), (20, 20, 1), scenes.material("Fog", volume=volume))


def sunlit(angle):
    """A sun that shines down, `angle` [rad] off the vertical."""
    data = bpy.data.lights.new("Sun", "SUN")
    data.energy, data.angle = SUN, 0.0
    scenes.add(data, rotation_euler=(0, angle, 0))


def seen_from_below(samples):
    eye = bpy.context.scene.camera
    eye.data.type, eye.data.ortho_scale = "ORTHO", 1e-3
    eye.location, eye.rotation_euler = (0, 0, -1), (pi, 0, 0)
    return scenes.cycles(samples).mean(axis=(0, 1))


def scattered_once(volume, angle, shape):
    """Radiance [W/(m^2 sr)] below a slab of `volume` under a sun of unit irradiance; shape: its phase function here."""
    extinction = volume.scattering + volume.absorption
    # Integral of exp(-a z) exp(-b (1 - z)) for the way of light to depth z and from there down.
    a, b = extinction / cos(angle), extinction
    return volume.scattering * shape * (np.exp(-b) - np.exp(-a)) / (a - b)


class Volumes(unittest.TestCase):
    def setUp(self):
        scene = scenes.empty()
        scene.cycles.max_bounces = 0

    def compare(self, make, shape=phase, reported=(), scatters=True):
        """Transmittance and single scattering under 40 degrees are those of Cycles. Returns the exported volume.

        Where a medium scatters, Cycles lets each of the 16 x 2048 samples through or not: three standard errors of the
        mean are below 1.5 % where a third is let through.
        """
        for scattering in (False, True) if scatters else (False,):
            self.setUp()
            slab(make)
            angle = radians(40)
            if scattering:
                sunlit(angle)
            else:
                # So small that it hardly lights the medium.
                lamp = scenes.grid(size=0.02, material=scenes.material("Lamp", shader("Emission", {"Strength": 3.0})))
                lamp.location, lamp.visible_volume_scatter = (0, 0, 2), False
            made, report = scenes.exported()
            self.assertEqual([e.what for e in report.entries if "Fog" in e.sources[0]], list(reported))
            (volume,) = made.volumes
            # Bounds are drawn in by up to 3.1e-5 of the largest coordinate.
            np.testing.assert_allclose([volume.min, volume.max], [(-20, -20, 0), (20, 20, 1)], atol=6.2e-4)
            shown = seen_from_below(2048 if scatters else 16)
            expected = 3.0 * np.exp(-volume.scattering - volume.absorption)
            if scattering:
                # The sun is behind the point that is seen: light goes on by 40 degrees off its way.
                expected = SUN * scattered_once(volume, angle, shape(volume, cos(angle)))
            np.testing.assert_allclose(expected, shown, rtol=1.5e-2 if scatters else 1e-4)
        return volume

    def test_volume_scatter_has_the_coefficients_of_cycles(self):
        for g in (0.0, 0.7, -0.5):
            with self.subTest(anisotropy=g):
                inputs = {"Color": (0.2, 0.5, 0.9), "Density": 1.3, "Anisotropy": g}
                self.assertAlmostEqual(self.compare(shader("VolumeScatter", inputs)).asymmetry, g, 6)

    def test_volume_absorption_has_the_coefficients_of_cycles(self):
        self.compare(shader("VolumeAbsorption", {"Color": (0.2, 0.5, 0.9), "Density": 1.3}), scatters=False)

    def test_principled_volume_has_the_coefficients_of_cycles(self):
        for tint in ((0.0, 0.0, 0.0), (0.1, 0.6, 1.0)):
            with self.subTest(absorption_color=tint):
                inputs = {"Color": (0.2, 0.5, 0.9), "Absorption Color": tint, "Density": 0.8, "Anisotropy": 0.4}
                self.compare(shader("VolumePrincipled", inputs))

    @unittest.skipIf(bpy.app.version < (5, 0), "Blender 4.2 has no such node")
    def test_volume_coefficients_are_those_of_cycles(self):
        inputs = {"Scatter Coefficients": (0.2, 0.5, 0.9), "Absorption Coefficients": (0.4, 0.1, 0.0)}
        inputs["Anisotropy"] = 0.3
        self.compare(shader("VolumeCoefficients", inputs))

    def test_mixed_and_added_volumes_have_the_coefficients_of_cycles(self):
        a = shader("VolumeScatter", {"Color": (0.2, 0.5, 0.9), "Density": 1.3, "Anisotropy": 0.4})
        b = shader("VolumeAbsorption", {"Color": (0.9, 0.5, 0.2), "Density": 0.7})
        self.compare(joined("MixShader", a, b, 0.3))
        self.compare(joined("AddShader", a, b))

    @unittest.skipIf(bpy.app.version < (4, 3), "Blender 4.2 has Henyey-Greenstein only")
    def test_rayleigh_scattering_is_that_of_cycles(self):
        def rayleigh(volume, cosine):
            return 3 / (16 * pi) * (1 + cosine**2)

        made = self.compare(shader("VolumeScatter", {"Color": (0.2, 0.5, 0.9)}, phase="RAYLEIGH"), rayleigh)
        self.assertEqual(made.asymmetry, 0.0)
        self.assertEqual(made.phase, Phase.RAYLEIGH)

    def test_a_sum_of_phase_functions_is_their_mixture_by_scattering(self):
        a = shader("VolumeScatter", {"Color": (1, 1, 1), "Density": 3.0, "Anisotropy": 0.8})
        b = shader("VolumeScatter", {"Color": (0.5, 0.5, 0.5), "Density": 2.0, "Anisotropy": -0.2})
        slab(joined("AddShader", a, b))
        made, report = scenes.exported()
        (volume,) = made.volumes
        ((phase, asymmetry, share),) = volume.lobes
        self.assertEqual((volume.phase, phase), (Phase.HENYEY_GREENSTEIN, Phase.HENYEY_GREENSTEIN))
        np.testing.assert_allclose((volume.asymmetry, asymmetry), (0.8, -0.2), rtol=1e-6)
        np.testing.assert_allclose(share, np.full(3, 1 / 4), rtol=1e-6)
        self.assertEqual(str(report), "")

    def test_draine_has_the_mean_cosine_of_its_integral(self):
        for g, alpha in ((0.7, 0.5), (-0.3, 1.0), (0.9, 30.0), (0.0, 1.0)):
            cosine = (np.arange(200_000) + 0.5) / 100_000 - 1
            value = (1 + alpha * cosine**2) / (1 + g * g - 2 * g * cosine) ** 1.5
            self.assertAlmostEqual(phases.draine(g, alpha), (value @ cosine) / value.sum(), 4)

    @unittest.skipIf(bpy.app.version < (4, 3), "Blender 4.2 has Henyey-Greenstein only")
    def test_other_phase_functions_have_the_mean_cosine_of_cycles(self):
        cases = [("MIE", {"Diameter": d}) for d in (0.05, 0.6, 2.0, 20.0)]
        cases += [("FOURNIER_FORAND", {"IOR": 1.33, "Backscatter": b}) for b in (0.1, 0.3)]
        cases += [("DRAINE", {"Anisotropy": 0.4, "Alpha": 0.7})]
        for kind, inputs in cases:
            with self.subTest(kind, **inputs):
                self.setUp()
                inputs = inputs | {"Color": (1, 1, 1), "Density": 1e-3}
                slab(shader("VolumeScatter", inputs, phase=kind))
                made, report = scenes.exported()
                self.assertIn("phase function", str(report))
                self.assertAlmostEqual(made.volumes[0].asymmetry, self.mean_cosine(), delta=0.01)

    def mean_cosine(self):
        """Of what Cycles scatters once in the slab under many angles, by Gauss' rule in the root of 1 - cosine."""
        x, weights = np.polynomial.legendre.leggauss(48)
        root, weights = (x + 1) / 2**0.5, weights / 2**0.5
        weights = weights * 2 * root
        sunlit(0.0)
        sun = bpy.data.objects["Sun"]
        # So thin that light passes: what it scatters depends on the angle by the phase function only.
        radiance = []
        for cosine in 1 - root**2:
            sun.rotation_euler = (0, np.arccos(cosine), 0)
            radiance.append(seen_from_below(16)[0])
        radiance = np.array(radiance) * weights
        return radiance @ (1 - root**2) / radiance.sum()

    def test_the_world_is_fog_everywhere(self):
        scenes.world(volume=shader("VolumeScatter", {"Density": 0.3}))
        scenes.box()
        made, _ = scenes.exported()
        self.assertEqual((made.world_volume, made.object_volumes.tolist()), (0, [-1]))
        self.assertTrue(np.all(np.isinf(made.volumes[0].min)) and np.all(np.isinf(made.volumes[0].max)))

    def test_glass_is_no_end_of_the_fog_and_a_material_of_volume_only_no_surface(self):
        slab(shader("VolumeScatter"))
        scenes.box(material=scenes.material("Glass", shader("BsdfGlass"))).location = (0, 0, 5)
        made, report = scenes.exported()
        self.assertEqual(made.object_volumes.tolist(), [-1, 0])
        self.assertEqual(made.object_closed.tolist(), [True, False])
        np.testing.assert_array_equal(made.materials["transparent"][0], (1, 1, 1))
        self.assertEqual(str(report), "")

    def test_instances_of_a_volume_are_volumes(self):
        thing = scenes.box("Cloud", material=scenes.material("Fog", volume=shader("VolumeScatter")))
        other = scenes.add(thing.data, "Other", location=(5, 0, 0), scale=(1, 2, 1))
        made, _ = scenes.exported()
        self.assertEqual([v.name for v in made.volumes], [thing.name, other.name])
        np.testing.assert_allclose([made.volumes[1].min, made.volumes[1].max], [(4, -2, -1), (6, 2, 1)], atol=1.9e-4)
        self.assertEqual(made.object_volumes.tolist(), [0, 1])

    def test_a_volume_without_density_is_none(self):
        slab(shader("VolumeScatter", {"Density": 0.0}))
        made, _ = scenes.exported()
        self.assertEqual((made.volumes, made.object_volumes.tolist()), ([], [-1]))

    def test_densities_that_are_no_numbers_are_none_and_none_is_too_large(self):
        slab(shader("VolumeScatter", {"Density": float("nan")}))
        self.assertEqual(scenes.exported()[0].volumes, [])
        for value in (float("inf"), 3e38):
            self.setUp()
            slab(shader("VolumeScatter", {"Density": value, "Anisotropy": float("nan")}))
            (volume,) = scenes.exported()[0].volumes
            self.assertEqual((volume.scattering.max(), volume.asymmetry), (1e9, 0))

    def test_where_volumes_overlap_is_their_sum(self):
        slab(shader("VolumeScatter", {"Color": (1, 1, 1), "Density": 0.3, "Anisotropy": 0.4}))
        more = scenes.material("More", volume=shader("VolumeScatter", {"Color": (1, 1, 1), "Density": 0.1}))
        inner, far = scenes.box("Inner", material=more), scenes.box("Far", material=more)
        inner.location, far.location = (0, 0, 1.5), (50, 0, 0)
        scenes.world(None, shader("VolumeAbsorption", {"Color": (0, 0, 0), "Density": 0.01}))
        made, report = scenes.exported()
        ((phase, _, share),) = made.volumes[-1].lobes
        self.assertEqual((phase, str(report)), (Phase.ISOTROPIC, ""))
        np.testing.assert_allclose(share, np.full(3, 1 / 4), rtol=1e-6)
        self.assertEqual([volume.parts for volume in made.volumes], [(), (), (), (), (0, 1)])
        np.testing.assert_allclose([v.scattering[0] for v in made.volumes], (0.3, 0.1, 0.1, 0, 0.4))
        # The world's is in all of them.
        np.testing.assert_allclose([v.absorption[0] for v in made.volumes], 0.01)
        self.assertEqual(made.world_volume, 3)
        both = made.volumes[4]
        self.assertAlmostEqual(both.asymmetry, 0.4, delta=1e-6)
        np.testing.assert_allclose([both.min, both.max], [(-1, -1, 0.5), (1, 1, 1)], atol=2e-3)

    def test_what_varies_is_added_up_from_place_to_place(self):
        def volume(tree):
            fade, fog = node(tree, "TexGradient", gradient_type="SPHERICAL"), node(tree, "VolumeScatter", {"Color": (1, 1, 1)})
            tree.links.new(node(tree, "TexCoord").outputs["Object"], fade.inputs["Vector"])
            tree.links.new(next(s for s in fade.outputs if s.identifier == "Fac"), fog.inputs["Density"])
            return fog

        even = scenes.material("Even", volume=shader("VolumeScatter", {"Color": (1, 1, 1), "Density": 0.5}))
        scenes.box("Cloud", material=scenes.material("Cloud", volume=volume))
        scenes.box("Even", material=even).location = (1, 0, 0)
        made, report = scenes.exported()
        self.assertEqual((str(report), [volume.density is not None for volume in made.volumes]), ("", [True, False, True]))
        places = np.array([[0.4, 0, 0], [0.8, 0.5, 0.1], [0.9, 0.9, 0.9]], np.float32)
        both = made.volumes[2]
        found = density_at(both.density, places) * both.scattering[0]
        np.testing.assert_allclose(found, 0.5 + np.maximum(1 - np.linalg.norm(places, axis=1), 0), atol=0.02)

    def test_volumes_that_overlap_in_too_many_ways_are_named(self):
        for k in range(6):
            size = 1 + 0.1 * k
            scenes.box(f"Nested {k}", (-size,) * 3, (size,) * 3, scenes.material(f"Fog {k}", volume=shader("VolumeScatter")))
        made, report = scenes.exported()
        self.assertEqual(len(made.volumes), 6 + 16)
        (entry,) = report.entries
        self.assertEqual((entry.what, entry.in_fog), ("overlaps too many others", True))
        self.assertIn('Volume of "Nested 5"', entry.sources)

    def test_a_textured_density_is_the_value_of_its_socket_and_named(self):
        def make(tree):
            noise, fog = node(tree, "AmbientOcclusion"), node(tree, "VolumeScatter", {"Color": (1, 1, 1), "Density": 0.25})
            tree.links.new(noise.outputs[0], fog.inputs["Density"])
            return fog

        slab(make)
        made, report = scenes.exported()
        np.testing.assert_allclose(made.volumes[0].scattering, 0.25)
        self.assertIn("Density of Volume Scatter comes from Ambient Occlusion", str(report))

    def test_an_open_mesh_with_a_volume_is_named(self):
        scenes.grid(material=scenes.material("Fog", volume=shader("VolumeScatter")))
        (entry,) = scenes.exported()[1].entries
        self.assertIn("in a mesh that is open", entry.what)
        self.assertTrue(entry.in_fog)


if __name__ == "__main__":
    unittest.main()
