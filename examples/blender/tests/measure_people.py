# SPDX-License-Identifier: GPL-3.0-or-later
"""The fog's light by covbeam beside what else an artist may pick, at equal CPU time, in scenes as people make them (people.py).

    python measure_people.py FOLDER [--width 128] [--seconds 4 16] [--reference 60] [--only slats ...]

Of each scene, the light of the fog before the first surface, two pictures by each of

- covbeam: Add Beams' picture, through the same node where Add Beams puts one behind noisy beams;
- Cycles, not denoised, without clamping and adaptive sampling;
- OIDN: Cycles' fog light through Blender's Denoise node, guided by albedo and normal of Cycles' denoising data, prefiltered;
- plain: beams with the same radius everywhere, paths that learn nothing, an eye ray through every pixel.

The error of a picture is the mean of (picture - a)(picture - b) over that of the reference's squared brightness, with a tenth of its mean added: a and b
are two long renders by others with seeds of their own, which share no noise with it: what they have between them falls out. Where Cycles finds
next to none of the light they are plain beams of a quarter of the radius, else Cycles': with beams of the same radius, plain beams' blur would be
in picture and reference alike, and no error. Also that of the worst of 4 x 4 blocks.

Prints a line a scene and time: the errors, in brackets those of the worst block and the seconds of CPU, of all threads, reading the scene in them; and
covbeam's over the least of the others. Writes them to people.md, and NAME.png: covbeam, Cycles, OIDN, plain at the last of the times, and the reference.
For Blender 5.0 and newer.
"""

import argparse
import os
import sys
import tempfile
from contextlib import closing
from dataclasses import fields, replace
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import fog_light
from covbeam import session
from covbeam.session import Layer, Method
from measure_glass_ball import show
from measure_tutorials import rendered_plainly, with_beams, with_cycles
from people import PEOPLE, make

import addon
from addon import latest
from addon.add_beams import NOISY
from addon.export.scene import export
from addon.host.session import described
from addon.settings import session_settings

#: Blocks along each side.
BLOCKS = 4

#: What is measured, covbeam first.
METHODS = ("covbeam", "Cycles", "OIDN", "plain")


def _plain_session(scene, seed, radius=0.0):
    """Of plain beams: of a radius in the first pass [m]; 0: the scene's own."""
    made, _ = export(bpy.context.evaluated_depsgraph_get())
    chosen = replace(session_settings(scene), beyond=False, seed=seed, radius=radius)
    given = {each.name: getattr(chosen, each.name) for each in fields(chosen)}
    return closing(session.Session(described(made), **given, method=Method.PLAIN))


def _plain(scene, seconds, seed, radius=0.0):
    """The fog's light by plain beams, after so many seconds by the clock."""
    with _plain_session(scene, seed, radius) as beams:
        beams.until(seconds=seconds)
        return beams.picture(Layer.ALL).astype(np.float64)


def _sharp(scene, seconds, seed):
    """Plain beams of a quarter of their radius: a sixteenth of their blur, and more noise, which falls out of the errors."""
    with _plain_session(scene, seed) as beams:
        beams.until(passes=1)
        radius = beams.picture(Layer.RADIUS).max()
    return _plain(scene, seconds, seed, float(radius) / 4)


def _through_denoiser(scene, seconds, seed, light):
    """What the compositor's Denoise node makes of what `light` gives: of the tree and its render layers, a socket."""
    layer = scene.view_layers[0]
    layer.cycles.denoising_store_passes = True
    tree = bpy.data.node_groups.new("Denoise", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    kept, scene.compositing_node_group = scene.compositing_node_group, tree
    layers, denoise, output = (tree.nodes.new(kind) for kind in ("CompositorNodeRLayers", "CompositorNodeDenoise", "NodeGroupOutput"))
    tree.links.new(light(tree, layers), denoise.inputs["Image"])
    for guide in ("Albedo", "Normal"):
        tree.links.new(layers.outputs[f"Denoising {guide}"], denoise.inputs[guide])
    tree.links.new(denoise.outputs["Image"], output.inputs[0])
    channels, _ = rendered_plainly(scene, seconds, seed, False)
    scene.compositing_node_group = kept
    return np.stack([channels[c] for c in "RGB"], axis=-1).astype(np.float64)


def _fog_of_cycles(tree, layers):
    total = tree.nodes.new("ShaderNodeMix")
    total.data_type, total.blend_type = "RGBA", "ADD"
    factor, a, b = [socket for socket in total.inputs if socket.enabled][:3]
    factor.default_value = 1.0
    tree.links.new(layers.outputs["Volume Direct"], a)
    tree.links.new(layers.outputs["Volume Indirect"], b)
    return next(socket for socket in total.outputs if socket.enabled)


def _denoised(scene, seconds, seed):
    """Cycles' fog light through the compositor's Denoise node."""
    return _through_denoiser(scene, seconds, seed, _fog_of_cycles)


def _denoised_beams(scene, beams):
    """A picture of beams through the node. Its guides are those of the surfaces, which Cycles renders whatever is done for their fog."""
    opaque = np.concatenate([beams[::-1], np.ones((*beams.shape[:2], 1))], axis=-1)
    image = fog_light.picture("Beams", opaque)

    def light(tree, layers):
        node = tree.nodes.new("CompositorNodeImage")
        node.image = image
        return node.outputs[0]

    return _through_denoiser(scene, 1.0, 1, light)


def _cycles(scene, seconds, seed):
    return with_cycles(scene, seconds, seed, plain=True).fog


def _covbeam(scene, seconds, seed):
    with tempfile.TemporaryDirectory() as folder:
        made = with_beams(scene, seconds, seed, Path(folder)).fog
        if bpy.ops.covbeam.remove_beams.poll():
            bpy.ops.covbeam.remove_beams()
    return made


_RENDER = dict(zip(METHODS, (_covbeam, _cycles, _denoised, _plain)), reference=_sharp)


def timed(method, scene, cpu, seed):
    """A picture of about so many seconds of CPU, and how many it took; those of surfaces alone are nobody's."""
    # All threads are busy most of the time; what is off is told.
    seconds = cpu / os.cpu_count()
    before = fog_light.cpu_seconds()
    picture = _RENDER[method](scene, seconds, seed)
    spent = fog_light.cpu_seconds() - before
    if method == "covbeam" and latest.noise(scene.view_layers[0].name) > NOISY:
        picture = _denoised_beams(scene, picture)
    return picture, spent


def parts(pictures):
    """Means of BLOCKS x BLOCKS parts of pictures (..., h, w); what is left at the borders is left out."""
    height, width = (size // BLOCKS for size in pictures.shape[-2:])
    cut = pictures[..., : height * BLOCKS, : width * BLOCKS]
    return cut.reshape(*cut.shape[:-2], BLOCKS, height, BLOCKS, width).mean(axis=(-3, -1))


def errors(picture, references):
    """Relative squared errors of a picture: of all of it, and of the worst block."""
    a, b = references
    mean = 0.5 * (a + b)
    product = ((picture - a) * (picture - b)).mean(axis=-1)
    weight = (a * b).mean(axis=-1) + (0.1 * mean.mean()) ** 2
    return product.mean() / weight.mean(), (parts(product) / parts(weight)).max()


def row(name, cpu, found):
    """A line of the table: of a scene, seconds of CPU and, by method, errors of the whole and of the worst block, and seconds spent."""
    least = min(found[method][0] for method in METHODS[1:])
    cells = [f"{found[method][0]:.1e} ({found[method][1]:.0e}; {found[method][2]:.1f} s)" for method in METHODS]
    return f"| {name} | {cpu:g} | {' | '.join(cells)} | {found['covbeam'][0] / max(least, 1e-12):.2f} |"


def table(rows):
    """The page's table."""
    head = f"| scene | CPU-s | {' | '.join(METHODS)} | covbeam over the least of the others |"
    return "\n".join([head, "|---" * (3 + len(METHODS)) + "|", *rows, ""])


def measure(name, width, times, reference, folder):
    """Renders a scene and prints what there is to say."""
    scene = make(name, width)
    by = "reference" if PEOPLE[name].focuses else "Cycles"
    references = np.array([timed(by, scene, reference, seed)[0] for seed in (101, 102)])
    shown, rows = [], []
    for cpu in times:
        found = {}
        for method in METHODS:
            pictures = [timed(method, scene, cpu, seed) for seed in (1, 2)]
            each = np.array([errors(picture, references) for picture, _ in pictures])
            found[method] = *each.mean(axis=0), np.mean([spent for _, spent in pictures])
            shown.append(pictures[0][0])
        rows.append(row(name, cpu, found))
        print(rows[-1], flush=True)
    mean = references.mean(axis=0)
    top = np.percentile(mean, 99)
    side_by_side = [np.clip(each / max(top, 1e-12), 0, 1) for each in [*shown[-len(METHODS) :], mean]]
    show(folder / name, np.kron(np.concatenate(side_by_side, axis=1), np.ones((2, 2, 1))))
    return rows


def main(words):
    """Runs the measurement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--width", type=int, default=128)
    parser.add_argument("--seconds", type=float, nargs="+", default=[4, 16], help="of CPU, of a picture")
    parser.add_argument("--reference", type=float, default=60, help="of CPU, of each of the two references")
    parser.add_argument("--only", nargs="*", choices=PEOPLE, default=list(PEOPLE))
    arguments = parser.parse_args(words)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    addon.register()
    rows = []
    for name in arguments.only:
        rows += measure(name, arguments.width, arguments.seconds, arguments.reference, arguments.folder)
        (arguments.folder / "people.md").write_text(table(rows))


if __name__ == "__main__":
    main(sys.argv[1:])
    sys.stdout.flush()
    # Some simulations end the process in a way of their own if that is not done here.
    os._exit(0)
