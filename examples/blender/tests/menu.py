# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's menus add to a scene, with what they give it but for what is said: for scenes that are made as people make them."""

import bpy
import cycles_scenes as scenes
from fog_light import Tree
from mathutils import Vector


def factory(width):
    """The factory's scene without its cube and lamp, `width` x 9/16 of it pixels, rendered by Cycles as Blender sets it."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    scene = bpy.context.scene
    for thing in ("Cube", "Light"):
        bpy.data.objects.remove(bpy.data.objects[thing])
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = width, round(width * 9 / 16)
    return scene


def facing(place, target):
    return (Vector(target) - Vector(place)).to_track_quat("-Z", "Y").to_euler()


def look(scene, place, target, lens=50.0):
    """Moves the factory's camera."""
    scene.camera.location, scene.camera.rotation_euler = place, facing(place, target)
    scene.camera.data.lens = lens


def light(kind, place, target, energy, **settings):
    """A lamp of Blender's menu, with what the menu gives it but for `settings`."""
    bpy.ops.object.light_add(type=kind, location=place, rotation=facing(place, target))
    lamp = bpy.context.object
    lamp.data.energy = energy
    for name, value in settings.items():
        setattr(lamp.data, name, value)
    return lamp


def mesh(kind, place, scale=(1, 1, 1), material=None, rotation=(0, 0, 0), **options):
    """A mesh of Blender's menu, scaled as an object."""
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(location=place, rotation=rotation, **options)
    thing = bpy.context.object
    thing.scale = scale
    if material is not None:
        thing.data.materials.append(material)
    return thing


def material(kind, socket="Surface", **values):
    """A material of one shader node; values: of its inputs, by name with _ for spaces."""
    return scenes.material("Material", (f"ShaderNode{kind}", {name.replace("_", " "): value for name, value in values.items()}, socket))


def principled(*colour, **values):
    return material("BsdfPrincipled", Base_Color=(*colour, 1), **values)


def haze(density, **values):
    return material("VolumePrincipled", "Volume", Density=density, **values)


def night(scene):
    """The world's Strength at 0."""
    scene.world.use_nodes = True
    Tree(scene.world.node_tree).found("BACKGROUND").inputs["Strength"].default_value = 0.0


def world_fog(scene, density, **values):
    scene.world.use_nodes = True
    tree = Tree(scene.world.node_tree)
    tree.link(tree.node("VolumeScatter", {"Density": density, **values}).outputs[0], tree.found("OUTPUT_WORLD"), "Volume")


def cut_window(room, place, scale):
    """Cuts a box out of a room, by a Boolean modifier."""
    cutter = mesh("cube", place, scale)
    cutter.display_type, cutter.hide_render = "WIRE", True
    cut = room.modifiers.new("Boolean", "BOOLEAN")
    cut.object = cutter
