# SPDX-License-Identifier: GPL-3.0-or-later
"""A program for Blender: renders what a Sky Texture looks like. Its arguments: the node's settings as JSON, and a folder for
other_blender.answered."""

import json
import sys
from math import pi
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

#: Pixels across the sky, and across its sun.
COLUMNS, SUN = 1024, 64


def scene_of(settings):
    """A scene with nothing in it but the sky; returns it and the node."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", 4
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = False
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGB"
    scene.world = bpy.data.worlds.new("World")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    # Nothing is lit here.
    scene.world.cycles.sampling_method = "NONE"
    tree = scene.world.node_tree
    tree.nodes.clear()
    background, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Background", "OutputWorld"))
    sky = tree.nodes.new("ShaderNodeTexSky")
    for name, value in settings.items():
        setattr(sky, name, value)
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    return scene, sky


def render(scene, width, height, folder):
    """Its picture: float32 (h, w, 3), rows from the top."""
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.filepath = str(folder / "sky.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[::-1, :, :3]


def whole(scene, folder):
    """Radiance from all directions, as host.scene.Light has it."""
    camera = scene.camera.data
    camera.type = "PANO"
    # Until Blender 4 it was a setting of Cycles'.
    (camera if hasattr(camera, "panorama_type") else camera.cycles).panorama_type = "EQUIRECTANGULAR"
    # Along +X, with +Z up.
    scene.camera.rotation_euler = (pi / 2, 0, -pi / 2)
    return render(scene, COLUMNS, COLUMNS // 2, folder)


def sun(scene, sky, direction, size, folder):
    """Irradiance [W/m^2] across the direction that the disc of this size [rad] is in."""
    camera = scene.camera.data
    camera.type, camera.sensor_fit, camera.lens_unit = "PERSP", "AUTO", "FOV"
    camera.angle = min(1.2 * size, 2.8)
    scene.camera.rotation_euler = Vector(direction).to_track_quat("-Z", "Y").to_euler()
    pictures = []
    for shown in (True, False):
        sky.sun_disc = shown
        pictures.append(render(scene, SUN, SUN, folder).astype(np.float64))
    reach = np.tan(camera.angle / 2)
    x, y = np.meshgrid(*[(np.arange(SUN) + 0.5) / SUN * 2 * reach - reach] * 2)
    # Solid angle of a pixel, times its cosine.
    shares = (2 * reach / SUN) ** 2 / (1 + x * x + y * y) ** 2
    return np.einsum("yxc,yx->c", pictures[0] - pictures[1], shares)


def main(settings, folder):
    """Renders and writes: the answer has the sun's `irradiance`, the array is all else."""
    folder = Path(folder)
    direction, space, size = settings.pop("direction"), settings.pop("space"), settings.get("sun_size", 0.0)
    has_sun = settings.get("sun_disc", False) and size > 0
    scene, sky = scene_of(settings)
    # Before Blender 5.0 there is one only.
    if bpy.app.version >= (5, 0):
        bpy.ops.wm.set_working_color_space(working_space=space)
    irradiance = sun(scene, sky, direction, size, folder) if has_sun else np.zeros(3)
    if hasattr(sky, "sun_disc"):
        sky.sun_disc = False
    # Without the disc it is smooth.
    scene.cycles.samples = 1
    cells = whole(scene, folder)
    cells.astype("<f4").tofile(folder / "0.f32")
    (folder / "answer.json").write_text(json.dumps({"irradiance": irradiance.tolist(), "shapes": [cells.shape]}))


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    main(json.loads(arguments[0]), arguments[1])
