# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes for tests of the host, made without Blender."""

import numpy as np
from addon.export.meshes import inset
from addon.host.scene import MATERIAL, OBJECT_RULES, Camera, Density, Light, LightKind, Phase, Projection, Scene, Volume
from covbeam.session import Geometry


def icosphere(radius, center=(0, 0, 0), levels=5):
    """(positions, triangles, corner normals) of a ball, counter-clockwise from outside; its volume is the ball's."""
    g = (1 + 5**0.5) / 2
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g)]
    points += [(g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = "0 11 5 0 5 1 0 1 7 0 7 10 0 10 11 1 5 9 5 11 4 11 10 2 10 7 6 7 1 8 "
    faces += "3 9 4 3 4 2 3 2 6 3 6 8 3 8 9 4 9 5 2 4 11 6 2 10 8 6 7 9 8 1"
    points, faces = np.array(points, np.float64), np.array(faces.split(), int).reshape(-1, 3)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(levels):
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        unique, where = np.unique(edges, axis=0, return_inverse=True)
        middle = points[unique].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        ab, bc, ca = where.reshape(-1).reshape(3, -1) + len(points)
        a, b, c = faces.T
        faces = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
        points = np.concatenate([points, middle])
    corners = points[faces]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    scale = radius * (4 / 3 * np.pi / volume) ** (1 / 3)
    positions = (points * scale + center).astype(np.float32)
    return positions, faces.astype(np.int32), corners.astype(np.float32)


def box(low, high):
    """(positions, triangles, None) of a closed box, counter-clockwise from outside."""
    corners = np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)], np.float32)
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32), None


def material(**values):
    """One row of MATERIAL."""
    row = np.zeros((), MATERIAL)
    row["ior"] = 1.5
    for name, value in values.items():
        row[name] = value
    return row


GLASS = material(glass_reflection=1, glass_transmission=1)
BLACK = material()
BOUND = material(transparent=1)


def volume(name, scattering, absorption, asymmetry=0.0, low=-np.inf, high=np.inf, density=None, glow=None):
    """A Volume, grey or of three channels; asymmetry: of Henyey-Greenstein; density: a Density, or None for 1 everywhere; glow: a Glow."""
    s, a, low, high = (np.broadcast_to(np.asarray(v, np.float64), 3).copy() for v in (scattering, absorption, low, high))
    phase = Phase.HENYEY_GREENSTEIN if asymmetry else Phase.ISOTROPIC
    return Volume(name, s, a, low, high, phase, asymmetry, density, glow)


_CELLS = 12


def _cloud():
    """Relative densities of a cloud at the middles of voxels between -1 and 1, (z, y, x), the largest 1: thick, thin, and none."""
    z, y, x = (np.mgrid[0:_CELLS, 0:_CELLS, 0:_CELLS] + 0.5) * (2 / _CELLS) - 1
    blobs = np.exp(-4 * ((x + 0.3) ** 2 + (y - 0.2) ** 2 + z**2)) + 0.6 * np.exp(-12 * ((x - 0.5) ** 2 + (y + 0.4) ** 2 + (z - 0.2) ** 2))
    blobs = np.maximum(blobs - 0.05, 0)
    return (blobs / blobs.max()).astype(np.float32)


def cloud():
    """The same as a Density."""
    return Density(np.full(3, -1.0), np.full(3, 1.0), _cloud())


def density(places):
    """That cloud's density at places (..., 3)."""
    return density_at(cloud(), places)


def density_at(density, places):
    """A Density at places (..., 3): trilinear between the middles of voxels, held beyond the outermost; 0 outside of its box."""
    values, found = density.values.astype(np.float64), 0
    cells = np.array(values.shape[::-1])
    at = np.clip((places - density.min) / (density.max - density.min) * cells - 0.5, 0, cells - 1)
    low = np.minimum(at.astype(int), np.maximum(cells - 2, 0))
    rest = at - low
    for corner in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(corner, rest, 1 - rest), axis=-1)
        place = (np.minimum(low[..., k] + corner[k], cells[k] - 1) for k in (2, 1, 0))
        found = found + weight * values[tuple(place)]
    return np.where(((places >= density.min) & (places <= density.max)).all(axis=-1), found, 0)


def glow_at(glow, places):
    """A Glow at places (n, 3), the same: (n, 3)."""
    channels = (Density(glow.min, glow.max, glow.values[..., k]) for k in range(3))
    return np.stack([density_at(channel, places) for channel in channels], axis=-1)


def camera(position, look_at, vertical_fov, width, height, up=(0, 1, 0)):
    """A Camera with square pixels; the angle is in degrees."""
    position = np.asarray(position, np.float64)
    forward = np.asarray(look_at, np.float64) - position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    pixel = 2 * np.tan(np.radians(vertical_fov) / 2) / height
    left, top = -0.5 * width * pixel, 0.5 * height * pixel
    return Camera(position, right, np.cross(right, forward), forward, left, top, (pixel, pixel), width, height)


def directions(view, x, y):
    """Unit directions of a Camera's eye rays through places of its picture (n,) [pixels]: float64 (n, 3)."""
    across, up = view.left + np.asarray(x) * view.step[0], view.top - np.asarray(y) * view.step[1]
    d = view.forward + across[:, None] * view.right + up[:, None] * view.up
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def rays(view, x, y):
    """Eye rays of a Camera of any projection through places of its picture (n,) [pixels], before its near plane is reached: where they
    start, and their unit directions, float64 (n, 3); nan where there is none."""
    h, v = view.left + np.asarray(x, float)[:, None] * view.step[0], view.top - np.asarray(y, float)[:, None] * view.step[1]
    starts = np.broadcast_to(view.position, (len(h), 3))
    match view.projection:
        case Projection.PERSPECTIVE:
            return starts, directions(view, x, y)
        case Projection.ORTHOGRAPHIC:
            return starts + h * view.right + v * view.up, np.broadcast_to(view.forward, (len(h), 3))
        case Projection.EQUIRECTANGULAR:
            level = np.cos(h) * view.forward + np.sin(h) * view.right
            return starts, np.cos(v) * level + np.sin(v) * view.up
        case Projection.FISHEYE:
            angle, turn = np.hypot(h, v), np.arctan2(v, h)
            outward = np.cos(turn) * view.right + np.sin(turn) * view.up
            found = np.cos(angle) * view.forward + np.sin(angle) * outward
            return starts, np.where(angle <= view.widest, found, np.nan)


def point(position, intensity, radius=0.0):
    """A ball of light."""
    place, grey = np.asarray(position, float), np.full(3, float(intensity))
    return Light("lamp", LightKind.POINT, position=place, intensity=grey, radius=radius)


def scene(meshes, lights, volumes, view, world=-1):
    """A Scene of (mesh, material, volume index or -1) triples."""
    geometry = Geometry()
    reach = max((float(np.abs(mesh[0]).max()) for mesh, _, _ in meshes), default=0.0)
    for number, ((positions, triangles, normals), surface, _) in enumerate(meshes):
        mesh, matrix = geometry.add_mesh(positions, triangles, number, normals), np.eye(4)
        if (surface["transparent"] >= 1).all():
            matrix, _, _ = inset(matrix, positions.min(axis=0), positions.max(axis=0), reach, number)
        geometry.add_instance(mesh, matrix, number)
    geometry.build()
    materials = np.array([m for _, m, _ in meshes] or [BLACK], MATERIAL)
    inside = np.array([v for _, _, v in meshes], np.int32)
    closed = np.ones(len(meshes), bool)
    return Scene(geometry, materials, inside, closed, np.zeros(len(inside), OBJECT_RULES), volumes, world, lights, view)


def open_glass_ball(size):
    """examples/scenes/open-glass-ball.toml: fog without end, and none in the glass."""
    fog, nothing = volume("fog", 0.15, 0.15), volume("nothing", 0, 0, low=-0.5, high=0.5)
    view = camera((0, 0, -4), (0, 0, 0), 40, size, size)
    return scene([(icosphere(0.5), GLASS, 1)], [point((1, 2.4, 0), 25)], [fog, nothing], view, world=0)


def black_ball(size, fog=None):
    """examples/scenes/black-ball.toml without floor and room: a shadow in fog without end."""
    view = camera((0, 0.5, -5), (0, 0, 0), 35, size, size)
    fog = fog or volume("fog", 0.2, 0.02)
    return scene([(icosphere(0.5), BLACK, -1)], [point((0, 2.5, 0), 25)], [fog], view, world=0)


def mixed(scale=1.0, at=(0, 0, 0), power=1.0, size=16):
    """Fog of three colours, a glass ball in it, a floor, a light of each kind: of any size and power, anywhere."""

    def place(*v):
        return scale * np.array(v, float) + np.asarray(at, float)

    grey = np.ones(3)
    corner = np.array([place(2, 0, 0), place(2, 0.5, 0), place(2.1, 0.1, 0.4)], np.float32)
    lights = [
        point(place(0.3, 1.9, 0.2), 10 * power * scale**2, radius=0.05 * scale),
        Light(
            "spot",
            LightKind.SPOT,
            position=place(-1.8, 0.9, 0.2),
            axis=np.array([0.9, -0.4, 0]) / np.hypot(0.9, 0.4),
            cosine=0.9,
            blend=0.05,
            radius=0.02 * scale,
            intensity=20 * power * scale**2 * grey,
        ),
        Light(
            "area",
            LightKind.AREA,
            position=place(-2, 0.3, 0.2),
            u=np.array([0, 0, -0.7]) * scale,
            v=np.array([0, 0.5, 0]) * scale,
            spread=1.0,
            radiance=9 * power * grey,
        ),
        Light("sun", LightKind.SUN, axis=np.array([0.6, -0.8, 0]), angle=0.02, irradiance=2 * power * grey),
        Light("mesh", LightKind.MESH, triangles=corner[None], radiance=9 * power * grey),
    ]
    low, high = place(-1, -1, -1), place(1, 1, 1)
    scattering, absorption = np.array([0.3, 0.2, 0.1]) / scale, np.array([0.1, 0.05, 0.02]) / scale
    fog = volume("fog", scattering, absorption, 0.4, low, high)
    meshes = [
        (box(low, high), BOUND, 0),
        (icosphere(0.4 * scale, place(0.2, 0.1, -0.3), 3), GLASS, -1),
        (box(place(-2, -1.4, -2), place(2, -1.2, 2)), material(diffuse=0.7), -1),
    ]
    return scene(meshes, lights, [fog], camera(place(0.3, 0.2, -4), place(0, 0, 0), 40, size, size))
