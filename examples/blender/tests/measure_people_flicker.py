# SPDX-License-Identifier: GPL-3.0-or-later
"""Flicker: how much of the change from frame to frame is noise, by covbeam and by Cycles through Blender's Denoise node, at equal CPU time.

    python measure_people_flicker.py [--only slats leaves] [--frames 24] [--width 128] [--seconds 4]

Scenes of people.py whose lights swing around the middle of the scene, half a degree a frame. Each frame is rendered with two seeds of its own. What the
changes from frame to frame of the two have in common is the light's; half of the mean square of their difference, over the mean squared brightness, is the
flicker. Also that of the picture's fourth by fourth parts, averaged before: flicker of large areas is seen best.

Seconds are of CPU, of all threads, a frame; reading the scene is in them. For Blender 5.0 and newer.
"""

import argparse
import os
import sys
from math import radians
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from measure_people import parts, timed
from people import PEOPLE, make

import addon

#: What is compared.
METHODS = ("covbeam", "OIDN")

#: The lights turn by so much a frame.
STEP = radians(0.5)


def _frame(name, width, frame):
    """The scene of a frame."""
    scene = make(name, width)
    turned = Matrix.Rotation(frame * STEP, 4, "Z")
    for thing in scene.objects:
        if thing.type == "LIGHT":
            thing.matrix_world = turned @ thing.matrix_world
    return scene


def flicker(first, second):
    """Of two renders (frames, h, w) with seeds of their own."""
    change = np.diff(first, axis=0) - np.diff(second, axis=0)
    return 0.5 * (change**2).mean() / (first * second).mean()


def _grey(method, name, arguments, frame, seed):
    """The mean of a frame's channels."""
    return timed(method, _frame(name, arguments.width, frame), arguments.seconds, 2 * frame + seed)[0].mean(axis=-1)


def main(words):
    """Runs the measurement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*", choices=PEOPLE, default=["slats", "leaves"])
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--width", type=int, default=128)
    parser.add_argument("--seconds", type=float, default=4, help="of CPU, of a frame")
    arguments = parser.parse_args(words)
    addon.register()
    for name in arguments.only:
        found = {}
        for method in METHODS:
            renders = np.array([[_grey(method, name, arguments, frame, seed) for frame in range(arguments.frames)] for seed in (1, 2)])
            found[method] = flicker(*renders), flicker(*parts(renders))
        told = ", ".join(f"{method} {pixels:.2e} (parts {large:.1e})" for method, (pixels, large) in found.items())
        ratios = np.divide(found["covbeam"], found["OIDN"])
        print(f"{name:10} {arguments.frames} frames of {arguments.seconds:g} s: {told}: {ratios[0]:.2f} ({ratios[1]:.2f})", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
    sys.stdout.flush()
    # Some simulations end the process in a way of their own if that is not done here.
    os._exit(0)
