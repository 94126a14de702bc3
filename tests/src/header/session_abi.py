"""The C ABI of sessions as ctypes sees it. Made from the headers by `cargo run -p covbeam-tests --bin header`; do not edit."""

import ctypes

from ._abi import GridLayout
{structs}

#: A letter for each parameter: see TYPES of _abi.
PROTOTYPES = {
{prototypes}
}
