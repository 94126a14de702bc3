# SPDX-License-Identifier: GPL-3.0-or-later
"""A hall of more than 500,000 triangles, with instances and modifiers, in fog: how long until there is something to see.

    python measure_large.py PICTURE.png [--passes 16] [--width 640] [--seconds 30] [--cancel 15]

Renders with the add-on's engine, as F12 does, and prints how long it read the scene, when pictures came, when it was done, and memory.
"""

import argparse
import math
import os
import resource
import sys
from pathlib import Path
from time import perf_counter

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import addon
import cycles_scenes as scenes
from addon import passes
from addon.engine import CovbeamEngine
from measure_glass_ball import save


def _stone(name, value):
    return scenes.material(name, ("ShaderNodeBsdfDiffuse", {"Color": (value, value, value, 1)}, "Surface"))


def make(width):
    """Columns, a statue and a glass ball on rough ground under a roof of slats, and a sun above."""
    scene = scenes.empty_scene(64)
    scene.render.resolution_x, scene.render.resolution_y = width, width * 9 // 16
    camera = scenes.look((-9.5, 2.6, 1.5), (1.5, 0.6, 2.4), 26)
    camera.data.clip_start = 0.01
    stone, dark = _stone("Stone", 0.5), _stone("Wood", 0.1)

    # 320,000 triangles of uneven ground.
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=400, y_subdivisions=400, size=24)
    ground = bpy.context.object
    ground.data.materials.append(stone)
    waves = ground.modifiers.new("Wave", "WAVE")
    waves.height, waves.width = 0.05, 2.0

    # 200,000 triangles of a statue.
    bpy.ops.mesh.primitive_monkey_add(size=1.6, location=(0.5, 0.2, 1.6), rotation=(0, 0, -1.4))
    statue = bpy.context.object
    statue.modifiers.new("Subdivision", "SUBSURF").levels = 4
    statue.modifiers["Subdivision"].render_levels = 4
    bpy.ops.object.shade_smooth()
    statue.data.materials.append(stone)

    # Forty columns are instances of one.
    bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=0.28, depth=5, location=(0, 0, -50))
    column = bpy.context.object
    column.data.materials.append(stone)
    points = [(x, y, 2.5) for x in range(-9, 11, 2) for y in (-4.5, -2.5, 4.5, 6.5)]
    mesh = bpy.data.meshes.new("Places")
    mesh.from_pydata([(x, y, z) for x, y, z in points], [], [])
    places = bpy.data.objects.new("Places", mesh)
    scene.collection.objects.link(places)
    places.instance_type, column.parent = "VERTS", places
    column.location = (0, 0, 0)

    # The roof: slats both ways, by arrays.
    for place, size, count, step in (
        ((-11.5, 1, 5.1), (1.2, 18, 0.1), 13, (2.0, 0, 0)),
        ((0, -7.5, 5.2), (26, 1.5, 0.1), 8, (0, 2.4, 0)),
    ):
        bpy.ops.mesh.primitive_cube_add(size=1, location=place)
        slat = bpy.context.object
        slat.scale = size
        slat.data.materials.append(dark)
        array = slat.modifiers.new("Array", "ARRAY")
        array.use_relative_offset, array.use_constant_offset = False, True
        array.constant_offset_displace = [s / length for s, length in zip(step, size)]
        array.count = count

    glass = ("ShaderNodeBsdfGlass", {"Color": (1, 1, 1, 1), "Roughness": 0.0, "IOR": 1.5}, "Surface")
    scenes.ball("Ball", (-4.2, 1.6, 1.1), 0.7, scenes.material("Glass", glass))
    fog = scenes.material("Fog", *scenes.fog((1, 1, 1), 0.06, 0.3))
    scenes.cube("Fog", (0, 1, 3.0), (24, 15.5, 6.4), fog)
    sun = scenes.lamp("SUN", (0, 0, 20), energy=5.0, angle=math.radians(0.5), color=(1.0, 0.85, 0.6))
    sun.rotation_euler = (math.radians(25), math.radians(22), 0)
    return scene


def main(words):
    """Renders, and prints the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("picture", type=Path)
    parser.add_argument("--passes", type=int, default=16)
    parser.add_argument("--width", type=int, default=640)
    parser.add_argument("--seconds", type=float, default=0.0, help="time limit; 0: none")
    parser.add_argument("--cancel", type=float, help="seconds after which Esc is pressed")
    arguments = parser.parse_args(words)
    addon.register()
    scene = make(arguments.width)
    scene.render.engine = "COVBEAM"
    scene.covbeam.passes, scene.covbeam.time_limit = arguments.passes, arguments.seconds
    path = arguments.picture.with_suffix(".exr")
    scene.render.filepath = str(path)
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    shown = []
    put = passes.put
    passes.put = lambda *given: (put(*given), shown.append(perf_counter()))
    start = perf_counter()
    if arguments.cancel:
        CovbeamEngine.goes_on = lambda engine: perf_counter() < start + arguments.cancel
    bpy.ops.render.render(write_still=True)
    done = perf_counter() - start
    latest = addon.latest.get()
    print("\n".join([latest.outcome.value, latest.error, *latest.figures, *latest.untranslated]))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    seen = ", ".join(f"{at - start:.1f}" for at in shown[:3])
    print(f"pictures after {seen} ... s, done after {done:.2f} s; peak memory {peak:.2f} GB, {before:.2f} GB before the render")
    save(arguments.picture, scenes.read_exr(str(path)))
    path.unlink()
    arguments.picture.with_suffix(".npy").unlink()
    sys.stdout.flush()
    # The bpy package of Blender 4.2 crashes when Python ends after a class was registered.
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1:])
