# SPDX-License-Identifier: GPL-3.0-or-later
"""What a Sky Texture looks like: Blender's models of it are asked in a process of their own."""

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import lru_cache
from math import cos, sin
from pathlib import Path

import bpy
import numpy as np

from ..host import Cancelled, ask

#: Settings of the node that its sky depends on, in any version of Blender.
_SETTINGS = (
    *("sky_type", "sun_direction", "turbidity", "ground_albedo", "sun_disc", "sun_size", "sun_intensity", "sun_elevation"),
    *("sun_rotation", "altitude", "air_density", "dust_density", "aerosol_density", "ozone_density"),
)

#: Models that have a disc of the sun.
_WITH_SUN = ("NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING")

#: A sky is given up after so long [s].
_PATIENCE = 120.0


class NoSky(Exception):
    """Why there is none."""


@dataclass(frozen=True)
class Sky:
    """A sky as the node gives it for the directions of the world."""

    #: Radiance without the sun's disc: cells as those of host.scene.Light.
    cells: np.ndarray
    #: Where the sun is, unit, float64 (3,); its angular radius [rad], and irradiance [W/m^2], float64 (3,): 0 without a disc.
    direction: np.ndarray
    angle: float
    irradiance: np.ndarray


def sky_of(node, poll):
    """The Sky of a node of type TEX_SKY. Raises NoSky; poll: as for export."""
    settings = {}
    for name in _SETTINGS:
        value = getattr(node, name, None)
        if value is not None:
            settings[name] = value if isinstance(value, (str, bool, int, float)) else tuple(value)
    if node.sky_type not in _WITH_SUN:
        settings["sun_disc"] = False
    elevation, turn = settings["sun_elevation"], settings["sun_rotation"]
    # Zero is north, and it goes on to the east.
    settings["direction"] = (cos(elevation) * sin(turn), cos(elevation) * cos(turn), sin(elevation))
    return _rendered(json.dumps(settings, sort_keys=True), _Poll(poll))


class _Poll:
    """A poll that does not tell skies apart."""

    def __init__(self, poll):
        self.poll = poll

    def __eq__(self, other):
        return isinstance(other, _Poll)

    def __hash__(self):
        return 0


@lru_cache(maxsize=8)
def _rendered(text, poll):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sky.npz"
        _run([*_blender(), "--", text, str(path)], poll.poll, Path(folder) / "output")
        with np.load(path) as found:
            cells, irradiance = found["cells"], found["irradiance"].astype(np.float64)
    settings = json.loads(text)
    cells = np.maximum(np.nan_to_num(cells, posinf=0.0), 0)
    return Sky(cells, np.array(settings["direction"]), settings.get("sun_size", 0.0) / 2, np.maximum(irradiance, 0))


def _blender():
    """The command for a Blender in background that runs sky_render.py."""
    program = str(Path(__file__).with_name("sky_render.py"))
    if bpy.app.binary_path:
        return bpy.app.binary_path, "--background", "--factory-startup", "--python-exit-code", "1", "--python", program
    # The bpy package is a module of Python's.
    return sys.executable, program


def _run(command, poll, said):
    """Runs a command, with all that it says in a file. Raises NoSky."""
    started = time.monotonic()
    hidden = {"creationflags": subprocess.CREATE_NO_WINDOW} if os.name == "nt" else {}
    try:
        with open(said, "wb") as output:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, **hidden)
            try:
                while (status := _status(process)) is None:
                    ask(poll)
                    if time.monotonic() - started > _PATIENCE:
                        raise NoSky(f"Blender takes more than {_PATIENCE:g} s for it")
            except (Cancelled, NoSky):
                process.kill()
                process.wait()
                raise
    except OSError as reason:
        raise NoSky(f"no other Blender can be started: {reason}") from reason
    # As a module Blender may crash as it ends, with all its work done.
    if status and not Path(command[-1]).is_file():
        lines = said.read_text(errors="replace").strip().splitlines()
        raise NoSky(f"Blender fails at it: {lines[-1] if lines else status}")


def _status(process):
    """The exit status of a process, if it ends within 50 ms."""
    try:
        return process.wait(0.05)
    except subprocess.TimeoutExpired:
        return None
