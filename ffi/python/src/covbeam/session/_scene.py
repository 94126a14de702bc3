"""Scenes: a geometry, and descriptions of all else in plain numbers."""

import ctypes
from enum import IntEnum

import numpy as np

from .. import _session_abi as abi
from .._handles import Object, Owner, using
from .._library import lib
from . import _library  # noqa: F401
from ._packed import number, packed, whole


class ShapeKind(IntEnum):
    """Kinds of shapes: a ball around `a` of `radius`, a box from `a` to `b`, the parallelogram at `a` with the edges `b` and `c`."""

    SPHERE = 0
    BOX = 1
    RECTANGLE = 2


#: How a surface treats light: weights per channel, 0 to 1, of the lobes that it is the sum of; what they leave is absorbed.
#:
#: - diffuse: of Lambert reflection; translucent: of Lambert transmission.
#: - metal: reflectance of a microfacet mirror at normal incidence; edge: at grazing incidence (Schlick's curve between them).
#: - glass_reflection, glass_transmission: factors on what Fresnel's equations reflect and transmit at a dielectric boundary.
#: - coat: weight of a dielectric reflection over what is diffuse: Fresnel's share of it is reflected, the rest goes on to `diffuse`.
#: - transparent: of light that goes straight on, as if nothing were there.
#: - ior: index of refraction of glass and coat, over that of the side that the normal points to; 0: 1.5.
#: - alpha: GGX's alpha of metal, glass and coat, 0 to 1; below 1e-3 they are perfectly smooth.
#: - shadow: like transparent, of light on its way from a lamp, if has_shadow is not 0; the other lobes lose nothing for it, but glass does not act on
#:   light that it lets by more freely than transparent says.
#: - asks: 0; hosts with geometry of their own, in C, have functions that it names.
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
        ("alpha", np.float32),
        ("asks", np.uint32),
        ("has_shadow", np.uint32),
        ("shadow", np.float32, (3,)),
    ]
)

#: Spheres, boxes and rectangles, exact where a mesh would have corners; kind: a ShapeKind, material: a number of it, volume: the index of the one that
#: fills it, which has no voxels, or -1; priority: of what of glass overlaps, that of the highest counts.
SHAPE = np.dtype(
    [
        ("kind", np.uint32),
        ("material", np.uint32),
        ("volume", np.int32),
        ("priority", np.int32),
        ("a", np.float32, (3,)),
        ("b", np.float32, (3,)),
        ("c", np.float32, (3,)),
        ("radius", np.float32),
    ]
)

#: By which rays and lamps an object is not heeded; all 0: by all it is.
#:
#: - hidden_from: sum of Rays that do not see it: to them it is not there.
#: - light_set, shadow_set: sets below 64 that it is in, for lamps that light some only, and of which some only cast shadows.
OBJECT_RULES = np.dtype([("hidden_from", np.uint32), ("light_set", np.uint32), ("shadow_set", np.uint32)])

_FLOAT, _INT, _DOUBLE = np.dtype(np.float32), np.dtype(np.int32), np.dtype(np.float64)
_OBJECT = np.dtype([("volume", np.int32), ("is_closed", np.uint32), *OBJECT_RULES.descr])
_u, _d = ctypes.c_uint32, ctypes.c_double
_d3 = _d * 3


class Scene(Object):
    """What is rendered. Copies all that it is given; the geometry is shared. Objects with these attributes will do in place of Light, Volume and
    Camera.

    - geometry: a Geometry that has been built, or None.
    - materials: MATERIAL (n,), by the numbers of triangles, instances and shapes.
    - camera: a Camera.
    - lights: each a Light.
    - volumes: each a Volume, up to 64 that fill objects.
    - world_volume: index of the volume that is outside of all objects and shapes, or -1.
    - shapes: SHAPE (k,).
    - object_volumes: int (m,), by the numbers of the instances: index of the volume that an object is filled with, or -1.
    - object_closed: bool (m,): whether it has an inside. Fog inside of what is of glass is kept apart from that outside.
    - object_rules: OBJECT_RULES (m,): by which rays and lamps an object is not heeded; empty: by all it is.
    - fog_alone: whether pictures show the light that fog scatters and nothing else: surfaces are black, and hide or mirror the fog behind them.
    """

    def __init__(
        self,
        geometry,
        materials,
        camera,
        lights,
        volumes=(),
        world_volume=-1,
        *,
        shapes=(),
        object_volumes=(),
        object_closed=(),
        object_rules=(),
        fog_alone=False,
    ):
        # Arrays that the description shows, until the call has ended.
        kept = [packed("materials", materials, MATERIAL, (None,))]
        kept.append(packed("shapes", shapes if len(shapes) else np.zeros(0, SHAPE), SHAPE, (None,)))
        kept.append(_objects(object_volumes, object_closed, object_rules))
        media = (abi.Volume * len(volumes))(*(_volume(f"volumes[{i}]", each, kept) for i, each in enumerate(volumes)))
        lamps = (abi.Light * len(lights))(*(_light(f"lights[{i}]", each, kept) for i, each in enumerate(lights)))
        description = abi.Description(
            struct_size=ctypes.sizeof(abi.Description),
            world_volume=whole("world_volume", world_volume, -(2**31), 2**31 - 1),
            fog_alone=bool(fog_alone),
            material_count=len(kept[0]),
            materials=kept[0].ctypes.data,
            shape_count=len(kept[1]),
            shapes=kept[1].ctypes.data,
            object_count=len(kept[2]),
            objects=kept[2].ctypes.data,
            volume_count=len(media),
            volumes=ctypes.addressof(media),
            light_count=len(lamps),
            lights=ctypes.addressof(lamps),
            camera=_camera(camera),
        )
        with using(geometry) as [handle]:
            self._owner = Owner(lib.covbeam_scene_new, lib.covbeam_scene_free, handle, ctypes.addressof(description))
        #: Pixels of a picture: down and across.
        self.shape = (description.camera.height, description.camera.width)


def _objects(volumes, closed, rules):
    volumes = packed("object_volumes", volumes if len(volumes) else np.zeros(0, int), _INT, (None,))
    closed = packed("object_closed", np.asarray(closed, bool), np.dtype(bool), (len(volumes),))
    objects = np.zeros(len(volumes), _OBJECT)
    objects["volume"], objects["is_closed"] = volumes, closed
    if len(rules):
        rules = packed("object_rules", rules, OBJECT_RULES, (len(volumes),))
        for name in OBJECT_RULES.names:
            objects[name] = rules[name]
    return objects


def _of(thing, field, default):
    return getattr(thing, field, default)


def _vectors(name, thing, fields):
    """Vectors among the fields of a thing, by name; 0 where it has none."""
    zeros = np.zeros(3)
    return {field: _d3(*packed(f"{name}.{field}", _of(thing, field, zeros), _DOUBLE, (3,))) for field in fields}


def _numbers(name, thing, fields):
    """Numbers among the fields of a thing, by name; 0 where it has none."""
    return {field: number(f"{name}.{field}", _of(thing, field, 0.0)) for field in fields}


def _volume(name, volume, kept):
    given = _vectors(name, volume, ("scattering", "absorption", "min", "max", "origin", "up")) | _numbers(name, volume, ("asymmetry", "scale_height"))
    given |= {field: whole(f"{name}.{field}", _of(volume, field, 0)) for field in ("phase", "hidden_from", "light_set", "shadow_set")}
    for field, shape in (("density", (None, None, None)), ("glow", (None, None, None, 3))):
        voxels = _of(volume, field, None)
        if voxels is None:
            continue
        values = packed(f"{name}.{field}.values", voxels.values, _FLOAT, shape)
        corners = _vectors(f"{name}.{field}", voxels, ("min", "max"))
        given |= {f"{field}_{corner}": value for corner, value in corners.items()}
        given |= {f"{field}_cells": (_u * 3)(*values.shape[2::-1]), field: values.ctypes.data}
        kept.append(values)
    parts = packed(f"{name}.parts", np.array(_of(volume, "parts", ()), int), _INT, (None,))
    kept.append(parts)
    lobes = [_lobe(f"{name}.lobes[{index}]", lobe) for index, lobe in enumerate(_of(volume, "lobes", ()))]
    lobes = (abi.PhaseLobe * len(lobes))(*lobes)
    kept.append(lobes)
    given |= {"lobe_count": len(lobes), "lobes": ctypes.addressof(lobes)}
    return abi.Volume(**given, part_count=len(parts), parts=parts.ctypes.data)


def _lobe(name, lobe):
    phase, asymmetry, share = lobe
    share = _d3(*packed(f"{name}.share", share, _DOUBLE, (3,)))
    return abi.PhaseLobe(phase=whole(f"{name}.phase", phase), asymmetry=number(f"{name}.asymmetry", asymmetry), share=share)


def _light(name, light, kept):
    given = _vectors(name, light, ("position", "axis", "u", "v", "intensity", "radiance", "irradiance"))
    given |= _numbers(name, light, ("radius", "cosine", "blend", "spread", "angle", "falloff", "smooth"))
    given["kind"] = whole(f"{name}.kind", light.kind)
    given["hidden_from"] = whole(f"{name}.hidden_from", _of(light, "hidden_from", 0))
    bounces = _of(light, "bounces", None)
    given["most_events"] = 0 if bounces is None else whole(f"{name}.bounces", bounces, 0, 2**31 - 1) + 1
    given |= {field: whole(f"{name}.{field}", _of(light, field, 0), 0, 2**64 - 1) for field in ("unlit", "unshadowed")}
    given |= {f"is_{field}": bool(_of(light, field, False)) for field in ("visible", "soft", "round")}
    triangles = packed(f"{name}.triangles", _of(light, "triangles", np.zeros((0, 3, 3))), _FLOAT, (None, 3, 3))
    kept.append(triangles)
    given |= {"triangle_count": len(triangles), "triangles": triangles.ctypes.data}
    pattern, sky = _of(light, "pattern", None), _of(light, "sky", None)
    if pattern is not None:
        given["reach"] = number(f"{name}.pattern.reach", pattern.reach)
        given |= _cells(f"{name}.pattern.cells", pattern.cells, f"{name}.pattern.axes", pattern.axes, kept)
    elif sky is not None:
        given |= _cells(f"{name}.sky", sky, f"{name}.turn", _of(light, "turn", np.eye(3)), kept)
    return abi.Light(**given)


def _cells(name, cells, axes_name, axes, kept):
    cells = packed(name, cells, _FLOAT, (None, None, 3))
    axes = packed(axes_name, axes, _DOUBLE, (3, 3))
    kept.append(cells)
    rows, columns, _ = cells.shape
    return {"rows": rows, "columns": columns, "cells": cells.ctypes.data, "axes": (_d3 * 3)(*map(tuple, axes))}


def _camera(camera):
    name = "camera"
    given = _vectors(name, camera, ("position", "up", "forward"))
    given |= _numbers(name, camera, ("half_height", "left", "top", "widest", "near"))
    given["step"] = (_d * 2)(*packed("camera.step", _of(camera, "step", (0.0, 0.0)), _DOUBLE, (2,)))
    given |= {field: whole(f"camera.{field}", getattr(camera, field)) for field in ("projection", "width", "height")}
    lens = _of(camera, "aperture", None)
    if lens is not None:
        name = "camera.aperture"
        numbers = _numbers(name, lens, ("radius", "focus", "rotation", "ratio"))
        if numbers["radius"] == 0:
            raise ValueError("camera.aperture.radius: 0; give None for a pinhole")
        given["aperture"] = numbers.pop("radius")
        given |= numbers | {"blades": whole("camera.aperture.blades", lens.blades)}
    return abi.Camera(**given)
