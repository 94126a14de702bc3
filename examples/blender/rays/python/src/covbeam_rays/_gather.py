"""covbeam's calls that take longest, on many threads."""

import ctypes
import threading

import numpy as np
from covbeam import EYE_RAY, FILM_PIXEL, GATHERED, Error, Kernel, Status
from covbeam._arrays import struct
from covbeam._handles import using
from covbeam._library import lib as covbeam_lib

from ._arrays import packed, result
from ._library import INTERVAL, Handle, check, lib, stopped

_FUNCTIONS = ("beam_map_gather", "film_picture", "scratch_new", "scratch_free", "last_error")


class Gather:
    """Calls covbeam on native threads, each with a Scratch of its own. Closed with the last reference or by close()."""

    def __init__(self):
        addresses = [ctypes.cast(getattr(covbeam_lib, f"covbeam_{name}"), ctypes.c_void_p) for name in _FUNCTIONS]
        functions = (ctypes.c_void_p * len(addresses))(*addresses)
        make, free = lib.covbeam_rays_gather_new, lib.covbeam_rays_gather_free
        self._handle = Handle(make, free, ctypes.addressof(functions))
        self._busy = threading.Lock()

    def close(self):
        """Gives the memory up, which goes when no call uses it any more; nothing happens the second time."""
        self._handle = None

    def gather(self, beam_map, kernel, grid, rays, starts, *, out=None, poll=None):
        """covbeam's BeamMap.gather, in tasks: GATHERED (n,). Stopped or failed, part of it is written.

        - beam_map, kernel, grid: as there; grid may be None.
        - rays: EYE_RAY (n,).
        - starts: intp (k + 1,), ascending from 0 to n: rays[starts[i]:starts[i + 1]] is one task, begun in this order.
          Tasks of some milliseconds, such as tiles of 8x8 to 32x32 pixels, keep all threads busy.
        - poll: a function asked at least every 50 ms: True to go on, False raises Cancelled.
        """
        rays = packed("rays", rays, EYE_RAY, (None,))
        starts = packed("starts", starts, np.dtype(np.intp), (None,))
        if len(starts) == 0:
            raise ValueError("starts: empty; give at least [0, n]")
        out = result("out", out, GATHERED, (len(rays),))
        kernel_address = struct("kernel", kernel, Kernel)
        with using(beam_map, grid) as [map_handle, grid_handle]:
            self._run(
                poll,
                lib.covbeam_rays_gather_start,
                map_handle,
                kernel_address,
                grid_handle,
                len(rays),
                rays.ctypes.data,
                rays.itemsize,
                len(starts) - 1,
                starts.ctypes.data,
                out.ctypes.data,
                out.itemsize,
            )
        return out

    def picture(self, film, *, out=None, poll=None):
        """covbeam's Film.picture: FILM_PIXEL (width x height,). Stopped or failed, part of it is written.

        - film: a Film that has been verified.
        - poll: as in gather.
        """
        with using(film) as [handle]:
            out = result("out", out, FILM_PIXEL, (film.width * film.height,))
            arguments = film.width, film.height, out.ctypes.data, out.itemsize
            self._run(poll, lib.covbeam_rays_picture_start, handle, *arguments)
        return out

    def _run(self, poll, start, *arguments):
        """Starts work, and waits for its end. The caller holds what the addresses among the arguments show."""
        handle = self._handle
        if handle is None:
            raise ValueError("Gather: used after close(); make a new one")
        if not self._busy.acquire(blocking=False):
            raise Error(Status.BUSY, "Gather: in use by another call; wait for that, or make another one")
        done, status = ctypes.c_uint32(), ctypes.c_int32()
        try:
            check(start(handle, *arguments))
            while not done.value:
                addresses = ctypes.addressof(done), ctypes.addressof(status)
                check(lib.covbeam_rays_gather_wait(handle, INTERVAL, *addresses), status.value)
                if not done.value and poll is not None and not poll():
                    raise stopped()
        finally:
            # The threads have left off when this returns.
            lib.covbeam_rays_gather_stop(handle)
            self._busy.release()
