# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenVDB files of tests, and what they have in them: `vdb` holds them, as Blender 4.2 cannot write any. They were made with Blender 5.0.1's
module by

    python vdb_files.py
"""

import os
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).with_name("vdb")

#: From cells to the object's space, of grids that are turned and stretched, and of grids that are not.
TURNED = np.array([(0.1, 0.02, 0, -0.6), (-0.03, 0.15, 0.01, -0.4), (0, 0.01, 0.2, -0.8), (0, 0, 0, 1)])
STRAIGHT = np.array([(0.125, 0, 0, -0.4), (0, 0.125, 0, -0.5), (0, 0, 0.125, -0.3), (0, 0, 0, 1)])


def values(seed, cells, channels):
    """Numbers from 0 to 1, none of them 0: float32 (*cells, channels), x first."""
    return np.random.default_rng(seed).uniform(0.01, 1, (*cells, channels)).astype(np.float32)


#: Grids by file and name: their first index, values and transform. Two grids of a file may differ in where their cells are.
FILES = {
    "cloud": {
        "density": ((-3, 1, 2), values(0, (9, 6, 5), 1), TURNED),
        "colour": ((1, 1, 2), values(1, (9, 6, 5), 3), TURNED),
        "flame": ((0, 0, 1), values(2, (5, 4, 6), 1), 2 * TURNED - np.diag([0, 0, 0, 1])),
    },
    "straight": {"density": ((0, 1, 0), values(3, (8, 7, 6), 1), STRAIGHT), "temperature": ((0, 1, 0), values(4, (3, 3, 3), 1), STRAIGHT)},
    "empty": {"density": ((0, 0, 0), np.zeros((0, 0, 0, 1), np.float32), STRAIGHT)},
}


def module():
    """Blender's own module of OpenVDB, which there is from 5.0 on."""
    import bpy

    sys.path.append(str(next(Path(bpy.utils.resource_path("LOCAL")).rglob("openvdb*.so")).parent))
    import openvdb

    return openvdb


def grid(openvdb, kind, name, first, values, transform):
    """A grid of a kind of the module's, of `values` (x, y, z, channels) from index `first` on."""
    made = kind()
    made.name, made.transform = name, openvdb.createLinearTransform(transform.T.tolist())
    if values.size:
        made.copyFromArray(values if values.shape[3] == 3 else values[..., 0], ijk=first)
    return made


def write(openvdb):
    """Writes them all, and one with a grid of another type, one with something all around, and one without any grid."""
    for name, grids in FILES.items():
        made = [grid(openvdb, openvdb.FloatGrid if of[1].shape[3] == 1 else openvdb.Vec3SGrid, key, *of) for key, of in grids.items()]
        openvdb.write(str(FOLDER / f"{name}.vdb"), made)
    of = FILES["straight"]["density"]
    openvdb.write(str(FOLDER / "double.vdb"), [grid(openvdb, openvdb.DoubleGrid, "density", *of)])
    openvdb.write(str(FOLDER / "background.vdb"), [grid(openvdb, lambda: openvdb.FloatGrid(0.5), "density", *of)])
    openvdb.write(str(FOLDER / "none.vdb"), [])


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    write(module())
    sys.stdout.flush()
    os._exit(0)
