"""How fast rays are cast: Blender's BVHTree in a loop, and covbeam_rays, on the same triangles. Prints both, and fails
if they see different distances.

Run by a Python that has bpy, covbeam and covbeam_rays:  python measure_casts.py [RAYS]
"""

import resource
import sys
import time

import bpy  # noqa: F401 - mathutils is a part of it
import covbeam_rays
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

#: Squares along a side of the grid: two triangles each.
SIDE = 500


def grid():
    """A displaced grid over [-1, 1]^2: positions (n, 3), triangles (m, 3)."""
    x, y = np.meshgrid(np.linspace(-1, 1, SIDE + 1), np.linspace(-1, 1, SIDE + 1))
    z = 0.3 * np.sin(5 * x) * np.cos(4 * y) + 0.05 * np.sin(40 * x) * np.sin(37 * y)
    positions = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)
    a = (np.arange(SIDE)[:, None] * (SIDE + 1) + np.arange(SIDE)).reshape(-1)
    b, c, d = a + 1, a + SIDE + 2, a + SIDE + 1
    return positions, np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).astype(np.int32)


def smooth_normals(positions, triangles):
    """Unit means of the faces' normals, one a corner."""
    corners = positions[triangles].astype(np.float64)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros(positions.shape)
    for corner in range(3):
        np.add.at(sums, triangles[:, corner], faces)
    return (sums / np.linalg.norm(sums, axis=1, keepdims=True)).astype(np.float32)[triangles]


def random_rays(count):
    """Incoherent: from anywhere in the box around the grid to anywhere."""
    random = np.random.default_rng(1)
    origins = random.uniform(-1, 1, (count, 3)) * (1, 1, 0.6)
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return origins.astype(np.float32), directions.astype(np.float32)


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


class Timed:
    """Prints a rate: by the clock, and by the time that cores were at work, which other programs hardly change."""

    def __init__(self, what, count):
        self.what, self.count = what, count

    def __enter__(self):
        self.wall, self.work = time.perf_counter(), time.process_time()

    def __exit__(self, *_):
        wall, work = time.perf_counter() - self.wall, time.process_time() - self.work
        rates = f"{self.count / wall / 1e6:.3f} million/s, {self.count / work / 1e6:.3f} million a core-second"
        print(f"{self.what}: {rates}")


def ours(positions, triangles, origins, directions):
    """Distances found by covbeam_rays."""
    normals = smooth_normals(positions, triangles)
    before, start = resident(), time.perf_counter()
    geometry = covbeam_rays.Geometry()
    geometry.add_instance(geometry.add_mesh(positions, triangles, 0, normals), np.eye(4), 0)
    added = time.perf_counter()
    geometry.build()
    built = time.perf_counter()
    print(
        f"covbeam_rays: copied in {added - start:.3f} s, built in {built - added:.3f} s, "
        f"holds {geometry.memory / 1e6:.0f} MB, resident +{(resident() - before) / 1e6:.0f} MB"
    )
    hits = np.zeros(len(origins), covbeam_rays.HIT)
    for threads in (1, 2):
        covbeam_rays.threads(threads)
        with Timed(f"covbeam_rays, casts with curvature, {threads} threads", len(origins)):
            geometry.cast(origins, directions, out=hits)
    few = slice(0, len(origins) // 20)
    with Timed("covbeam_rays, searches for edges, 2 threads", few.stop):
        counts, _ = geometry.edges(origins[few], directions[few], hits[few])
    print(f"{np.isfinite(hits['distance']).mean():.0%} of the rays hit; {counts.mean():.2f} edges a ray")
    return hits["distance"].astype(np.float64)


def theirs(positions, triangles, origins, directions):
    """Distances found by Blender's BVHTree."""
    before, start = resident(), time.perf_counter()
    tree = BVHTree.FromPolygons(positions.tolist(), triangles.tolist(), all_triangles=True)
    print(f"BVHTree: built in {time.perf_counter() - start:.3f} s, resident +{(resident() - before) / 1e6:.0f} MB")
    pairs = list(zip(map(Vector, origins.tolist()), map(Vector, directions.tolist())))
    with Timed("BVHTree.ray_cast in a loop, its vectors made before", len(pairs)):
        found = [tree.ray_cast(origin, direction)[3] for origin, direction in pairs]
    return np.array([np.inf if distance is None else distance for distance in found])


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    positions, triangles = grid()
    origins, directions = random_rays(count)
    print(f"{len(triangles)} triangles, {count} rays that have nothing in common")
    few = min(count, 200_000)
    a = ours(positions, triangles, origins, directions)[:few]
    b = theirs(positions, triangles, origins[:few], directions[:few])
    both = np.isfinite(a) & np.isfinite(b)
    # Both work in single precision on coordinates up to 1: a few roundings of 6e-8, over the cosine at grazing hits.
    off = (np.abs(a[both] - b[both]) > 1e-5).sum()
    one = (np.isfinite(a) != np.isfinite(b)).sum()
    print(f"distances differ by more than 1e-5: {off} of {both.sum()}; only one of the two hits: {one}")
    # Rays through edges and tips, where rounding decides.
    if off + one > 1e-4 * few:
        sys.exit("covbeam_rays and BVHTree see different surfaces")


main()
