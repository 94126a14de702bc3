# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory this process holds, for tests that it does not grow."""

import ctypes
import gc
import time
from pathlib import Path

#: After this long the threads of a session that was freed have ended [s]. They need milliseconds.
PATIENCE = 10.0


class _MallInfo(ctypes.Structure):
    """What mallinfo2 of glibc returns."""

    _names = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost"
    _fields_ = [(name, ctypes.c_size_t) for name in _names.split()]


_C = ctypes.CDLL(None)
_C.mallinfo2.restype = _MallInfo


def in_use():
    """What has been allocated and not freed [bytes], by the C library's own account, once the threads of sessions that were freed have ended.

    What the process occupies says little: each thread has an arena, more or fewer by how they happen to run, and what is free at an
    arena's end stays with it, after malloc_trim too. So 20 renders that left nothing grew it by 9 to 12 MB, or by nothing.
    """
    gc.collect()
    begun = time.perf_counter()
    while any(_is_of_a_session(thread) for thread in Path("/proc/self/task").iterdir()):
        if time.perf_counter() - begun > PATIENCE:
            raise AssertionError("threads of a session that should have ended go on")
        time.sleep(0.01)
    info = _C.mallinfo2()
    return info.uordblks + info.hblkhd


def _is_of_a_session(thread):
    try:
        return (thread / "comm").read_text().startswith("covbeam ")
    except OSError:
        # It has ended.
        return False
