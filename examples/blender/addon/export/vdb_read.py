# SPDX-License-Identifier: GPL-3.0-or-later
"""A program for Blender: reads grids of an OpenVDB file. Its arguments: JSON with the file's path, names of grids, the most cells of each
and the seconds that it may take; and a folder for other_blender.answered."""

import json
import os
import signal
import sys
from pathlib import Path

import bpy
import numpy as np

#: Cells that are looked at together, and in all: of what is larger only some are looked at.
SLICE, MOST_LOOKS = 1 << 20, 1 << 27

#: Whole numbers up to here are floats too.
MOST_INDEX = 1 << 24

#: Memory that a file may take: so much, and so many times its size [bytes].
MEMORY, TIMES = 2 << 30, 64

#: By type of a grid: that of Blender's nodes, name of the property of an attribute that they store, and channels.
KINDS = {"FLOAT": ("FLOAT", "value", 1), "VECTOR_FLOAT": ("VECTOR", "vector", 3)}


class Failed(Exception):
    """Why a grid cannot be read."""


def set_kind(node, kind):
    """Sets the type that a node works with: nodes have different names for vectors."""
    for name in ("VECTOR", "VECTOR_FLOAT", "FLOAT_VECTOR") if kind == "VECTOR" else (kind,):
        try:
            node.data_type = name
            return
        except TypeError:
            pass
    raise ValueError(f"{node.bl_idname} has no {kind}")


def socket(sockets, name):
    """The one of that name that is in use."""
    return next(each for each in sockets if each.name == name and each.enabled)


class Reader:
    """Looks at grids of a volume: an object has points, of which geometry nodes make what a grid has there."""

    def __init__(self, volume):
        self._volume = bpy.data.objects.new("Volume", volume)
        self._points = bpy.data.objects.new("Points", bpy.data.meshes.new("Points"))
        bpy.context.scene.collection.objects.link(self._points)
        self._nodes = self._points.modifiers.new("Nodes", "NODES")

    def bounds(self, grid):
        """Corners of all that a grid has, float64 (2, 3) [m]; None if that is nothing."""
        tree, first, last, value = self._tree(grid)
        store, box = tree.nodes.new("GeometryNodeStoreNamedGrid"), tree.nodes.new("GeometryNodeBoundBox")
        set_kind(store, KINDS[grid.data_type][0])
        store.inputs["Name"].default_value = "grid"
        tree.links.new(value, socket(store.inputs, "Grid"))
        tree.links.new(store.outputs[0], box.inputs[0])
        geometry = self._store(tree, first, "low", "VECTOR", box.outputs["Min"])
        tree.links.new(self._store(tree, geometry, "high", "VECTOR", box.outputs["Max"]), last)
        self._put(np.zeros((1, 3)))
        ends = np.concatenate([self._found(name, "vector", 3) for name in ("low", "high")]).astype(np.float64)
        return ends if np.isfinite(ends).all() and (ends[1] > ends[0]).all() else None

    def look(self, grid):
        """Begins to look at a grid; returns a function of indices, (n, 3), that gives what is there, float32 (n, channels)."""
        kind, key, channels = KINDS[grid.data_type]
        tree, first, last, value = self._tree(grid)
        sample, position, parts = (tree.nodes.new(k) for k in ("GeometryNodeSampleGridIndex", "GeometryNodeInputPosition", "ShaderNodeSeparateXYZ"))
        set_kind(sample, kind)
        tree.links.new(value, socket(sample.inputs, "Grid"))
        tree.links.new(position.outputs[0], parts.inputs[0])
        for axis in "XYZ":
            tree.links.new(parts.outputs[axis], socket(sample.inputs, axis))
        tree.links.new(self._store(tree, first, "found", kind, socket(sample.outputs, "Value")), last)

        def at(indices):
            self._put(indices)
            return self._found("found", key, channels)

        return at

    def _tree(self, grid):
        """A new tree of nodes, its input, its output, and the grid of the volume in it."""
        tree = bpy.data.node_groups.new("Tree", "GeometryNodeTree")
        for way in ("INPUT", "OUTPUT"):
            tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        kinds = "NodeGroupInput", "NodeGroupOutput", "GeometryNodeObjectInfo", "GeometryNodeGetNamedGrid"
        first, last, info, get = (tree.nodes.new(kind) for kind in kinds)
        info.inputs["Object"].default_value = self._volume
        set_kind(get, KINDS[grid.data_type][0])
        get.inputs["Name"].default_value = grid.name
        tree.links.new(info.outputs["Geometry"], get.inputs[0])
        self._nodes.node_group = tree
        return tree, first.outputs[0], last.inputs[0], socket(get.outputs, "Grid")

    def _store(self, tree, geometry, name, kind, value):
        """Adds a node that stores a value as an attribute; returns the geometry after it."""
        store = tree.nodes.new("GeometryNodeStoreNamedAttribute")
        set_kind(store, kind)
        store.inputs["Name"].default_value = name
        tree.links.new(geometry, store.inputs["Geometry"])
        tree.links.new(value, socket(store.inputs, "Value"))
        return store.outputs[0]

    def _put(self, places):
        """Sets the points, (n, 3)."""
        mesh = self._points.data
        if len(mesh.vertices) != len(places):
            mesh.clear_geometry()
            mesh.vertices.add(len(places))
        mesh.vertices.foreach_set("co", places.astype(np.float32).ravel())
        mesh.update()

    def _found(self, name, key, channels):
        """What an attribute has at the points, (n, channels)."""
        evaluated = self._points.evaluated_get(bpy.context.evaluated_depsgraph_get())
        attribute = evaluated.data.attributes[name]
        values = np.empty(len(attribute.data) * channels, np.float32)
        attribute.data.foreach_get(key, values)
        return values.reshape(-1, channels)


def extent(reader, grid, back):
    """Lowest index of what a grid has, and how many there are from there on along each axis, int64 (3,) both; None if there is nothing.
    back: its transform's inverse."""
    ends = reader.bounds(grid)
    if ends is None:
        return None
    corners = np.array([[ends[k][axis] for axis, k in enumerate(corner)] for corner in np.ndindex(2, 2, 2)])
    corners = corners @ back[:3, :3].T + back[:3, 3]
    if not np.abs(corners).max() < MOST_INDEX:
        raise Failed("it has cells too far from its origin")
    # To the middles of the outermost cells, or half a cell more, by Blender's version.
    low, high = np.ceil(corners.min(axis=0) - 0.25), np.floor(corners.max(axis=0) + 0.25)
    return low.astype(np.int64), np.maximum(high - low + 1, 1).astype(np.int64)


def edge(cells, most):
    """How many cells along an axis blocks have, so that there are no more than `most` of them."""
    block = 1
    while np.prod(np.ceil(cells / block)) > most:
        block += 1
    return block


def means(at, low, cells, most):
    """Means of blocks of cells, no more than `most`, float32 (nz, ny, nx, channels), how many cells along an axis each is, and which cells
    along x, y and z have something. If there are more than MOST_LOOKS cells, that is by as many as are looked at."""
    step = edge(cells, MOST_LOOKS)
    each = -(-edge(cells, most) // step)
    block = each * step
    count = -(-cells // block)
    shape = np.array([count[0] * each, count[1] * each, each])
    layers, full = [], [np.zeros(shape[0], bool), np.zeros(shape[1], bool), np.zeros(count[2] * each, bool)]
    for k in range(count[2]):
        # A layer of blocks: of each block each^3 cells.
        found = []
        for start in range(0, int(np.prod(shape)), SLICE):
            index = np.arange(start, min(start + SLICE, int(np.prod(shape))))
            place = np.stack([index % shape[0], index // shape[0] % shape[1], index // (shape[0] * shape[1])], axis=1)
            found.append(at(low + [0, 0, k * block] + step // 2 + step * place))
        fine = np.nan_to_num(np.concatenate(found), nan=0.0, posinf=0.0, neginf=0.0)
        layers.append(fine.reshape(each, count[1], each, count[0], each, -1).mean(axis=(0, 2, 4)))
        some = fine.any(axis=1).reshape(shape[::-1])
        full[0] |= some.any(axis=(0, 1))
        full[1] |= some.any(axis=(0, 2))
        full[2][k * each : (k + 1) * each] = some.any(axis=(1, 2))
    return np.array(layers), block, [np.flatnonzero(of.repeat(step)) for of in full]


def read(reader, grid, most):
    """Values, to_cells as of grids.Grid, of how many cells along an axis each value is the mean, and the largest number that is where there are
    no cells; None if there is nothing."""
    if grid.data_type not in KINDS:
        raise Failed(f"it is of type {grid.data_type}")
    matrix = np.array(grid.matrix_object, np.float64)
    if not (np.isfinite(matrix).all() and np.linalg.matrix_rank(matrix[:3, :3] / max(np.abs(matrix[:3, :3]).max(), 1e-300)) == 3):
        raise Failed("its transform has no inverse")
    back = np.linalg.inv(matrix)
    box = extent(reader, grid, back)
    if box is None:
        return None
    low, cells = box
    at = reader.look(grid)
    # Beyond blocks of 8 cells, of which Blender's bounds are.
    around = float(np.abs(at(low[None] - 16)).max())
    values, block, full = means(at, low, cells, most)
    if not len(full[0]):
        if block == 1:
            return None
        raise Failed("it is so large that nothing is found in it")
    # Blender's bounds have empty cells in them.
    first, last = (np.array([of[k] for of in full]) for k in (0, -1))
    if edge(last - first + 1, most) < block:
        low, cells = low + first, last - first + 1
        values, block, _ = means(at, low, cells, most)
    else:
        first, last = first // block, last // block
        values = values[first[2] : last[2] + 1, first[1] : last[1] + 1, first[0] : last[0] + 1]
        low = low + block * first
    to_cells = np.diag([1 / block] * 3 + [1.0]) @ back
    to_cells[:3, 3] -= (low + (block - 1) / 2) / block
    return values, to_cells, block, around


def limit(path, seconds):
    """Makes the process end before it takes gigabytes for a file that is not worth them, or goes on for ever when nobody waits any more."""
    if hasattr(signal, "alarm"):
        signal.alarm(seconds)
    try:
        import resource

        held = next(line.split() for line in open("/proc/self/status") if line.startswith("VmData:"))
    except (ImportError, OSError, StopIteration):
        # Elsewhere than on Linux there is no such limit, or it is not heeded.
        return
    most = 1024 * int(held[1]) + MEMORY + TIMES * Path(path).stat().st_size
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))


def main(path, names, most, folder):
    """Reads and writes. The answer: `names` in the file, or the `error`; and `grids`: of each asked for that is there its `to_cells`,
    `block` and `around`, or an `error`, or nothing if it has none. The arrays: values of those with the former, in that order."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    volume = bpy.data.volumes.new("Volume")
    volume.filepath = path
    answer, arrays = {"grids": {}}, []
    if not volume.grids.load():
        answer["error"] = volume.grids.error_message or "it cannot be read"
    answer["names"] = [grid.name for grid in volume.grids]
    reader = Reader(volume)
    for grid in volume.grids:
        if grid.name not in names or grid.name in answer["grids"]:
            continue
        of = answer["grids"][grid.name] = {}
        try:
            made = read(reader, grid, most)
        except Failed as reason:
            of["error"] = str(reason)
            continue
        # What Blender cannot read is empty.
        if volume.grids.error_message:
            of["error"] = volume.grids.error_message
        elif made is not None:
            of["to_cells"], of["block"], of["around"] = made[1].tolist(), made[2], made[3]
            arrays.append(made[0])
    answer["shapes"] = [array.shape for array in arrays]
    for k, array in enumerate(arrays):
        array.astype("<f4").tofile(Path(folder) / f"{k}.f32")
    (Path(folder) / "answer.json").write_text(json.dumps(answer))


if __name__ == "__main__":
    text, folder = sys.argv[sys.argv.index("--") + 1 :]
    given = json.loads(text)
    limit(given["path"], given["seconds"])
    main(given["path"], given["names"], given["most"], folder)
    if not bpy.app.binary_path:
        # As a module Blender may crash as it ends.
        sys.stdout.flush()
        os._exit(0)
