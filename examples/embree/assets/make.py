#!/usr/bin/env python3
"""Images and meshes of the scenes: examples/embree/assets/make.py writes them beside itself, the same bytes everywhere."""
import math
import pathlib

FOLDER = pathlib.Path(__file__).parent


def image(name, size, color):
    pixels = bytes(
        min(255, max(0, round(255 * value)))
        for y in range(size)
        for x in range(size)
        for value in color((x + 0.5) / size, (y + 0.5) / size)
    )
    (FOLDER / name).write_bytes(b"P6\n%d %d\n255\n" % (size, size) + pixels)


def veins(u, v):
    """Sines of places that sines have moved; periodic."""
    turn = 2 * math.pi
    x = u + 0.11 * math.sin(turn * (2 * v + 0.3 * math.sin(turn * u))) + 0.04 * math.sin(turn * (5 * v - 3 * u))
    y = v + 0.09 * math.sin(turn * (2 * u + 0.2)) + 0.03 * math.sin(turn * (4 * u + 5 * v))
    return abs(math.sin(math.pi * (2 * x + 2 * y))) ** 0.35


def marble(u, v):
    level = 0.55 + 0.4 * veins(u, v)
    return level, 0.97 * level, 0.92 * level


def tiles(u, v):
    joint = min(u % 0.5, v % 0.5, -u % 0.5, -v % 0.5) < 0.008
    dark = (u < 0.5) != (v < 0.5)
    level = 0.3 if joint else (0.35 if dark else 0.8) * (0.75 + 0.25 * veins(v, u))
    return (level, 0.75 * level, 0.6 * level) if dark else (level, 0.96 * level, 0.88 * level)


def edge(u, v):
    """How far inside of the leaf's outline a place is: five lobes with teeth, around its middle."""
    x, y = 2 * u - 1, 1.1 - 2 * v
    angle = math.atan2(x, y)
    lobes = 0.5 + 0.38 * abs(math.cos(2.5 * angle * 0.8)) ** 0.7 + 0.05 * math.cos(31 * angle)
    stalk = 0.03 - abs(x) if y < 0 else -1
    return max((lobes if abs(angle) < 2.6 else 0.12) - math.hypot(x, y), stalk)


def mask(u, v):
    hole = math.hypot(u - 0.38, v - 0.45) < 0.04 or math.hypot(u - 0.66, v - 0.5) < 0.03
    return (0.0 if hole else min(1.0, max(0.0, 0.5 + 64 * edge(u, v))),) * 3


def leaf(u, v):
    x, y = 2 * u - 1, 1.1 - 2 * v
    angle, far = math.atan2(x, y), math.hypot(x, y)
    vein = min(abs(angle - k * math.pi / 4) for k in range(-3, 4)) * far < 0.02
    shade = 0.95 if vein else 0.7 + 0.12 * math.sin(40 * far) * math.cos(9 * angle)
    return 0.85 * shade, (0.45 + 0.25 * far) * shade, 0.2 * shade


def write(name, positions, uvs, normals, faces):
    """Numbers of corners from 0 on; they are those of texture coordinates and normals, too."""
    lines = ["# Written by make.py."]
    for kind, rows in ("v", positions), ("vt", uvs), ("vn", normals):
        lines += [kind + " " + " ".join(f"{value:.6g}" for value in row) for row in rows]
    corner = "{0}" + ("/{0}" if uvs else "") + ("/{0}" if normals else "")
    lines += ["f " + " ".join(corner.format(k + 1) for k in face) for face in faces]
    (FOLDER / name).write_text("\n".join(lines) + "\n")


def rectangle(name, corner, u, v, repeats):
    places = [[c + a * x + b * y for c, x, y in zip(corner, u, v)] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    write(name, places, [(repeats * a, repeats * b) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))], [], [(0, 1, 2, 3)])


def box(name, low, high):
    places = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    write(name, places, [], [], [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)])


def leaves(name):
    """Bent squares of 8 x 8 quads that hang from hooks, each turned around its stalk."""
    count, places, uvs, normals, faces = 8, [], [], [], []
    for *hook, turn in (-1.75, 3.75, -0.45, 0.9), (-1.35, 3.2, 0.1, 0.5), (-0.95, 3.1, -0.45, 1.1), (-1.0, 2.35, -0.1, 0.7):
        c, s, first = math.cos(turn), math.sin(turn), len(places)
        for u, v in ((i / count, j / count) for j in range(count + 1) for i in range(count + 1)):
            x, y, slope = u - 0.5, v - 1, (1.2 * (u - 0.5), -0.7 * (v - 1))
            z, length = 0.6 * x * x - 0.35 * y * y, math.hypot(*slope, 1)
            places.append([h + 0.62 * value for h, value in zip(hook, (c * x + s * z, y, c * z - s * x))])
            normals.append([value / length for value in (c * slope[0] - s, slope[1], -c - s * slope[0])])
            uvs.append((u, v))
        row = count + 1
        corners = (first + j * row + i for j in range(count) for i in range(count))
        faces += [(k, k + row, k + row + 1, k + 1) for k in corners]
    write(name, places, uvs, normals, faces)


image("marble.ppm", 128, marble)
image("tiles.ppm", 96, tiles)
image("leaf.ppm", 64, leaf)
image("leaf-mask.ppm", 96, mask)
leaves("leaves.obj")
rectangle("leaves-floor.obj", (-4, 0, -6), (0, 0, 10), (8, 0, 0), 4)
rectangle("leaves-wall.obj", (-4, 0, 3.9), (0, 5, 0), (8, 0, 0), 2)
box("leaves-room.obj", (-4.1, -0.1, -6.1), (4.1, 5, 4))
rectangle("glass-ball-floor.obj", (-4, -1.5, -6), (0, 0, 10), (8, 0, 0), 1)
box("glass-ball-room.obj", (-4, -1.51, -6), (4, 4.5, 4))
rectangle("shaft-floor.obj", (-4, 0, -7), (0, 0, 11), (8, 0, 0), 1)
box("shaft-room.obj", (-4, -0.01, -7), (4, 5, 4))
box("rose-window-room.obj", (-9, -1, -19), (9, 20, 26))
