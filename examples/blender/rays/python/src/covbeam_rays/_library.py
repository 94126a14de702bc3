"""Finds the shared library, refuses one that this module was not written for, turns its statuses into exceptions."""

import ctypes
import os
import platform
import sys
from pathlib import Path

#: Of the library: ABI in abi/mod.rs.
ABI_VERSION = 5

FILE_NAME = {"darwin": "libcovbeam_rays.dylib", "win32": "covbeam_rays.dll"}.get(sys.platform, "libcovbeam_rays.so")

#: Between two questions whether to go on [ms].
INTERVAL = 40

_p, _z, _u, _i = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint32, ctypes.c_int32

PROTOTYPES = {
    "covbeam_rays_geometry_new": [_p],
    "covbeam_rays_geometry_free": [_p],
    "covbeam_rays_geometry_add_mesh": [_p, _z, _p, _z, _p, _z, _p, _p, _p, _p],
    "covbeam_rays_geometry_add_instance": [_p, _u, _p, _i, _i],
    "covbeam_rays_geometry_build": [_p],
    "covbeam_rays_geometry_wait": [_p, _u, _p],
    "covbeam_rays_geometry_cancel": [_p],
    "covbeam_rays_geometry_info": [_p, _p],
    "covbeam_rays_geometry_cast": [_p, _z, _p, _p, _p],
    "covbeam_rays_scene_new": [_p, _p, _p],
    "covbeam_rays_scene_free": [_p],
    "covbeam_rays_session_new": [_z, _p, _p, _p],
    "covbeam_rays_session_free": [_p],
    "covbeam_rays_session_start": [_p, _u],
    "covbeam_rays_session_wait": [_p, _u, _p],
    "covbeam_rays_session_stop": [_p],
    "covbeam_rays_session_restart": [_p, _u, _u],
    "covbeam_rays_session_info": [_p, _p],
    "covbeam_rays_session_picture": [_p, _z, _p, _p, _p, _p, _p],
}


class Error(Exception):
    """A call came too early or too late, or the library has a defect."""


class Cancelled(Exception):
    """A poll has said no. What was done before is kept."""


def find() -> Path:
    """The library in the wheel, else the one that COVBEAM_RAYS_LIBRARY names."""
    bundled = Path(__file__).with_name(FILE_NAME)
    if bundled.exists():
        return bundled
    given = os.environ.get("COVBEAM_RAYS_LIBRARY")
    if given is None or not Path(given).is_file():
        raise ImportError(
            f"covbeam_rays: there is no {FILE_NAME} beside the module, and COVBEAM_RAYS_LIBRARY is {given!r}. "
            f"Install the covbeam_rays wheel for this machine, or set COVBEAM_RAYS_LIBRARY to the path of {FILE_NAME}."
        )
    return Path(given)


def load(path: Path) -> ctypes.CDLL:
    """Loads a library and checks its ABI before anything of it is called."""
    try:
        library = ctypes.CDLL(str(path))
        library.covbeam_rays_abi_version.restype = ctypes.c_uint32
        abi = library.covbeam_rays_abi_version()
    except (OSError, AttributeError) as error:
        raise ImportError(
            f"covbeam_rays: {path} cannot be loaded on {sys.platform} {platform.machine()}: {error}. "
            "Install the covbeam_rays wheel for this machine."
        ) from error
    if abi != ABI_VERSION:
        raise ImportError(
            f"covbeam_rays: {path} has ABI {abi}, this module is for ABI {ABI_VERSION}. "
            "Take module and library from the same version: install one covbeam_rays wheel."
        )
    for name, parameters in PROTOTYPES.items():
        function = getattr(library, name, None)
        if function is None:
            raise ImportError(
                f"covbeam_rays: {path} has no {name}. Take module and library from the same version: install one covbeam_rays wheel."
            )
        function.argtypes = parameters
        function.restype = ctypes.c_int32
    library.covbeam_rays_last_error.restype = library.covbeam_rays_version.restype = ctypes.c_char_p
    return library


lib = load(find())

version = lib.covbeam_rays_version().decode()

_EXCEPTIONS = {1: ValueError, 2: Error, 3: Cancelled, 4: MemoryError, 5: Error}


def check(status: int):
    """Raises what a status means."""
    if status != 0:
        raise _EXCEPTIONS[status](lib.covbeam_rays_last_error().decode())


class Handle:
    """A handle of the library, passed as it is. Freed with the last reference: a call that uses it holds one."""

    def __init__(self, make, free, *arguments):
        self._free = free
        handle = ctypes.c_void_p()
        check(make(*arguments, ctypes.addressof(handle)))
        self._as_parameter_ = handle

    def __del__(self):
        # Not there if the library refused to make the object.
        if hasattr(self, "_as_parameter_"):
            self._free(self._as_parameter_)


def wait(function, handle, poll):
    """Calls a function that waits for what goes on until that has ended; raises Cancelled if `poll` says no meanwhile."""
    done = ctypes.c_uint32()
    while True:
        check(function(handle, INTERVAL, ctypes.addressof(done)))
        if done.value:
            return
        if poll is not None and not poll():
            raise Cancelled("stopped by poll")
