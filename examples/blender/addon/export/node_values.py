# SPDX-License-Identifier: GPL-3.0-or-later
"""A program for Blender: has Cycles compute shader nodes at places. Its argument: a folder for other_blender.Helper."""

import json
import os
import shutil
import sys
from pathlib import Path

import bpy
import numpy as np

#: Where in its pixel the triangle of a place is.
_TRIANGLE = np.array([[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]])

#: Pixels across a picture of few places, and of many.
_FEW, _MANY = 256, 1024


def empty_scene():
    """A scene with nothing in it, in which a bake looks once at each pixel."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", 1
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    return scene


def triangles(arrays, count, width, height):
    """A mesh of one triangle a place, each across a pixel of its own: what a face has is the same all over it, and nothing is interpolated.

    arrays: by name, (count, 1) or (count, 3).
    """
    mesh = bpy.data.meshes.new("Places")
    mesh.vertices.add(3)
    mesh.loops.add(3 * count)
    mesh.polygons.add(count)
    mesh.vertices.foreach_set("co", [0, 0, 0, 1, 0, 0, 0, 1, 0])
    mesh.loops.foreach_set("vertex_index", np.tile(np.arange(3, dtype=np.int32), count))
    mesh.polygons.foreach_set("loop_start", np.arange(count, dtype=np.int32) * 3)
    pixels = np.stack([np.arange(count) % width, np.arange(count) // width], axis=1)
    places = (pixels[:, None] + _TRIANGLE) / (width, height)
    mesh.attributes.new("UVMap", "FLOAT2", "CORNER").data.foreach_set("vector", places.astype(np.float32).ravel())
    for name, values in arrays.items():
        kind, field = ("FLOAT", "value") if values.shape[1] == 1 else ("FLOAT_VECTOR", "vector")
        mesh.attributes.new(name, kind, "FACE").data.foreach_set(field, values.ravel())
    mesh.update(calc_edges=False)
    return mesh


def set_all(thing, settings):
    """Sets properties by name; what is a dict is one with properties of its own."""
    for name, value in settings.items():
        if isinstance(value, dict):
            set_all(getattr(thing, name), value)
        else:
            setattr(thing, name, value)


def set_ramp(ramp, described):
    """Makes a colour ramp as it is described."""
    set_all(ramp, described["settings"])
    for _ in described["elements"][2:]:
        ramp.elements.new(1.0)
    if len(described["elements"]) == 1:
        ramp.elements.remove(ramp.elements[1])
    for element, (place, colour) in zip(ramp.elements, described["elements"]):
        element.position, element.color = place, colour


def set_curves(mapping, described):
    """Makes a curve mapping as it is described."""
    set_all(mapping, described["settings"])
    for curve, points in zip(mapping.curves, described["curves"]):
        for _ in points[2:]:
            curve.points.new(1.0, 1.0)
        for point, (place, handle) in zip(curve.points, points):
            point.location, point.handle_type = place, handle
    mapping.update()


def image_of(described, folder):
    """A bpy.types.Image as it is described."""
    width, height = described["size"]
    image = bpy.data.images.new("Image", width, height, alpha=True, float_buffer=described["is_float"])
    image.colorspace_settings.name, image.alpha_mode = described["space"], described["alpha_mode"]
    image.pixels.foreach_set(np.fromfile(folder / "image.f32", "<f4"))
    image.update()
    image.pack()
    return image


def linked_value(tree, name, value):
    """The output of a node that gives `value`: a number or three, as they are, or the name of an attribute."""
    if value is None:
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = name
        return node
    numbers = []
    for number in value:
        node = tree.nodes.new("ShaderNodeValue")
        node.outputs[0].default_value = number
        numbers.append(node.outputs[0])
    if len(numbers) == 1:
        return numbers[0]
    node = tree.nodes.new("ShaderNodeCombineXYZ")
    for output, socket in zip(numbers, node.inputs):
        tree.links.new(output, socket)
    return node.outputs[0]


def find(sockets, identifier):
    """The socket of this identifier."""
    return next(s for s in sockets if s.identifier == identifier)


def node_of(tree, request, folder):
    """The node that is asked for, with its inputs linked."""
    node = tree.nodes.new(request["type"])
    set_all(node, request["settings"])
    if "ramp" in request:
        set_ramp(node.color_ramp, request["ramp"])
    if "curves" in request:
        set_curves(node.mapping, request["curves"])
    if "image" in request:
        node.image = image_of(request["image"], folder)
    for k, (identifier, channels, value) in enumerate(request["inputs"]):
        made = linked_value(tree, f"input {k}", value)
        if value is None:
            made = made.outputs["Fac" if channels == 1 else "Vector"]
        tree.links.new(made, find(node.inputs, identifier))
    return node


def computed(scene, request, folder):
    """What a node gives at all places: float32 (n, 3)."""
    # Before Blender 5.0 there is one only.
    if bpy.app.version >= (5, 0) and bpy.data.colorspace.working_space != request["space"]:
        bpy.ops.wm.set_working_color_space(working_space=request["space"])
    count = request["count"]
    width = min(count, _FEW if count <= _FEW * _FEW else _MANY)
    height = -(-count // width)
    arrays = {
        f"input {k}": np.fromfile(folder / f"{k}.f32", "<f4").reshape(count, channels)
        for k, (_, channels, value) in enumerate(request["inputs"])
        if value is None
    }
    mesh = triangles(arrays, count, width, height)
    material = bpy.data.materials.new("Material")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    target, emission, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Emission", "OutputMaterial"))
    target.image = bpy.data.images.new("Values", width, height, alpha=False, float_buffer=True, is_data=True)
    tree.nodes.active = target
    tree.links.new(find(node_of(tree, request, folder).outputs, request["output"]), emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    mesh.materials.append(material)
    thing = bpy.data.objects.new("Places", mesh)
    scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    bpy.ops.object.bake(type="EMIT", target="IMAGE_TEXTURES", save_mode="INTERNAL", margin=0, use_clear=False)
    pixels = np.empty(4 * width * height, np.float32)
    target.image.pixels.foreach_get(pixels)
    bpy.data.batch_remove([thing, mesh, material, *bpy.data.images])
    return pixels.reshape(-1, 4)[:count, :3]


def answer(scene, folder):
    """Answers the request that lies in the folder: values.f32, and then answer.json, which has an `error` if there is none."""
    said = {}
    try:
        values = computed(scene, json.loads((folder / "request.json").read_text()), folder)
        values.astype("<f4").tofile(folder / "values.f32")
    except Exception as reason:
        # Whatever Blender does not take: who asks is told.
        said = {"error": f"{type(reason).__name__}: {reason}"}
    (folder / "answer.part").write_text(json.dumps(said))
    os.replace(folder / "answer.part", folder / "answer.json")


def main(folder):
    """Answers a request for each line that comes, and ends with the Blender that asks."""
    scene = empty_scene()
    for _ in sys.stdin:
        answer(scene, folder)
    shutil.rmtree(folder, ignore_errors=True)
    # As a module Blender may crash as it ends.
    os._exit(0)


if __name__ == "__main__":
    main(Path(sys.argv[-1]))
