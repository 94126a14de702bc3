# SPDX-License-Identifier: GPL-3.0-or-later
"""Small foggy scenes in which one thing is changed, and the light of their fog by Cycles and by Add Beams. For walk.py."""

from pathlib import Path

import bpy
import cycles_scenes as scenes
import exr
import harness
import numpy as np
from mathutils import Euler

from addon import latest

#: Pixels along a picture, and along the blocks of which means are compared.
SIZE, BLOCKS = 32, 4

#: Samples of Cycles' pictures, and passes of covbeam's: of one of each for a look, and of two of each where they do not agree at once. Light paths
#: of a pass.
LOOK, AGAIN, _PHOTONS = (128, 6), (384, 20), 1000

#: Seeds of the two.
_SEEDS = (1, 2)

#: Names of Cycles' passes of fog light before Blender 5.0 and since.
_PASSES = ("VolumeDir", "VolumeInd", "Volume Direct", "Volume Indirect")


def stage(kind="SPOT"):
    """A box of fog on a grey floor, a ball in the beam of a lamp of some kind, a dim lamp beside it; the scene, for Cycles. Both lamps hang above the
    fog: fog next to a lamp is as bright as the noise of few samples."""
    scene = scenes.empty_scene(SIZE)
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.volume_bounces = 3
    # Whatever else the harness of tests asks of Cycles, this is what artists have.
    scene.cycles.glossy_bounces, scene.cycles.transmission_bounces, scene.cycles.transparent_max_bounces = 4, 12, 8
    scenes.look((0, -6, 1.8), (0, 0, 1.5), 32)
    grey = scenes.material("Grey", ("ShaderNodeBsdfDiffuse", {"Color": (0.4, 0.4, 0.4, 1)}, "Surface"))
    bpy.ops.mesh.primitive_plane_add(size=14)
    floor = bpy.context.object
    floor.name = "Floor"
    floor.data.materials.append(grey)
    scenes.cube("Fog", (0, 0, 1.77), (6, 5, 3.5), scenes.material("Mist", *scenes.fog(density=0.15)))
    bright = {"SPOT": 900, "POINT": 250, "AREA": 150, "SUN": 4}[kind]
    key = scenes.lamp(kind, (-1, 0, 4.6), (-0.3, 0, 0), energy=bright)
    key.name = "Key"
    if kind == "SPOT":
        key.data.spot_size, key.data.spot_blend = 0.7, 0.2
    if kind in ("SPOT", "POINT"):
        key.data.shadow_soft_size, key.data.use_soft_falloff = 0.05, False
    scenes.lamp("POINT", (1.8, 0.5, 4.3), energy=60, shadow_soft_size=0.05, use_soft_falloff=False).name = "Fill"
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=0.4, location=(-0.62, 0, 2.4))
    ball = bpy.context.object
    ball.name = "Ball"
    ball.data.shade_smooth()
    ball.data.materials.append(grey.copy())
    ball.data.materials[0].name = "Skin"
    layer = scene.view_layers[0]
    layer.cycles.use_pass_volume_direct = layer.cycles.use_pass_volume_indirect = True
    return scene


def card(made):
    """A square of a material in the beam of the lamp."""
    bpy.ops.mesh.primitive_plane_add(size=1.2, location=(-0.75, 0, 2.9), rotation=Euler((0.2, 0.1, 0)))
    bpy.context.object.name = "Card"
    bpy.context.object.data.materials.append(made)


def blocks(picture):
    """Means over equal blocks, (n, n, 3)."""
    height, width, _ = picture.shape
    ends = [np.linspace(0, size, BLOCKS + 1).astype(int) for size in (height, width)]
    return np.array([[picture[a:b, c:d].mean((0, 1)) for c, d in zip(ends[1], ends[1][1:])] for a, b in zip(ends[0], ends[0][1:])], float)


def by_cycles(scene, folder, effort=AGAIN):
    """Blocks of the fog's light by Cycles, and their standard error: two (n, n, 3); or None twice without such light. effort: LOOK, without an
    error, or AGAIN."""
    harness.write_exr(scene.render.image_settings)
    scene.render.engine, found = "CYCLES", []
    scene.cycles.samples = effort[0]
    for seed in _SEEDS[: 2 if effort is AGAIN else 1]:
        scene.cycles.seed = seed
        scene.render.filepath = str(Path(folder) / "cycles.exr")
        bpy.ops.render.render(write_still=True)
        planes = exr.read(Path(scene.render.filepath))
        layers = {tuple(name.split(".")[-2:]): values for name, values in planes.items()}
        # A setting may be one for which Cycles has no such pass: then there is no light of fog.
        light = sum(np.stack([layers[name, c] for c in "RGB"], -1).astype(float) for name in _PASSES if (name, "R") in layers)
        found.append(blocks(light) if np.ndim(light) else None)
    if found[0] is None:
        return None, None
    return _mean_and_error(found)


def _mean_and_error(found):
    """Of one picture of blocks or two: of one the error is none."""
    if len(found) == 1:
        return found[0], np.zeros_like(found[0])
    return (found[0] + found[1]) / 2, np.abs(found[0] - found[1]) / 2


class Answer:
    """What Add Beams made of a scene.

    picture: blocks of its fog light, (n, n, 3), or None; error: theirs between seeds; asks: entries of what is missing in fog; refused: why
    there is no picture, or empty.
    """

    def __init__(self, scene, folder, effort=AGAIN):
        settings = scene.covbeam
        settings.passes, settings.photons, settings.time_limit, settings.folder = effort[1], _PHOTONS, 0, str(folder)
        scene.render.image_settings.exr_codec = "NONE"
        found, self.asks, self.refused = [], [], ""
        layer = next(layer for layer in scene.view_layers if layer.use)
        seeds = _SEEDS[: 2 if effort is AGAIN else 1]
        for seed in seeds:
            settings.seed = seed
            for old in Path(folder).glob("beams_*.exr"):
                old.unlink()
            try:
                bpy.ops.covbeam.add_beams()
            except RuntimeError as error:
                self.refused = str(error).strip().removeprefix("Error: ")
                break
            self.asks = latest.missing_in_fog()
            if bpy.ops.covbeam.remove_beams.poll():
                bpy.ops.covbeam.remove_beams()
            path = Path(folder) / f"beams_{bpy.path.clean_name(layer.name)}_{scene.frame_current:04}.exr"
            if self.asks or not path.is_file():
                break
            planes = exr.read(path)
            found.append(blocks(np.stack([next(v for k, v in planes.items() if k.endswith(f"In-Scattered.{c}")) for c in "RGB"], -1).astype(float)))
        self.advice = list(latest.get().advice)
        self.entries = list(latest.get().untranslated)
        self.picture, self.error = _mean_and_error(found) if len(found) == len(seeds) else (None, None)


def differs(cycles, error, other, of_other):
    """How two pictures of blocks differ, as text, beyond their standard errors and 2 % of the mean (3 % of a block's light and 1 % of the mean
    in one block); empty: they do not."""
    mean = max(float(cycles.mean()), 1e-12)
    # Of sixteen blocks with three channels that have two samples each the largest of 4.5 standard errors is a rare one; a pooled error steadies it.
    both = np.sqrt(error**2 + of_other**2)
    pooled = np.sqrt((both**2).mean())
    overall = float(np.sqrt((both**2).sum())) / both.size
    ratio = other.mean() / mean
    if abs(ratio - 1) > 0.02 + 4 * overall / mean:
        return f"{ratio:.3f} of the light"
    far = np.abs(other - cycles) - (0.03 * cycles + 0.01 * mean + 4.5 * np.maximum(both, pooled))
    if far.max() > 0:
        y, x, _ = np.unravel_index(far.argmax(), far.shape)
        return f"{other[y, x].mean() / max(cycles[y, x].mean(), 1e-12):.3f} of the light in a block ({y}, {x})"
    return ""
