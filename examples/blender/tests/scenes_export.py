# SPDX-License-Identifier: GPL-3.0-or-later
"""Small Blender scenes made by script, and what Cycles shows of them."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector


def empty():
    """A scene with nothing in it but a camera, rendered by Cycles; returns the scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.sample_clamp_indirect = 0
    scene.cycles.light_sampling_threshold = 0
    # A box of one pixel: means of regions are then means over what they show.
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.camera = add(bpy.data.cameras.new("Camera"))
    return scene


def march_volumes():
    """Lets Cycles go through volumes by steps, as it did before Blender 5.0: to find out first how dense they are where takes it ten
    times as long as a small picture."""
    if bpy.app.version >= (5, 0, 0):
        bpy.context.scene.cycles.volume_biased = True


def add(data, name=None, **settings):
    """Links a new object with this data to the scene; `settings` are set on the object."""
    thing = bpy.data.objects.new(name or (data.name if data is not None else "Empty"), data)
    bpy.context.scene.collection.objects.link(thing)
    for key, value in settings.items():
        setattr(thing, key, value)
    return thing


def look(thing, position, target):
    """Puts a camera or light at `position`, directed at `target`."""
    forward = (Vector(target) - Vector(position)).normalized()
    thing.location = position
    thing.rotation_euler = forward.to_track_quat("-Z", "Y").to_euler()


def grid(name="Grid", size=1.0, material=None):
    """A square of edge `size` around the origin, its front up."""
    s = size / 2
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], [], [(0, 1, 2, 3)])
    if material is not None:
        mesh.materials.append(material)
    return add(mesh)


def box(name="Box", low=(-1, -1, -1), high=(1, 1, 1), material=None):
    """A box between two corners, faces to the outside."""
    mesh = bpy.data.meshes.new(name)
    corners = [[(low, high)[(k >> axis) & 1][axis] for axis in range(3)] for k in range(8)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    mesh.from_pydata(corners, [], faces)
    if material is not None:
        mesh.materials.append(material)
    return add(mesh)


def tree_of(block):
    """The node tree of a material, world or light, emptied."""
    if block.node_tree is None or bpy.app.version < (5, 0) or isinstance(block, bpy.types.Light):
        block.use_nodes = True
    block.node_tree.nodes.clear()
    return block.node_tree


def node(tree, kind, inputs=(), **settings):
    """A new node of type ShaderNode`kind`; inputs: values by identifier."""
    made = tree.nodes.new(f"ShaderNode{kind}")
    for key, value in settings.items():
        setattr(made, key, value)
    for identifier, value in dict(inputs).items():
        socket = next(s for s in made.inputs if s.identifier == identifier)
        socket.default_value = (*value, 1) if socket.type == "RGBA" and len(value) == 3 else value
    return made


def material(name, surface=None, volume=None):
    """A material; surface, volume: functions of its tree that return the shader node, or None."""
    block = bpy.data.materials.new(name)
    tree = tree_of(block)
    output = node(tree, "OutputMaterial")
    _connect(tree, output, surface, volume)
    return block


def world(surface=None, volume=None):
    """Gives the scene a world; arguments as of `material`."""
    block = bpy.data.worlds.new("World")
    tree = tree_of(block)
    output = node(tree, "OutputWorld")
    _connect(tree, output, surface, volume)
    bpy.context.scene.world = block
    return block


def _connect(tree, output, surface, volume):
    for name, make in (("Surface", surface), ("Volume", volume)):
        if make is not None:
            tree.links.new(make(tree).outputs[0], output.inputs[name])


def shader(kind, inputs=(), **settings):
    """A function for `material` and `world` that makes one node."""
    return lambda tree: node(tree, kind, inputs, **settings)


def joined(kind, first, second, factor=None):
    """The same for MixShader or AddShader of two such functions."""

    def make(tree):
        both = node(tree, kind)
        if factor is not None:
            both.inputs[0].default_value = factor
        start = 1 if kind == "MixShader" else 0
        for k, each in enumerate((first, second)):
            tree.links.new(each(tree).outputs[0], both.inputs[start + k])
        return both

    return make


def cycles(samples, width=4, height=4):
    """What Cycles renders, of the border if there is one: linear Rec. 709, (rows, columns, 3), top row first."""
    scene = bpy.context.scene
    scene.cycles.samples = samples
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "image.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        width, height = image.size
        bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[::-1, :, :3].astype(np.float64)


def cycles_at(point, samples=256, above=1.0, size=1e-3):
    """Mean of what Cycles shows of a tiny square around `point`, seen straight down from `above` it [m]: (3,)."""
    eye = bpy.context.scene.camera
    eye.data.type, eye.data.ortho_scale = "ORTHO", size
    eye.location = Vector(point) + Vector((0, 0, above))
    return cycles(samples).mean(axis=(0, 1))


def exported():
    """What `export` makes of the scene, seen by a camera that it can use: host.scene.Scene, Report."""
    from addon.export.scene import export

    scene = bpy.context.scene
    kept = scene.camera
    scene.camera = scene.camera or add(bpy.data.cameras.new("Camera"))
    kind, scene.camera.data.type = scene.camera.data.type, "PERSP"
    bpy.context.view_layer.update()
    try:
        return export(bpy.context.evaluated_depsgraph_get())
    finally:
        scene.camera.data.type = kind
        scene.camera = kept
