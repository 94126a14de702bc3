"""Meshes and their instances."""

import ctypes
import hashlib

import numpy as np

from .. import _session_abi as abi
from .._callbacks import Call
from .._handles import Object, Owner, using
from .._library import check, lib
from . import _library  # noqa: F401
from ._packed import packed, whole

#: Where a ray meets a surface [m]. inf = nothing hit, then all else is 0 but material and object, which are -1.
HIT = np.dtype(
    [
        ("distance", np.float32),  # along the unit direction
        ("position", np.float32, (3,)),  # moved onto the surface
        ("geometric_normal", np.float32, (3,)),  # unit, of the triangle: counter-clockwise from its front
        ("normal", np.float32, (3,)),  # unit shading normal, on the same side
        ("material", np.int32),  # given with the instance, or if that is -1 with the triangle
        ("object", np.int32),  # given with the instance
    ]
)

_FLOAT, _INT, _DOUBLE = np.dtype(np.float32), np.dtype(np.int32), np.dtype(np.float64)


class Geometry(Object):
    """Meshes and their instances: first added, then built. Closed with the last reference or by close().

    - has_digest: whether it is to be compared with others; what is added is hashed then, 30 MB in 40 ms.
    """

    def __init__(self, has_digest=False):
        self._owner = Owner(lib.covbeam_geometry_new, lib.covbeam_geometry_free)
        self._meshes = 0
        #: Triangles of no area that were left out so far.
        self.dropped = 0
        self._contents = hashlib.blake2b(digest_size=16) if has_digest else None

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
        dropped = ctypes.c_size_t()
        mesh = abi.Mesh(
            struct_size=ctypes.sizeof(abi.Mesh),
            material_count=len(materials),
            materials=materials.ctypes.data,
            position_count=len(positions),
            positions=positions.ctypes.data,
            triangle_count=len(triangles),
            triangles=triangles.ctypes.data,
            normals=None if normals is None else normals.ctypes.data,
        )
        with using(changed=self) as [geometry]:
            check(lib.covbeam_geometry_add_mesh(geometry, ctypes.addressof(mesh), ctypes.addressof(dropped)))
        self.dropped += dropped.value
        self._meshes += 1
        self._note(b"mesh", positions, triangles, materials, *([] if normals is None else [normals]))
        return self._meshes - 1

    def add_instance(self, mesh, matrix, object, material=-1):
        """Places a mesh in the world.

        - mesh: of add_mesh.
        - matrix: (4, 4), affine, mesh to world [m]. One that flattens is refused: leave such an instance out.
        - object: its number in a scene.
        - material: number of the material of all of it; -1 for those of the triangles.
        """
        matrix = packed("matrix", matrix, _DOUBLE, (4, 4))
        mesh, object = whole("mesh", mesh), whole("object", object, -(2**31), 2**31 - 1)
        material = whole("material", material, -(2**31), 2**31 - 1)
        instance = abi.Instance((ctypes.c_double * 16)(*matrix.reshape(-1)), mesh, object, material)
        with using(changed=self) as [geometry]:
            check(lib.covbeam_geometry_add_instances(geometry, 1, ctypes.addressof(instance), 0))
        self._note(b"instance", matrix, np.array([mesh, object, material]))

    def build(self, poll=None):
        """Builds the hierarchies on native threads; once, after all meshes and instances.

        - poll: a function asked at least every 50 ms: False stops, which raises Cancelled and closes the geometry.
        """
        call = Call(poll)
        try:
            with using(changed=self) as [geometry]:
                call.check(lib.covbeam_geometry_build(geometry, call.poll, None))
        except BaseException:
            # Without waiting for the threads, which work on copies.
            self.close()
            raise

    def cast(self, origins, directions):
        """The nearest hits of rays, to look at what was built: HIT (n,).

        - origins: float32 (n, 3) [m].
        - directions: float32 (n, 3), unit.
        """
        origins = packed("origins", origins, _FLOAT, (None, 3))
        count = len(origins)
        directions = packed("directions", directions, _FLOAT, (count, 3))
        hits = np.empty(count, HIT)
        arrays = [word for array in (origins, directions, hits) for word in (array.ctypes.data, array.strides[0] if count else 0)]
        with using(self) as [geometry]:
            check(lib.covbeam_geometry_cast(geometry, count, *arrays))
        return hits

    @property
    def digest(self) -> bytes:
        """Equal for geometries that the same was added to, in the same order. Raises RuntimeError if it was made without."""
        if self._contents is None:
            raise RuntimeError("a geometry without a digest: make it with has_digest=True")
        return self._contents.digest()

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

    def _note(self, kind, *arrays):
        if self._contents is None:
            return
        self._contents.update(kind)
        for array in arrays:
            self._contents.update(str(array.shape).encode())
            self._contents.update(np.ascontiguousarray(array).data)

    def _info(self):
        info = abi.GeometryInfo()
        with using(self) as [geometry]:
            check(lib.covbeam_geometry_get_info(geometry, ctypes.addressof(info)))
        return info
