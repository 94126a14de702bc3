# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage with what artists light: haze that thins out with height, a cloud of noise in it, a slide in front of a spot. covbeam and
Cycles, the fog's light alone, two seeds of each.

    python measure_stage.py FOLDER [--seconds 30] [--samples 96] [--width 480]

Prints CPU time, means, the variance between the seeds over the squared brightness, and how 16 x 16 blocks of pixels of the means of both
differ where Cycles' own seeds agree within 3 %. Writes covbeam's and Cycles' picture of the first seed, one above the other.
"""

import argparse
import sys
import tempfile
from pathlib import Path
from time import process_time

import bpy
import exr
import numpy as np
from mathutils import Matrix, Vector

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import cycles_scenes as scenes
from addon.export.scene import export
from addon.host.session import Session, Settings
from measure_glass_ball import save

#: Scatterings and reflections of light in both.
BOUNCES = 8

COLOURS = ((1, 0.15, 0.1), (0.1, 0.4, 1), (1, 0.75, 0.15), (0.2, 0.9, 0.3))


class Tree:
    """Nodes of a material or lamp."""

    def __init__(self, tree):
        self._tree = tree

    def node(self, kind, values=(), **settings):
        """A new node; values: of its inputs by name."""
        made = self._tree.nodes.new(f"ShaderNode{kind}")
        for name, value in settings.items():
            setattr(made, name, value)
        for name, value in dict(values).items():
            made.inputs[name].default_value = value
        return made

    def link(self, output, made, name=0):
        """Links an output to an input; returns the node's first output."""
        self._tree.links.new(output, made.inputs[name])
        return made.outputs[0]


def fog(name, density):
    """A white medium; density: function of a Tree that returns an output."""
    made = scenes.material(name, *scenes.fog(density=1.0, anisotropy=0.4))
    scatter = next(node for node in made.node_tree.nodes if node.type == "VOLUME_SCATTER")
    made.node_tree.links.new(density(Tree(made.node_tree)), scatter.inputs["Density"])
    return made


def haze(tree):
    """Thinner with height."""
    parts = tree.node("SeparateXYZ")
    tree.link(tree.node("NewGeometry").outputs["Position"], parts)
    fade = {"From Min": 0.0, "From Max": 3.2, "To Min": 0.12, "To Max": 0.01}
    return tree.link(parts.outputs["Z"], tree.node("MapRange", fade, interpolation_type="SMOOTHSTEP"))


def cloud(tree):
    """Noise that ends with a gradient."""
    place = tree.node("TexCoord").outputs["Object"]
    noise = tree.node("TexNoise", {"Scale": 2.2, "Detail": 3.0, "Distortion": 0.5})
    thick = tree.node("MapRange", {"From Min": 0.4, "From Max": 0.7, "To Min": 0.0, "To Max": 8.0})
    fade, both = tree.node("TexGradient", gradient_type="SPHERICAL"), tree.node("Math", operation="MULTIPLY")
    tree.link(tree.link(tree.link(place, noise), thick, "Value"), both, 0)
    tree.link(place, fade)
    return tree.link(next(s for s in fade.outputs if s.identifier == "Fac"), both, 1)


def slide(lamp):
    """Puts a slide of coloured panes in front of a spot."""
    lamp.use_nodes = True
    tree = Tree(lamp.node_tree)
    panes = np.zeros((96, 96, 4), np.float32)
    for k in range(16):
        row, column = divmod(k, 4)
        panes[8 + row * 21 : 23 + row * 21, 8 + column * 21 : 23 + column * 21, :3] = COLOURS[(3 * row + column) % 4]
    image = bpy.data.images.new("Slide", 96, 96, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    image.pixels.foreach_set(panes.ravel())
    texture = tree.node("TexImage", extension="CLIP")
    texture.image = image
    parts, place = tree.node("SeparateXYZ"), tree.node("CombineXYZ")
    tree.link(tree.node("TexCoord").outputs["Normal"], parts)
    for axis in "XY":
        slope = tree.node("Math", operation="DIVIDE")
        tree.link(parts.outputs["Z"], slope, 1)
        moved = tree.node("Math", {1: -1 / 0.8, 2: 0.5}, operation="MULTIPLY_ADD")
        tree.link(tree.link(tree.link(parts.outputs[axis], slope), moved), place, axis)
    tree.link(place.outputs[0], texture)
    emission = next(node for node in lamp.node_tree.nodes if node.type == "EMISSION")
    tree.link(texture.outputs["Color"], emission, "Color")


def make(width):
    """The stage."""
    scene = scenes.empty_scene(64)
    scene.render.resolution_x, scene.render.resolution_y = width, width * 9 // 16
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.cycles.max_bounces = scene.cycles.volume_bounces = BOUNCES
    scenes.wire(scene.world, [])
    scenes.look((0, -9, 2.2), (0, 0, 1.6), 35)
    grey = scenes.material("Grey", ("ShaderNodeBsdfDiffuse", {"Color": (0.5, 0.45, 0.4, 1)}, "Surface"))
    scenes.cube("Haze", (0, 0, 2), (9, 7, 3.98), fog("Haze", haze))
    box = scenes.cube("Cloud", (1.5, -0.6, 1.6), (1.5, 1.1, 1.2), fog("Cloud", cloud))
    # In its own space from -1 to 1, where the gradient ends.
    box.data.transform(Matrix.Diagonal((2, 2, 2, 1)))
    scenes.cube("Floor", (0, 0, -0.1), (12, 12, 0.2), grey)
    scenes.cube("Wall", (0, 3.4, 2), (12, 0.2, 6), grey)
    scenes.ball("Ball", (-0.9, -0.6, 0.6), 0.6, grey)
    spot = {"shadow_soft_size": 0.0, "spot_blend": 0.2}
    projector = scenes.lamp("SPOT", (-3.2, 2.6, 4.6), (0.2, -1.2, 0.2), energy=6000.0, spot_size=0.9, **spot)
    slide(projector.data)
    scenes.lamp("SPOT", (3.8, -2.0, 4.6), (1.5, -0.6, 1.6), energy=1500.0, spot_size=0.4, color=(0.6, 0.75, 1.0), **spot)
    return scene


def with_covbeam(seconds, seed):
    """Light of the fog before the first surface after some CPU time."""
    start = process_time()
    exported, report = export(bpy.context.evaluated_depsgraph_get())
    if seed == 1:
        print(report)
    session = Session(exported, Settings(seed=seed, threads=1, bounces=BOUNCES, beyond=False))
    try:
        while session.passes == 0 or (process_time() - start) * (1 + 0.5 / session.passes) < seconds:
            session.render_pass()
        picture = session.picture().first
        print(f"covbeam: {session.passes} passes, {process_time() - start:.1f} CPU-s", flush=True)
        return picture
    finally:
        session.close()


def with_cycles(scene, samples, seed):
    """The sum of Cycles' passes of volumes."""
    start = process_time()
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.view_layers[0].cycles.use_pass_volume_direct = scene.view_layers[0].cycles.use_pass_volume_indirect = True
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR_MULTILAYER", "32", "NONE"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "stage.exr")
        bpy.ops.render.render(write_still=True)
        found = exr.read(Path(scene.render.filepath))
    print(f"Cycles: {samples} samples, {process_time() - start:.1f} CPU-s", flush=True)
    # "Volume Direct" and "Volume Indirect", or "VolumeDir" and "VolumeInd" before Blender 5.0.
    parts = [[v for k, v in found.items() if ".Volume" in k and k.endswith(f".{channel}")] for channel in "RGB"]
    assert all(len(part) == 2 for part in parts), list(found)
    return np.stack([sum(part) for part in parts], axis=-1)


def blocks(pictures):
    """Means of squares of 16 x 16 pixels and of the channels."""
    height, width = (16 * (n // 16) for n in pictures.shape[-3:-1])
    cut = pictures[..., :height, :width, :].mean(axis=-1)
    return cut.reshape(*cut.shape[:-2], height // 16, 16, width // 16, 16).mean(axis=(-3, -1))


def main(words):
    """Runs the measurement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--samples", type=int, default=96)
    parser.add_argument("--width", type=int, default=480)
    arguments = parser.parse_args(words)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    scene = make(arguments.width)
    ours = np.array([with_covbeam(arguments.seconds, seed) for seed in (1, 2)], np.float64)
    cycles = np.array([with_cycles(scene, arguments.samples, seed) for seed in (1, 2)], np.float64)
    mean = 0.5 * (ours.mean(axis=0) + cycles.mean(axis=0))
    scale = mean**2 + (0.01 * mean.mean()) ** 2
    variance = [float(((run[0] - run[1]) ** 2 / 2 / scale).mean()) for run in (ours, cycles)]
    print(f"covbeam / Cycles: means {ours.mean() / cycles.mean():.4f}, variance {variance[0]:.2e} and {variance[1]:.2e}")
    first, second = blocks(cycles)
    agree = np.abs(first / second - 1) < 0.03
    ratio = (blocks(ours).mean(axis=0) / (0.5 * (first + second)))[agree]
    print(f"{agree.sum()} of {agree.size} blocks: covbeam / Cycles {np.quantile(ratio, 0.05):.3f} to {np.quantile(ratio, 0.95):.3f} (90 %)")
    save(arguments.folder / "stage", np.concatenate([ours[0], cycles[0]]))


if __name__ == "__main__":
    main(sys.argv[1:])
