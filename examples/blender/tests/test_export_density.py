# SPDX-License-Identifier: GPL-3.0-or-later
"""What varies in a volume: nodes against Cycles, and voxels against closed forms."""

import sys
import unittest
from pathlib import Path

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parent)]

import scenes_export as scenes  # noqa: E402
from host_scenes import density_at  # noqa: E402
from scenes_export import node  # noqa: E402

from addon.export.nodes import Values  # noqa: E402
from addon.export.report import Report  # noqa: E402
from addon.export.volumes import Frame  # noqa: E402
from addon.host.session import described  # noqa: E402

#: Pixels across, looks across a pixel, and samples of Cycles'.
PIXELS, LOOKS, SAMPLES = 24, 8, 256


def chain(tree, *nodes):
    """Links nodes of (kind, inputs, settings, name of the output, identifier of the input that is linked) after each other; returns the
    last output."""
    output = None
    for kind, inputs, settings, out, into in nodes:
        # Images go with each new file.
        images = {"image": checkers()} if "image" in settings else {}
        made = node(tree, kind, inputs, **{**settings, **images})
        if output is not None:
            tree.links.new(output, next(s for s in made.inputs if s.identifier == into))
        output = next(s for s in made.outputs if s.name == out or s.identifier == out)
    return output


def checkers():
    """An image of 5 x 3 pixels of all kinds."""
    image = bpy.data.images.new("Checkers", 5, 3, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    image.pixels.foreach_set(np.random.default_rng(4).random(60).astype(np.float32))
    image.update()
    return image


def coordinates(name="Object"):
    return ("TexCoord", {}, {}, name, None)


def math(operation, b=0.5, c=0.5):
    return ("Math", {"Value_001": b, "Value_002": c}, {"operation": operation}, "Value", "Value")


def gradient(kind):
    return ("TexGradient", {}, {"gradient_type": kind}, "Fac", "Vector")


def noise(**inputs):
    return ("TexNoise", inputs, {}, "Fac", "Vector")


def mapping(kind):
    values = {"Location": (0.3, -0.2, 0.1), "Rotation": (0.2, 0.4, 1.1), "Scale": (1.5, 0.7, 2.0)}
    return ("Mapping", values, {"vector_type": kind}, "Vector", "Vector")


def ramp(interpolation):
    def made(tree):
        output = chain(tree, coordinates(), gradient("LINEAR"), ("ValToRGB", {}, {}, "Color", "Fac"))
        of = output.node.color_ramp
        of.interpolation = interpolation
        of.elements[0].position, of.elements[1].position = 0.2, 0.7
        of.elements[0].color, of.elements[1].color = (0.1, 0.4, 0.2, 1), (0.9, 0.3, 0.6, 1)
        return output

    return made


def separated(tree):
    """The length of (x sqrt(y + 2), 0.7, 0), by nodes."""
    parts = node(tree, "SeparateXYZ")
    tree.links.new(chain(tree, coordinates()), parts.inputs[0])
    root, times = node(tree, "Math", {"Value_001": 2.0}, operation="ADD"), node(tree, "Math", operation="MULTIPLY")
    tree.links.new(parts.outputs["Y"], root.inputs[0])
    sqrt = node(tree, "Math", operation="SQRT")
    tree.links.new(root.outputs[0], sqrt.inputs[0])
    tree.links.new(parts.outputs["X"], times.inputs[0])
    tree.links.new(sqrt.outputs[0], times.inputs[1])
    together = node(tree, "CombineXYZ", {"Y": 0.7})
    tree.links.new(times.outputs[0], together.inputs["X"])
    length = node(tree, "VectorMath", operation="LENGTH")
    tree.links.new(together.outputs[0], length.inputs[0])
    return length.outputs["Value"]


def other_object(tree):
    around = scenes.add(None, "Around", location=(0.3, 0.4, 0.2), rotation_euler=(0, 0, 0.5), scale=(2, 1, 1))
    bpy.context.view_layer.update()
    output = chain(tree, coordinates(), gradient("SPHERICAL"))
    next(n for n in tree.nodes if n.type == "TEX_COORD").object = around
    return output


def linear(*nodes):
    return lambda tree: chain(tree, *nodes)


MAP_RANGE = {"From Min": 0.1, "From Max": 0.8, "To Min": 0.9, "To Max": 0.2}

GRAPHS = {
    **{f"gradient {kind}": linear(coordinates(), gradient(kind)) for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL")},
    **{f"gradient {kind}": linear(coordinates(), gradient(kind)) for kind in ("RADIAL", "QUADRATIC_SPHERE", "SPHERICAL")},
    "generated": linear(coordinates("Generated"), gradient("DIAGONAL")),
    "no vector": linear(gradient("DIAGONAL")),
    "position": linear(("NewGeometry", {}, {}, "Position", None), gradient("DIAGONAL")),
    "another object": other_object,
    **{f"mapping {kind}": linear(coordinates(), mapping(kind), gradient("DIAGONAL")) for kind in ("POINT", "TEXTURE", "VECTOR")},
    "noise": linear(coordinates(), noise(Scale=3.0)),
    "noise of no vector": linear(noise(Scale=3.0)),
    "noise, a share of an octave": linear(coordinates(), noise(Scale=2.0, Detail=2.4, Roughness=0.7, Lacunarity=1.8)),
    "noise, distorted": linear(coordinates(), noise(Scale=2.0, Detail=1.0, Distortion=0.6)),
    **{
        f"math {kind}": linear(coordinates(), gradient("LINEAR"), math(kind))
        for kind in ("ADD SUBTRACT MULTIPLY DIVIDE POWER MINIMUM MAXIMUM EXPONENT MULTIPLY_ADD SINE COSINE FRACT PINGPONG ABSOLUTE").split()
    },
    **{f"math {kind}": linear(coordinates(), gradient("LINEAR"), math(kind)) for kind in ("LESS_THAN", "GREATER_THAN", "CEIL")},
    **{
        f"map range {kind}": linear(
            coordinates(), gradient("LINEAR"), ("MapRange", MAP_RANGE, {"interpolation_type": kind}, "Result", "Value")
        )
        for kind in ("LINEAR", "SMOOTHSTEP", "SMOOTHERSTEP")
    },
    **{
        f"image {extension} {interpolation}": linear(
            coordinates(), ("TexImage", {}, {"image": ..., "extension": extension, "interpolation": interpolation}, "Color", "Vector")
        )
        for extension in ("REPEAT", "EXTEND", "CLIP")
        for interpolation in ("Linear", "Closest")
    },
    "alpha of an image": linear(coordinates(), ("TexImage", {}, {"image": ...}, "Alpha", "Vector")),
    "clamp": linear(coordinates(), gradient("LINEAR"), ("Clamp", {"Min": 0.3, "Max": 0.6}, {}, "Result", "Value")),
    "ramp": ramp("LINEAR"),
    "ramp of steps": ramp("CONSTANT"),
    "ramp that eases": ramp("EASE"),
    "parts of a vector": separated,
    "vector as a number": linear(coordinates(), math("ADD", 1.0)),
}


class Nodes(unittest.TestCase):
    """Values of nodes, from place to place, are those that Cycles shows."""

    def test_values_are_those_of_cycles(self):
        for name, graph in GRAPHS.items():
            with self.subTest(name):
                self.compare(graph)

    def compare(self, graph):
        scenes.empty()
        bpy.context.scene.view_settings.view_transform = "Raw"
        shine = []

        def surface(tree):
            shine.append(node(tree, "Emission", {"Color": (1, 1, 1)}))
            tree.links.new(graph(tree), shine[0].inputs["Strength"])
            return shine[0]

        plane = scenes.grid(size=2.0, material=scenes.material("Shine", surface=surface))
        plane.location, plane.rotation_euler, plane.scale = (0.2, 0.1, 0.3), (0, 0, 0.4), (1.3, 1.1, 1.0)
        eye = bpy.context.scene.camera
        eye.data.type, eye.data.ortho_scale, eye.location = "ORTHO", 1.6, (0.2, 0.1, 2.0)
        bpy.context.view_layer.update()
        expected = scenes.cycles(SAMPLES, PIXELS, PIXELS)[..., 0]
        y, x = (np.mgrid[0 : PIXELS * LOOKS, 0 : PIXELS * LOOKS] + 0.5) / (PIXELS * LOOKS)
        world = np.stack([0.2 + 1.6 * (x - 0.5), 0.1 - 1.6 * (y - 0.5), np.full_like(x, 0.3)], axis=-1).reshape(-1, 3)
        frame = Frame(np.array(plane.matrix_world, np.float64), *np.array([plane.data.texspace_location, plane.data.texspace_size]), np.zeros(3))
        report = Report()
        found = Values("Shine", report, places=frame.places(world)).number(shine[0], "Strength", ())
        self.assertEqual(str(report), "")
        found = np.broadcast_to(found, (len(world), 1)).reshape(PIXELS, LOOKS, PIXELS, LOOKS).mean(axis=(1, 3))
        self.assertGreater(np.ptp(expected), 0.01)
        # Cycles has 256 samples in a pixel and covbeam's check 64 places, which differ where a pixel holds a step.
        difference = np.abs(found - expected)
        self.assertLess(np.median(difference), 2e-3 * np.ptp(expected))
        self.assertLess(difference.mean(), 0.01 * np.ptp(expected))


class Voxels(unittest.TestCase):
    """Volumes whose density varies."""

    def fog(self, *nodes, **values):
        def volume(tree):
            made = node(tree, "VolumeScatter", {"Color": (0.8, 0.5, 0.2), **values})
            tree.links.new(chain(tree, *nodes), made.inputs["Density"])
            return made

        scenes.empty()
        box = scenes.box("Cloud", material=scenes.material("Cloud", volume=volume))
        box.location, box.rotation_euler, box.scale = (1, 2, 3), (0, 0, 0.6), (2, 1, 0.5)
        bpy.context.view_layer.update()
        return box, scenes.exported()

    def test_voxels_have_the_density_of_the_nodes(self):
        box, (made, report) = self.fog(coordinates(), gradient("SPHERICAL"), math("MULTIPLY", 3.0), Anisotropy=0.3)
        self.assertEqual(str(report), "")
        (volume,) = made.volumes
        self.assertIsNotNone(volume.density)
        self.assertEqual(volume.asymmetry, np.float32(0.3))
        np.testing.assert_allclose(volume.scattering / volume.scattering[0], (1, 0.625, 0.25), rtol=1e-5)
        inside = np.random.default_rng(1).uniform(-1, 1, (2000, 3))
        matrix = np.array(box.matrix_world, np.float64)
        world = inside @ matrix[:3, :3].T + matrix[:3, 3]
        found = density_at(volume.density, world) * volume.scattering[0]
        expected = 3 * 0.8 * np.maximum(1 - np.linalg.norm(inside, axis=1), 0)
        self.assertLess(np.abs(found - expected).mean(), 0.01 * expected.mean())
        self.assertEqual(density_at(volume.density, np.full(3, 9.0)), 0)

    def test_what_voxels_cannot_show_is_named_with_its_error(self):
        _, (_, report) = self.fog(coordinates(), noise(Scale=80.0))
        self.assertRegex(str(report), r'Material "Cloud": density that varies finely: .*voxels, which are \d+\.\d% off on average')

    def test_no_density_is_no_fog(self):
        _, (made, _) = self.fog(coordinates(), gradient("LINEAR"), math("MULTIPLY", 0.0))
        self.assertFalse(made.volumes[0].scattering.any())
        self.assertIsNone(made.volumes[0].density)

    def test_values_that_are_no_numbers_are_nothing(self):
        _, (made, _) = self.fog(coordinates(), gradient("LINEAR"), math("MULTIPLY", float("nan")))
        self.assertTrue(np.isfinite(made.volumes[0].scattering).all())

    def test_whatever_numbers_nodes_have_a_medium_comes_of_them(self):
        nan, inf = float("nan"), float("inf")
        for value in (nan, inf, 3e38, -1.0):
            turned = {"Location": (value, 0, 0), "Rotation": (value, 0, 0), "Scale": (value, 1, value)}
            for nodes in (
                (coordinates(), gradient("SPHERICAL"), math("MULTIPLY", value)),
                (coordinates(), gradient("SPHERICAL"), math("DIVIDE", value)),
                (coordinates(), noise(Scale=value, Distortion=value)),
                (coordinates(), noise(Detail=value, Roughness=value, Lacunarity=value)),
                (coordinates(), ("Mapping", turned, {"vector_type": "TEXTURE"}, "Vector", "Vector"), gradient("SPHERICAL")),
                (coordinates(), ("Mapping", turned, {}, "Vector", "Vector"), ("TexImage", {}, {"image": ...}, "Color", "Vector")),
                (coordinates(), gradient("LINEAR"), math("MULTIPLY", value), ("ValToRGB", {}, {}, "Color", "Fac")),
            ):
                _, (made, _) = self.fog(*nodes, Anisotropy=value)
                volume = made.volumes[0]
                self.assertTrue((np.isfinite(volume.scattering) & (volume.scattering >= 0)).all(), (value, nodes))
                # A medium that the library takes.
                described(made)

    def test_a_colour_that_varies_is_its_mean_and_named(self):
        def volume(tree):
            made = node(tree, "VolumeScatter", {"Density": 2.0})
            output = chain(tree, coordinates("Generated"), gradient("LINEAR"), ("ValToRGB", {}, {}, "Color", "Fac"))
            output.node.color_ramp.elements[0].color = (1, 0, 0, 1)
            output.node.color_ramp.elements[1].color = (0, 0, 1, 1)
            tree.links.new(output, made.inputs["Color"])
            return made

        scenes.empty()
        scenes.box("Cloud", material=scenes.material("Cloud", volume=volume))
        made, report = scenes.exported()
        np.testing.assert_allclose(made.volumes[0].scattering, (1, 0, 1), atol=0.01)
        self.assertIn("colour that varies in a volume: its mean", str(report))


if __name__ == "__main__":
    unittest.main()
