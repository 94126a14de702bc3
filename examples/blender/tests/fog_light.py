# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of the fog alone, as covbeam and as Cycles render it, and what it takes of processors; for measurements of both."""

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import cycles_scenes as scenes
import exr
import numpy as np
from addon.export.motion import exposures
from addon.host.session import Session, Settings


@dataclass(frozen=True)
class Run:
    """One picture: float64 (h, w, 3), rows from the top; CPU seconds of all of it, and of getting ready; passes or samples."""

    picture: np.ndarray
    seconds: float
    ready: float
    count: int


class Tree:
    """Nodes of a material, lamp or world."""

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
        """Links an output to an input; returns the node's first output, None of a last node."""
        self._tree.links.new(output, made.inputs[name])
        return next(iter(made.outputs), None)

    def found(self, kind):
        """The node of a type that is there already."""
        return next(node for node in self._tree.nodes if node.type == kind)


def medium(name, density, colour=(1, 1, 1), anisotropy=0.4):
    """A material of fog; density: a number, or a function of its Tree that returns an output."""
    made = scenes.material(name, *scenes.fog(colour, 1.0 if callable(density) else density, anisotropy))
    if callable(density):
        tree = Tree(made.node_tree)
        tree.link(density(tree), tree.found("VOLUME_SCATTER"), "Density")
    return made


def slide(lamp, image, width):
    """Puts an image in front of a spot, that fills a square of `width` at 1 m."""
    lamp.use_nodes = True
    tree = Tree(lamp.node_tree)
    texture = tree.node("TexImage", extension="CLIP")
    texture.image = image
    parts, place = tree.node("SeparateXYZ"), tree.node("CombineXYZ")
    tree.link(tree.node("TexCoord").outputs["Normal"], parts)
    for axis in "XY":
        slope = tree.node("Math", operation="DIVIDE")
        tree.link(parts.outputs["Z"], slope, 1)
        moved = tree.node("Math", {1: -1 / width, 2: 0.5}, operation="MULTIPLY_ADD")
        tree.link(tree.link(tree.link(parts.outputs[axis], slope), moved), place, axis)
    tree.link(place.outputs[0], texture)
    tree.link(texture.outputs["Color"], tree.found("EMISSION"), "Color")


def picture(name, pixels):
    """An image of linear colours and alpha, (h, w, 4), rows from below."""
    image = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0], alpha=True, float_buffer=True)
    image.colorspace_settings.name, image.alpha_mode = "Linear Rec.709", "CHANNEL_PACKED"
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    return image


def cpu_seconds():
    """Of this process, all its threads, and the processes that it has waited for."""
    return sum(os.times()[:4])


def with_covbeam(seed, bounces, threads, seconds, passes=None, glowing=False):
    """A Run of so many passes, or about so many CPU seconds, and the report; glowing: with what volumes send straight to the eye."""
    scene = bpy.context.scene
    start = cpu_seconds()
    made, report = exposures(bpy.context.evaluated_depsgraph_get(), lambda frame, part: scene.frame_set(frame, subframe=part))
    session = Session(made[0], Settings(seed=seed, threads=threads, bounces=bounces, beyond=False), instants=made[1:])
    try:
        ready = cpu_seconds() - start

        def enough():
            done = session.passes
            if passes is not None:
                return done >= passes
            spent = cpu_seconds() - start
            # Instants have equal shares of the passes. Half a pass early is as good as half a pass late; to get ready is no part of it.
            is_whole = done and done % (2 * len(made) if len(made) > 1 else 1) == 0
            return is_whole and spent + 0.5 * (spent - ready) / done >= seconds

        while not enough():
            session.render_pass()
        found = session.picture()
        light = found.in_scattered if glowing else found.first
        return Run(light.astype(np.float64), cpu_seconds() - start, ready, session.passes), report
    finally:
        session.close()


def with_cycles(scene, samples, seed, threads, guided=False, glowing=False, ready=0.0):
    """A Run of the sum of Cycles' passes of volumes; guided: by path guiding; glowing: with its pass Emission, of scenes in which nothing
    but volumes shines that is seen; ready: seconds of getting ready, of an earlier render that has kept it."""
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.cycles.samples, scene.cycles.seed, scene.cycles.use_guiding = samples, seed, guided
    layer = scene.view_layers[0]
    layer.cycles.use_pass_volume_direct = layer.cycles.use_pass_volume_indirect = True
    layer.use_pass_emit = glowing
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR_MULTILAYER", "32", "NONE"
    start = cpu_seconds()
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "fog.exr")
        bpy.ops.render.render(write_still=True)
        seconds = cpu_seconds() - start
        found = exr.read(Path(scene.render.filepath))
    # "Volume Direct" and "Volume Indirect", or "VolumeDir" and "VolumeInd" before Blender 5.0.
    names = (".Volume", ".Emi") if glowing else (".Volume",)
    parts = [[v for k, v in found.items() if any(name in k for name in names) and k.endswith(f".{channel}")] for channel in "RGB"]
    assert all(len(part) == 2 + glowing for part in parts), list(found)
    return Run(np.stack([sum(part) for part in parts], axis=-1).astype(np.float64), seconds + ready, ready, samples)


def noise(pictures, mean):
    """Variance of pictures of several seeds over the squared brightness `mean`, a mean over pixels and channels."""
    return float((pictures.var(axis=0, ddof=1) / (mean**2 + (0.01 * mean.mean()) ** 2)).mean())


def blocks(pictures, size):
    """Means of squares of size x size pixels and of the channels: (..., rows, columns); what is left at the borders is left out."""
    height, width = (size * (n // size) for n in pictures.shape[-3:-1])
    cut = pictures[..., :height, :width, :].mean(axis=-1)
    return cut.reshape(*cut.shape[:-2], height // size, size, width // size, size).mean(axis=(-3, -1))
