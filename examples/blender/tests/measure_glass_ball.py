# SPDX-License-Identifier: GPL-3.0-or-later
"""A glass ball in fog: covbeam against Cycles, with and without path guiding, after the same time by the clock.

    python measure_glass_ball.py FOLDER [--seconds 60] [--threads 2] [--size 256] [--reference 900]

Writes pictures and the reference (kept for later runs) into FOLDER. Errors are relMSE, mean((picture - reference)^2 / (reference^2 +
(mean / 100)^2)), of the pixels beside the ball: what Cycles sees through it holds the lamp's own image too. Cycles
clamps indirect light at 10, as Blender has it by default: without, a few pixels of 10^9 are all of its error.
The times are those of the whole render: reading the scene and building hierarchies included, the start of Blender not.
"""

import argparse
import sys
from pathlib import Path
from time import perf_counter

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import cycles_scenes as scenes
from addon.export.scene import export
from addon.host.session import Session, Settings

RADIUS, DISTANCE, LENS, SENSOR = 0.5, 4.0, 50.0, 36.0


def make(size, threads):
    """A lamp of 10 cm across above a glass ball, in fog that scatters half of what it takes out, without end."""
    scene = scenes.empty_scene(size)
    scene.cycles.sample_clamp_indirect = 10.0
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scenes.look((0, -DISTANCE, 0), (0, 0, 0), LENS)
    scenes.wire(scene.world, scenes.fog((1, 1, 1), 0.15, 0.0, (0, 0, 0), 0.15))
    glass = ("ShaderNodeBsdfGlass", {"Color": (1, 1, 1, 1), "Roughness": 0.0, "IOR": 1.5}, "Surface")
    scenes.ball("Ball", (0, 0, 0), RADIUS, scenes.material("Glass", glass))
    light = scenes.lamp("POINT", (1.0, 0.0, 2.4), energy=25 * 4 * np.pi, shadow_soft_size=0.05)
    light.data.use_soft_falloff = False
    return scene


def beside_the_ball(size):
    """Which pixels do not see the ball, a pixel's margin left: bool (size, size)."""
    tangent = SENSOR / LENS / size
    place = (np.arange(size) + 0.5 - size / 2) * tangent
    x, y = np.meshgrid(place, place)
    edge = RADIUS / np.sqrt(DISTANCE**2 - RADIUS**2)
    return np.hypot(x, y) > edge + 2 * tangent


def with_cycles(scene, seconds, guided):
    """Cycles' picture after some seconds, how many samples a pixel that were is not told."""
    scene.cycles.samples = 1 << 20
    scene.cycles.time_limit = seconds
    scene.cycles.use_guiding = guided
    start = perf_counter()
    return scenes.cycles_picture(scene), perf_counter() - start


def with_covbeam(seconds, threads, seed, **settings):
    """covbeam's picture after some seconds, or one pass."""
    start = perf_counter()
    exported, report = export(bpy.context.evaluated_depsgraph_get())
    assert not len(report), str(report)
    session = Session(exported, Settings(seed=seed, threads=threads, **settings))
    try:
        while True:
            session.render_pass()
            # Half a pass early is as good as half a pass late; the picture takes its time too.
            elapsed = perf_counter() - start
            if elapsed * (1 + 0.5 / session.passes) + 0.5 > seconds:
                break
        picture = session.picture()
        taken = perf_counter() - start
        parts = ", ".join(f"{name} {value:.1f}" for name, value in session.times.items())
        print(f"covbeam: {session.passes} passes, {session.pairs / 1e6:.0f} million pairs, {parts} s")
        return picture.in_scattered, taken
    finally:
        session.close()


def rel_mse(picture, reference, mask):
    """(mean of squared relative differences, ratio of means) of some pixels."""
    a, b = picture[mask].astype(np.float64).mean(axis=1), reference[mask].astype(np.float64).mean(axis=1)
    return float(np.mean((a - b) ** 2 / (b**2 + (0.01 * b.mean()) ** 2))), float(a.mean() / b.mean())


def save(path, picture):
    """An array for later, a PNG to look at."""
    np.save(path.with_suffix(".npy"), picture)
    show(path, picture)


def show(path, picture):
    """Writes a PNG: sRGB, 1.0 at the 99.5th percentile."""
    height, width, _ = picture.shape
    scaled = np.clip(picture / np.percentile(picture, 99.5), 0, 1)
    encoded = np.where(scaled <= 0.0031308, 12.92 * scaled, 1.055 * np.maximum(scaled, 1e-9) ** (1 / 2.4) - 0.055)
    image = bpy.data.images.new(path.stem, width, height)
    image.pixels.foreach_set(np.concatenate([encoded, np.ones_like(encoded[..., :1])], 2)[::-1].astype(np.float32).ravel())
    image.filepath_raw, image.file_format = str(path.with_suffix(".png")), "PNG"
    image.save()
    bpy.data.images.remove(image)


def main(words):
    """Runs the measurement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--reference", type=float, default=900, help="seconds for the reference, if FOLDER has none")
    arguments = parser.parse_args(words)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    scene = make(arguments.size, arguments.threads)
    mask = beside_the_ball(arguments.size)
    kept = arguments.folder / f"reference-{arguments.size}.npy"
    if not kept.exists():
        picture, _ = with_covbeam(arguments.reference, arguments.threads, 1000, quality=0.004)
        save(kept, picture)
    reference = np.load(kept)
    results = {}
    for name, run in (
        # As Add Beams renders, without what is seen through the ball; and as the engine does.
        ("covbeam-first", lambda: with_covbeam(arguments.seconds, arguments.threads, 1, beyond=False)),
        ("covbeam", lambda: with_covbeam(arguments.seconds, arguments.threads, 1)),
        ("cycles", lambda: with_cycles(scene, arguments.seconds, False)),
        ("cycles-guided", lambda: with_cycles(scene, arguments.seconds, True)),
    ):
        picture, taken = run()
        save(arguments.folder / name, picture)
        results[name], mean = rel_mse(picture, reference, mask)
        print(f"{name:14} {taken:6.1f} s  relMSE {results[name]:.3e}  mean / reference {mean:.4f}", flush=True)
    for name in ("cycles", "cycles-guided"):
        for ours in ("covbeam-first", "covbeam"):
            print(f"{name} / {ours}: {results[name] / results[ours]:.0f}")


if __name__ == "__main__":
    main(sys.argv[1:])
