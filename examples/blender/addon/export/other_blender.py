# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs that run in a Blender of their own, in background: what they do cannot harm this one."""

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from math import prod
from pathlib import Path

import bpy
import numpy as np

from ..host import ask

#: A program is given up after so long [s].
PATIENCE = 300.0

#: Its arrays have no more numbers in all, and its answer no more characters.
_MOST_NUMBERS, _MOST_CHARACTERS = 1 << 27, 1 << 20


class Failed(Exception):
    """Why a program has made nothing."""


def answered(program, text, poll):
    """What a program of this folder makes of `text`: its answer, a dict, and arrays, float32.

    It is given the text, and a folder for the arrays, 0.f32, 1.f32 and so on, and answer.json, which has their `shapes`.

    poll: as for export. Raises Failed, or host.Cancelled.
    """
    with tempfile.TemporaryDirectory() as folder:
        said = Path(folder) / "output"
        status = _run([*command(program), "--", text, folder], said, poll)
        # As a module Blender may crash as it ends, with all its work done.
        if not (Path(folder) / "answer.json").is_file():
            lines = said.read_text(errors="replace").strip().splitlines()
            raise Failed(f"Blender fails at it: {lines[-1][:200] if lines else status}")
        try:
            return _read(Path(folder))
        except (ValueError, KeyError, TypeError, OSError) as reason:
            raise Failed(f"Blender gives a wrong answer: {reason}") from reason


def _read(folder):
    if (folder / "answer.json").stat().st_size > _MOST_CHARACTERS:
        raise ValueError("it is too long")
    answer = json.loads((folder / "answer.json").read_text())
    counts = [prod(shape) for shape in answer["shapes"]]
    if sum(counts) > _MOST_NUMBERS:
        raise ValueError("it has too many numbers")
    arrays = []
    for k, (shape, count) in enumerate(zip(answer["shapes"], counts)):
        path = folder / f"{k}.f32"
        if path.stat().st_size != 4 * count:
            raise ValueError(f"array {k} is not as large as it says")
        arrays.append(np.fromfile(path, "<f4").reshape(shape))
    return answer, arrays


@dataclass(frozen=True)
class Unseen:
    """Something that functools.lru_cache does not tell calls apart by."""

    what: object

    def __eq__(self, other):
        return isinstance(other, Unseen)

    def __hash__(self):
        return 0


def command(program):
    """The command that runs a program of this folder."""
    path = str(Path(__file__).with_name(program))
    if bpy.app.binary_path:
        return [bpy.app.binary_path, "--background", "--factory-startup", "--python-exit-code", "1", "--python", path]
    # The bpy package is a module of Python's.
    return [sys.executable, path]


def _run(words, said, poll):
    """Runs a command, with all that it says in a file; returns its exit status."""
    started = time.monotonic()
    hidden = {"creationflags": subprocess.CREATE_NO_WINDOW} if os.name == "nt" else {}
    try:
        with open(said, "wb") as output:
            process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=output, stderr=output, **hidden)
    except OSError as reason:
        raise Failed(f"no other Blender can be started: {reason}") from reason
    try:
        while (status := _status(process)) is None:
            ask(poll)
            if time.monotonic() - started > PATIENCE:
                raise Failed(f"Blender takes more than {PATIENCE:g} s for it")
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
    return status


def _status(process):
    """The exit status of a process, if it ends within 50 ms."""
    try:
        return process.wait(0.05)
    except subprocess.TimeoutExpired:
        return None
