# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume objects -> Grids: another Blender reads their OpenVDB files, as it may be brought to its end by a bad one."""

import json
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

import bpy
import numpy as np

from . import density, other_blender
from .grids import Grid, Grids
from .other_blender import Failed, Unseen, answered

#: Of Blender's frames: that of a sequence that has none.
_NO_FRAME = 2**31 - 1

#: How much farther along each axis Cycles shows everything, in cells.
_FARTHER = 0.5 if bpy.app.version < (5, 0) else 0.0

#: Bytes before a file's grids that are another each time: magic number, versions, and the file's own number.
_HEAD = 57

#: What is to be done about a bad file.
_REMEDY = "left out; set its path, or write the file anew"


@dataclass(frozen=True)
class _Read:
    """What a file has of the grids that have been asked for, all by name."""

    grids: dict
    #: Of how many cells along an axis a value is the mean, where that is not one.
    coarser: dict
    #: What is where they have no cells, where that is not 0.
    around: dict
    #: What is wrong, and names of grids with nothing in them.
    errors: dict
    empty: list
    #: All that the file has, asked for or not.
    names: tuple[str, ...]


def vdb(volume, names, source, report, poll):
    """The Grids of an evaluated bpy.types.Volume that are called any of `names`, or None if there are none; what is amiss is reported.

    - source: of the report; poll: as for export.
    """
    # Blender has what modifiers or geometry nodes make as data without an original.
    is_made = not volume.is_evaluated
    grids = volume.grids
    # This reads no more than what the file has, as Blender does to draw it.
    if not is_made and not grids.is_loaded and not grids.error_message:
        grids.load()
    if not names or (not is_made and (not volume.filepath or grids.frame == _NO_FRAME)):
        return None
    if not is_made and not grids.frame_filepath:
        reason = grids.error_message or "it cannot be read"
        report.add(source, f"OpenVDB file {Path(volume.filepath).name} ({reason})", _REMEDY, True)
        return None
    path = Path(grids.frame_filepath)
    what = "volume that modifiers or geometry nodes make" if is_made else f"OpenVDB file {path.name}"
    wanted = tuple(sorted(names))
    try:
        if is_made:
            found = _read_made(grids, wanted, poll)
        else:
            stat = path.stat()
            found = _read(str(path), stat.st_mtime_ns, stat.st_size, wanted, Unseen(poll))
    except OSError as reason:
        report.add(source, f"{what} ({reason.strerror})", _REMEDY, True)
        return None
    if isinstance(found, str):
        report.add(source, f"{what} ({found})", _REMEDY, True)
        return None
    for name in sorted(names - set(found.names)):
        has = ", ".join(found.names) or "nothing"
        report.add(source, f"{what} without the grid {name} (it has {has})", "0; write the file anew, or name one that it has in the material", True)
    for name, reason in found.errors.items():
        report.add(source, f"grid {name} of {what} ({reason})", "0; write the file anew", True)
    for name in found.empty:
        # So Blender shows damaged files too. Smoke that has not risen yet is nothing to ask about.
        instead = "0; write the file anew, if it should have something"
        report.add(source, f"grid {name} of {what} with nothing in it", instead, in_fog=not volume.is_sequence)
    for name, value in found.around.items():
        report.add(source, f"grid {name} of {what} with a background of {value:.3g}", "it ends with the blocks of cells that are stored", True)
    for name, cells in found.coarser.items():
        report.add(source, f"grid {name} of {what} with more than {density.MOST:,} cells", f"means of {cells} x {cells} x {cells} cells")
    if not found.grids:
        return None
    lattices = [(grid.values.shape[2::-1], grid.to_cells) for grid in found.grids.values()]
    return Grids(found.grids.get, lattices)


def _read_made(grids, names, poll):
    """The _Read of bpy.types.VolumeGrids that are in no file, by way of one, or why there is none, as text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made.vdb"
        if not grids.save(filepath=str(path)):
            return grids.error_message or "it cannot be written"
        # The same grids have the same file, but for the random number in its head, and are read once.
        return _read(_Made(path, sha256(path.read_bytes()[_HEAD:]).digest()), 0, path.stat().st_size, names, Unseen(poll))


class _Made:
    """The path of a file that is known by what is in it."""

    def __init__(self, path, digest):
        self._path, self._digest = path, digest

    def __eq__(self, other):
        return isinstance(other, _Made) and self._digest == other._digest

    def __hash__(self):
        return hash(self._digest)

    def __str__(self):
        return str(self._path)


@lru_cache(maxsize=8)
def _read(path, changed, size, names, poll):
    """The _Read of a file, or why there is none, as text: a bad file is not tried again before it changes."""
    question = {"path": str(path), "names": names, "most": density.MOST, "seconds": int(other_blender.PATIENCE) + 60}
    try:
        answer, arrays = answered("vdb_read.py", json.dumps(question), poll.what)
        return answer["error"] if "error" in answer else _understood(answer, iter(arrays))
    except Failed as reason:
        return str(reason)
    except (KeyError, TypeError, ValueError, StopIteration) as reason:
        return f"Blender gives a wrong answer: {reason!r}"


def _understood(answer, arrays):
    """The _Read of an answer of vdb_read.py's and its arrays."""
    grids, coarser, around, errors, empty = {}, {}, {}, {}, []
    for name, of in answer["grids"].items():
        if "error" in of:
            errors[name] = of["error"]
        elif "to_cells" not in of:
            empty.append(name)
        else:
            to_cells = np.array(of["to_cells"])
            to_cells[:3, 3] -= _FARTHER / of["block"]
            grids[name] = Grid(next(arrays), to_cells)
            if of["block"] > 1:
                coarser[name] = of["block"]
            if of["around"]:
                around[name] = of["around"]
    return _Read(grids, coarser, around, errors, empty, tuple(answer["names"]))
