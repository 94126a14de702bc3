# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures of what artists light fog with, a scene for each kind of thing. For measure_kinds.py."""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import bpy
import cycles_scenes as scenes
import numpy as np
import smoke_scenes
import vdb_files
from fog_light import Tree, medium, picture, slide
from mathutils import Matrix

#: Scatterings and reflections of light.
BOUNCES = 4


@dataclass(frozen=True)
class Kind:
    """A scene: what builds it, and whether what volumes send straight to the eye belongs to it."""

    build: Callable
    glowing: bool = False


def make(name, width):
    """The Blender scene of a name."""
    scene = scenes.empty_scene(8)
    # Whole squares of 8 x 8 pixels.
    scene.render.resolution_x, scene.render.resolution_y = width, 8 * round(width * 9 / 128)
    scene.cycles.max_bounces = scene.cycles.volume_bounces = BOUNCES
    scenes.wire(scene.world, [])
    KINDS[name].build(scene)
    return scene


def _matt(*colour):
    return scenes.material("Matt", ("ShaderNodeBsdfDiffuse", {"Color": (*colour, 1)}, "Surface"))


def _cylinder(place, radius, depth, made, rotation=(0, 0, 0)):
    bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=radius, depth=depth, location=place, rotation=rotation)
    bpy.context.object.data.materials.append(made)
    return bpy.context.object


def _card(place, size, made, rotation=(0, 0, 0)):
    bpy.ops.mesh.primitive_plane_add(size=1, location=place, rotation=rotation)
    thing = bpy.context.object
    thing.scale = (*size, 1)
    thing.data.materials.append(made)
    return thing


def _stage():
    """A floor and a wall."""
    grey = _matt(0.45, 0.42, 0.4)
    scenes.cube("Floor", (0, 0, -0.1), (14, 14, 0.2), grey)
    scenes.cube("Wall", (0, 3.2, 2.5), (14, 0.2, 6), grey)


def _mist(scene):
    """Morning: mist of noise that lies between two hills, a low sun behind them, cold light from the side."""
    scenes.look((0, -8, 1.8), (0, 0, 1.0), 40)

    def density(tree):
        place, parts = tree.node("NewGeometry").outputs["Position"], tree.node("SeparateXYZ")
        tree.link(place, parts)
        low = tree.node("MapRange", {"From Min": 0.1, "From Max": 2.4, "To Min": 1.0, "To Max": 0.03}, interpolation_type="SMOOTHSTEP")
        patch = tree.node("MapRange", {"From Min": 0.35, "From Max": 0.65, "To Min": 0.03, "To Max": 0.8})
        both = tree.node("Math", operation="MULTIPLY")
        tree.link(tree.link(parts.outputs["Z"], low, "Value"), both, 0)
        noise = tree.node("TexNoise", {"Scale": 0.8, "Detail": 2.0})
        tree.link(tree.link(tree.link(place, noise), patch, "Value"), both, 1)
        return both.outputs[0]

    scenes.cube("Mist", (0, 0, 1.5), (10, 7, 2.96), medium("Mist", density, anisotropy=0.5))
    ground = _matt(0.15, 0.2, 0.1)
    scenes.cube("Ground", (0, 0, -0.1), (14, 12, 0.2), ground)
    for place, size in (((-2.2, 1.0, 0), (1.8, 1.5, 1.7)), ((2.4, 0.4, 0), (1.5, 1.2, 1.3))):
        scenes.ball("Hill", place, 1.0, ground, 4).scale = size
    scenes.lamp("SUN", (3, 6, 2.2), (0, 0, 0.4), energy=6.0, angle=0.05, color=(1, 0.7, 0.4))
    scenes.lamp("AREA", (-4.5, -3, 4), (0, 0, 0.5), energy=300.0, size=2.0, color=(0.5, 0.7, 1.0))


def _plume(scene):
    """A mushroom cloud of an OpenVDB file, lit from behind and by a cold area."""
    scenes.look((0, -6, 1.0), (0, 0, 1.1), 45)
    _stage()
    cells = 48
    x, y, z = (np.mgrid[:cells, :cells, :cells] + 0.5) * (2 / cells) - 1
    far, turn = np.hypot(x, y), np.arctan2(y, x)
    cap = np.exp(-((far - 0.42) ** 2 + 0.8 * (z - 0.4 - 0.06 * np.sin(5 * turn)) ** 2) / 0.035) * (0.8 + 0.3 * np.sin(7 * turn + 9 * z))
    stem = np.exp(-((far / (0.14 + 0.1 * (z + 0.2) ** 2)) ** 2)) / (1 + np.exp(20 * (z - 0.4))) * (0.8 + 0.3 * np.sin(14 * z + 3 * turn))
    density = np.maximum(cap + stem - 0.03, 0) * (z > -0.95)
    density[[0, -1]] = density[:, [0, -1]] = density[:, :, [0, -1]] = 0
    step = 2.4 / cells
    transform = np.array([(step, 0, 0, -1.2), (0, step, 0, -1.2), (0, 0, step, 0.05), (0, 0, 0, 1)])
    openvdb = vdb_files.module()
    grid = vdb_files.grid(openvdb, openvdb.FloatGrid, "density", (0, 0, 0), density[..., None].astype(np.float32), transform)
    data = bpy.data.volumes.new("Plume")
    data.filepath = str(Path(tempfile.mkdtemp(dir=bpy.app.tempdir)) / "plume.vdb")
    openvdb.write(data.filepath, [grid])
    gas = {"Color": (0.9, 0.8, 0.7, 1), "Density": 5.0, "Anisotropy": 0.2}
    data.materials.append(scenes.material("Plume", ("ShaderNodeVolumePrincipled", gas, "Volume")))
    scene.collection.objects.link(bpy.data.objects.new("Plume", data))
    spot = {"spot_size": 0.7, "spot_blend": 0.3, "shadow_soft_size": 0.0}
    scenes.lamp("SPOT", (2.8, 2.6, 3.2), (0, 0, 1.2), energy=2500.0, color=(1, 0.6, 0.3), **spot)
    scenes.lamp("AREA", (-3, -2, 2.5), (0, 0, 1.2), energy=200.0, size=1.0, color=(0.4, 0.6, 1.0))


def _chimney(scene):
    """Simulated smoke above a stack, in a spot from above and behind and the light of an area."""
    scenes.look((0, -5.5, 0.3), (0, 0, 0), 45)
    grey = _matt(0.4, 0.38, 0.36)
    gas = {"Color": (0.85, 0.85, 0.9, 1), "Density": 5.0, "Anisotropy": 0.3}
    smoke_scenes.domain(28, 16, scenes.material("Smoke", ("ShaderNodeVolumePrincipled", gas, "Volume")))
    scenes.cube("Roof", (0, 0, -1.2), (6, 6, 0.3), grey)
    scenes.cube("Wall", (0, 2.6, 1), (8, 0.2, 5), grey)
    _cylinder((0.2, -0.1, -0.8), 0.25, 0.5, grey)
    spot = {"spot_size": 0.6, "spot_blend": 0.4, "shadow_soft_size": 0.0}
    scenes.lamp("SPOT", (-2.6, 1.8, 2.6), (0.1, 0, 0), energy=1500.0, color=(1, 0.85, 0.6), **spot)
    scenes.lamp("AREA", (2.6, -1.6, 0.6), (0, 0, 0), energy=100.0, size=0.8, color=(0.4, 0.6, 1.0))


def _lighthouse(scene):
    """A lighthouse in haze: its two beams cross a bank of fog and two coloured clouds, all of which overlap."""
    scenes.look((0, -9, 1.6), (0, 0, 1.7), 40)
    scenes.cube("Sea", (0, 0, -0.1), (14, 12, 0.2), _matt(0.05, 0.08, 0.1))
    _cylinder((-0.9, 0, 0.95), 0.22, 1.9, _matt(0.7, 0.7, 0.7))
    scenes.cube("Haze", (0, 0, 2), (10, 6, 3.96), medium("Haze", 0.05))

    def fading(tree):
        fade, thick = tree.node("TexGradient", gradient_type="SPHERICAL"), tree.node("Math", {1: 0.8}, operation="MULTIPLY")
        tree.link(tree.node("TexCoord").outputs["Object"], fade)
        return tree.link(next(s for s in fade.outputs if s.identifier == "Fac"), thick, 0)

    scenes.to_unit(scenes.cube("Bank", (-3.0, 0, 1.4), (3.2, 2.4, 2.6), medium("Bank", fading)))
    scenes.ball("Cloud", (1.7, 0, 2.3), 0.9, medium("Cloud", 0.5, (1, 0.7, 0.4)), 4)
    scenes.ball("Other", (2.8, 0.2, 2.0), 0.8, medium("Other", 0.3, (0.4, 0.7, 1)), 4)
    for side in (-1, 1):
        spot = {"spot_size": 0.35, "spot_blend": 0.3, "shadow_soft_size": 0.0}
        scenes.lamp("SPOT", (-0.9 + 0.3 * side, 0, 2.2), (-0.9 + 4 * side, -0.3 * side, 2.1), energy=800.0, color=(1, 0.95, 0.8), **spot)


def _temple(scene):
    """Columns of a temple in haze, under a picture of an evening's sky and a Sky Texture with its sun, half each."""
    scenes.look((0, -7, 1.3), (0, 0, 1.6), 32)
    stone = _matt(0.6, 0.55, 0.5)
    cells = np.empty((32, 64, 3))
    cells[:] = np.linspace(1, 0.1, 32)[:, None, None] * (0.3, 0.5, 1.0)
    # Low, and behind the columns: in the middle of the picture is -X, and a quarter to its left +Y.
    cells[11:14, 20:24] = (90.0, 45.0, 15.0)
    scenes.picture_of_the_sky(scene.world, cells, (0, 0, 0.3))
    tree = Tree(scene.world.node_tree)
    first, second, mix = tree.found("BACKGROUND"), tree.node("Background", {"Strength": 0.25}), tree.node("MixShader", {"Fac": 0.5})
    sky = tree.node("TexSky")
    sky.sun_elevation, sky.sun_rotation, sky.sun_size = 0.6, -0.6, 0.1
    tree.link(sky.outputs[0], second)
    tree.link(first.outputs[0], mix, 1)
    tree.link(tree.link(second.outputs[0], mix, 2), tree.found("OUTPUT_WORLD"), "Surface")
    scenes.cube("Haze", (0, 0, 1.9), (9, 6, 3.76), medium("Haze", 0.12, anisotropy=0.5))
    scenes.cube("Floor", (0, 0, -0.1), (10, 7, 0.2), stone)
    scenes.cube("Roof", (0, 0, 4.0), (10, 7, 0.4), stone)
    for x in (-3.2, -1.6, 0.0, 1.6, 3.2):
        for y in (-0.6, 2.4):
            _cylinder((x, y, 1.9), 0.3, 3.8, stone)


def _campfire(scene):
    """A fire between stones, that lights the fog around it, and some moonlight."""
    scenes.look((0, -5, 1.3), (0, 0, 0.7), 40)
    ground, wood = _matt(0.25, 0.2, 0.15), _matt(0.3, 0.18, 0.1)
    scenes.cube("Ground", (0, 0, -0.1), (10, 10, 0.2), ground)
    for turn in range(3):
        _cylinder((0, 0, 0.12), 0.07, 0.9, wood, (np.pi / 2, 0.15, turn * np.pi / 3))
    for turn in np.arange(7) * (2 * np.pi / 7):
        scenes.ball("Stone", (0.75 * np.cos(turn), 0.75 * np.sin(turn), 0.1), 0.17, ground, 3)
    scenes.cube("Fog", (0, 0, 1.6), (6, 5, 3.18), medium("Fog", 0.4, (1, 0.95, 0.9), 0.3))
    flame = scenes.material("Fire", ("ShaderNodeEmission", {}, "Volume"))
    tree = Tree(flame.node_tree)
    place, fade = tree.node("TexCoord").outputs["Object"], tree.node("TexGradient", gradient_type="SPHERICAL")
    noise = tree.node("TexNoise", {"Scale": 2.0, "Detail": 1.0, "Distortion": 1.0})
    tongues = tree.node("MapRange", {"From Min": 0.4, "From Max": 0.65, "To Min": 0.0, "To Max": 1.0})
    strength, bright = tree.node("Math", operation="MULTIPLY"), tree.node("Math", {1: 60.0}, operation="MULTIPLY")
    ramp, emission = tree.node("ValToRGB"), tree.found("EMISSION")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (1, 0.12, 0.02, 1), (1, 0.5, 0.15, 1)
    tree.link(place, fade)
    tree.link(place, noise)
    warm = next(s for s in fade.outputs if s.identifier == "Fac")
    tree.link(warm, strength, 0)
    tree.link(tree.link(noise.outputs[0], tongues, "Value"), strength, 1)
    tree.link(tree.link(strength.outputs[0], bright, 0), emission, "Strength")
    tree.link(tree.link(warm, ramp), emission, "Color")
    scenes.to_unit(scenes.cube("Fire", (0, 0, 0.75), (0.8, 0.8, 1.2), flame))
    scenes.lamp("SUN", (-3, 2, 5), (0, 0, 0), energy=0.05, angle=0.02, color=(0.5, 0.7, 1.0))


def _star(scene):
    """A star of coloured light that comes out of the dark onto a ball."""
    scenes.look((0, -7, 1.4), (0, 0, 1.5), 35)
    _stage()
    scenes.cube("Haze", (0, 0, 2), (9, 6, 3.96), medium("Haze", 0.08, anisotropy=0.3))
    scenes.ball("Ball", (0.6, -0.8, 0.7), 0.45, _matt(0.7, 0.7, 0.7), 4)
    y, x = (np.mgrid[:96, :96] + 0.5) / 48 - 1
    far, turn = np.hypot(x, y), np.arctan2(y, x)
    inside = far < 0.9 / (1 + 1.4 * np.abs(np.arcsin(np.sin(2.5 * turn)) / (np.pi / 2)))
    pixels = np.ones((96, 96, 4))
    pixels[..., :3] = inside[..., None] * (0.5 + 0.5 * np.cos(turn[..., None] + np.array([0, 2.1, 4.2])))
    spot = scenes.lamp("SPOT", (-2.6, 2.4, 3.6), (0.6, -0.8, 0.6), energy=5000.0, spot_size=0.8, spot_blend=0.1, shadow_soft_size=0.0)
    slide(spot.data, picture("Star", pixels), 0.8)
    scenes.lamp("AREA", (3.5, -2, 3.5), (0, 0, 1), energy=40.0, size=1.0, color=(0.4, 0.5, 1.0))


def _corridor(scene):
    """Three lamps of an IES file along a wall: bright rings, and a little light upwards."""
    scenes.look((0, -6.5, 1.5), (0, 0, 1.4), 32)
    _stage()
    scenes.cube("Haze", (0, 0.2, 1.6), (9, 5.6, 3.16), medium("Haze", 0.1, anisotropy=0.2))
    vertical, horizontal = np.arange(0, 181, 7.5), np.arange(0, 361, 45)
    v, h = np.radians(vertical), np.radians(horizontal)[:, None]
    ring = np.exp(-(((v - 0.55) / 0.2) ** 2)) * (1 + 0.5 * np.cos(2 * h)) + 0.3 * np.exp(-((v / 0.15) ** 2))
    ring = ring + 0.15 * np.exp(-(((v - 2.8) / 0.3) ** 2))
    rows = [vertical, horizontal, *(3000 * ring).round(2)]
    text = bpy.data.texts.new("Lamp")
    text.write(f"IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {len(vertical)} {len(horizontal)} 1 2 0 0 0\n1 1 100\n")
    text.write("\n".join(" ".join(map(str, row)) for row in rows) + "\n")
    for x, colour in ((-2.4, (1, 0.8, 0.5)), (0.0, (1, 1, 1)), (2.4, (0.5, 0.8, 1))):
        lamp = scenes.lamp("POINT", (x, 1.8, 2.6), (x, 1.8, 0), energy=1.0, shadow_soft_size=0.0, color=colour)
        lamp.data.use_nodes = True
        tree = Tree(lamp.data.node_tree)
        ies = tree.node("TexIES", {"Strength": 1.0}, mode="INTERNAL")
        ies.ies = text
        tree.link(ies.outputs[0], tree.found("EMISSION"), "Strength")


def _leaves(scene):
    """Sun through a canopy of leaves that an image cuts out of cards, and through a fence."""
    scenes.look((0, -7, 1.2), (0, 0, 1.5), 35)
    scenes.cube("Ground", (0, 0, -0.1), (14, 12, 0.2), _matt(0.15, 0.2, 0.1))
    scenes.cube("Haze", (0, 0, 1.9), (8, 5, 3.76), medium("Haze", 0.1, anisotropy=0.5))
    _cylinder((2.2, 1.0, 1.9), 0.18, 3.8, _matt(0.2, 0.12, 0.08))
    random = np.random.default_rng(5)
    y, x = (np.mgrid[:64, :64] + 0.5) / 64
    pixels = np.full((64, 64, 4), (0.15, 0.4, 0.08, 0.0))
    for at, size, turn in zip(random.random((150, 2)), random.uniform(0.04, 0.09, 150), random.uniform(0, np.pi, 150)):
        right, up = x - at[0], y - at[1]
        along, across = right * np.cos(turn) + up * np.sin(turn), up * np.cos(turn) - right * np.sin(turn)
        pixels[(along / size) ** 2 + (2 * across / size) ** 2 < 1, 3] = 1
    slats = np.full((32, 32, 4), (0.4, 0.3, 0.2, 0.0))
    slats[:, :2, 3] = slats[14:18, :, 3] = slats[:, 16:18, 3] = 1

    def cut_out(name, image):
        made = scenes.material(name, ("ShaderNodeBsdfPrincipled", {"Roughness": 0.8, "Specular IOR Level": 0.0}, "Surface"))
        tree = Tree(made.node_tree)
        texture, surface = tree.node("TexImage", interpolation="Closest"), tree.found("BSDF_PRINCIPLED")
        texture.image = image
        tree.link(texture.outputs["Color"], surface, "Base Color")
        tree.link(texture.outputs["Alpha"], surface, "Alpha")
        return made

    first = _card((-2, 0, 4.1), (2.6, 5.5), cut_out("Leaves", picture("Leaves", pixels)), (0.1, 0, 0.1))
    for place, rotation in (((0.3, 0.2, 4.3), (0.1, 0.1, 1.5)), ((2.6, 0, 4.0), (-0.1, -0.05, 0.3))):
        other = first.copy()
        other.location, other.rotation_euler, other.scale = place, rotation, (3.2, 5.5, 1) if rotation[2] < 1 else (5.5, 2.8, 1)
        scene.collection.objects.link(other)
    fence = _card((-1.9, -0.8, 0.6), (2.4, 1.2), cut_out("Fence", picture("Fence", slats)), (np.pi / 2, 0, 0.3))
    for loop in fence.data.uv_layers.active.data:
        loop.uv = (4 * loop.uv[0], 2 * loop.uv[1])
    scenes.lamp("SUN", (-1.6, 2.2, 5), (0, 0, 0), energy=8.0, angle=0.02, color=(1, 0.9, 0.7))


def _chapel(scene):
    """Sun through three windows: an image of panes, colours of vertices, and milk glass."""
    scenes.look((0, -5.6, 1.3), (0, 0, 1.6), 32)
    stone = _matt(0.5, 0.48, 0.45)
    for place, size in (
        ((0, 0, -0.1), (8, 7, 0.2)),
        ((0, 0, 4.1), (8, 7, 0.2)),
        ((-3.9, 0, 2), (0.2, 7, 4)),
        ((3.9, 0, 2), (0.2, 7, 4)),
        ((0, 2.4, 0.5), (7.6, 0.2, 1)),
        ((0, 2.4, 3.6), (7.6, 0.2, 0.8)),
    ):
        scenes.cube("Stone", place, size, stone)
    for x, width in ((-3.2, 1.2), (-1.05, 0.9), (1.05, 0.9), (3.2, 1.2)):
        scenes.cube("Pier", (x, 2.4, 2.1), (width, 0.2, 2.2), stone)
    scenes.cube("Haze", (0, -0.4, 2), (7.5, 5.2, 3.96), medium("Haze", 0.08, anisotropy=0.4))
    random = np.random.default_rng(2)
    colours = np.array([(0.9, 0.1, 0.05), (0.1, 0.3, 0.9), (0.95, 0.7, 0.1), (0.1, 0.7, 0.2)])
    panes = np.zeros((48, 24, 4))
    for row in range(6):
        for column in range(3):
            panes[8 * row + 1 : 8 * row + 8, 8 * column + 1 : 8 * column + 8, :3] = colours[random.integers(4)]
    image = picture("Panes", panes)

    def window(x, closure, image=None):
        made = scenes.material("Window", (closure, {}, "Surface"))
        tree = Tree(made.node_tree)
        card = _card((x, 2.4, 2.1), (1.3, 2.2), made, (np.pi / 2, 0, 0))
        if image is None:
            colour = tree.node("VertexColor", layer_name="Tint").outputs["Color"]
            mesh = card.data
            tint = mesh.color_attributes.new("Tint", "FLOAT_COLOR", "POINT")
            for point, value in zip(tint.data, colours):
                point.color = (*value, 1)
        else:
            texture = tree.node("TexImage", interpolation="Closest")
            texture.image, colour = image, texture.outputs["Color"]
        tree.link(colour, next(n for n in made.node_tree.nodes if n.bl_idname == closure), "Color")

    window(-2.05, "ShaderNodeBsdfTransparent", image)
    window(0.0, "ShaderNodeBsdfTransparent")
    window(2.05, "ShaderNodeBsdfTranslucent", image)
    scenes.lamp("SUN", (1.2, 4, 3), (0, 0, 0), energy=20.0, angle=0.02)


def _fan(scene):
    """A fan turns in front of a spot with soft falloff; the camera, out of focus behind, moves past."""
    eye = scenes.look((0, -6, 1.5), (0, 0, 1.5), 40)
    _stage()
    scenes.cube("Haze", (0, 0, 2), (9, 6, 3.96), medium("Haze", 0.12, anisotropy=0.3))
    black = _matt(0.05, 0.05, 0.05)
    # Its own axis, X, is the spot's.
    hub = _cylinder((1.3, 0.4, 2.2), 0.1, 0.1, black, (0, np.pi / 2, 0))
    hub.rotation_euler = (0, 0, 0)
    hub.data.transform(Matrix.Rotation(np.pi / 2, 4, "Y"))
    for turn in range(3):
        blade = scenes.cube("Blade", (0, 0, 0), (1, 1, 1), black)
        shape = Matrix.Translation((0, 0, 0.35)) @ Matrix.Diagonal((0.02, 0.28, 0.55, 1))
        blade.data.transform(Matrix.Rotation(turn * 2 * np.pi / 3, 4, "X") @ shape)
        blade.parent = hub
    scenes.moves(hub, "rotation_euler", 0.0, 0.5, 1.0)
    scenes.moves(eye, "location", -0.1, 0.0, 0.1)
    dof = eye.data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 5.0, 0.15
    spot = {"spot_size": 0.9, "spot_blend": 0.3, "shadow_soft_size": 0.05, "use_soft_falloff": True}
    scenes.lamp("SPOT", (2.6, 0.4, 2.4), (-1.5, 0.2, 1.2), energy=1500.0, color=(1, 0.85, 0.6), **spot)
    scenes.lamp("AREA", (-3.5, -2, 3.5), (0, 0, 1), energy=30.0, size=1.0, color=(0.4, 0.5, 1.0))
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(2)


def _treasure(scene):
    """A crystal ball with fog in it, drops of coloured glass that are instances, a mirror, and a shining panel above."""
    scenes.look((0, -6, 1.6), (0, 0, 1.2), 40)
    _stage()
    scenes.cube("Haze", (0, 0, 1.8), (8, 5.5, 3.56), medium("Haze", 0.06, anisotropy=0.2))

    def glass(name, colour, *fog):
        return scenes.material(name, ("ShaderNodeBsdfGlass", {"Color": (*colour, 1), "Roughness": 0.0, "IOR": 1.45}, "Surface"), *fog)

    scenes.ball("Crystal", (0.5, 0.2, 1.0), 0.5, glass("Crystal", (1, 1, 1), *scenes.fog((0.5, 0.9, 1.0), 0.8, 0.2)), 5)
    drops = bpy.data.collections.new("Drops")
    for place, colour in (((0, 0, 0), (1, 0.3, 0.2)), ((0.55, 0.1, 0.1), (0.3, 1, 0.4))):
        drop = scenes.ball("Drop", place, 0.25, glass("Drop", colour), 5)
        scene.collection.objects.unlink(drop)
        drops.objects.link(drop)
    for place in ((-1.6, 0.0, 1.6), (1.5, -0.4, 1.9)):
        group = bpy.data.objects.new("Drops", None)
        group.instance_type, group.instance_collection, group.location = "COLLECTION", drops, place
        scene.collection.objects.link(group)
    mirror = scenes.material("Mirror", ("ShaderNodeBsdfGlossy", {"Color": (0.9, 0.9, 0.9, 1), "Roughness": 0.0}, "Surface"))
    _card((-1.5, 0.6, 0.5), (1.3, 1.3), mirror, (0.3, 0.5, 0))
    shine = scenes.material("Panel", ("ShaderNodeEmission", {"Color": (1, 0.9, 0.75, 1), "Strength": 30.0}, "Surface"))
    _card((-0.2, 0.2, 3.7), (0.7, 0.7), shine, (np.pi, 0, 0))


KINDS = {
    "MIST": Kind(_mist),
    "PLUME": Kind(_plume),
    "CHIMNEY": Kind(_chimney),
    "LIGHTHOUSE": Kind(_lighthouse),
    "TEMPLE": Kind(_temple),
    "CAMPFIRE": Kind(_campfire, glowing=True),
    "STAR": Kind(_star),
    "CORRIDOR": Kind(_corridor),
    "LEAVES": Kind(_leaves),
    "CHAPEL": Kind(_chapel),
    "FAN": Kind(_fan),
    "TREASURE": Kind(_treasure),
}
