"""The C ABI as ctypes sees it. Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit."""

import ctypes

#: COVBEAM_ABI_VERSION of the header that this module was written for.
ABI_VERSION = {version}
{structs}

Poll = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p)
# The user pointer is a number here: see _callbacks.
Shade = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)
Probe = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p)

#: The letters of PROTOTYPES: an address (data, handle or callback), size_t, float, uint32_t, int32_t.
TYPES = {
    "p": ctypes.c_void_p,
    "z": ctypes.c_size_t,
    "f": ctypes.c_float,
    "u": ctypes.c_uint32,
    "i": ctypes.c_int32,
}

#: Functions that do not return a covbeam_status.
RESULTS = {
{results}
}

#: Parameters of every function that the library exports.
PROTOTYPES = {
{prototypes}
}
