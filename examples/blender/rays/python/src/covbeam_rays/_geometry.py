"""Meshes, instances, and what rays hit."""

import ctypes

import covbeam
import numpy as np

from ._arrays import packed, result
from ._library import INTERVAL, Handle, Info, check, lib, stopped

#: Where a ray meets a surface [m]. inf = nothing hit, then all else is 0 but material and object, which are -1.
HIT = np.dtype(
    [
        ("distance", np.float32),  # along the unit direction
        ("position", np.float32, (3,)),  # moved onto the surface
        ("geometric_normal", np.float32, (3,)),  # unit, of the triangle: counter-clockwise from its front
        ("normal", np.float32, (3,)),  # unit shading normal, on the same side
        ("curvature", covbeam.CURVATURE),  # of the field of shading normals, positive = convex on their side
        ("material", np.int32),  # given with the instance, or if that is -1 with the triangle
        ("object", np.int32),  # given with the instance
        ("offset", np.float32),  # a ray that leaves starts at position +- offset * geometric_normal
    ],
    align=True,
)

#: An edge of an occluder beside a ray: distance along the ray at which it passes by [m], distance from the ray there
#: [m], unit direction from the ray to it.
EDGE = np.dtype([("depth", np.float32), ("distance", np.float32), ("towards", np.float32, (3,))], align=True)

_FLOAT, _INT, _DOUBLE = np.dtype(np.float32), np.dtype(np.int32), np.dtype(np.float64)


class Geometry:
    """Meshes and their instances: first added, then built, then hit. Closed with the last reference or by close()."""

    def __init__(self):
        self._handle = Handle(lib.covbeam_rays_geometry_new, lib.covbeam_rays_geometry_free)
        #: Triangles of no area that were left out so far.
        self.dropped = 0

    def close(self):
        """Gives the memory up, which goes when no call uses it any more; nothing happens the second time."""
        self._handle = None

    def add_mesh(self, positions, triangles, materials, normals=None) -> int:
        """Copies a mesh; returns its number. Triangles of no area are left out and counted in `dropped`.

        - positions: float32 (n, 3), in the mesh's space, finite, up to 1e9.
        - triangles: int32 (m, 3), counter-clockwise seen from the front.
        - materials: int32 (m,), or one number.
        - normals: float32 (m, 3, 3), unit, one a corner, in the mesh's space; None: shaded flat.
        """
        positions = packed("positions", positions, _FLOAT, (None, 3))
        triangles = packed("triangles", triangles, _INT, (None, 3))
        materials = packed("materials", np.atleast_1d(materials), _INT, (None,))
        if normals is not None:
            normals = packed("normals", normals, _FLOAT, (len(triangles), 3, 3))
        mesh, dropped = ctypes.c_uint32(), ctypes.c_size_t()
        check(
            lib.covbeam_rays_geometry_add_mesh(
                self._open(),
                len(positions),
                positions.ctypes.data,
                len(triangles),
                triangles.ctypes.data,
                len(materials),
                materials.ctypes.data,
                None if normals is None else normals.ctypes.data,
                ctypes.addressof(mesh),
                ctypes.addressof(dropped),
            )
        )
        self.dropped += dropped.value
        return mesh.value

    def add_instance(self, mesh, matrix, object, material=-1):
        """Places a mesh in the world.

        - mesh: of add_mesh.
        - matrix: (4, 4), affine, mesh to world [m]. One that flattens is refused: leave such an instance out.
        - object: number that its hits bear.
        - material: number that its hits bear; -1 for those of the triangles.
        """
        matrix = packed("matrix", matrix, _DOUBLE, (4, 4))
        check(lib.covbeam_rays_geometry_add_instance(self._open(), mesh, matrix.ctypes.data, object, material))

    def build(self, poll=None):
        """Builds the hierarchies on native threads; once, after all meshes and instances.

        - poll: a function asked at least every 50 ms: False stops, which raises Cancelled and closes the geometry.
        """
        done = ctypes.c_uint32()
        check(lib.covbeam_rays_geometry_build(self._open()))
        try:
            while not done.value:
                check(lib.covbeam_rays_geometry_wait(self._open(), INTERVAL, ctypes.addressof(done)))
                if not done.value and poll is not None and not poll():
                    raise stopped()
        finally:
            if not done.value:
                # Without waiting for the threads, which work on copies.
                self.close()

    def cast(self, origins, directions, lengths=np.inf, *, out=None):
        """The nearest hits, with distance in (0, length): HIT (n,).

        - origins: float32 (n, 3) [m].
        - directions: float32 (n, 3), unit.
        - lengths: float32 (n,), or one number [m] >= 0.
        """
        origins = packed("origins", origins, _FLOAT, (None, 3))
        count = len(origins)
        directions = packed("directions", directions, _FLOAT, (count, 3))
        lengths = np.atleast_1d(lengths)
        lengths = packed("lengths", lengths, _FLOAT, (1,) if len(lengths) == 1 else (count,))
        hits = result("out", out, HIT, (count,))
        check(
            lib.covbeam_rays_geometry_cast(
                self._open(),
                count,
                origins.ctypes.data,
                directions.ctypes.data,
                len(lengths),
                lengths.ctypes.data,
                hits.ctypes.data,
            )
        )
        return hits

    def edges(self, origins, directions, hits, through=()):
        """The silhouettes beside rays up to their hits, up to four a ray that mask light most, sorted by depth.

        - origins, directions: as in cast.
        - hits: what cast returned for them.
        - through: bool (m,), for each material number whether it casts no shadow, such as the bounds of fog; none beyond these.

        Returns how many of each ray, uint8 (n,), and these, EDGE (n, 4). About 30 to 80 casts a ray.
        """
        origins = packed("origins", origins, _FLOAT, (None, 3))
        count = len(origins)
        directions = packed("directions", directions, _FLOAT, (count, 3))
        hits = packed("hits", hits, HIT, (count,))
        through = packed("through", np.asarray(through, bool), np.dtype(bool), (None,))
        counts, edges = np.empty(count, np.uint8), np.empty((count, 4), EDGE)
        check(
            lib.covbeam_rays_geometry_edges(
                self._open(),
                count,
                origins.ctypes.data,
                directions.ctypes.data,
                hits.ctypes.data,
                len(through),
                through.ctypes.data,
                counts.ctypes.data,
                edges.ctypes.data,
            )
        )
        return counts, edges

    @property
    def triangle_count(self) -> int:
        """Triangles of all meshes, each counted once however many instances it has."""
        return self._info().triangle_count

    @property
    def memory(self) -> int:
        """Memory held after the build [bytes]."""
        return self._info().memory

    @property
    def bounds(self):
        """(min, max), float32 (3,) [m]: a box around the transformed boxes of all meshes; zeros without any."""
        info = self._info()
        return np.array(info.min, np.float32), np.array(info.max, np.float32)

    def _info(self):
        info = Info()
        check(lib.covbeam_rays_geometry_info(self._open(), ctypes.addressof(info)))
        return info

    def _open(self):
        if self._handle is None:
            raise ValueError("Geometry: used after close(); make a new one")
        return self._handle
