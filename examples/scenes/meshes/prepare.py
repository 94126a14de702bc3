"""Makes figurine.obj from the scan of the Stanford bunny that the PyPI package pymeshfix carries.

    pip install numpy==2.4.6 pymeshfix==0.18.1 fast-simplification==0.2.0
    python prepare.py figurine.obj

Steps: fill the holes of the scan, simplify, repair, stand the mesh on y = 0 with height 1 and centre it on
x = z = 0 (+y up), round to five decimals, check, write. The checks stop the program: it never writes a mesh
that is not closed.
"""

import sys
from pathlib import Path

import fast_simplification
import numpy as np
import pymeshfix

SCAN = Path(pymeshfix.__file__).parent / "examples" / "StanfordBunny.ply"
TRIANGLES = 24_000
DECIMALS = 5


def read_ply(path):
    """Positions and triangles of a binary little-endian PLY with float positions and triangles only."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    lines = head.decode("ascii").split("\n")
    assert "format binary_little_endian 1.0" in lines and "property list uchar int vertex_indices" in lines
    floats = [line for line in lines if line.startswith("property float")]
    assert floats == ["property float x", "property float y", "property float z"]
    count = {words[1]: int(words[2]) for words in map(str.split, lines) if words[:1] == ["element"]}
    points = np.frombuffer(body, "<f4", 3 * count["vertex"]).reshape(-1, 3)
    face = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    table = np.frombuffer(body, face, count["face"], points.nbytes)
    assert np.all(table["count"] == 3), "not all faces are triangles"
    return points.astype(float), table["corners"].astype(int)


def repair(points, faces):
    """The largest piece, its holes filled and its degenerate and self-intersecting triangles replaced."""
    fix = pymeshfix.MeshFix(points.astype(float), faces.astype(np.int32))
    fix.repair()
    return np.asarray(fix.points, dtype=float), np.asarray(fix.faces, dtype=int)


def signed_volume(points, faces):
    a, b, c = points[faces].swapaxes(0, 1)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def place(points):
    """Turns +z (up in the package's file) to +y, then stands the mesh on y = 0 with height 1, centred."""
    points = np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2.0
    return np.round((points - [middle[0], low[1], middle[2]]) / (high[1] - low[1]), DECIMALS)


def check(points, faces):
    """Closed, manifold, consistently wound outward, one piece of genus 0, no degenerate triangle."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    directed = {tuple(edge) for edge in edges}
    assert len(directed) == len(edges), "an edge is used twice in one direction"
    assert all((b, a) in directed for a, b in directed), "an edge has no opposite: open or badly wound"
    assert len(points) - len(edges) // 2 + len(faces) == 2, "not one piece of genus 0"
    assert len(np.unique(points, axis=0)) == len(points), "two vertices coincide after rounding"
    assert len(np.unique(faces)) == len(points), "a vertex is unused"
    a, b, c = points[faces].swapaxes(0, 1)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    # A grid step of 10^-5 moves an edge by that much: below 10^-8 the normal of a triangle is rounding noise.
    assert areas.min() > 1e-8, f"degenerate triangle, area {areas.min():.2e}"
    assert signed_volume(points, faces) > 0.0, "wound inward"
    return areas.min()


def main():
    points, faces = repair(*read_ply(SCAN))
    points, faces = fast_simplification.simplify(points, faces.astype(np.int32), target_count=TRIANGLES)
    points, faces = repair(points, faces)
    if signed_volume(points, faces) < 0.0:
        faces = faces[:, ::-1]
    points = place(points)
    smallest = check(points, faces)
    with open(sys.argv[1], "w", encoding="ascii") as out:
        out.write("# Stanford bunny, simplified: Stanford Computer Graphics Laboratory; terms in README.md\n")
        out.writelines(f"v {x:.5f} {y:.5f} {z:.5f}\n" for x, y, z in points + 0.0)
        out.writelines(f"f {a} {b} {c}\n" for a, b, c in faces + 1)
    print(f"{len(points)} vertices, {len(faces)} triangles, volume {signed_volume(points, faces):.4f},")
    print(f"smallest triangle {smallest:.1e}, box {points.min(axis=0)} to {points.max(axis=0)}")


main()
