"""Scenes: a geometry, and descriptions of all else in plain numbers."""

import ctypes

import numpy as np

from ._arrays import number, packed, whole
from ._library import Handle, lib

#: How a surface treats light: weights per channel, 0 to 1, of the lobes that it is the sum of; what they leave is absorbed.
#:
#: - diffuse: of Lambert reflection; translucent: of Lambert transmission.
#: - metal: reflectance of a microfacet mirror at normal incidence; edge: at grazing incidence (Schlick's curve between them).
#: - glass_reflection, glass_transmission: factors on what Fresnel's equations reflect and transmit at a dielectric boundary.
#: - coat: weight of a dielectric reflection over what is diffuse: Fresnel's share of it is reflected, the rest goes on to `diffuse`.
#: - transparent: of light that goes straight on, as if nothing were there.
#: - ior: refractive index of glass and coat, over that of the side that the normal points to.
#: - roughness: GGX's alpha of metal, glass and coat, 0 to 1; below 1e-3 they are perfectly smooth.
MATERIAL = np.dtype(
    [
        ("diffuse", np.float32, (3,)),
        ("translucent", np.float32, (3,)),
        ("metal", np.float32, (3,)),
        ("edge", np.float32, (3,)),
        ("glass_reflection", np.float32, (3,)),
        ("glass_transmission", np.float32, (3,)),
        ("coat", np.float32, (3,)),
        ("transparent", np.float32, (3,)),
        ("ior", np.float32),
        ("roughness", np.float32),
    ]
)

_FLOAT, _INT, _DOUBLE = np.dtype(np.float32), np.dtype(np.int32), np.dtype(np.float64)
_p, _z, _u, _i, _d = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint32, ctypes.c_int32, ctypes.c_double
_d3 = _d * 3


class _Volume(ctypes.Structure):
    _fields_ = [(name, _d3) for name in ("scattering", "absorption", "min", "max")]
    _fields_ += [("asymmetry", _d), ("density_min", _d3), ("density_max", _d3), ("glow_min", _d3), ("glow_max", _d3)]
    _fields_ += [("cells", _u * 3), ("glow_cells", _u * 3), ("phase", _u)]
    # The last is what aligns the arrays.
    _fields_ += [("_", _u), ("densities", _p), ("glow", _p), ("part_count", _z), ("parts", _p)]


class _Light(ctypes.Structure):
    _fields_ = [(name, _d3) for name in ("position", "axis", "u", "v", "intensity", "radiance", "irradiance")]
    _fields_ += [("axes", _d * 9)]
    _fields_ += [(name, _d) for name in ("radius", "cosine", "blend", "spread", "angle", "reach")]
    # The last is what aligns the arrays.
    _fields_ += [(name, _u) for name in ("kind", "soft", "round", "rows", "columns", "_")]
    _fields_ += [("triangle_count", _z), ("triangles", _p), ("cells", _p)]


class _Camera(ctypes.Structure):
    _fields_ = [(name, _d3) for name in ("position", "right", "up", "forward")]
    _fields_ += [("left", _d), ("top", _d), ("step", _d * 2), ("widest", _d)]
    _fields_ += [(name, _d) for name in ("near", "aperture", "focus", "rotation", "ratio")]
    _fields_ += [(name, _u) for name in ("blades", "projection", "width", "height")]


class _Description(ctypes.Structure):
    _fields_ = [("material_count", _z), ("materials", _p), ("object_count", _z), ("object_volumes", _p), ("object_closed", _p)]
    _fields_ += [("volume_count", _z), ("volumes", _p), ("light_count", _z), ("lights", _p), ("world_volume", _i), ("camera", _Camera)]


class Scene:
    """What is rendered. Copies all that it is given; the geometry is shared.

    - geometry: a Geometry that has been built.
    - materials: MATERIAL (n,), by the numbers of the triangles and instances.
    - object_volumes: int (m,), by the numbers of the instances: index of the volume that an object is filled with, or -1.
    - object_closed: bool (m,): whether it has an inside. Fog inside of what is of glass is kept apart from that outside.
    - volumes: media and where they are, up to 64 that fill objects. Of each: `scattering` and `absorption` coefficients [1/m] (3,);
      `phase`, 0 isotropic, 1 Henyey-Greenstein, 2 Rayleigh, and `asymmetry`, the mean cosine of Henyey-Greenstein in (-1, 1); `min` and
      `max`, corners of what it fills [m], not read for the world's; `density`, None or what has `min` and `max` [m] and `values`, float32
      (z, y, x), relative densities at the middles of voxels; `glow`, the same, of emission coefficients, float32 (z, y, x, 3)
      [W/(m^3 sr)], of what fills objects; `parts`, of a sum: the indices of the volumes that overlap where it counts.
    - world_volume: index of the volume that is outside of all objects, or -1.
    - lights: each with `kind` and what that needs; see LightKind and Light of the extension.
    - camera: with `position`, `right`, `up`, `forward` (3,), `projection`, 0 perspective, 1 orthographic, 2 equirectangular, 3 fisheye,
      `left`, `top`, `step` (2,), `widest`, `width`, `height`, `near`, and `aperture`, None or what has `radius`, `focus`, `blades`,
      `rotation`, `ratio`; see Camera and Aperture of the extension.
    """

    def __init__(self, geometry, materials, object_volumes, object_closed, volumes, world_volume, lights, camera):
        # Arrays that the description shows, until the call has ended.
        kept = [packed("materials", materials, MATERIAL, (None,))]
        kept.append(packed("object_volumes", object_volumes, _INT, (None,)))
        count = len(kept[1])
        kept.append(packed("object_closed", np.asarray(object_closed, bool), np.dtype(bool), (count,)))
        media = (_Volume * len(volumes))(*(_volume(f"volumes[{i}]", each, kept) for i, each in enumerate(volumes)))
        lamps = (_Light * len(lights))(*(_light(f"lights[{i}]", each, kept) for i, each in enumerate(lights)))
        description = _Description(
            material_count=len(kept[0]),
            materials=kept[0].ctypes.data,
            object_count=count,
            object_volumes=kept[1].ctypes.data,
            object_closed=kept[2].ctypes.data,
            volume_count=len(media),
            volumes=ctypes.addressof(media),
            light_count=len(lamps),
            lights=ctypes.addressof(lamps),
            world_volume=whole("world_volume", world_volume, -(2**31), 2**31 - 1),
            camera=_camera(camera),
        )
        make, free = lib.covbeam_rays_scene_new, lib.covbeam_rays_scene_free
        self._handle = Handle(make, free, geometry._open(), ctypes.addressof(description))
        #: Pixels of a picture: down and across.
        self.shape = (description.camera.height, description.camera.width)

    def close(self):
        """Gives the memory up, which goes when no session uses it any more; nothing happens the second time."""
        self._handle = None

    def _open(self):
        if self._handle is None:
            raise ValueError("Scene: used after close(); make a new one")
        return self._handle


def _vectors(name, thing, fields):
    """Vectors among the fields of a thing, by name."""
    return {field: _d3(*packed(f"{name}.{field}", getattr(thing, field), _DOUBLE, (3,))) for field in fields}


def _numbers(name, thing, fields):
    """Numbers among the fields of a thing, by name."""
    return {field: number(f"{name}.{field}", getattr(thing, field)) for field in fields}


def _volume(name, volume, kept):
    given = _vectors(name, volume, ("scattering", "absorption", "min", "max")) | _numbers(name, volume, ("asymmetry",))
    given["phase"] = whole(f"{name}.phase", volume.phase)
    if volume.density is not None:
        values = packed(f"{name}.density.values", volume.density.values, _FLOAT, (None, None, None))
        corners = _vectors(f"{name}.density", volume.density, ("min", "max"))
        given |= {f"density_{corner}": value for corner, value in corners.items()}
        given |= {"cells": (_u * 3)(*values.shape[::-1]), "densities": values.ctypes.data}
        kept.append(values)
    if volume.glow is not None:
        values = packed(f"{name}.glow.values", volume.glow.values, _FLOAT, (None, None, None, 3))
        corners = _vectors(f"{name}.glow", volume.glow, ("min", "max"))
        given |= {f"glow_{corner}": value for corner, value in corners.items()}
        given |= {"glow_cells": (_u * 3)(*values.shape[2::-1]), "glow": values.ctypes.data}
        kept.append(values)
    parts = packed(f"{name}.parts", np.array(volume.parts, int), _INT, (None,))
    kept.append(parts)
    return _Volume(**given, part_count=len(parts), parts=parts.ctypes.data)


def _light(name, light, kept):
    given = _vectors(name, light, ("position", "axis", "u", "v", "intensity", "radiance", "irradiance"))
    given |= _numbers(name, light, ("radius", "cosine", "blend", "spread", "angle"))
    given |= {"kind": whole(f"{name}.kind", light.kind), "soft": bool(light.soft), "round": bool(light.round)}
    triangles = packed(f"{name}.triangles", light.triangles, _FLOAT, (None, 3, 3))
    kept.append(triangles)
    given |= {"triangle_count": len(triangles), "triangles": triangles.ctypes.data}
    if light.pattern is not None:
        given["reach"] = number(f"{name}.pattern.reach", light.pattern.reach)
        given |= _cells(f"{name}.pattern.cells", light.pattern.cells, f"{name}.pattern.axes", light.pattern.axes, kept)
    elif light.sky is not None:
        given |= _cells(f"{name}.sky", light.sky, f"{name}.turn", light.turn, kept)
    return _Light(**given)


def _cells(name, cells, axes_name, axes, kept):
    cells = packed(name, cells, _FLOAT, (None, None, 3))
    axes = packed(axes_name, axes, _DOUBLE, (3, 3))
    kept.append(cells)
    rows, columns, _ = cells.shape
    return {"rows": rows, "columns": columns, "cells": cells.ctypes.data, "axes": (_d * 9)(*axes.reshape(-1))}


def _camera(camera):
    name = "camera"
    given = _vectors(name, camera, ("position", "right", "up", "forward")) | _numbers(name, camera, ("left", "top", "widest", "near"))
    given["step"] = (_d * 2)(*packed("camera.step", camera.step, _DOUBLE, (2,)))
    given |= {field: whole(f"camera.{field}", getattr(camera, field)) for field in ("projection", "width", "height")}
    lens = camera.aperture
    if lens is not None:
        name = "camera.aperture"
        numbers = _numbers(name, lens, ("radius", "focus", "rotation", "ratio"))
        if numbers["radius"] == 0:
            raise ValueError("camera.aperture.radius: 0; give None for a pinhole")
        given["aperture"] = numbers.pop("radius")
        given |= numbers | {"blades": whole("camera.aperture.blades", lens.blades)}
    return _Camera(**given)
