# SPDX-License-Identifier: GPL-3.0-or-later
"""Brightness and noise of covbeam and Cycles in twelve small pictures, one for each kind of thing that artists light fog with (kinds.py).

    python measure_kinds.py FOLDER [--width 96] [--seconds 12 | --passes 32] [--samples 128] [--seeds 3] [--threads 1] [--only MIST ...]

The fog's light alone, before the first surface. Cycles renders as many seeds again with path guiding: the mean of all of them is the
reference. Prints of each scene, with standard errors between seeds:

- the means of both pictures;
- how means of 8 x 8 pixels differ, in how many of them 2 % can be seen (Cycles' own error is below 1 %), how many of these differ by
  more, and how many would by noise alone;
- brightness over the reference's by distance from the brightest part, all pixels above half of the 99th percentile;
- variance between seeds over squared brightness, times CPU seconds, of Cycles over covbeam's: without and with path guiding, of whole
  renders, and of what comes after a scene is read (which takes Cycles as long as a render of one sample).

A first run of covbeam is not measured: what Blender does once in a process is in none.

Writes covbeam's and Cycles' mean pictures side by side, all of them on one sheet, and all runs as arrays. CPU seconds are those of all
threads and of what else was started. Blender 5.0 or newer, as 4.2 cannot write OpenVDB files.
"""

import argparse
import os
import sys
from math import erfc, sqrt
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import fog_light
from kinds import BOUNCES, KINDS, make
from measure_glass_ball import show

#: Pixels along blocks; the difference that is looked for; Cycles' own error that lets it be seen.
BLOCK, WANTED, SEEN = 8, 0.02, 0.01

#: Blocks and rings darker than this share of the picture's mean are left out.
DARK = 0.02

#: Where rings end [pixels].
RINGS = (0.5, 2.5, 4.5, 8.5, 16.5, 32.5, np.inf)


def error(runs):
    """Standard error of the mean of runs."""
    return runs.std(axis=0, ddof=1) / np.sqrt(len(runs))


def smoothed(values):
    """Means of 3 x 3 neighbours."""
    padded = np.pad(values, 1, mode="edge")
    return sum(padded[i : i + values.shape[0], j : j + values.shape[1]] for i in range(3) for j in range(3)) / 9


def block_line(ours, cycles):
    """What blocks of runs (n, h, w, 3) say, as text."""
    ours, cycles = (fog_light.blocks(runs, BLOCK) for runs in (ours, cycles))
    found, expected = ours.mean(axis=0), cycles.mean(axis=0)
    lit = expected > DARK * expected.mean()
    # Of few seeds a block's own error is uncertain: its neighbours' tell of it too.
    share = smoothed(lit.astype(float)).clip(1e-9)
    errors = [np.sqrt(smoothed((error(runs) / np.where(lit, expected, np.inf)) ** 2) / share) for runs in (ours, cycles)]
    seen = lit & (errors[1] < SEEN)
    if not seen.any():
        return f"blocks: {lit.sum()} lit, Cycles' errors let {WANTED:.0%} be seen in none"
    difference, both = (found / np.where(lit, expected, 1) - 1)[seen], np.hypot(*errors)[seen]
    chance = sum(erfc(WANTED / (sqrt(2) * s)) for s in both)
    worst = np.abs(difference).argmax()
    return (
        f"blocks: {lit.sum()} lit, {WANTED:.0%} can be seen in {seen.sum()}: beyond it {(np.abs(difference) > WANTED).sum()}, by noise "
        f"alone {chance:.1f}; largest {100 * difference[worst]:+.1f} % ({np.abs(difference / both)[worst]:.1f} errors), RMS "
        f"{100 * np.sqrt(np.mean(difference**2)):.2f} %, of noise {100 * np.sqrt(np.mean(both**2)):.2f} %"
    )


def distances(bright):
    """How far each pixel is from the next one that is set, bool (h, w) [pixels]."""
    height, width = bright.shape
    # Along columns first, then across them.
    rows = np.arange(height)
    far = np.full((height, width), 1e9)
    for row in np.flatnonzero(bright.any(axis=1)):
        far[:, bright[row]] = np.minimum(far[:, bright[row]], np.abs(rows - row)[:, None])
    across = np.abs(np.arange(width)[:, None] - np.arange(width))
    return np.sqrt(np.min(far[:, None, :] ** 2 + across**2, axis=2))


def ring_line(ours, cycles):
    """What rings around the brightest part say, as text."""
    # covbeam's, as it has the least noise: pixels that are bright by noise of one picture would be darker in the other.
    grey = ours.mean(axis=(0, -1))
    far = distances(grey > 0.5 * np.percentile(grey, 99))
    rings, begin = [], -1.0
    for end in RINGS:
        ring, begin = (far > begin) & (far <= end), end
        if not ring.any() or grey[ring].mean() < DARK * grey.mean():
            continue
        means = [runs[:, ring].mean(axis=(1, 2)) for runs in (ours, cycles)]
        ratio = means[0].mean() / means[1].mean()
        off = ratio * np.hypot(*(error(of) / of.mean() for of in means))
        rings.append(f"{'further' if end == np.inf else f'to {int(end)}'} {ratio:.3f}+-{off:.3f}")
    return "rings [pixels]: " + ", ".join(rings)


def noise_line(ours, others, mean):
    """Noise at equal CPU time over covbeam's; ours, others: lists of Run; others: by what they are called."""

    def cost(runs, ready):
        spent = np.mean([run.seconds - (run.ready if ready else 0) for run in runs])
        return fog_light.noise(np.array([run.picture for run in runs]), mean) * spent

    parts = []
    for name, runs in others.items():
        whole, after = (cost(runs, ready) / cost(ours, ready) for ready in (False, True))
        parts.append(f"{name} {whole:.1f} ({after:.1f} after reading)")
    counts = ", ".join(
        f"{name} {runs[0].count} in {np.mean([run.seconds for run in runs]):.1f} CPU-s ({np.mean([run.ready for run in runs]):.1f} ready)"
        for name, runs in {"covbeam": ours, **others}.items()
    )
    return f"noise / covbeam's: {', '.join(parts)}; {counts}"


def measure(name, arguments):
    """Renders a scene and prints what there is to say. Returns both mean pictures, side by side."""
    scene, glowing = make(name, arguments.width), KINDS[name].glowing
    seeds = range(1, arguments.seeds + 1)
    ours, threads = [], arguments.threads
    # What Blender does once, as to get ready to render a sky, would count for the first run alone.
    fog_light.with_covbeam(0, BOUNCES, threads, arguments.seconds, 1, glowing)
    for seed in seeds:
        run, report = fog_light.with_covbeam(seed, BOUNCES, threads, arguments.seconds, arguments.passes, glowing)
        ours.append(run)
    # What Cycles knows of the scene is made once, with a sample, and counts for each render.
    scene.render.use_persistent_data = True
    ready = fog_light.with_cycles(scene, 1, 0, threads, glowing=glowing).seconds
    others = {
        title: [fog_light.with_cycles(scene, arguments.samples, seed, threads, guided, glowing, ready) for seed in seeds]
        for title, guided in (("Cycles", False), ("guided", True))
    }
    covbeam = np.array([run.picture for run in ours])
    cycles = np.array([run.picture for runs in others.values() for run in runs])
    plain, guided = (np.array([run.picture.mean() for run in runs]) for runs in others.values())
    means = [covbeam.mean(axis=(1, 2, 3)), cycles.mean(axis=(1, 2, 3))]
    values = [f"{of.mean():.4g}+-{error(of):.2g}" for of in (*means, plain, guided)]
    ratio = means[0].mean() / means[1].mean()
    off = ratio * np.hypot(*(error(of) / of.mean() for of in means))
    mean = 0.5 * (covbeam.mean(axis=0) + cycles.mean(axis=0))
    print(f"{name}: covbeam {values[0]}, Cycles {values[1]} (plain {values[2]}, guided {values[3]}): {ratio:.4f}+-{off:.4f}")
    for line in (*str(report).splitlines(), block_line(covbeam, cycles), ring_line(covbeam, cycles), noise_line(ours, others, mean)):
        print(f"  {line}", flush=True)
    np.savez(arguments.folder / f"{name.lower()}.npz", covbeam=covbeam, cycles=cycles)
    pair = np.concatenate([covbeam.mean(axis=0), cycles.mean(axis=0)], axis=1)
    show(arguments.folder / name.lower(), pair)
    return pair


def main(words):
    """Runs the measurement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--width", type=int, default=96)
    parser.add_argument("--seconds", type=float, default=12, help="CPU seconds of each of covbeam's pictures")
    parser.add_argument("--passes", type=int, help="of each of covbeam's pictures, instead")
    parser.add_argument("--samples", type=int, default=128)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--only", nargs="*", choices=KINDS, default=list(KINDS))
    arguments = parser.parse_args(words)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    pairs = [measure(name, arguments) for name in arguments.only]
    show(arguments.folder / "sheet", np.concatenate([np.clip(pair / np.percentile(pair, 99.5), 0, 1) for pair in pairs]))


if __name__ == "__main__":
    main(sys.argv[1:])
    sys.stdout.flush()
    # Mantaflow ends the process in a way of its own if that is not done here.
    os._exit(0)
