"""covbeam_rays: what would be a loop in Python for each ray, on native threads.

- Geometry: meshes and instances; nearest hits with curvature, and the silhouettes beside rays.
- Gather: covbeam's BeamMap.gather and Film.picture on many threads.
- threads: how many.

Results are the same, to the bit, for any number of threads. Arguments that are wrong raise ValueError or TypeError with
what to do. A long call asks its `poll` at least every 50 ms whether to go on, and raises Cancelled if not. What covbeam
or the order of calls refuses raises covbeam.Error.
"""

from covbeam import Cancelled

from ._gather import Gather
from ._geometry import EDGE, HIT, Geometry
from ._library import threads

__all__ = ["EDGE", "HIT", "Cancelled", "Gather", "Geometry", "threads"]
