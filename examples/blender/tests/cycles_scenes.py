# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender scenes that Cycles and covbeam can both render, and Cycles' pictures of them."""

import os
import tempfile

import bpy
import numpy as np
from mathutils import Matrix, Vector


def empty_scene(size, samples=64, seed=0):
    """A new file with an empty scene for Cycles, `size` x `size` pixels, that follows light as far as it goes."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = False
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed = samples, seed
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces"):
        setattr(cycles, name, 128)
    cycles.transparent_max_bounces = 128
    # A box filter a pixel wide: what a pixel's mean is.
    cycles.pixel_filter_type = "BOX"
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    return scene


def look(location, target, lens=50.0):
    """Adds the scene's camera."""
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    camera = bpy.data.objects.new("Camera", data)
    camera.location = location
    camera.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    return camera


def lamp(kind, location, target=(0, 0, 0), **values):
    """Adds a light of Blender's kind that points at `target`."""
    data = bpy.data.lights.new(kind.title(), kind)
    for name, value in values.items():
        setattr(data, name, value)
    light = bpy.data.objects.new(kind.title(), data)
    light.location = location
    light.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(light)
    return light


def material(name, *nodes):
    """A material of (node type, {input: value}, output socket) triples; shaders of one output are added."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    wire(made, nodes)
    return made


def wire(owner, nodes):
    """Replaces all nodes of a material or world."""
    tree = owner.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputWorld" if isinstance(owner, bpy.types.World) else "ShaderNodeOutputMaterial")
    for type_, values, socket in nodes:
        node = tree.nodes.new(type_)
        for name, value in values.items():
            node.inputs[name].default_value = value
        shader = node.outputs[0]
        if output.inputs[socket].is_linked:
            add = tree.nodes.new("ShaderNodeAddShader")
            tree.links.new(output.inputs[socket].links[0].from_socket, add.inputs[0])
            tree.links.new(shader, add.inputs[1])
            shader = add.outputs[0]
        tree.links.new(shader, output.inputs[socket])


def fog(scatter=(1, 1, 1), density=0.2, anisotropy=0.0, absorption=(1, 1, 1), absorbed=0.0):
    """Node triples of a homogeneous medium."""
    nodes = [
        (
            "ShaderNodeVolumeScatter",
            {"Color": (*scatter, 1), "Density": density, "Anisotropy": anisotropy},
            "Volume",
        )
    ]
    if absorbed:
        nodes.append(("ShaderNodeVolumeAbsorption", {"Color": (*absorption, 1), "Density": absorbed}, "Volume"))
    return nodes


def ball(name, location, radius, made, subdivisions=6):
    """Adds a smooth ball."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=radius, location=location)
    thing = bpy.context.object
    thing.name = name
    thing.data.materials.append(made)
    thing.data.shade_smooth()
    return thing


def cube(name, location, size, made):
    """Adds a box of edges `size`."""
    bpy.ops.mesh.primitive_cube_add(size=1, location=location)
    thing = bpy.context.object
    thing.name, thing.scale = name, size
    thing.data.materials.append(made)
    return thing


def to_unit(box):
    """Makes a box's own space go from -1 to 1, where gradients end."""
    box.data.transform(Matrix.Diagonal((2, 2, 2, 1)))
    return box


def moves(thing, path, *values, every=1.0, axis=0):
    """Keys a property of a thing so that it goes through values from frame 1 on, as evenly as a clock."""
    for count, value in enumerate(values):
        getattr(thing, path)[axis] = value
        thing.keyframe_insert(path, index=axis, frame=1 + count * every)
    action = thing.animation_data.action
    curves = action.fcurves if hasattr(action, "fcurves") else action.layers[0].strips[0].channelbags[0].fcurves
    for curve in curves:
        curve.extrapolation = "LINEAR"
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def picture_of_the_sky(world, cells, rotation=(0, 0, 0)):
    """A world that shines as a picture, (h, w, 3) from the top, turned by a Mapping node."""
    wire(world, [("ShaderNodeBackground", {}, "Surface")])
    height, width, _ = cells.shape
    image = bpy.data.images.new("Sky", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = cells[::-1]
    image.pixels.foreach_set(pixels.reshape(-1))
    image.update()
    tree = world.node_tree
    place, mapping, sky = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "Mapping", "TexEnvironment"))
    sky.image, sky.interpolation = image, "Closest"
    mapping.inputs["Rotation"].default_value = rotation
    tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], sky.inputs["Vector"])
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(sky.outputs["Color"], background.inputs["Color"])


BLACK = ("ShaderNodeBsdfDiffuse", {"Color": (0, 0, 0, 1)}, "Surface")


def cycles_picture(scene):
    """Renders with Cycles: radiance, float32 (h, w, 3), rows from the top."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "cycles.exr")
        settings = scene.render.image_settings
        if hasattr(settings, "media_type"):
            settings.media_type = "IMAGE"
        settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGB"
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        return read_exr(path)


def read_exr(path):
    """Pixels of an EXR file of one layer: float32 (h, w, 3), rows from the top."""
    image = bpy.data.images.load(path)
    try:
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        return pixels.reshape(height, width, -1)[::-1, :, :3].copy()
    finally:
        bpy.data.images.remove(image)


def region_means(picture, across):
    """Means over across x across equal squares: float64 (across^2, 3)."""
    height, width, _ = picture.shape
    squares = picture.astype(np.float64).reshape(across, height // across, across, width // across, 3)
    return squares.mean(axis=(1, 3)).reshape(-1, 3)
