# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage with what artists light: haze that thins out with height, a cloud of noise in it, a slide in front of a spot. covbeam and
Cycles, the fog's light alone, two seeds of each.

    python measure_stage.py FOLDER [--seconds 30] [--samples 96] [--width 480]

Prints CPU time, means, the variance between the seeds over the squared brightness, and how 16 x 16 blocks of pixels of the means of both
differ where Cycles' own seeds agree within 3 %. Writes covbeam's and Cycles' picture of the first seed, one above the other.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import cycles_scenes as scenes
import fog_light
from measure_glass_ball import save

#: Scatterings and reflections of light in both.
BOUNCES = 8

COLOURS = ((1, 0.15, 0.1), (0.1, 0.4, 1), (1, 0.75, 0.15), (0.2, 0.9, 0.3))


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


def panes():
    """The picture of a slide of coloured panes."""
    pixels = np.zeros((96, 96, 4))
    for k in range(16):
        row, column = divmod(k, 4)
        pixels[8 + row * 21 : 23 + row * 21, 8 + column * 21 : 23 + column * 21, :3] = COLOURS[(3 * row + column) % 4]
    return fog_light.picture("Slide", pixels)


def make(width):
    """The stage."""
    scene = scenes.empty_scene(64)
    scene.render.resolution_x, scene.render.resolution_y = width, width * 9 // 16
    scene.cycles.max_bounces = scene.cycles.volume_bounces = BOUNCES
    scenes.wire(scene.world, [])
    scenes.look((0, -9, 2.2), (0, 0, 1.6), 35)
    grey = scenes.material("Grey", ("ShaderNodeBsdfDiffuse", {"Color": (0.5, 0.45, 0.4, 1)}, "Surface"))
    scenes.cube("Haze", (0, 0, 2), (9, 7, 3.98), fog_light.medium("Haze", haze))
    scenes.to_unit(scenes.cube("Cloud", (1.5, -0.6, 1.6), (1.5, 1.1, 1.2), fog_light.medium("Cloud", cloud)))
    scenes.cube("Floor", (0, 0, -0.1), (12, 12, 0.2), grey)
    scenes.cube("Wall", (0, 3.4, 2), (12, 0.2, 6), grey)
    scenes.ball("Ball", (-0.9, -0.6, 0.6), 0.6, grey)
    spot = {"shadow_soft_size": 0.0, "spot_blend": 0.2}
    projector = scenes.lamp("SPOT", (-3.2, 2.6, 4.6), (0.2, -1.2, 0.2), energy=6000.0, spot_size=0.9, **spot)
    fog_light.slide(projector.data, panes(), 0.8)
    scenes.lamp("SPOT", (3.8, -2.0, 4.6), (1.5, -0.6, 1.6), energy=1500.0, spot_size=0.4, color=(0.6, 0.75, 1.0), **spot)
    return scene


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
    runs = []
    for seed in (1, 2):
        run, report = fog_light.with_covbeam(seed, BOUNCES, 1, arguments.seconds)
        if seed == 1:
            print(report)
        print(f"covbeam: {run.count} passes, {run.seconds:.1f} CPU-s", flush=True)
        runs.append(run)
    for seed in (1, 2):
        runs.append(fog_light.with_cycles(scene, arguments.samples, seed, 1))
        print(f"Cycles: {arguments.samples} samples, {runs[-1].seconds:.1f} CPU-s", flush=True)
    ours, cycles = np.array([run.picture for run in runs]).reshape(2, 2, *runs[0].picture.shape)
    variance = [fog_light.noise(run, 0.5 * (ours.mean(axis=0) + cycles.mean(axis=0))) for run in (ours, cycles)]
    print(f"covbeam / Cycles: means {ours.mean() / cycles.mean():.4f}, variance {variance[0]:.2e} and {variance[1]:.2e}")
    first, second = fog_light.blocks(cycles, 16)
    agree = np.abs(first / second - 1) < 0.03
    ratio = (fog_light.blocks(ours, 16).mean(axis=0) / (0.5 * (first + second)))[agree]
    print(f"{agree.sum()} of {agree.size} blocks: covbeam / Cycles {np.quantile(ratio, 0.05):.3f} to {np.quantile(ratio, 0.95):.3f} (90 %)")
    save(arguments.folder / "stage", np.concatenate([ours[0], cycles[0]]))


if __name__ == "__main__":
    main(sys.argv[1:])
