# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lights -> host.scene.Light, in the units of Cycles."""

import math

import numpy as np

from ..host.scene import Light, LightKind, Pattern
from .falloff import DISTANCES, NONE, falloff
from .nodes import Values, follow
from .patterns import cells_of, directions
from .textures import Places


def light(lamp, name, matrix, report, facts=()):
    """The host's light, or None if it emits nothing.

    - lamp: evaluated bpy.types.Light; name: of its object.
    - matrix: light -> world, float64 (4, 4).
    - facts: as nodes.Values has them.
    """
    values = Values(f'Light "{name}"', report, facts=facts)
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not lengths.all():
        values.note("a scale of 0", "it does not shine", in_fog=True)
        return None
    axes = (matrix[:3, :3] / lengths).T
    strength, pattern, (exponent, smooth) = _strength(lamp, values, axes)
    if np.any(strength < 0):
        values.note("negative strength", "it does not shine", in_fog=True)
        return None
    portal = lamp.type == "AREA" and hasattr(lamp, "cycles") and lamp.cycles.is_portal
    if portal or not strength.any() or (pattern is not None and not pattern.cells.any()):
        return None
    # What is the strength at a metre is the host's times 1 / (1 + smooth).
    strength = strength * (1 + smooth)
    placed = {"name": name, "position": matrix[:3, 3].copy(), "axis": -axes[2], "falloff": exponent, "smooth": smooth}
    if pattern is not None:
        placed["pattern"] = pattern
    return _KINDS[lamp.type](lamp, matrix, axes, strength, placed, values)


def _strength(lamp, values, axes):
    """What Cycles multiplies the light's geometric factor with, (3,): colour times power, and the Emission node; a host.scene.Pattern if that
    differs with direction, or None; and the host's falloff and smooth."""
    strength = np.array(lamp.color, np.float64) * lamp.energy
    # Both came after Blender 4.2.
    if getattr(lamp, "use_temperature", False):
        strength = strength * np.array(lamp.temperature_color, np.float64)
    strength = strength * 2.0 ** getattr(lamp, "exposure", 0.0)
    if not lamp.use_nodes or lamp.node_tree is None:
        return strength, None, NONE
    trial = values.quiet()
    emission = _emission(lamp.node_tree, trial)
    if not trial.varies:
        values.report.extend(trial.report)
        return strength * emission, None, NONE
    if lamp.type == "SUN":
        return strength * _emissions(lamp, values, distance=np.full((1, 1), np.inf))[0], None, NONE
    trial = values.quiet()
    along = _emissions(lamp, trial, distance=DISTANCES)
    if lamp.type == "AREA" or not len(trial.report):
        values.report.extend(trial.report)
        return strength * along[0], None, _falloff(values, along[None])
    away = directions(_reach(lamp), 8, 8)
    places = {"away": np.repeat(away, len(DISTANCES), axis=0), "distance": np.tile(DISTANCES, (len(away), 1))}
    along = _emissions(lamp, values.quiet(), away_in_world=places["away"] @ axes, **places)
    return strength, _pattern(lamp, values, axes), _falloff(values, along.reshape(len(away), len(DISTANCES), 3))


def _emissions(lamp, values, **places):
    """The Emission node's light where places are, float64 (n, 3): finite and >= 0."""
    # What is no number is dark.
    with np.errstate(all="ignore"):
        found = _emission(lamp.node_tree, values.at(Places(**places)))
    return np.clip(np.nan_to_num(np.broadcast_to(found, (len(places["distance"]), 3)), posinf=0.0), 0, 1e30)


def _falloff(values, strengths):
    """The host's falloff and smooth of strengths at DISTANCES in some directions, (m, n, 3)."""
    shining = strengths[:, 0] > 0
    found = falloff((strengths[:, 1:] / np.where(shining, strengths[:, 0], 1)[:, None]).swapaxes(1, 2)[shining].T) if shining.any() else NONE
    if found is None:
        values.note("a strength that changes with distance", "the one at a metre, at all distances", in_fog=True)
    return found or NONE


def _reach(lamp):
    return min(lamp.spot_size / 2, math.pi) if lamp.type == "SPOT" else math.pi


def _emission(tree, values):
    output = tree.get_output_node("CYCLES")
    end = follow(output.inputs["Surface"]) if output is not None else None
    if end is None or end.node is None:
        return np.zeros(3)
    if end.node.type != "EMISSION":
        values.note(f"{end.node.bl_label} in a light", "the light's own strength and colour are used", in_fog=True)
        return np.ones(3)
    return values.colour(end.node, "Color", end.groups) * values.number(end.node, "Strength", end.groups)


def _pattern(lamp, values, axes):
    """The Emission node's light a metre away in all directions that a lamp shines in."""

    def shines(normals, leaving):
        near = np.full((len(normals), 1), DISTANCES[0])
        return _emissions(lamp, values, away=normals, away_in_world=normals @ axes, leaving=leaving @ axes, distance=near)

    is_ball = lamp.shadow_soft_size > 0 and not lamp.use_soft_falloff
    return Pattern(cells_of(shines, _reach(lamp), is_ball, values), np.stack([axes[0], axes[1], -axes[2]]), _reach(lamp))


def _point_intensity(lamp, strength):
    """[W/sr] of a point or spot light, on the axis."""
    if getattr(lamp, "normalize", True):
        return strength / (4 * math.pi)
    # Cycles: the strength is then pi times the radiance, or the intensity of a light without size.
    size = lamp.shadow_soft_size
    return strength * (size**2 if size > 0 else 1 / math.pi)


def _point(lamp, matrix, axes, strength, placed, values):
    intensity, radius = _point_intensity(lamp, strength), lamp.shadow_soft_size
    return Light(kind=LightKind.POINT, radius=radius, soft=lamp.use_soft_falloff, intensity=intensity, **placed)


def _spot(lamp, matrix, axes, strength, placed, values):
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if np.ptp(lengths) > 1e-3 * lengths.max():
        values.note("spot with uneven scale", "its cone stays round, with the angle of its Spot Size", in_fog=True)
    if lamp.shadow_soft_size > 0 and not lamp.use_soft_falloff:
        values.note("spot without Soft Falloff", "in Cycles the fog inside of its ball is up to 1.5 times as bright")
    cosine = math.cos(lamp.spot_size / 2)
    return Light(
        kind=LightKind.SPOT,
        radius=lamp.shadow_soft_size,
        soft=lamp.use_soft_falloff,
        intensity=_point_intensity(lamp, strength),
        cosine=cosine,
        # Blend 0 is a jump, which 1e-6 is in single precision.
        blend=max((1 - cosine) * lamp.spot_blend, 1e-6),
        **placed,
    )


def _area(lamp, matrix, axes, strength, placed, values):
    round_ = lamp.shape in ("DISK", "ELLIPSE")
    u = matrix[:3, 0] * lamp.size
    v = matrix[:3, 1] * (lamp.size_y if lamp.shape in ("RECTANGLE", "ELLIPSE") else lamp.size)
    area = np.linalg.norm(u) * np.linalg.norm(v) * (math.pi / 4 if round_ else 1)
    if area == 0:
        return None
    across = np.cross(u, v)
    if np.linalg.norm(np.cross(across, axes[2])) > 1e-3 * np.linalg.norm(across):
        values.note("sheared area light", "it shines at right angles to its face", in_fog=True)
    if across @ axes[2] > 0:
        # Blender's lights shine along -Z; the host's along u x v.
        v = -v
    radiance = strength / math.pi
    if getattr(lamp, "normalize", True):
        radiance = radiance / area
    if lamp.spread < 1e-3:
        values.note("area light without spread", "a spread of 0.06 degrees", in_fog=True)
    spread = max(lamp.spread / 2, 5e-4)
    return Light(kind=LightKind.AREA, u=u, v=v, round=round_, spread=spread, radiance=radiance, **placed)


def _sun(lamp, matrix, axes, strength, placed, values):
    angle = lamp.angle / 2
    if not getattr(lamp, "normalize", True) and angle > 0:
        # The strength is then the radiance.
        strength = strength * math.pi * math.sin(angle) ** 2
    return Light(kind=LightKind.SUN, irradiance=strength, angle=angle, **placed)


_KINDS = {"POINT": _point, "SPOT": _spot, "AREA": _area, "SUN": _sun}
