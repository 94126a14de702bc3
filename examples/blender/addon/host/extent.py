# SPDX-License-Identifier: GPL-3.0-or-later
"""How large the things are that a picture is about: what is lit, and what a covariance grid has to cover."""

import covbeam
import numpy as np

from .emitting import Ball
from .scene import LightKind

#: The world's fog is looked at as far as this optical depth from camera and lights.
_DEPTH = 4.0


#: How far the bounds of fog are drawn in, in shares of the scene's largest coordinate: four times what rays start off
#: surfaces. Those of different objects differ, or the faces of fog in fog would still coincide; so many do.
_INSET, _INSETS = 2.0**-18, 8


def inset(matrix, low, high, reach, number):
    """The transform (4, 4) of an object that does nothing but bound fog, made smaller by a hair, and its corners then.

    Fog stands on floors and touches walls and other fog. Of two faces in one plane a ray would cross one only, or the
    wrong one.

    - low, high: corners of the object in the world [m]; reach: the largest coordinate of the scene [m].
    - number: of the object.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    hair = np.minimum((1 + number % _INSETS) * _INSET * reach, 0.1 * half)
    smaller = np.eye(4)
    smaller[:3, :3] = np.diag(np.where(half > 0, 1 - hair / np.where(half > 0, half, 1), 1))
    smaller[:3, 3] = middle - smaller[:3, :3] @ middle
    return smaller @ matrix, low + hair, high - hair


def _lights_and_camera(scene):
    points = [np.asarray(scene.camera.position, np.float64)]
    for light in scene.lights:
        if light.kind == LightKind.MESH:
            corners = light.triangles.reshape(-1, 3).astype(np.float64)
            points += [corners.min(axis=0), corners.max(axis=0)]
        elif light.kind not in (LightKind.SUN, LightKind.WORLD):
            points.append(np.asarray(light.position, np.float64))
    return np.array(points)


def volume_box(scene, number):
    """(low, high) of where a volume matters: its bounds, or for the world's what camera, lights and geometry fill."""
    volume = scene.volumes[number]
    if number != scene.world_volume:
        return np.asarray(volume.min, np.float64), np.asarray(volume.max, np.float64)
    points = _lights_and_camera(scene)
    low, high = points.min(axis=0), points.max(axis=0)
    extinction = float(np.mean(volume.scattering + volume.absorption))
    size = max(float(np.linalg.norm(high - low)), 1e-6)
    if scene.geometry.triangle_count:
        # Geometry farther away than twice the camera from the lights is background.
        seen = _DEPTH / extinction if extinction > 0 else size
        reach = min(2 * size, seen) if len(points) > 1 else seen
        bottom, top = (np.asarray(b, np.float64) for b in scene.geometry.bounds)
        near_bottom, near_top = np.clip(bottom, low - reach, high + reach), np.clip(top, low - reach, high + reach)
        low, high = np.minimum(low, near_bottom), np.maximum(high, near_top)
    # With nothing around, the camera looks into fog as far as it sees.
    diagonal = float(np.linalg.norm(high - low))
    margin = 0.1 * diagonal if diagonal > 1e-6 else (1 / extinction if extinction > 0 else 1.0)
    return low - margin, high + margin


def lit_ball(scene):
    """The ball around all volumes; without any, one around the camera."""
    if not scene.volumes:
        return Ball(np.asarray(scene.camera.position, np.float64), 1.0)
    boxes = [volume_box(scene, i) for i in range(len(scene.volumes))]
    return Ball.around(np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0))


def scene_ball(scene, lit):
    """The ball around what is lit and all geometry."""
    low, high = lit.center - lit.radius, lit.center + lit.radius
    if scene.geometry.triangle_count:
        bottom, top = scene.geometry.bounds
        low, high = np.minimum(low, bottom), np.maximum(high, top)
    return Ball.around(low, high)


def grid_layout(scene, number, voxels):
    """The GridLayout of a volume: cubes, `voxels` along the longest side."""
    low, high = volume_box(scene, number)
    # What is flat still needs a box that has a volume in single precision.
    least = max(1e-6 * float(np.abs([low, high]).max()), 1e-5 * float((high - low).max()), 1e-9)
    flat = 0.5 * np.maximum(least - (high - low), 0)
    low, high = low - flat, high + flat
    size = high - low
    side = float(size.max()) / voxels
    cells = [max(1, int(np.ceil(length / side - 1e-6))) for length in size]
    return covbeam.GridLayout(tuple(low.tolist()), tuple(high.tolist()), tuple(cells))


def typical_radiance(scene, emitter, lit):
    """Radiance of the picture to within a few powers of ten [W/(m^2 sr)]: that of light scattered once, if all of the lights' power
    crossed a sphere as large as the distance from the camera to what is lit."""
    away = float(np.linalg.norm(np.asarray(scene.camera.position, np.float64) - lit.center))
    distance = max(lit.radius, away)
    scattering = max((float(np.max(volume.scattering)) for volume in scene.volumes), default=0.0)
    scattered = min(max(scattering * distance, 1e-3), 1.0)
    typical = scattered * emitter.flux / (4 * np.pi * distance**2)
    # What is beyond single precision is dark, or makes no picture anyway.
    return min(max(typical, 1e-30), 1e30) if typical > 0 else 1.0
