# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lights -> host.scene.Light, in the units of Cycles."""

import math

import numpy as np

from ..host.scene import Light, LightKind, Pattern
from .nodes import Values, follow
from .textures import Places

#: Directions of a lamp are told apart by angles from its axis and around it.
_CELLS = 512, 1024

#: The same where a ball's normals are averaged, which leaves nothing fine: by so many of them. And places that tell whether that must be.
_COARSE, _NORMALS, _LOOKS = (64, 128), 256, 64


def light(lamp, name, matrix, report):
    """The host's light, or None if it emits nothing.

    - lamp: evaluated bpy.types.Light; name: of its object.
    - matrix: light -> world, float64 (4, 4).
    """
    values = Values(f'Light "{name}"', report, in_fog=True)
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not lengths.all():
        values.note("a scale of 0", "it does not shine")
        return None
    axes = (matrix[:3, :3] / lengths).T
    strength, pattern = _strength(lamp, values, axes)
    if np.any(strength < 0):
        values.note("negative strength", "it does not shine")
        return None
    portal = lamp.type == "AREA" and hasattr(lamp, "cycles") and lamp.cycles.is_portal
    if portal or not strength.any() or (pattern is not None and not pattern.cells.any()):
        return None
    placed = {"name": name, "position": matrix[:3, 3].copy(), "axis": -axes[2]}
    if pattern is not None:
        placed["pattern"] = pattern
    return _KINDS[lamp.type](lamp, matrix, axes, strength, placed, values)


def _strength(lamp, values, axes):
    """What Cycles multiplies the light's geometric factor with, (3,): colour times power, and the Emission node; and a host.scene.Pattern
    if that differs with direction, or None."""
    strength = np.array(lamp.color, np.float64) * lamp.energy
    # Both came after Blender 4.2.
    if getattr(lamp, "use_temperature", False):
        strength = strength * np.array(lamp.temperature_color, np.float64)
    strength = strength * 2.0 ** getattr(lamp, "exposure", 0.0)
    if not lamp.use_nodes or lamp.node_tree is None:
        return strength, None
    trial = values.quiet()
    emission = _emission(lamp.node_tree, trial)
    if trial.varies and lamp.type in ("POINT", "SPOT"):
        return strength, _pattern(lamp, values, axes)
    values.report.extend(trial.report)
    return strength * emission, None


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
    """The Emission node's light in all directions that a lamp shines in."""
    reach = min(lamp.spot_size / 2, math.pi) if lamp.type == "SPOT" else math.pi
    along = np.stack([axes[0], axes[1], -axes[2]])

    def shines(normals, leaving):
        """Light of places with some normals that leaves them along directions, (n, 3) both, of the lamp's own space."""
        with np.errstate(all="ignore"):
            places = Places(away=normals, away_in_world=normals @ axes, leaving=leaving @ axes)
            found = _emission(lamp.node_tree, values.at(places))
        # What is no number is dark.
        return np.clip(np.nan_to_num(np.broadcast_to(found, normals.shape), posinf=0.0), 0, 1e30)

    # The ball of a lamp with a size has a normal at each place that is seen; a disk that faces what it lights has one, as a point has.
    if lamp.shadow_soft_size > 0 and not lamp.use_soft_falloff and _heeds_normals(shines, values):
        return Pattern(_of_ball(shines, reach), along, reach)
    away = _directions(*_CELLS, reach)
    return Pattern(shines(away, away).reshape(*_CELLS, 3).astype(np.float32), along, reach)


def _directions(rows, columns, reach):
    """Unit vectors in the middles of cells of a Pattern, in the lamp's own space: float64 (rows * columns, 3)."""
    angle, turn = (np.arange(rows) + 0.5) * (reach / rows), (np.arange(columns) + 0.5) * (2 * math.pi / columns)
    angle, turn = np.meshgrid(angle, turn, indexing="ij")
    # A lamp shines along its -Z.
    return np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), -np.cos(angle)], axis=-1).reshape(-1, 3)


def _heeds_normals(shines, values):
    """Whether light depends on the normal where it leaves; that it depends on its direction too is said."""
    random = np.random.default_rng(0).normal(size=(2, _LOOKS, 3))
    normals, leaving = random / np.linalg.norm(random, axis=-1, keepdims=True)
    one = np.broadcast_to(normals[:1], normals.shape)
    by_normal, by_direction = shines(normals, one), shines(one, leaving)
    if not (by_normal != by_normal[0]).any():
        return False
    if (by_direction != by_direction[0]).any():
        values.note("a pattern of a ball by normals and directions", "coarser than 3 degrees by directions", in_fog=True)
    return True


def _of_ball(shines, reach):
    """Cells of what all places of a ball that are seen from far away send there, each as large as it is seen: float32 (rows, columns, 3)."""
    rows, columns = _COARSE
    away = _directions(rows, columns, reach)
    # Normals around a direction, as many for the same area that is seen: evenly over a disk (Vogel's spiral), and up from there.
    radius, turn = np.sqrt((np.arange(_NORMALS) + 0.5) / _NORMALS), np.arange(_NORMALS) * (math.pi * (3 - math.sqrt(5)))
    disk = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - radius**2)], axis=-1)
    side = np.cross(away, np.where(np.abs(away[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    total = np.zeros_like(away)
    for x, y, z in disk:
        total += shines(x * side + y * np.cross(away, side) + z * away, away)
    coarse = (total / _NORMALS).reshape(rows, columns, 3)
    # What lies beyond a pole is half a turn away.
    ends = [np.roll(coarse[row], columns // 2, axis=0)[None] for row in (0, -1)]
    coarse = np.concatenate([ends[0], coarse, ends[1] if reach == math.pi else coarse[-1:]])
    # Between the middles of coarse cells, and around.
    place = [(np.arange(fine) + 0.5) * (few / fine) - 0.5 for fine, few in zip(_CELLS, _COARSE)]
    low = [np.floor(at).astype(int) for at in place]
    rest = [(at - below)[:, None, None] for at, below in zip(place, low)]
    by_rows = (1 - rest[0]) * coarse[low[0] + 1] + rest[0] * coarse[low[0] + 2]
    turned = np.moveaxis(by_rows, 1, 0)
    cells = (1 - rest[1]) * turned[low[1] % columns] + rest[1] * turned[(low[1] + 1) % columns]
    return np.moveaxis(cells, 0, 1).astype(np.float32)


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
        values.note("spot with uneven scale", "its cone stays round, with the angle of its Spot Size")
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
        values.note("sheared area light", "it shines at right angles to its face")
    if across @ axes[2] > 0:
        # Blender's lights shine along -Z; the host's along u x v.
        v = -v
    radiance = strength / math.pi
    if getattr(lamp, "normalize", True):
        radiance = radiance / area
    if lamp.spread < 1e-3:
        values.note("area light without spread", "a spread of 0.06 degrees")
    spread = max(lamp.spread / 2, 5e-4)
    return Light(kind=LightKind.AREA, u=u, v=v, round=round_, spread=spread, radiance=radiance, **placed)


def _sun(lamp, matrix, axes, strength, placed, values):
    angle = lamp.angle / 2
    if not getattr(lamp, "normalize", True) and angle > 0:
        # The strength is then the radiance.
        strength = strength * math.pi * math.sin(angle) ** 2
    return Light(kind=LightKind.SUN, irradiance=strength, angle=angle, **placed)


_KINDS = {"POINT": _point, "SPOT": _spot, "AREA": _area, "SUN": _sun}
