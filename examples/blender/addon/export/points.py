# SPDX-License-Identifier: GPL-3.0-or-later
"""Point clouds -> triangles: balls that take as much light, on average, as the spheres that Cycles has."""

import numpy as np

from .meshes import Triangles, extent_of

#: Triangles of all balls; how often the eight faces of a ball are cut into four, the best first.
_MOST, _CUTS = 4_000_000, (3, 2, 1, 0)

#: Cycles' radius where points have none [m].
_NO_RADIUS = 0.01


def balls(cloud):
    """The Triangles of an evaluated bpy.types.PointCloud, or None without points, and of how many points one is there, as wide as all of them."""
    count = len(cloud.points)
    if count == 0:
        return None, 1
    positions, radii = np.empty(3 * count, np.float32), np.full(count, _NO_RADIUS, np.float32)
    cloud.attributes["position"].data.foreach_get("vector", positions)
    found = cloud.attributes.get("radius")
    if found is not None and found.domain == "POINT" and found.data_type == "FLOAT":
        found.data.foreach_get("value", radii)
    every = -(-8 * count // _MOST)
    positions, radii = positions.reshape(-1, 3)[::every], np.maximum(radii[::every], 0) * np.float32(every**0.5)
    out, faces = next(ball for cuts in _CUTS if len((ball := _ball(cuts))[1]) * len(radii) <= _MOST or cuts == 0)
    made = positions[:, None] + radii[:, None, None] * (out * _wider(out, faces)).astype(np.float32)
    corners = (len(out) * np.arange(len(radii))[:, None, None] + faces).reshape(-1, 3).astype(np.int32)
    normals = out.astype(np.float32)[faces]
    normals = np.broadcast_to(normals, (len(radii), *normals.shape)).reshape(-1, 3, 3)
    made = made.reshape(-1, 3)
    slots = np.zeros(len(corners), np.int32)
    return Triangles(made, corners, slots, np.zeros(1, np.int64), np.ascontiguousarray(normals), extent_of(made)), every


def _ball(cuts):
    """Corners (n, 3), at a distance of 1, and faces (m, 3) to the outside of an octahedron whose faces are cut into four so often."""
    corners = np.concatenate([np.eye(3), -np.eye(3)])
    faces = np.array([(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)])
    for _ in range(cuts):
        sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
        ends, index = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
        middles = corners[ends].sum(axis=1)
        ab, bc, ca = (len(corners) + index.reshape(-1, 3)).T
        corners = np.concatenate([corners, middles / np.linalg.norm(middles, axis=1, keepdims=True)])
        a, b, c = faces.T
        faces = np.concatenate([np.stack(of, axis=1) for of in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return corners, faces


def _wider(corners, faces):
    """By how much such a ball must be wider to be seen as large as a sphere, on average from all around: a fourth of its surface."""
    a, b, c = (corners[faces[:, k]] for k in range(3))
    return np.sqrt(4 * np.pi / (0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()))
