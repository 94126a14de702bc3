# SPDX-License-Identifier: GPL-3.0-or-later
"""Thirteen scenes that artists light fog with, on whole and half metres, many of them without glass or mirrors: what covbeam is measured on beside
Cycles and its denoiser. For measure_people.py."""

from dataclasses import dataclass
from math import radians
from typing import Callable

import bpy
import cycles_scenes as scenes
import numpy as np
from fog_light import Tree
from menu import cut_window, factory, haze, light, look, material, mesh, night, principled


@dataclass(frozen=True)
class Person:
    """A scene: what builds it, and whether Cycles lacks much of its fog light, which came by way of glass, mirrors or water."""

    build: Callable
    focuses: bool = False


def make(name, width):
    """The Blender scene of a name, `width` x 9/16 of it pixels, all orders of scattering in its fog; Cycles keeps its fog's light in passes."""
    scene = factory(width)
    passes = scene.view_layers[0].cycles
    passes.use_pass_volume_direct = passes.use_pass_volume_indirect = True
    scene.cycles.volume_bounces = scene.cycles.max_bounces = 12
    # Filter Glossy takes a hundredth of the light that fog gets from glossy floors.
    scene.cycles.blur_glossy = 0
    # Covbeam's pixels are squares: Cycles' own filter would count as an error at each edge.
    scene.cycles.pixel_filter_type = "BOX"
    PEOPLE[name].build(scene)
    return scene


def _floor(*colour):
    """A floor a hair above where the fog ends: where both are in one plane Cycles, which is the reference, loses half of the light of the floor."""
    mesh("plane", (0, 0, 0.01), material=principled(*colour), size=20)


def _faces(name, corners, made):
    """A mesh of triangles or squares of their own corners, (n, 3 or 4, 3)."""
    count, sides, _ = corners.shape
    shape = bpy.data.meshes.new(name)
    shape.from_pydata(corners.reshape(-1, 3).tolist(), [], np.arange(count * sides).reshape(count, sides).tolist())
    shape.materials.append(made)
    thing = bpy.data.objects.new(name, shape)
    bpy.context.collection.objects.link(thing)
    return thing


def _turned(count, random):
    """Two unit vectors across each other, of any direction, (count, 3) each."""
    first, other = random.normal(size=(2, count, 3))
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    other = np.cross(first, other)
    return first, other / np.linalg.norm(other, axis=1, keepdims=True)


def _crown(count, size, sides):
    """Leaves in three crowns side by side, a third of them in each: cards or triangles of a size."""
    random = np.random.default_rng(3)
    inside = random.normal(size=(count, 3))
    inside *= (random.random((count, 1)) ** (1 / 3)) / np.linalg.norm(inside, axis=1, keepdims=True)
    middles = np.array([(-3.0, 1, 4), (0, 2, 4.5), (3, 1, 4)])[np.arange(count) % 3]
    places = middles + inside * (1.5, 1.5, 1.25)
    right, up = _turned(count, random)
    around = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])[:sides]
    corners = places[:, None] + size * (around[None, :, :1] * right[:, None] + around[None, :, 1:] * up[:, None])
    _faces("Leaves", corners, principled(0.1, 0.3, 0.05))


def _wood(scene, count, size, sides):
    night(scene)
    look(scene, (0, -9, 1.5), (0, 0, 2), 28)
    _floor(0.2, 0.2, 0.1)
    mesh("cube", (0, 0, 3), (6, 4, 3), haze(0.08, Anisotropy=0.5))
    for x, y in ((-3, 1), (0, 2), (3, 1)):
        mesh("cylinder", (x, y, 2), material=principled(0.15, 0.1, 0.05), radius=0.25, depth=4)
    _crown(count, size, sides)
    light("SUN", (0, 0, 10), (2, -4, 4), 6, color=(1, 0.85, 0.6))


def slats(scene):
    """A spot of 1000 W behind a blind of twelve slats."""
    night(scene)
    look(scene, (0, -7, 1.5), (0, 0, 1.5), 30)
    _floor(0.5, 0.5, 0.5)
    mesh("cube", (0, 0, 2), (4, 3, 2), haze(0.1))
    for row in range(12):
        mesh("cube", (1, 0, 0.75 + 0.25 * row), (0.05, 1.5, 0.05), principled(0.2, 0.2, 0.2))
    light("SPOT", (3.5, 0, 3), (-1, 0, 1), 1000, spot_size=radians(60), shadow_soft_size=0.05)


def cards(scene):
    """Sun through 120 leaves of half a metre."""
    _wood(scene, 120, 0.5, 4)


def leaves(scene):
    """Sun through 20,000 triangles."""
    _wood(scene, 20_000, 0.15, 3)


def posts(scene):
    """Five posts in fog under a picture of a sky: bright clouds on blue, a sun behind one of them."""
    y, x = np.mgrid[:64, :128] / 64.0
    clouds = np.clip(np.sin(12 * x + 3 * np.sin(9 * y)) * np.sin(20 * y + 2 * np.sin(8 * x)), 0, 1)
    sky = np.array([0.15, 0.3, 0.7]) + clouds[..., None] * (0.9, 0.8, 0.6)
    sky[34:] = 0.05, 0.05, 0.04
    sky[24:28, 60:66] = 60, 50, 35
    scenes.picture_of_the_sky(scene.world, sky)
    look(scene, (0, -8, 1.5), (0, 0, 1.5), 32)
    _floor(0.3, 0.3, 0.25)
    for x in (-3, -1.5, 0, 1.5, 3):
        mesh("cylinder", (x, 0.5 * abs(x), 1.5), material=principled(0.3, 0.2, 0.1), radius=0.125, depth=3)
    mesh("cube", (0, 0, 2), (5, 4, 2), haze(0.1, Anisotropy=0.3))


def wine(scene):
    """A glass with wine in it that touches it, and a bubble in the wine, under a spot."""
    night(scene)
    look(scene, (0, -3, 1.25), (0, 0, 0.75), 45)
    _floor(0.6, 0.6, 0.6)
    mesh("cube", (0, 0, 1), (1.5, 1.5, 1), haze(0.3))

    def glass(*colour, index=1.45):
        return material("BsdfGlass", Color=(*colour, 1), Roughness=0.0, IOR=index)

    for radius, made in ((0.5, glass(1, 1, 1)), (0.45, glass(0.7, 0.05, 0.1, index=1.33)), (0.1, glass(1, 1, 1, index=1.0))):
        mesh("uv_sphere", (0, 0, 0.75), material=made, radius=radius, segments=48, ring_count=24).data.shade_smooth()
    mesh("cylinder", (0, 0, 0.125), material=glass(1, 1, 1), radius=0.05, depth=0.25)
    light("SPOT", (1.5, -0.5, 2), (0, 0, 0.75), 200, spot_size=radians(40), shadow_soft_size=0.02)


def _rig(rows, columns, energy, colours):
    """Spots in a row of rows under a ceiling, straight down."""
    for row in range(rows):
        for column in range(columns):
            place = (8 * (column + 0.5) / columns - 4, 4 * (row + 0.5) / rows - 1, 4)
            colour = colours[(row + column) % len(colours)]
            spot = {"color": colour, "spot_size": radians(25), "spot_blend": 0.25, "shadow_soft_size": 0.02}
            light("SPOT", place, (place[0] + 0.5 * (column % 3 - 1), place[1], 0), energy, **spot)


def rig(scene):
    """A stage under 60 spots of four colours."""
    night(scene)
    look(scene, (0, -7, 1.5), (0, 0, 2), 28)
    _floor(0.1, 0.1, 0.1)
    mesh("cube", (0, 0.5, 2.1), (5, 3, 2.1), haze(0.06))
    mesh("cube", (0, 1, 0.5), (1, 0.5, 0.5), principled(0.5, 0.5, 0.5))
    _rig(5, 12, 100, ((1, 0.1, 0.1), (0.1, 0.3, 1), (1, 0.6, 0.1), (0.2, 1, 0.3)))


def lamps(scene):
    """300 bulbs on strings over a street."""
    night(scene)
    look(scene, (0, -8, 1.5), (0, 0, 2.5), 28)
    _floor(0.2, 0.2, 0.2)
    mesh("cube", (0, 2, 2.5), (5, 6, 2.5), haze(0.05))
    for index in range(300):
        row, column = divmod(index, 25)
        light("POINT", (column / 3 - 4, row - 3, 4 - 0.5 * np.sin(np.pi * column / 24)), (0, 0, 0), 4, color=(1, 0.7, 0.4), shadow_soft_size=0.03)


def headlight(scene):
    """A bulb in the focus of a parabola of metal, 0.2 m wide."""
    night(scene)
    look(scene, (0, -4, 1.5), (0, 0, 1), 32)
    _floor(0.3, 0.3, 0.3)
    mesh("cube", (0, 0, 1), (3, 1.5, 1), haze(0.15))
    rings, around, focus = 24, 64, 0.06
    radius = np.linspace(0.02, 0.2, rings)
    angle = np.linspace(0, 2 * np.pi, around + 1)[:-1]
    points = np.stack([np.repeat(radius**2 / (4 * focus), around), np.outer(radius, np.cos(angle)).ravel(), np.outer(radius, np.sin(angle)).ravel()], 1)
    at = np.arange(rings * around).reshape(rings, around)
    nexts = np.roll(at, -1, axis=1)
    faces = np.stack([at[:-1], nexts[:-1], nexts[1:], at[1:]], -1).reshape(-1, 4)
    shape = bpy.data.meshes.new("Reflector")
    shape.from_pydata((points + (-2.5, 0, 1)).tolist(), [], faces.tolist())
    shape.materials.append(material("BsdfGlossy", Color=(0.9, 0.9, 0.9, 1), Roughness=0.0))
    shape.shade_smooth()
    bpy.context.collection.objects.link(bpy.data.objects.new("Reflector", shape))
    light("POINT", (-2.5 + focus, 0, 1), (0, 0, 0), 100, shadow_soft_size=0.01)
    mesh("cube", (1, 0, 0.5), (0.25, 0.25, 0.5), principled(0.5, 0.5, 0.5))


def pool(scene):
    """In a pool, under waves of water that a sun shines through."""
    night(scene)
    look(scene, (0, -3.5, -1.5), (0, 0, -1), 24)
    sea = mesh("grid", (0, 0, 0), x_subdivisions=64, y_subdivisions=64, size=10)
    for point in sea.data.vertices:
        x, y, _ = point.co
        point.co.z = 0.05 * (np.sin(4 * x + y) + np.sin(3 * y - 2 * x) + 0.5 * np.sin(7 * x))
    sea.data.shade_smooth()
    sea.data.materials.append(material("BsdfGlass", Roughness=0.0, IOR=1.33))
    water = material("VolumeScatter", "Volume", Color=(0.5, 0.8, 1, 1), Density=0.15)
    mesh("cube", (0, 0, -1.25), (4, 4, 1.25), water)
    mesh("plane", (0, 0, -2.5), material=principled(0.6, 0.7, 0.7), size=20)
    light("SUN", (0, 0, 10), (-2, 1, 0), 5, angle=radians(0.5))


def hall(scene):
    """A hall with four windows and a sun."""
    night(scene)
    look(scene, (-3, -4, 1.5), (1, 1, 1.5), 22)
    walls = mesh("cube", (0, 0, 2), (4, 5, 2), principled(0.6, 0.55, 0.5))
    walls.modifiers.new("Solidify", "SOLIDIFY").thickness = -0.25
    for y in (-3, -1, 1, 3):
        cut_window(walls, (4, y, 2.25), (1, 0.5, 1))
    # A hair larger than the room, for the same reason as above.
    mesh("cube", (0, 0, 2), (4.01, 5.01, 2.01), haze(0.06, Anisotropy=0.3))
    light("SUN", (10, 0, 10), (0, 2, 1), 20, color=(1, 0.9, 0.7))


def cloud(scene):
    """A cloud of 3 m, 6 of its mean free paths wide, with edges by a noise, in the sun."""
    look(scene, (0, -7, 2), (0, 0, 2), 40)
    made = haze(0.0, Anisotropy=0.6)
    tree = Tree(made.node_tree)
    noise = tree.node("TexNoise", {"Scale": 1.5})
    place = tree.node("TexCoord")
    tree.link(place.outputs["Object"], noise, "Vector")
    length = tree.node("VectorMath", operation="LENGTH")
    tree.link(place.outputs["Object"], length, 0)
    edge, thick = tree.node("Math", operation="SUBTRACT"), tree.node("Math", {1: 20.0}, operation="MULTIPLY")
    bend = tree.node("Math", {1: 1.4, 2: 0.1}, operation="MULTIPLY_ADD")
    tree.link(noise.outputs["Factor" if "Factor" in noise.outputs else "Fac"], bend, 0)
    tree.link(bend.outputs[0], edge, 0)
    tree.link(length.outputs["Value"], edge, 1)
    tree.link(edge.outputs[0], thick, 0)
    most = tree.node("Clamp", {"Max": 4.0})
    tree.link(thick.outputs[0], most)
    tree.link(most.outputs[0], tree.found("PRINCIPLED_VOLUME"), "Density")
    mesh("cube", (0, 0, 2), (1.5, 1.5, 1.5), made)
    light("SUN", (0, 0, 10), (2, 2, 0), 5)


def coloured(scene):
    """Green fog, whose channels are 8 to 1 apart, with a spot in it and a block in its light."""
    night(scene)
    look(scene, (0, -5, 1.5), (0, 0, 1), 32)
    _floor(0.5, 0.5, 0.5)
    made = material("VolumeScatter", "Volume", Color=(0.125, 1, 0.25, 1), Density=0.5)
    mesh("cube", (0, 0, 1.5), (3, 2, 1.5), made)
    mesh("cube", (0, 0, 0.75), (0.25, 0.25, 0.25), principled(0.2, 0.2, 0.2))
    light("SPOT", (2, 0, 2.5), (0, 0, 0.75), 500, spot_size=radians(45), shadow_soft_size=0.05)


def figurine(scene):
    """A monkey of glass among four posts."""
    night(scene)
    look(scene, (0, -5, 1.5), (0, 0, 1), 35)
    _floor(0.5, 0.5, 0.5)
    mesh("cube", (0, 0, 1.5), (3, 2, 1.5), haze(0.1))
    glass = material("BsdfGlass", Roughness=0.0, IOR=1.5)
    monkey = mesh("monkey", (0, 0, 1), material=glass, size=1.5)
    finer = monkey.modifiers.new("Subdivision", "SUBSURF")
    finer.levels = finer.render_levels = 2
    monkey.data.shade_smooth()
    for x, y in ((-1.5, -0.5), (1.5, -0.5), (-1.5, 1), (1.5, 1)):
        mesh("cylinder", (x, y, 1), material=principled(0.3, 0.3, 0.35), radius=0.1, depth=2)
    light("SPOT", (1.5, -1.5, 3.5), (0, 0, 1), 500, spot_size=radians(40), shadow_soft_size=0.02)


#: The scenes by name.
PEOPLE = {
    "slats": Person(slats),
    "cards": Person(cards),
    "leaves": Person(leaves),
    "posts": Person(posts),
    "wine": Person(wine, focuses=True),
    "rig": Person(rig),
    "lamps": Person(lamps),
    "headlight": Person(headlight, focuses=True),
    "pool": Person(pool, focuses=True),
    "hall": Person(hall),
    "cloud": Person(cloud),
    "coloured": Person(coloured),
    "figurine": Person(figurine, focuses=True),
}
