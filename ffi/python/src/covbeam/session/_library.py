"""The functions of sessions in the library, if it has them."""

import ctypes

from .._abi import TYPES
from .._library import lib
from .._session_abi import PROTOTYPES

for name, parameters in PROTOTYPES.items():
    function = getattr(lib, name, None)
    if function is None:
        raise ImportError(
            f"covbeam.session: the library has no {name}: it was built without the feature `session`. "
            "Install the covbeam wheel for this machine, or set COVBEAM_LIBRARY to a library that has it."
        )
    function.argtypes = [TYPES[letter] for letter in parameters]
    function.restype = ctypes.c_int32
