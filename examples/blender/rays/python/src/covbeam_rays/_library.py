"""Finds the shared library, refuses one that this module was not written for, turns its statuses into exceptions."""

import ctypes
import os
import platform
import sys
from pathlib import Path

from covbeam import Cancelled, Error, Status

#: Of the library: ABI in abi/mod.rs.
ABI_VERSION = 2

FILE_NAME = {"darwin": "libcovbeam_rays.dylib", "win32": "covbeam_rays.dll"}.get(sys.platform, "libcovbeam_rays.so")

#: Between two questions whether to go on [ms].
INTERVAL = 40

_p, _z, _u, _i = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint32, ctypes.c_int32

PROTOTYPES = {
    "covbeam_rays_set_threads": [_z],
    "covbeam_rays_get_threads": [_p],
    "covbeam_rays_geometry_new": [_p],
    "covbeam_rays_geometry_free": [_p],
    "covbeam_rays_geometry_add_mesh": [_p, _z, _p, _z, _p, _z, _p, _p, _p, _p],
    "covbeam_rays_geometry_add_instance": [_p, _u, _p, _i, _i],
    "covbeam_rays_geometry_build": [_p],
    "covbeam_rays_geometry_wait": [_p, _u, _p],
    "covbeam_rays_geometry_cancel": [_p],
    "covbeam_rays_geometry_info": [_p, _p],
    "covbeam_rays_geometry_cast": [_p, _z, _p, _p, _z, _p, _p],
    "covbeam_rays_geometry_edges": [_p, _z, _p, _p, _p, _z, _p, _p, _p],
    "covbeam_rays_gather_new": [_p, _p],
    "covbeam_rays_gather_free": [_p],
    "covbeam_rays_gather_start": [_p, _p, _p, _p, _z, _p, _z, _z, _p, _p, _z],
    "covbeam_rays_picture_start": [_p, _p, _u, _u, _p, _z],
    "covbeam_rays_gather_wait": [_p, _u, _p, _p],
    "covbeam_rays_gather_stop": [_p],
}


class Info(ctypes.Structure):
    _fields_ = [
        ("triangle_count", ctypes.c_uint64),
        ("memory", ctypes.c_uint64),
        ("min", ctypes.c_float * 3),
        ("max", ctypes.c_float * 3),
    ]


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
        function = getattr(library, name)
        function.argtypes = parameters
        function.restype = ctypes.c_int32
    library.covbeam_rays_last_error.restype = ctypes.c_char_p
    return library


lib = load(find())


def check(status: int, covbeam_status: int = 0):
    """Raises what a status means. `covbeam_status` is what the call of covbeam returned, if that is what failed."""
    if status == 0:
        return
    message = lib.covbeam_rays_last_error().decode()
    match status:
        case 1:
            raise ValueError(message)
        case 2:
            raise Error(Status.WRONG_ORDER, message)
        case 3:
            raise Cancelled(Status.CANCELLED, message)
        case 4:
            raise Error(Status(covbeam_status), message)
        case _:
            raise Error(Status.PANICKED, message)


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


def stopped():
    """What a poll that said no raises."""
    return Cancelled(Status.CANCELLED, "stopped by poll")


def threads(count: int | None = None) -> int:
    """How many native threads calls use, after setting it to `count` if that is given; 0 = one a core."""
    if count is not None:
        if count < 0:
            raise ValueError(f"count: {count}; give 0 for one a core, or how many")
        check(lib.covbeam_rays_set_threads(count))
    number = ctypes.c_size_t()
    check(lib.covbeam_rays_get_threads(ctypes.addressof(number)))
    return number.value
