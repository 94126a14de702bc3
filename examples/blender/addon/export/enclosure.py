# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that hold fog: whether their faces are around it, as seen by rays."""

import numpy as np
from covbeam.session import Geometry

#: Rays, and how many faces each may meet: more are as good as right.
_RAYS, _FACES = 1024, 64

#: How far rays start behind a face, in shares of the mesh's size.
_BEHIND = 1e-5


def wrong(mesh, poll):
    """The share of rays through the faces of a meshes.Triangles that do not go in by a front and out by a back, each time.

    Cycles' fog begins behind each front and ends at each back, if it is there at all: where a mesh is open, inside out or goes through itself it
    depends on where one looks from.
    """
    geometry = Geometry()
    number = geometry.add_mesh(mesh.positions, mesh.corners, 0, None)
    geometry.add_instance(number, np.eye(4), 0)
    geometry.build(poll)
    a, b, c = (mesh.positions[mesh.corners[:, k]].astype(np.float64) for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    if not 0 < areas.sum() < np.inf:
        return 0.0
    rng = np.random.default_rng(0)
    of = rng.choice(len(areas), _RAYS, p=areas / areas.sum())
    shares = rng.dirichlet((1, 1, 1), _RAYS)
    targets = np.einsum("nc,ncx->nx", shares, np.stack([a, b, c], axis=1)[of])
    ways = rng.normal(size=(_RAYS, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    size = float(np.linalg.norm(mesh.positions.max(axis=0).astype(np.float64) - mesh.positions.min(axis=0)))
    places, live = targets - 1.5 * size * ways, np.arange(_RAYS)
    inside, bad = np.zeros(_RAYS, bool), np.zeros(_RAYS, bool)
    for _ in range(_FACES):
        hits = geometry.cast(places[live].astype(np.float32), ways[live].astype(np.float32))
        met = hits["distance"] < 3 * size
        bad[live[~met]] |= inside[live[~met]]
        live, hits = live[met], hits[met]
        if not len(live):
            break
        is_front = np.einsum("nk,nk->n", hits["geometric_normal"], ways[live]) < 0
        bad[live] |= is_front == inside[live]
        inside[live] = is_front
        places[live] = hits["position"] + _BEHIND * size * ways[live]
    return float(bad.mean())
