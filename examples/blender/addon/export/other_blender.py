# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs that run in a Blender of their own, in background: what they do cannot harm this one."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from contextvars import ContextVar
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


#: Whether to go on, as for export, for those who ask from deep inside of it.
_POLL = ContextVar("poll", default=None)


@contextmanager
def polling(poll):
    """While it lasts a Helper asks `poll`, as for export, whether to go on."""
    token = _POLL.set(poll)
    try:
        yield
    finally:
        _POLL.reset(token)


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
            raise Failed(f"Blender fails at it: {_last_words(said, status)}")
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


class Helper:
    """A program of this folder that goes on answering: it is started when it is first asked, and ends with this Blender.

    For each line that it is sent it reads request.json and arrays from its folder, and writes values.f32, float32 (n, 3), and then
    answer.json.
    """

    def __init__(self, program):
        self._program, self._process, self._folder = program, None, None

    def values(self, request, arrays):
        """Its answer, float32 (count, 3). request: what JSON can say, with `count`; arrays: float32, by name of file.

        Raises Failed, or host.Cancelled, which `polling` can ask for; the program is ended then.
        """
        if self._process is None or self._process.poll() is not None:
            self._start()
        try:
            return self._answer(request, arrays)
        except BaseException:
            # What it is at, or whether it is sound, is not known.
            self.stop()
            raise

    def stop(self):
        """Ends the program, if it runs."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process.stdin.close()
            shutil.rmtree(self._folder, ignore_errors=True)
            self._process = None

    def _start(self):
        self.stop()
        self._folder = Path(tempfile.mkdtemp())
        words = [*command(self._program), "--", str(self._folder)]
        self._process = _started(words, self._folder / "output", subprocess.PIPE)

    def _answer(self, request, arrays):
        answer, began = self._folder / "answer.json", time.monotonic()
        answer.unlink(missing_ok=True)
        for name, array in arrays.items():
            array.tofile(self._folder / name)
        (self._folder / "request.json").write_text(json.dumps(request))
        try:
            self._process.stdin.write(b"\n")
            self._process.stdin.flush()
            while not answer.is_file():
                ask(_POLL.get())
                if self._process.poll() is not None:
                    raise Failed(f"Blender fails at it: {_last_words(self._folder / 'output', self._process.poll())}")
                if time.monotonic() - began > PATIENCE:
                    raise Failed(f"Blender takes more than {PATIENCE:g} s for it")
                time.sleep(0.002)
            said = json.loads(answer.read_text())
            if "error" in said:
                raise Failed(said["error"])
            return np.fromfile(self._folder / "values.f32", "<f4").reshape(request["count"], 3)
        except (OSError, ValueError) as reason:
            raise Failed(f"Blender gives a wrong answer: {reason}") from reason


def _last_words(said, status):
    """The last line that a program has said, or else its exit status."""
    lines = said.read_text(errors="replace").strip().splitlines()
    return lines[-1][:200] if lines else status


def _started(words, said, stdin=subprocess.DEVNULL):
    """The process of a command, with all that it says in a file."""
    hidden = {"creationflags": subprocess.CREATE_NO_WINDOW} if os.name == "nt" else {}
    try:
        with open(said, "wb") as output:
            return subprocess.Popen(words, stdin=stdin, stdout=output, stderr=output, **hidden)
    except OSError as reason:
        raise Failed(f"no other Blender can be started: {reason}") from reason


def _run(words, said, poll):
    """Runs a command, with all that it says in a file; returns its exit status."""
    started = time.monotonic()
    process = _started(words, said)
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
