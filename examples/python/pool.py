"""A tank of water with waves, lit from above: shafts and caustics, of a scene that is described in numpy arrays.

    python pool.py pool.pfm [--seconds 30] [--size 256] [--waves 0.08] [--seed 0]

Ctrl-C keeps the picture of the passes done. Copy it and change it: geometry is `tank`, all else is `scene`.
"""

import argparse
import sys
import time

import numpy as np

import covbeam.session as cs

#: The tank's width, height of the water and depth [m]; cells along its surface.
SIZE, CELLS = np.array([2.0, 1.2, 1.0]), np.array([128, 64])

#: Numbers of materials, volumes and objects.
WATER, WALL = 0, 1


def surface(height):
    """The water's surface, and its unit normals, (rows, columns, 3): a sum of waves that are level at the walls, so that its borders are straight."""
    z, x = (np.linspace(0, 1, count + 1) for count in (CELLS[1], CELLS[0]))
    x, z = np.meshgrid(x, z)
    y, slope_x, slope_z = np.zeros((3, *x.shape))
    for nx, nz, share in ((3, 2, 0.4), (7, 4, 0.3), (11, 5, 0.2), (6, 9, 0.1)):
        y += share * np.sin(np.pi * nx * x) * np.sin(np.pi * nz * z)
        slope_x += share * np.pi * nx * np.cos(np.pi * nx * x) * np.sin(np.pi * nz * z)
        slope_z += share * np.pi * nz * np.sin(np.pi * nx * x) * np.cos(np.pi * nz * z)
    positions = np.stack([SIZE[0] * (x - 0.5), SIZE[1] + height * y, SIZE[2] * (z - 0.5)], axis=-1)
    normals = np.stack([-height * slope_x / SIZE[0], np.ones_like(x), -height * slope_z / SIZE[2]], axis=-1)
    return positions, normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def tank(height):
    """The water as a closed mesh, counter-clockwise seen from outside: positions, triangles, and normals of all corners."""
    top, top_normals = surface(height)
    bottom = top * [1, 0, 1]
    number = np.arange(top.shape[0] * top.shape[1]).reshape(top.shape[:2])
    below = number + number.size

    def quads(a, b, c, d):
        return np.concatenate([np.stack([p.ravel() for p in (a, b, c)], 1) for b, c in ((b, c), (c, d))])

    up = quads(number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    border = np.concatenate([number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[:0:-1, 0]])
    after = np.roll(border, -1)
    sides = quads(border, after, after + number.size, border + number.size)
    down = quads(below[:-1, :-1], below[:-1, 1:], below[1:, 1:], below[1:, :-1])
    positions = np.concatenate([top.reshape(-1, 3), bottom.reshape(-1, 3)])
    triangles = np.concatenate([up, sides, down])
    corners = positions[triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.repeat(flat[:, None] / np.linalg.norm(flat, axis=1)[:, None, None], 3, axis=1)
    normals[: len(up)] = top_normals.reshape(-1, 3)[up]
    return positions.astype(np.float32), triangles.astype(np.int32), normals.astype(np.float32)


def scene(size, waves):
    """The tank on a grey floor before a wall, in thin haze, with a lamp above it."""
    geometry = cs.Geometry()
    positions, triangles, normals = tank(waves)
    mesh = geometry.add_mesh(positions, triangles, WATER, normals)
    # The floor lies a little below, so that nothing else is in its plane.
    geometry.add_instance(mesh, np.diag([1, 1, 1, 1.0]), object=0)
    geometry.build()

    materials = np.zeros(2, cs.MATERIAL)
    materials["glass_reflection"][WATER] = materials["glass_transmission"][WATER] = 1
    materials["ior"][WATER] = 1.33
    materials["diffuse"][WALL] = 0.2

    shapes = np.zeros(2, cs.SHAPE)
    shapes["kind"], shapes["material"], shapes["volume"] = cs.ShapeKind.RECTANGLE, WALL, -1
    shapes["a"], shapes["b"], shapes["c"] = [(-4, -0.02, -4), (-4, -0.02, 1.5)], [(0, 0, 8), (8, 0, 0)], [(8, 0, 0), (0, 4, 0)]

    water = cs.Volume((0.12, 0.16, 0.18), (0.25, 0.05, 0.03), min=-SIZE / [2, 1, 2] * [1, 0, 1] - 0.1, max=SIZE * [0.5, 1, 0.5] + 0.1)
    haze = cs.Volume((0.01, 0.01, 0.01))
    lamp = cs.Light(cs.LightKind.SPOT, position=(0.9, 4, 0.1), axis=(-0.2425, -0.9701, 0), intensity=(90, 85, 75), cosine=0.975, blend=0.004, radius=0.01)
    camera = cs.Camera.at((0.4, 1.1, -3.6), (0, 0.55, 0), fov=0.55, width=size, height=size * 3 // 4)
    return cs.Scene(geometry, materials, camera, [lamp], [water, haze], world_volume=1, shapes=shapes, object_volumes=[0], object_closed=[True])


def render(described, seconds, seed):
    """The picture after so many seconds, or when Ctrl-C is pressed after the first pass."""
    session = cs.Session(described, seed=seed)
    start, shown = time.monotonic(), None

    def poll():
        nonlocal shown
        line = f"pass {session.passes + 1}, {max(0, start + seconds - time.monotonic()):.0f} s left"
        if line != shown:
            print(f"\r{line:30}", end="", file=sys.stderr, flush=True)
            shown = line
        return True

    try:
        session.until(seconds=seconds, poll=poll)
    except KeyboardInterrupt:
        if session.passes == 0:
            raise
    print(f"\r{session.passes} passes of {session.photons} light paths", file=sys.stderr)
    return session.picture()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="where the picture goes: a portable float map, linear")
    parser.add_argument("--seconds", type=float, default=30.0, help="how long it renders")
    parser.add_argument("--size", type=int, default=256, help="pixels across")
    parser.add_argument("--waves", type=float, default=0.08, help="height of the waves [m]; 0: still water")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    picture = render(scene(options.size, options.waves), options.seconds, options.seed)
    height, width, _ = picture.shape
    with open(options.file, "wb") as file:
        # Rows from the bottom; the minus says that the numbers are little-endian.
        file.write(f"PF\n{width} {height}\n-1\n".encode() + picture[::-1].astype("<f4").tobytes())


if __name__ == "__main__":
    main()
