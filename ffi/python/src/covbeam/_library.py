"""Finds the shared library, and refuses one that this module was not written for."""

import ctypes
import os
import platform
import sys
from pathlib import Path

from ._abi import ABI_VERSION, PROTOTYPES, RESULTS, TYPES
from .errors import Cancelled, Error, InvalidValue, OutOfMemory, Status

FILE_NAME = {"darwin": "libcovbeam.dylib", "win32": "covbeam.dll"}.get(sys.platform, "libcovbeam.so")


def find() -> Path:
    """The library in the wheel, else the one that COVBEAM_LIBRARY names."""
    bundled = Path(__file__).with_name(FILE_NAME)
    if bundled.exists():
        return bundled
    given = os.environ.get("COVBEAM_LIBRARY")
    if given is None:
        raise ImportError(
            f"covbeam: there is no {FILE_NAME} beside the module, and COVBEAM_LIBRARY is not set. "
            f"Install the covbeam wheel for this machine, or set COVBEAM_LIBRARY to the path of {FILE_NAME}."
        )
    if not Path(given).is_file():
        raise ImportError(f"covbeam: COVBEAM_LIBRARY is {given!r}, where there is no file. Set it to the path of {FILE_NAME}.")
    return Path(given)


def load(path: Path) -> ctypes.CDLL:
    """Loads a library and checks its ABI before anything of it is called."""
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise ImportError(
            f"covbeam: {path} cannot be loaded on {sys.platform} {platform.machine()}: {error}. "
            "Install the covbeam wheel for this machine, or set COVBEAM_LIBRARY to a library built for it."
        ) from error
    try:
        library.covbeam_abi_version.restype = ctypes.c_uint32
        library.covbeam_version.restype = ctypes.c_char_p
    except AttributeError as error:
        raise ImportError(f"covbeam: {path} is not {FILE_NAME}: {error}") from error
    abi = library.covbeam_abi_version()
    if abi != ABI_VERSION:
        version = library.covbeam_version().decode()
        raise ImportError(
            f"covbeam: {path} (version {version}) has ABI {abi}, this module is for ABI {ABI_VERSION}. "
            "Take module and library from the same version: install one covbeam wheel, "
            f"or set COVBEAM_LIBRARY to a library with ABI {ABI_VERSION}."
        )
    for name, parameters in PROTOTYPES.items():
        function = getattr(library, name, None)
        if function is None:
            raise ImportError(
                f"covbeam: {path} has no {name}, though its ABI is {abi}: it is of another version, or not whole. "
                "Install the covbeam wheel for this machine, or set COVBEAM_LIBRARY to a library of this module's version."
            )
        function.argtypes = [TYPES[letter] for letter in parameters]
        function.restype = RESULTS.get(name, ctypes.c_int32)
    return library


lib = load(find())

#: The version of the library that runs, such as "0.1.0".
version = lib.covbeam_version().decode()


_RAISED = {Status.INVALID_VALUE: InvalidValue, Status.OUT_OF_MEMORY: OutOfMemory, Status.CANCELLED: Cancelled}


def check(status: int):
    """Raises what a status means."""
    if status != Status.OK:
        raise _RAISED.get(status, Error)(Status(status), lib.covbeam_last_error().decode())
