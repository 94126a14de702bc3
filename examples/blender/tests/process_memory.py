# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory this process holds, for tests that it does not grow."""

import ctypes
import os


def resident():
    """Memory of the process [bytes], without what the C library's allocator keeps of what threads have freed: that is more or less by how
    they happened to run (65 MB were seen)."""
    ctypes.CDLL(None).malloc_trim(0)
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
