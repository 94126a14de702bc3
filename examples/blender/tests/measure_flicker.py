# SPDX-License-Identifier: GPL-3.0-or-later
"""An animation: how much its frames differ, and how much of that is noise. A spot swings over a ball in fog.

    python measure_flicker.py [--frames 24] [--width 96] [--passes 16] [--photons 20000] [--truth 96]

With Animate Seed off, where noise goes with the light, and on, where each frame has its own: the change of smooth pixels from frame to
frame, over that of the truth, is to be at most 3. Smooth are pixels at least half as bright as the mean that differ from their
neighbours by less than a tenth. Changes are root mean squares over these, of luminance over their mean brightness.

Each is rendered with two seeds: noise of one knows nothing of that of the other, and so the mean product of both changes is the square of
what is no noise. So is the truth's, of many passes.
"""

import argparse
import sys
from pathlib import Path
from time import perf_counter

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import addon
import cycles_scenes as scenes
from addon.export.scene import export
from addon.host.session import Session
from addon.settings import session_settings

#: What the change of smooth pixels may be, over the truth's.
ALLOWED = 3.0


def make(width, frames):
    """A spot that swings once to the side in the frames of a second, 24; all of them are rendered, or the first few."""
    scene = scenes.empty_scene(64)
    scene.render.resolution_x, scene.render.resolution_y = width, width * 9 // 16
    scene.frame_start, scene.frame_end = 1, frames
    scenes.look((0, -7, 1.8), (0, 0, 1.4), 35)
    grey = scenes.material("Grey", ("ShaderNodeBsdfDiffuse", {"Color": (0.5, 0.5, 0.5, 1)}, "Surface"))
    scenes.wire(scene.world, [])
    scenes.cube("Fog", (0, 0, 2), (7, 5, 3.98), scenes.material("Fog", *scenes.fog(density=0.1, anisotropy=0.3)))
    scenes.cube("Floor", (0, 0, -0.1), (12, 12, 0.2), grey)
    scenes.ball("Ball", (0, 0, 1.2), 0.4, grey)
    spot = scenes.lamp("SPOT", (0, 0, 3.8), (0, 0, 0), energy=2000.0, spot_size=0.8, spot_blend=0.3, shadow_soft_size=0.05)
    for frame, x in ((1, -1.5), (24, 1.5)):
        spot.location.x = x
        spot.keyframe_insert("location", frame=frame)
    return scene


def animation(scene, seed, animated, passes, photons):
    """Luminance of the fog's light in each frame: (frames, h, w)."""
    chosen, start = scene.covbeam, perf_counter()
    chosen.seed, chosen.animate_seed, chosen.photons = seed, animated, photons
    shown = []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        exported, _ = export(bpy.context.evaluated_depsgraph_get())
        session = Session(exported, session_settings(scene))
        try:
            for _ in range(passes):
                session.render_pass()
            shown.append(session.picture().in_scattered.astype(np.float64) @ (0.2126, 0.7152, 0.0722))
        finally:
            session.close()
    print(f"seed {seed}, {passes} passes, {(perf_counter() - start) / len(shown):.1f} s a frame", file=sys.stderr, flush=True)
    return np.array(shown)


def smooth(truth):
    """Which pixels are smooth in two frames that follow each other: bool (frames - 1, h, w)."""
    # Means of 3 x 3 pixels: what is left of the truth's noise is no border.
    padded = np.pad(truth, ((0, 0), (1, 1), (1, 1)), mode="edge")
    size = truth.shape[1:]
    mean = sum(padded[:, j : j + size[0], i : i + size[1]] for j in range(3) for i in range(3)) / 9
    steep = np.maximum(*(np.abs(np.gradient(mean, axis=axis)) for axis in (1, 2)))
    calm = (mean > 0.5 * mean.mean(axis=(1, 2), keepdims=True)) & (steep < 0.1 * mean)
    return calm[1:] & calm[:-1]


def changes(one, other, calm):
    """Root mean squares of a frame's change, in two renders with different seeds: all of it, and what is no noise."""
    first, second = (np.diff(frames, axis=0)[calm] for frames in (one, other))
    return np.sqrt(0.5 * (np.mean(first**2) + np.mean(second**2))), np.sqrt(max(np.mean(first * second), 0.0))


def main(words):
    """Runs the measurement; the exit status is 1 if more changes than is allowed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--width", type=int, default=96)
    parser.add_argument("--passes", type=int, default=16)
    parser.add_argument("--photons", type=int, default=20_000)
    parser.add_argument("--truth", type=int, default=96, help="passes of each half of the truth")
    arguments = parser.parse_args(words)
    addon.register()
    scene = make(arguments.width, arguments.frames)

    def both(seeds, animated, passes):
        return [animation(scene, seed, animated, passes, arguments.photons) for seed in seeds]

    truth = both((1001, 1002), True, arguments.truth)
    mean = 0.5 * (truth[0] + truth[1])
    calm = smooth(mean)
    scale = mean[1:][calm].mean()
    _, true = changes(*truth, calm)
    print(f"{calm.mean():.0%} of the pixels are smooth; the truth's change: {true / scale:.4f} of their brightness")
    worst = 0.0
    for name, animated in (("off", False), ("on", True)):
        change, kept = changes(*both((1, 2), animated, arguments.passes), calm)
        noise = np.sqrt(max(change**2 - kept**2, 0.0))
        worst = max(worst, change / true)
        print(f"Animate Seed {name}: change {change / true:.2f} of the truth's; {kept / true:.2f} without noise, {noise / true:.2f} noise")
    print(f"at most {ALLOWED:.0f}: {'yes' if worst <= ALLOWED else 'no'}")
    return 0 if worst <= ALLOWED else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
