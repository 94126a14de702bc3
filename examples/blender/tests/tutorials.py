# SPDX-License-Identifier: GPL-3.0-or-later
"""Twelve scenes of light in fog as people make them: each by a tutorial or thread that anyone can read, from Blender's factory scene on, with the
names, snapped lengths, modifiers and settings of Cycles that come of doing what it says. For measure_tutorials.py."""

from dataclasses import dataclass
from math import radians
from typing import Callable

import bpy
import numpy as np
import smoke_scenes
from fog_light import Tree, picture
from menu import cut_window, factory, haze, light, look, material, mesh, night, principled, world_fog


@dataclass(frozen=True)
class Tutorial:
    """A scene: what builds it, and what of its fog light Cycles hardly finds, as text; empty: it finds all."""

    build: Callable
    caustic: str = ""


def make(name, width):
    """The Blender scene of a name, `width` x 9/16 of it pixels: the factory's without its cube and lamp, rendered by Cycles as Blender sets it."""
    scene = factory(width)
    TUTORIALS[name].build(scene)
    return scene


def bars(scene):
    """God rays through bars: a cube of Principled Volume, Density .08, on the floor, an Area of 3000 W and .02 m behind a row of bars.
    https://blenderartists.org/t/god-rays-the-ultimate-discussion/1409820"""
    night(scene)
    look(scene, (0, -9, 2), (0, 0, 1.75), 35)
    mesh("plane", (0, 0, 0), material=principled(0.5, 0.5, 0.5), size=20)
    bar = mesh("cube", (-3, 1, 1.5), (0.125, 0.125, 1.5), principled(0.1, 0.1, 0.1))
    row = bar.modifiers.new("Array", "ARRAY")
    row.count, row.relative_offset_displace = 9, (3, 0, 0)
    mesh("cube", (0, 0, 2.5), (5, 4, 2.5), haze(0.08))
    light("AREA", (0, 3, 3), (0, 0, 1), 3000, size=0.02)


def window(scene):
    """A dark room of a cube, its windows, a spot of constant Light Falloff outside; the world's Volume Scatter of .1, Clamp Indirect 3, no bounces in
    volumes. https://nafergo.github.io/manual-livre-blender/godrays_no_cycles.html"""
    world_fog(scene, 0.1)
    scene.cycles.sample_clamp_indirect, scene.cycles.volume_bounces = 3, 0
    look(scene, (-2, -3.5, 1.5), (0.5, 1, 1.25), 24)
    walls = mesh("cube", (0, 0, 1.5), (3, 4, 1.5), principled(0.8, 0.8, 0.8))
    walls.modifiers.new("Solidify", "SOLIDIFY").thickness = -0.2
    for y in (0, 1, 2):
        cut_window(walls, (3, y, 1.75), (1, 0.25, 0.5))
    mesh("monkey", (0, 1, 0.75), (0.5, 0.5, 0.5), principled(0.8, 0.4, 0.2), (0, 0, radians(-45)))
    spot = light("SPOT", (8, 1, 5), (0, 1, 0.5), 50, color=(1, 0.85, 0.6), spot_size=radians(40))
    spot.data.use_nodes = True
    tree = Tree(spot.data.node_tree)
    tree.link(tree.node("LightFalloff", {"Strength": 10.0}).outputs["Constant"], tree.found("EMISSION"), "Strength")


def room(scene):
    """A room, an Area of 10 m and 20000 W outside that shines in at its windows, with Max Bounces 0; a cube of Principled Volume, Density .1, as
    large as the room. https://oldetinkererstudio.com/creating-god-rays-blender-3d-cycles"""
    look(scene, (-3, -3.5, 1.75), (1, 1, 1.25), 24)
    walls = mesh("cube", (0, 0, 1.5), (4, 4, 1.5), principled(0.6, 0.55, 0.5))
    walls.modifiers.new("Solidify", "SOLIDIFY").thickness = -0.25
    for x in (-0.5, 2):
        cut_window(walls, (x, 4, 1.75), (0.75, 1, 0.75))
    mesh("cube", (0, 0, 1.5), (4, 4, 1.5), haze(0.1))
    wood = principled(0.3, 0.15, 0.05)
    mesh("cube", (1, 1, 0.75), (1, 0.5, 0.05), wood)
    for x in (0.25, 1.75):
        mesh("cylinder", (x, 1, 0.375), material=wood, radius=0.05, depth=0.75)
    area = light("AREA", (2, 16, 9), (0.75, 2, 1), 20000, size=10)
    area.data.cycles.max_bounces = 0


def _web(size, seed):
    """A painted net of caustics, 0 to 1, (size, size): bright where the nearest two of random points are as near."""
    random = np.random.default_rng(seed)
    cells = (np.arange(size) + 0.5) / size
    far = np.abs(np.stack(np.meshgrid(cells, cells), -1)[:, :, None] - random.random((40, 2)))
    near = np.sort(np.hypot(*np.moveaxis(np.minimum(far, 1 - far), -1, 0)), axis=-1)
    return np.clip(1 - (near[..., 1] - near[..., 0]) / 0.04, 0, 1)


def _painted(colours, alpha):
    """An image of a grey, or of colours (h, w, 3), and of alpha (h, w)."""
    pixels = np.empty((*alpha.shape, 4))
    pixels[..., :3], pixels[..., 3] = colours, alpha
    return picture("Image", pixels)


def _cut_out(image, colour):
    """Transparent and Diffuse mixed by the alpha of an Image Texture, to whose Vector nothing is linked: it takes the mesh's UV map."""
    made = material("BsdfDiffuse", Color=(*colour, 1))
    tree = Tree(made.node_tree)
    texture, mix = tree.node("TexImage"), tree.node("MixShader")
    texture.image = image
    tree.link(texture.outputs["Alpha"], mix, 0)
    tree.link(tree.node("BsdfTransparent").outputs[0], mix, 1)
    tree.link(tree.found("BSDF_DIFFUSE").outputs[0], mix, 2)
    tree.link(mix.outputs[0], tree.found("OUTPUT_MATERIAL"), "Surface")
    return made


def _displaced(thing, texture, strength, **settings):
    """A Displace modifier by one of Blender's old textures."""
    modifier = thing.modifiers.new("Displace", "DISPLACE")
    modifier.texture, modifier.strength = texture, strength
    for name, value in settings.items():
        setattr(modifier, name, value)


def underwater(scene):
    """Under water: the world is Volume Scatter, blue and .05; strong spots shine down through a plane with an alpha map of caustics, upon sand of a
    Displace modifier. https://blenderartists.org/t/underwater-caustics/622845"""
    world_fog(scene, 0.05, Color=(0.3, 0.7, 1, 1))
    Tree(scene.world.node_tree).found("BACKGROUND").inputs["Color"].default_value = (0, 0.02, 0.05, 1)
    look(scene, (0, -9, 1.5), (0, 0, 2), 35)
    sand = mesh("grid", (0, 0, 0), material=principled(0.7, 0.6, 0.4), x_subdivisions=64, y_subdivisions=64, size=20)
    clouds = bpy.data.textures.new("Texture", "CLOUDS")
    clouds.noise_scale = 1.5
    _displaced(sand, clouds, 0.75)
    rock = principled(0.2, 0.2, 0.2)
    for place, scale in (((-2, 1, 0.5), 0.75), ((2.5, 0, 0.5), 1)):
        _displaced(mesh("ico_sphere", place, (scale,) * 3, rock, subdivisions=4), clouds, 0.5)
    mesh("plane", (0, 0, 6), material=_cut_out(_painted(0, 1 - _web(128, 1)), (0, 0, 0)), size=8)
    for x in (-2, 0, 2):
        light("SPOT", (x, 0, 10), (0.75 * x, 0, 0), 20000, color=(0.7, 0.9, 1), spot_size=radians(45))


def fortune_teller(scene):
    """A crystal ball on a table, under an Area whose colour is the difference of two Voronois by a ramp; a cube of haze.
    http://livio.nerling.ch/fortune-teller-copy/"""
    night(scene)
    look(scene, (0, -4, 1.75), (0, 0, 1), 40)
    mesh("cube", (0, 0, 0), (1.5, 1.5, 0.25), principled(0.3, 0.05, 0.1))
    ball = mesh("uv_sphere", (0, 0, 0.75), (0.5, 0.5, 0.5), material("BsdfGlass", Roughness=0.0, IOR=1.45))
    ball.data.shade_smooth()
    mesh("torus", (0, 0, 0.3), material=principled(0.8, 0.6, 0.2, Metallic=1.0, Roughness=0.3), major_radius=0.35, minor_radius=0.08)
    mesh("cube", (0, 0, 1.75), (3, 2, 1.5), haze(0.1))
    area = light("AREA", (0, 0.5, 3), (0, 0, 0.5), 300, size=1)
    area.data.use_nodes = True
    tree = Tree(area.data.node_tree)
    place, ramp = tree.node("TexCoord").outputs["UV"], tree.node("ValToRGB")
    difference = tree.node("Math", operation="SUBTRACT")
    for index, scale in enumerate((5.0, 7.0)):
        voronoi = tree.node("TexVoronoi", {"Scale": scale})
        tree.link(place, voronoi, "Vector")
        tree.link(voronoi.outputs["Distance"], difference, index)
    ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 0.3, (0.4, 0.6, 1, 1)
    tree.link(difference.outputs[0], ramp)
    tree.link(ramp.outputs["Color"], tree.found("EMISSION"), "Color")


def ocean(scene):
    """Below an Ocean modifier's waves of glass that casts no shadow, as Is Shadow Ray mixes Transparent in; a cube of water, a Sun of .01.
    https://trantor.is/content/SrLH-AwN48Oo63Pk/ch29s03.html"""
    look(scene, (0, -9, -2.5), (0, 0, -1.5), 24)
    sea = mesh("plane", (0, 0, 0), material=material("BsdfGlass", Roughness=0.0, IOR=1.33), size=1)
    waves = sea.modifiers.new("Ocean", "OCEAN")
    waves.spatial_size, waves.resolution, waves.wave_scale, waves.choppiness = 20, 8, 1.0, 0.5
    tree = Tree(sea.data.materials[0].node_tree)
    mix = tree.node("MixShader")
    tree.link(tree.node("LightPath").outputs["Is Shadow Ray"], mix, 0)
    tree.link(tree.found("BSDF_GLASS").outputs[0], mix, 1)
    tree.link(tree.node("BsdfTransparent", {"Color": (0.8, 0.95, 1, 1)}).outputs[0], mix, 2)
    tree.link(mix.outputs[0], tree.found("OUTPUT_MATERIAL"), "Surface")
    mesh("cube", (0, 0, -3.5), (10, 10, 3), material("VolumeScatter", "Volume", Color=(0.4, 0.8, 1, 1), Density=0.1))
    mesh("plane", (0, 0, -6.5), material=principled(0.6, 0.5, 0.35), size=30)
    for x, y in ((-2, 1), (1.5, 0), (4, 3)):
        mesh("ico_sphere", (x, y, -6.25), (1, 1, 0.75), principled(0.25, 0.25, 0.25), subdivisions=3)
    light("SUN", (0, 0, 10), (-3, -2, 0), 5, angle=0.01)


def laser(scene):
    """A laser: a red Area of Spread 0 that shines through a block of Glass with a Bevel modifier, Roughness .05, Filter Glossy 0; in haze.
    https://soyuzkerman.net/article/blender-lasers/1-1-simple-light/"""
    night(scene)
    scene.cycles.blur_glossy = 0
    look(scene, (0, -5, 3), (0, 0, 0.5), 40)
    mesh("plane", (0, 0, 0), material=material("BsdfDiffuse", Roughness=1.0), size=10)
    block = mesh("cube", (0.5, 0, 0.5), (0.5, 0.5, 0.5), material("BsdfGlass", Roughness=0.05, IOR=1.5), (0, 0, radians(30)))
    block.modifiers.new("Bevel", "BEVEL").width = 0.02
    mesh("cube", (0, 0, 1), (4, 2, 1), haze(0.1))
    light("AREA", (-3, 0, 0.75), (0.5, 0, 0.5), 5, color=(1, 0.05, 0.02), size=0.1, spread=0)
    light("POINT", (2, -1, 1.75), (0, 0, 0), 5)


def gaussian_beam(scene):
    """A laser beam that is a cylinder of Emission with a Gaussian profile, by Math nodes, and of Volume Scatter; in a cube of haze.
    https://blender.stackexchange.com/questions/24650/make-gaussian-laser-beam-object-with-variable-radial-emission-profile"""
    night(scene)
    look(scene, (0, -6, 1.75), (0, 0, 1), 40)
    mesh("plane", (0, 0, 0), material=principled(0.5, 0.5, 0.5), size=12)
    mesh("uv_sphere", (1, 0.5, 0.5), (0.5, 0.5, 0.5), principled(0.8, 0.8, 0.8))
    mesh("cube", (0, 0, 1), (4, 2, 1), material("VolumeScatter", "Volume", Density=0.1))
    made = material("Emission", "Volume", Color=(0.1, 1, 0.2, 1))
    tree = Tree(made.node_tree)
    parts = tree.node("SeparateXYZ")
    tree.link(tree.node("TexCoord").outputs["Object"], parts)
    across = tree.node("Math", operation="ADD")
    for index, axis in enumerate("XY"):
        square = tree.node("Math", {1: 2.0}, operation="POWER")
        tree.link(tree.link(parts.outputs[axis], square), across, index)
    profile = tree.node("Math", {0: 2.71828}, operation="POWER")
    strength = tree.node("Math", {1: 50.0}, operation="MULTIPLY")
    tree.link(tree.link(across.outputs[0], tree.node("Math", {1: -4.0}, operation="MULTIPLY")), profile, 1)
    tree.link(tree.link(profile.outputs[0], strength), tree.found("EMISSION"), "Strength")
    both = tree.node("AddShader")
    tree.link(tree.found("EMISSION").outputs[0], both, 0)
    tree.link(tree.node("VolumeScatter", {"Density": 0.1}).outputs[0], both, 1)
    tree.link(both.outputs[0], tree.found("OUTPUT_MATERIAL"), "Volume")
    mesh("cylinder", (0, 0, 1.25), (0.25, 0.25, 3), made, (0, radians(90), 0), radius=1, depth=1)


def projector(scene):
    """A spot that projects an image: Texture Coordinate's Normal, Mapping, Image Texture, Emission with a greater Strength; a cube of haze, a screen.
    https://b3d.interplanety.org/osveschenie-teksturoy-iz-lampy"""
    night(scene)
    look(scene, (-4, -5, 2.5), (0.5, 0, 1.25), 35)
    mesh("plane", (0, 0, 0), material=principled(0.2, 0.2, 0.2), size=14)
    mesh("plane", (4, 0, 1.75), (1.5, 1.5, 1), principled(0.8, 0.8, 0.8), (0, radians(90), 0))
    mesh("cube", (0, 0, 2), (5, 3, 2), haze(0.05))
    # Panes of colours in lead.
    colours = np.kron(np.random.default_rng(4).random((6, 6, 3)) ** 3, np.ones((10, 10, 1)))
    colours[::10] = colours[:, ::10] = 0
    spot = light("SPOT", (-4.5, 0, 1.75), (4, 0, 1.75), 1000, spot_size=radians(40))
    spot.data.use_nodes = True
    tree = Tree(spot.data.node_tree)
    texture, mapping = tree.node("TexImage", extension="CLIP"), tree.node("Mapping", {"Location": (0.5, 0.5, 0), "Scale": (1.75, 1.75, 1)})
    texture.image = _painted(colours, np.ones(colours.shape[:2]))
    tree.link(tree.link(tree.node("TexCoord").outputs["Normal"], mapping), texture)
    tree.link(texture.outputs["Color"], tree.found("EMISSION"), "Color")
    tree.found("EMISSION").inputs["Strength"].default_value = 3.0


def fire(scene):
    """Fire and smoke of a Fluid domain: Principled Volume, its Blackbody Intensity 1, and the world's Strength at 0.
    https://www.francescomilanese.com/tutorials-en-all/en-b3d-fire-smoke/tut-172-en-b3d-fire-smoke-02.html"""
    night(scene)
    look(scene, (0, -5, 0.5), (0, 0, 0.25), 45)
    smoke_scenes.domain(32, 16, material("VolumePrincipled", "Volume", Blackbody_Intensity=1.0))
    mesh("plane", (0, 0, -1), material=principled(0.5, 0.5, 0.5), size=10)
    light("POINT", (2, -1, 2), (0, 0, 0), 100)


def candles(scene):
    """Candles: cones with a Displace modifier of clouds by an Empty, a Gradient Texture that mixes Transparent and Emission; in haze, at night.
    https://foro3d.com/en/2026/february/create-realistic-candle-flames-in-blender-with-textures-and-modifiers-.html"""
    night(scene)
    look(scene, (0, -3, 1.25), (0, 0, 0.6), 45)
    mesh("plane", (0, 0, 0), material=principled(0.3, 0.18, 0.1, Roughness=0.4), size=8)
    mesh("cube", (0, 0, 1), (2.5, 1.5, 1), haze(0.1))
    wax = principled(0.9, 0.8, 0.6, Subsurface_Weight=0.3)
    flame = material("Emission", Color=(1, 0.4, 0.08, 1), Strength=60.0)
    tree = Tree(flame.node_tree)
    gradient, mapping, mix = tree.node("TexGradient"), tree.node("Mapping", {"Rotation": (0, radians(90), 0)}), tree.node("MixShader")
    tree.link(tree.link(tree.node("TexCoord").outputs["Generated"], mapping), gradient)
    tree.link(gradient.outputs["Color"], mix, 0)
    tree.link(tree.node("BsdfTransparent").outputs[0], mix, 1)
    tree.link(tree.found("EMISSION").outputs[0], mix, 2)
    tree.link(mix.outputs[0], tree.found("OUTPUT_MATERIAL"), "Surface")
    clouds = bpy.data.textures.new("Texture", "CLOUDS")
    bpy.ops.object.empty_add(location=(0, 0, 2))
    empty, first = bpy.context.object, None
    for x, y, height in ((-0.75, 0, 0.5), (0, 0.25, 0.75), (0.75, -0.25, 0.25)):
        mesh("cylinder", (x, y, 0.5 * height), material=wax, radius=0.1, depth=height)
        place = (x, y, height + 0.125)
        if first is None:
            first = mesh("cone", place, (0.75, 0.75, 1), flame, vertices=24, radius1=0.05, depth=0.2)
            first.modifiers.new("Subdivision", "SUBSURF").levels = 2
            _displaced(first, clouds, 0.05, texture_coords="OBJECT", texture_coords_object=empty)
        else:
            # Alt+D: the same mesh, its modifiers with it.
            other = first.copy()
            other.location = place
            scene.collection.objects.link(other)


def _leaf():
    """A painted leaf with its alpha."""
    y, x = (np.mgrid[:64, :64] + 0.5) / 32 - 1
    colours = np.array([0.1, 0.3, 0.03]) * (0.6 + 0.4 * np.abs(np.sin(12 * (y + np.abs(x)))))[..., None]
    return _painted(colours, (np.abs(x) < 0.6 * (1 - y**2)).astype(float))


def forest(scene):
    """Morning in a wood: the fog's Density falls off with height, .026 * exp(-z / 4), Anisotropy .6; a low Sun behind trees whose leaves are planes
    with an image's alpha, by a particle system of hair.
    https://github.com/EL4CTEO/blender-skills: skills/blender-time-of-day/references/fog-volumetrics.md"""
    look(scene, (0, -10, 1.75), (0, 0, 2.25), 30)
    mesh("plane", (0, 0, 0), material=principled(0.1, 0.12, 0.05), size=40)
    fog = haze(0.0, Anisotropy=0.6)
    tree = Tree(fog.node_tree)
    parts, down = tree.node("SeparateXYZ"), tree.node("Math", {1: -0.25}, operation="MULTIPLY")
    tree.link(tree.node("NewGeometry").outputs["Position"], parts)
    power, density = tree.node("Math", operation="EXPONENT"), tree.node("Math", {1: 0.026}, operation="MULTIPLY")
    tree.link(tree.link(tree.link(parts.outputs["Z"], down), power), density)
    tree.link(density.outputs[0], tree.found("PRINCIPLED_VOLUME"), "Density")
    mesh("cube", (0, 0, 4), (8, 8, 4), fog)
    leaf = mesh("plane", (0, 0, -5), material=_cut_out(_leaf(), (0.1, 0.3, 0.03)), size=1)
    bark = principled(0.12, 0.08, 0.05)
    for x, y in ((-4.5, 3), (-3, 1), (-1.5, 4), (0, 2), (1.5, 5), (3, 2), (4.5, 4)):
        mesh("cylinder", (x, y, 2), material=bark, radius=0.2, depth=4)
        crown = mesh("ico_sphere", (x, y, 4.5), (1.5, 1.5, 1.25), subdivisions=3)
        crown.show_instancer_for_render = False
        grown = crown.modifiers.new("ParticleSystem", "PARTICLE_SYSTEM").particle_system.settings
        grown.type, grown.count, grown.render_type, grown.instance_object = "HAIR", 400, "OBJECT", leaf
        grown.particle_size, grown.size_random, grown.use_advanced_hair, grown.use_rotations = 0.15, 0.5, True, True
        grown.rotation_factor_random, grown.phase_factor_random = 1.0, 2.0
    light("SUN", (0, 0, 10), (1, -6, 5.5), 8, color=(1, 0.8, 0.55))


#: The scenes by name.
TUTORIALS = {
    "bars": Tutorial(bars),
    "window": Tutorial(window),
    "room": Tutorial(room),
    "underwater": Tutorial(underwater),
    "fortune_teller": Tutorial(fortune_teller, "what the ball gathers below it"),
    "ocean": Tutorial(ocean),
    "laser": Tutorial(laser, "the beam inside and behind the glass"),
    "gaussian_beam": Tutorial(gaussian_beam),
    "projector": Tutorial(projector),
    "fire": Tutorial(fire),
    "candles": Tutorial(candles),
    "forest": Tutorial(forest),
}
