"""covbeam: frequency-aware photon beams. Fog, smoke and water lit by strong lights.

The library's C functions on numpy arrays, under the same names without the prefix: covbeam_light_fields_travel is
light_field.travel, covbeam_beam_map_gather is BeamMap.gather. covbeam.h is the manual of what they compute.

- Arrays are passed by address and stride, never copied: views work, and what cannot be passed is refused with TypeError or
  ValueError. The dtypes (LIGHT_FIELD, BEAM, EYE_RAY, SEGMENT, ...) are the C structs; numbers are float32.
- A call that fails raises Error, with its status and a message, and has changed nothing.
- Objects (Grid, Density, BeamMap, Scratch, Film, March, Importance) close at the end of a `with`, by close(), or with their last reference.
- Threads: several may read an object at once, one may change it; a call that would break this raises Error. The library runs
  without the interpreter's lock.
"""

from . import dtypes, image, kernel, light_field, march, segment, spectrum
from ._abi import ABI_VERSION
from ._library import version as __version__
from .beams import BeamMap, Scratch
from .column import Column
from .dtypes import (
    BEAM,
    CONTACT,
    CROSSING,
    CURVATURE,
    DERIVATIVES,
    EDGE,
    EYE_RAY,
    FILM_PIXEL,
    FILM_RAY,
    FLUENCE_CELL,
    GATHERED,
    GRID_CELL,
    IMAGE_FILTER,
    IMAGE_SPECTRUM,
    IMPORTANCE_CELL,
    KNOT,
    LIGHT_FIELD,
    MARCH_KNOT,
    MARCH_SAMPLE,
    PIXEL_STEP,
    PROBE_HIT,
    SEGMENT,
    SEGMENT_IMPORTANCE,
    SPECTRUM,
)
from .emission import emission_guide_fill, emission_guide_warp, path_numbers
from .errors import Cancelled, Error, Status
from .grid import Grid
from .image import Film
from .importance import Importance, weight_window
from .kernel import Kernel, KernelShape, Schedule
from .march import March
from .media import Density, Exponential, GridLayout, Medium
from .pairs import cross, filter_beams, gather_pair
from .phase import Phase

__all__ = [name for name in dir() if not name.startswith("_")]
