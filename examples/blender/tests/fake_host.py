# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for export and host: a picture that is known exactly, so that what Blender makes of it can be judged."""

import sys
import time
import types
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Settings:
    seed: int
    photons: int
    grid: int
    radius: float
    quality: float
    bounces: int | None
    limits: object
    beyond: bool
    threads: int


@dataclass
class Picture:
    in_scattered: np.ndarray
    first: np.ndarray
    radius: np.ndarray
    bandwidth: np.ndarray
    error: np.ndarray
    groups: dict = field(default_factory=dict)


class Geometry:
    triangle_count = 12
    memory = 3456


@dataclass
class Camera:
    width: int
    height: int

    def coarser(self, pixel):
        return Camera(-(-self.width // pixel), -(-self.height // pixel))


@dataclass
class Scene:
    camera: Camera
    geometry: Geometry
    volumes: tuple = ("fog",)
    lights: tuple = ("lamp",)

    @property
    def shines(self):
        return bool(self.lights) or any(getattr(volume, "glow", None) is not None for volume in self.volumes)


def picture(width, height, passes=1, error=0.01):
    """Channels: red grows to the right, green downwards, from the first to the last pixel; blue counts passes. error: standard one, of red light."""
    values = np.zeros((height, width, 3), np.float32)
    values[..., 0] = np.linspace(0, 1, width)
    values[..., 1] = np.linspace(0, 1, height)[:, None]
    values[..., 2] = passes
    return Picture(values, values / 2, values[..., 0] + 2, values[..., 1] + 3, error * values[..., 0])


class Session:
    """seconds: how long a pass takes, in sleeps of `nap` between polls; error: of pictures. open: sessions that have not been closed."""

    seconds = 0.0
    error = 0.01
    nap = 0.02
    open = 0
    settings = []
    memory = 7_000_000
    pairs = 0

    def __init__(self, scene, settings, poll=None, instants=()):
        # Nobody's choice is the scene's own.
        self.scene, self.passes, self._most = scene, 0, settings.photons or 5000
        self.photons = self._most
        # Of parts that passes add to, and all that the library has.
        self.times = dict.fromkeys(("photons", "light fields", "grid", "beams", "plan", "gather", "picture"), 0.0)
        Session.open += 1
        Session.settings.append(settings)

    def render_pass(self, poll):
        from addon.host import ask

        end = time.perf_counter() + self.seconds
        ask(poll)
        while time.perf_counter() < end:
            time.sleep(self.nap)
            ask(poll)
        self.passes += 1

    def restart(self, photons, plain=False):
        self.passes, self.photons = 0, min(photons, self._most)

    def picture(self, poll=None):
        return picture(self.scene.camera.width, self.scene.camera.height, self.passes, self.error)

    def close(self):
        Session.open -= 1


def border(render):
    """Pixels of the part that is rendered, as Blender cuts it: x, y, width, height."""
    width = render.resolution_x * render.resolution_percentage // 100
    height = render.resolution_y * render.resolution_percentage // 100
    if not render.use_border:
        return 0, 0, width, height
    x, y = int(render.border_min_x * width), int(render.border_min_y * height)
    return x, y, int(render.border_max_x * width) - x, int(render.border_max_y * height) - y


def export(depsgraph, poll=None):
    from addon.export.report import Report

    report = Report()
    report.add('Object "Cube"', "hair", "left out")
    _, _, width, height = border(depsgraph.scene.render)
    return Scene(Camera(width, height), Geometry()), report


def export_view(depsgraph, space):
    from addon.export.report import Report

    return Scene(None, Geometry()), Report()


def _still(depsgraph, poll):
    scene, report = export(depsgraph, poll)
    return [scene], report


def install():
    """Puts the fakes in the place of the add-on's modules, which must not have been imported yet."""
    import addon.export
    import addon.host

    for package, name, contents in (
        (addon.host, "session", {"Session": Session, "Settings": Settings, "Picture": Picture}),
        (
            addon.export,
            "scene",
            {"export": lambda *given, **named: export(*given, **named), "export_view": lambda *given: export_view(*given)},
        ),
        (addon.export, "motion", {"exposures": lambda depsgraph, frame_set, poll: _still(depsgraph, poll)}),
    ):
        module = types.ModuleType(f"{package.__name__}.{name}")
        vars(module).update(contents)
        sys.modules[module.__name__] = module
        setattr(package, name, module)
