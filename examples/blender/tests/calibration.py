# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether covbeam and Cycles see the same light, in scenes that both can do: region means of their pictures.

    python calibration.py [--size 32] [--seeds 4] [--samples 256] [--passes 16] [--photons 20000] [--only POINT ...]

The first scenes are the shadow of a black ball in coloured fog under each kind of light, scattered once. The others have a box of
fog, a lamp above it, and out of sight what sends its light back: they test scattering and surfaces. Prints the means of both
pictures and differences of these and of 16 regions x 3 channels, and exits with 1 if one is above 1 %, noise of regions allowed for.
"""

import argparse
import functools
import os
import sys
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import cycles_scenes as scenes
import fog_light
import smoke_scenes
from addon.export.scene import export
from addon.host.session import Session, Settings

#: Red, green and blue differ in scattering and in absorption.
COLOURED = scenes.fog((1.0, 0.8, 0.5), 0.2, 0.3, (0.5, 1.0, 1.0), 0.1)

#: A place in the picture.
SEEN = (-0.8, 0.1, 0.9)

#: Regions darker than this share of the picture's mean are left out: a relative difference of next to nothing says little.
DARK = 0.05


def black_ball(light, place=(0.3, 0, 2.5), soft=False, **values):
    """A scene of the first kind; lights of the sun stand over a box of fog: they do not get through a world of it."""

    def build(scene):
        if light == "SUN":
            scenes.wire(scene.world, [])
            scenes.cube("Fog", (0, 0, 0), (30, 30, 4), scenes.material("Fog", *COLOURED))
        else:
            scenes.wire(scene.world, COLOURED)
        scenes.ball("Ball", (0, 0, 0), 0.5, scenes.material("Black", scenes.BLACK))
        made = scenes.lamp(light, place, **values)
        if hasattr(made.data, "use_soft_falloff"):
            made.data.use_soft_falloff = soft

    return build, 0


def projected():
    """The shadow of a black ball in the light of a spot with a picture in front of it that looks different from all sides."""

    def build(scene):
        black_ball("SPOT", energy=300.0, shadow_soft_size=0.0, spot_size=1.2, spot_blend=0.3)[0](scene)
        lamp = bpy.data.objects["Spot"]
        lamp.rotation_euler.rotate_axis("Z", 0.7)
        cells = np.full((6, 6, 4), (0.1, 0.1, 0.2, 1.0), np.float32)
        cells[1, 1:5, 0] = cells[2:5, 1, 1] = cells[3, 3, :3] = 4.0
        # From -.7 to .7 across the cone.
        fog_light.slide(lamp.data, fog_light.picture("Slide", cells), 1.4)

    return build, 0


def uneven():
    """A point whose light differs with its direction in the world, seen beside a black ball."""

    def build(scene):
        black_ball("POINT", energy=300.0, shadow_soft_size=0.0)[0](scene)
        emission, link, new = _emission_of(bpy.data.objects["Point"].data)
        noise, mapping = new("ShaderNodeTexNoise"), new("ShaderNodeMapping")
        mapping.inputs["Rotation"].default_value, noise.inputs["Scale"].default_value = (0.3, 0.5, 0.7), 3.0
        link(new("ShaderNodeNewGeometry").outputs["Incoming"], mapping.inputs["Vector"])
        link(mapping.outputs[0], noise.inputs["Vector"])
        link(noise.outputs[0], emission.inputs["Strength"])

    return build, 0


def measured(angles):
    """A spot that shines as an IES file says, given all around or for half of that; unlike in all directions of those."""

    def build(scene):
        black_ball("POINT", energy=3.0, shadow_soft_size=0.0)[0](scene)
        lamp = bpy.data.objects["Point"]
        lamp.rotation_euler = (0.4, 0.3, 0.5)
        vertical, horizontal = np.arange(0, 181, 15), np.arange(0, angles + 1, 30)
        v, h = np.radians(vertical), np.radians(horizontal)[:, None]
        values = 1000 * (1.2 + np.cos(v)) * (1.5 + 0.5 * np.cos(h) + (0.4 * np.sin(h + 2 * v) if angles == 360 else 0) * np.sin(v))
        rows = [vertical, horizontal, *values.round(2)]
        header = f"IESNA:LM-63-2002\nTILT=NONE\n1 -1 0.5 {len(vertical)} {len(horizontal)} 1 2 0 0 0\n1 1 100\n"
        text = bpy.data.texts.new("Lamp")
        text.write(header + "\n".join(" ".join(map(str, row)) for row in rows) + "\n")
        emission, link, new = _emission_of(lamp.data)
        ies = new("ShaderNodeTexIES")
        ies.mode, ies.ies, ies.inputs["Strength"].default_value = "INTERNAL", text, 40.0
        link(ies.outputs[0], emission.inputs["Strength"])

    return build, 0


def _emission_of(lamp):
    """A lamp's Emission node, and what links and makes nodes in its tree."""
    lamp.use_nodes = True
    tree = lamp.node_tree
    return next(node for node in tree.nodes if node.type == "EMISSION"), tree.links.new, tree.nodes.new


def computed_sky():
    """A ball of fog under a sky that nodes compute: a gradient from below to above, and to one side another colour."""

    def build(scene):
        under_sky()[0](scene)
        tree = scene.world.node_tree
        new, link = tree.nodes.new, tree.links.new
        first = next(node for node in tree.nodes if node.type == "BACKGROUND")
        second, mix, parts, rise = (new(f"ShaderNode{kind}") for kind in ("Background", "MixShader", "SeparateXYZ", "MapRange"))
        side, ramp = new("ShaderNodeMapRange"), new("ShaderNodeValToRGB")
        link(new("ShaderNodeTexCoord").outputs["Generated"], parts.inputs[0])
        for range_, axis in ((rise, "Z"), (side, "X")):
            range_.inputs["From Min"].default_value = -1.0
            link(parts.outputs[axis], range_.inputs["Value"])
        ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.1, 0.1, 0.05, 1), (1.0, 1.5, 3.0, 1)
        link(rise.outputs[0], ramp.inputs[0])
        link(ramp.outputs[0], first.inputs["Color"])
        second.inputs["Color"].default_value = (3.0, 0.6, 0.2, 1)
        link(side.outputs[0], mix.inputs[0])
        link(first.outputs[0], mix.inputs[1])
        link(second.outputs[0], mix.inputs[2])
        link(mix.outputs[0], tree.nodes["World Output"].inputs["Surface"])

    return build, 0


def sky_texture():
    """A ball of fog under a Sky Texture and its sun, which are about as bright in it."""

    def build(scene):
        under_sky()[0](scene)
        tree = scene.world.node_tree
        sky, background = tree.nodes.new("ShaderNodeTexSky"), next(node for node in tree.nodes if node.type == "BACKGROUND")
        # The best that this Blender has, and it begins with.
        sky.sun_elevation, sky.sun_rotation, sky.sun_size = 0.5, 2.0, 0.1
        tree.links.new(sky.outputs[0], background.inputs["Color"])
        background.inputs["Strength"].default_value = 0.1

    return build, 0


def out_of_focus():
    """The shadow of a black ball that the lens blurs, as far as to a third of the picture, with five blades."""

    def build(scene):
        black_ball("POINT", energy=300.0, shadow_soft_size=0.0)[0](scene)
        dof = scene.camera.data.dof
        dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 2.0, 0.05
        dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 5, 0.4, 1.5

    return build, 0


def seen_otherwise(kind, **values):
    """The shadow of a black ball in a spot's light, seen by another kind of camera than one in perspective, which stands near it."""

    def build(scene):
        black_ball("SPOT", soft=True, energy=300.0, shadow_soft_size=0.05, spot_size=1.0, spot_blend=0.4)[0](scene)
        scene.camera.location.y = -2.5
        scene.camera.data.type, scene.camera.data.clip_start = kind, 0.3
        for name, value in values.items():
            setattr(scene.camera.data, name, value)

    return build, 0


def under_sky(picture=False):
    """The shadow of a black ball in a ball of fog whose light all comes from the world. The fog sends light on forwards, so that the
    picture is lit unevenly if the sky is: it has a bright patch above and behind, and is turned about all axes."""

    def build(scene):
        if picture:
            cells = np.full((16, 32, 3), (0.1, 0.15, 0.3))
            cells[3:5, 20:23] = (60.0, 40.0, 20.0)
            scenes.picture_of_the_sky(scene.world, cells, (0.4, -0.7, 2.0))
        else:
            scenes.wire(scene.world, [("ShaderNodeBackground", {"Color": (0.3, 0.6, 1.0, 1), "Strength": 2.0}, "Surface")])
        # Only its light in fog is compared.
        scene.world.cycles_visibility.camera = False
        scenes.ball("Fog", (0, 0, 0), 1.5, scenes.material("Fog", *scenes.fog((1.0, 0.8, 0.5), 0.4, 0.6)))
        scenes.ball("Ball", (0, 0, 0), 0.5, scenes.material("Black", scenes.BLACK))

    return build, 0


def fog_box(nodes, *surface, bounces, medium=None):
    """A scene of the second kind: `surface` is the material of a square, or of a ball (if its name says so), below the picture."""

    def build(scene):
        scenes.wire(scene.world, [])
        scenes.cube("Fog", (0, 0, 0), (4, 4, 5), scenes.material("Fog", *(medium or scenes.fog((1, 0.9, 0.8), 0.2))))
        # Above the fog: in a point's neighbourhood light that is scattered twice is nothing but noise.
        scenes.lamp("AREA", (0.2, 0.1, 2.8), (0.2, 0.1, -3), energy=300, shape="SQUARE", size=0.6, spread=1.2)
        for node in nodes:
            node()
        if surface:
            bpy.ops.mesh.primitive_plane_add(size=2, location=(0, 0, -2.6))
            bpy.context.object.data.materials.append(scenes.material("Square", *surface))

    return build, bounces


def cloud(bounces):
    """A cloud of noise that thins out towards its border, in a box that is turned and stretched."""

    def build(scene):
        scenes.wire(scene.world, [])
        fog = scenes.material("Cloud", *scenes.fog((1, 0.9, 0.8), 1.0, 0.3, (0.5, 1.0, 1.0), 0.1))
        tree = fog.node_tree
        new, link = tree.nodes.new, tree.links.new
        place, noise, fade, density = (new(f"ShaderNode{kind}") for kind in ("TexCoord", "TexNoise", "TexGradient", "Math"))
        noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 1.6, 1.0
        fade.gradient_type, density.operation = "SPHERICAL", "MULTIPLY"
        thick = new("ShaderNodeMapRange")
        for name, value in (("From Min", 0.35), ("From Max", 0.75), ("To Min", 0.0), ("To Max", 4.0)):
            thick.inputs[name].default_value = value
        for texture in (noise, fade):
            link(place.outputs["Object"], texture.inputs["Vector"])
        link(noise.outputs[0], thick.inputs["Value"])
        link(thick.outputs[0], density.inputs[0])
        link(next(s for s in fade.outputs if s.identifier == "Fac"), density.inputs[1])
        for node in tree.nodes:
            if node.type in ("VOLUME_SCATTER", "VOLUME_ABSORPTION"):
                link(density.outputs[0], node.inputs["Density"])
        box = scenes.to_unit(scenes.cube("Cloud", (0, 0, 0.2), (1.4, 1.0, 1.1), fog))
        box.rotation_euler = (0.2, 0.3, 0.5)
        scenes.lamp("AREA", (1.0, 0.5, 3.0), (0, 0, 0), energy=300, shape="SQUARE", size=0.6)

    return build, bounces


def smoke(bounces):
    """Smoke of a simulation."""

    def build(scene):
        scenes.wire(scene.world, [])
        fog = scenes.material("Smoke", ("ShaderNodeVolumePrincipled", {"Color": (1.0, 0.8, 0.5, 1), "Density": 4.0}, "Volume"))
        smoke_scenes.domain(20, 6, fog)
        scenes.lamp("AREA", (1.0, 0.5, 3.0), (0, 0, 0), energy=300, shape="SQUARE", size=0.6)

    return build, bounces


def overlapping(bounces):
    """Two boxes of fog that overlap each other in fog of the world, one of them with a gradient, and a black ball across their faces."""

    def build(scene):
        scenes.wire(scene.world, scenes.fog((1.0, 0.8, 0.5), 0.05, 0.3))
        scenes.cube("Even", (-0.4, 0, 0), (1.6, 1.2, 1.4), scenes.material("Even", *scenes.fog((1.0, 0.8, 0.5), 0.5, 0.3)))
        fog = scenes.material("Varied", *scenes.fog((1.0, 0.8, 0.5), 1.0, 0.3))
        tree = fog.node_tree
        fade = tree.nodes.new("ShaderNodeTexGradient")
        scatter = next(node for node in tree.nodes if node.type == "VOLUME_SCATTER")
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], fade.inputs["Vector"])
        tree.links.new(next(s for s in fade.outputs if s.identifier == "Fac"), scatter.inputs["Density"])
        scenes.cube("Varied", (0.5, 0, 0.2), (1.5, 1.5, 1.2), fog)
        scenes.ball("Ball", (0.2, 0, 0), 0.3, scenes.material("Black", scenes.BLACK))
        scenes.lamp("POINT", (0.3, 0, 2.5), energy=300.0, shadow_soft_size=0.0)

    return build, bounces


def fire(bounces):
    """A ball of fire, noisy and of two colours, that overlaps a box of fog, the only light there is; and a black ball beside it."""

    def build(scene):
        scenes.wire(scene.world, [])
        scenes.cube("Fog", (0, 0, 0), (4, 4, 4), scenes.material("Fog", *scenes.fog((1, 0.9, 0.8), 0.4)))
        flame = scenes.material("Fire", ("ShaderNodeEmission", {}, "Volume"))
        tree = flame.node_tree
        new, link = tree.nodes.new, tree.links.new
        place, noise, fade, strength = (new(f"ShaderNode{kind}") for kind in ("TexCoord", "TexNoise", "TexGradient", "Math"))
        noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 1.5, 0.0
        fade.gradient_type, strength.operation = "SPHERICAL", "MULTIPLY"
        ramp, emission = new("ShaderNodeValToRGB"), next(node for node in tree.nodes if node.type == "EMISSION")
        ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (4, 0.4, 0.1, 1), (1, 2, 4, 1)
        for texture in (noise, fade):
            link(place.outputs["Object"], texture.inputs["Vector"])
        link(next(s for s in fade.outputs if s.identifier == "Fac"), strength.inputs[0])
        link(noise.outputs[0], strength.inputs[1])
        link(noise.outputs[0], ramp.inputs[0])
        link(strength.outputs[0], emission.inputs["Strength"])
        link(ramp.outputs[0], emission.inputs["Color"])
        scenes.to_unit(scenes.cube("Fire", (-0.3, 0.2, 0.2), (1.2, 1.2, 1.2), flame))
        scenes.ball("Ball", (0.9, -0.8, 0), 0.4, scenes.material("Black", scenes.BLACK))

    return build, bounces


def flames(bounces):
    """Smoke of a simulation that its own fire lights, and no lamp."""

    def build(scene):
        scenes.wire(scene.world, [])
        hot = {"Color": (1.0, 0.8, 0.5, 1), "Density": 4.0, "Blackbody Intensity": 1.0, "Temperature Attribute": ""}
        made = scenes.material("Fire", ("ShaderNodeVolumePrincipled", hot, "Volume"))
        # By a node, as samples of Cycles 5.0.1 miss what glows by a Temperature Attribute.
        tree = made.node_tree
        heat, kelvin = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeMath")
        heat.attribute_name, kelvin.operation, kelvin.inputs[1].default_value = "temperature", "MULTIPLY", 1000.0
        tree.links.new(heat.outputs["Fac"], kelvin.inputs[0])
        gas = next(node for node in tree.nodes if node.type == "PRINCIPLED_VOLUME")
        tree.links.new(kelvin.outputs[0], gas.inputs["Temperature"])
        smoke_scenes.domain(20, 6, made)

    return build, bounces


def _tinted(kind, **values):
    return (f"ShaderNodeBsdf{kind}", {"Color": (0.9, 0.6, 0.3, 1), **values}, "Surface")


def _glass_ball():
    # Just out of sight; what it gathers falls into the fog below.
    glass = ("ShaderNodeBsdfGlass", {"Color": (1, 1, 1, 1), "Roughness": 0.0, "IOR": 1.45}, "Surface")
    scenes.ball("Lens", (0.2, 0.1, 2.15), 0.3, scenes.material("Glass", glass))


def _card(closure, output):
    """A square below the lamp, one of whose inputs an image of 4 x 4 pixels gives: colours, and an alpha of 0 or 1."""
    bpy.ops.mesh.primitive_plane_add(size=2.4, location=(0.2, 0.1, 2.6))
    pixels = np.random.default_rng(3).random((4, 4, 4)).astype(np.float32)
    pixels[..., 3] = np.round(pixels[..., 3])
    of = bpy.data.images.new("Pattern", 4, 4, alpha=True, float_buffer=True)
    of.colorspace_settings.name, of.alpha_mode = "Linear Rec.709", "CHANNEL_PACKED"
    of.pixels.foreach_set(pixels.ravel())
    card = scenes.material("Card", (closure, {}, "Surface"))
    bpy.context.object.data.materials.append(card)
    texture = card.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation = of, "Closest"
    surface = next(node for node in card.node_tree.nodes if node.bl_idname == closure)
    card.node_tree.links.new(texture.outputs[output], surface.inputs[output if output in surface.inputs else "Color"])


def _holes():
    _card("ShaderNodeBsdfPrincipled", "Alpha")


def _panes():
    _card("ShaderNodeBsdfTransparent", "Color")


def _veil():
    _card("ShaderNodeBsdfTranslucent", "Color")


def _screen():
    _card("ShaderNodeEmission", "Color")


def _shining_square():
    bpy.ops.mesh.primitive_plane_add(size=0.5, location=(0, 0, 2.3))
    shine = ("ShaderNodeEmission", {"Color": (1.0, 0.5, 0.2, 1), "Strength": 30.0}, "Surface")
    bpy.context.object.data.materials.append(scenes.material("Shine", shine))


SCENES = {
    "POINT": black_ball("POINT", energy=300.0, shadow_soft_size=0.0),
    "BALL": black_ball("POINT", energy=300.0, shadow_soft_size=0.4),
    "SPOT": black_ball("SPOT", soft=True, energy=300.0, shadow_soft_size=0.05, spot_size=1.0, spot_blend=0.4),
    # In the picture, with fog inside.
    "SEEN": black_ball("POINT", SEEN, energy=300.0, shadow_soft_size=0.3),
    "SEEN SOFT": black_ball("POINT", SEEN, True, energy=300.0, shadow_soft_size=0.3),
    "SEEN SOFT SPOT": black_ball("SPOT", SEEN, True, energy=300.0, shadow_soft_size=0.3, spot_size=1.0, spot_blend=0.4),
    "AREA": black_ball("AREA", energy=100.0, shape="RECTANGLE", size=1.0, size_y=0.5),
    "DISK": black_ball("AREA", energy=100.0, shape="DISK", size=1.0, spread=1.2),
    "SUN": black_ball("SUN", energy=3.0, angle=0.05, color=(0.3, 0.6, 1.0)),
    "SLIDE": projected(),
    "UNEVEN": uneven(),
    "IES": measured(360),
    "HALF AN IES": measured(180),
    "FOCUS": out_of_focus(),
    "PARALLEL": seen_otherwise("ORTHO", ortho_scale=3.5, shift_x=0.05),
    "ALL AROUND": seen_otherwise("PANO", panorama_type="EQUIRECTANGULAR", latitude_max=0.4, longitude_min=-1.5, longitude_max=2.0),
    "FISHEYE": seen_otherwise("PANO", panorama_type="FISHEYE_EQUIDISTANT", fisheye_fov=1.4),
    "WORLD": under_sky(),
    "SKY": under_sky(picture=True),
    "COMPUTED SKY": computed_sky(),
    "SKY TEXTURE": sky_texture(),
    "MESH": fog_box([_shining_square], bounces=0),
    "CLOUD": cloud(0),
    "WHITE CLOUD": cloud(16),
    "SMOKE": smoke(0),
    "WHITE SMOKE": smoke(16),
    "FIRE": fire(0),
    "WHITE FIRE": fire(8),
    "FLAMES": flames(4),
    "OVERLAP": overlapping(0),
    "OVERLAPS": overlapping(8),
    "MULTIPLE": fog_box([], bounces=16, medium=scenes.fog((1, 0.9, 0.8), 0.4, -0.4)),
    "DIFFUSE": fog_box([], _tinted("Diffuse"), bounces=1),
    "METAL": fog_box([], _tinted("Glossy", Roughness=0.4), bounces=1),
    "HOLES": fog_box([_holes], bounces=0),
    "PANES": fog_box([_panes], bounces=0),
    "VEIL": fog_box([_veil], bounces=1),
    "SCREEN": fog_box([_screen], bounces=0),
    "GLASS": fog_box([_glass_ball], bounces=8, medium=scenes.fog((1, 0.9, 0.8), 0.02)),
}


def make(name, size, samples):
    """The Blender scene of a name, and how often light is scattered or reflected before it is seen."""
    scene = scenes.empty_scene(size, samples)
    scenes.look((0, -5, 0.5), (0, 0, 0))
    build, bounces = SCENES[name]
    build(scene)
    scene.cycles.max_bounces = scene.cycles.volume_bounces = bounces
    # Only the seed changes from one picture to the next.
    scene.render.use_persistent_data = True
    return scene, bounces


def covbeam_picture(passes, photons, seed, bounces):
    """Renders with covbeam: float32 (h, w, 3), rows from the top."""
    exported, report = export(bpy.context.evaluated_depsgraph_get())
    assert not len(report), str(report)
    session = Session(exported, Settings(seed=seed, photons=photons, bounces=bounces))
    try:
        for _ in range(passes):
            session.render_pass()
        return session.picture().in_scattered
    finally:
        session.close()


@dataclass(frozen=True)
class Comparison:
    """covbeam over Cycles, less 1, of whole pictures and of regions, per channel, with standard errors."""

    name: str
    means: np.ndarray
    mean_difference: np.ndarray
    mean_error: np.ndarray
    difference: np.ndarray
    error: np.ndarray

    def regions_agree(self, within):
        """Whether no region differs by more than a share `within`, beyond noise.

        Student's t of two means of 4 seeds each exceeds 4 in 1 of 140 cases, and of 48 regions and channels, which share light
        paths, about 10 are independent: so 5, which is 1 in 400.
        """
        return bool((np.abs(self.difference) < within + 5 * self.error).all())

    def __str__(self):
        return (
            f"{self.name:8} covbeam {self.means[0].round(5)} Cycles {self.means[1].round(5)} differ by "
            f"{(100 * self.mean_difference).round(2)} % +- {(100 * self.mean_error).round(2)}; regions by up to "
            f"{100 * np.abs(self.difference).max():.1f} %, which are {np.abs(self.difference / self.error).max():.1f} standard "
            f"errors at most"
        )


@functools.cache
def runs_of_both(name, size, seeds, samples, passes, photons, across):
    """Means of across x across regions in pictures of covbeam and of Cycles, of so many seeds each."""
    scene, bounces = make(name, size, samples)

    def cycles(seed):
        scene.cycles.seed = seed
        return scenes.region_means(scenes.cycles_picture(scene), across)

    def ours(seed):
        return scenes.region_means(covbeam_picture(passes, photons, seed, bounces), across)

    return tuple(np.array([picture(seed) for seed in range(seeds)]) for picture in (ours, cycles))


def compare(name, size, seeds, samples, passes, photons, across=4, brighter=1.0):
    """Compares both in one scene, and across x across regions. `brighter` is a factor on covbeam's picture, to see whether it would
    be noticed."""
    ours, cycles = runs_of_both(name, size, seeds, samples, passes, photons, across)
    runs = [brighter * ours, cycles]
    wholes = [run.mean(axis=1) for run in runs]
    errors = [run.std(axis=0, ddof=1) / np.sqrt(seeds) for run in runs]
    means = np.array([whole.mean(axis=0) for whole in wholes])
    mean_error = np.hypot(*(whole.std(axis=0, ddof=1) / np.sqrt(seeds) for whole in wholes)) / means[1]
    found, expected = (run.mean(axis=0) for run in runs)
    lit = expected > DARK * expected.mean(axis=0)
    difference = (found - expected)[lit] / expected[lit]
    return Comparison(name, means, means[0] / means[1] - 1, mean_error, difference, np.hypot(*errors)[lit] / expected[lit])


def main(words):
    """Runs the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=32)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--passes", type=int, default=16)
    parser.add_argument("--photons", type=int, default=20_000)
    parser.add_argument("--only", nargs="*", choices=SCENES, default=list(SCENES))
    arguments = parser.parse_args(words)
    agreed = True
    for name in arguments.only:
        comparison = compare(
            name, arguments.size, arguments.seeds, arguments.samples, arguments.passes, arguments.photons
        )
        print(comparison, flush=True)
        whole = np.abs(comparison.mean_difference) < 0.01
        agreed &= bool(whole.all()) and comparison.regions_agree(0.01)
    return 0 if agreed else 1


if __name__ == "__main__":
    status = main(sys.argv[1:])
    sys.stdout.flush()
    # Mantaflow ends the process in a way of its own if that is not done here.
    os._exit(status)
