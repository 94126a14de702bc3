"""The arrays that covbeam reads and writes, as numpy dtypes laid out as the structs of covbeam.h.

Make them with np.zeros(n, dtype): every field is then a view, `beams["origin"]` of shape (n, 3). Lengths are in metres (or
any other unit, used throughout), power in watts per channel, frequencies in cycles/m and cycles/rad.
"""

import numpy as np

_f4 = np.float32


def _struct(*fields):
    return np.dtype(list(fields), align=True)


#: Square root of the covariance of a local light field's spectrum; made by covbeam.light_field.point and its kin.
LIGHT_FIELD = _struct(("root", _f4, (10,)), ("x_axis", _f4, (3,)), ("direction", _f4, (3,)))

#: Curvature of a surface at a hit [1/m], positive where it is convex on the side of the normal; all 0 is a plane.
CURVATURE = _struct(("tangent", _f4, (3,)), ("along", _f4), ("across", _f4), ("twist", _f4))

#: Covariance of the spectrum of the fluence around a point, in world axes [cycles^2/m^2].
SPECTRUM = _struct(*((name, _f4) for name in ("xx", "yy", "zz", "xy", "xz", "yz")))

#: What one voxel has collected: sum of weight x (xx, yy, zz, xy, xz, yz), and sum of the weights.
GRID_CELL = _struct(("sum", np.float64, (6,)), ("weight", np.float64))

#: The mean spectrum of one voxel, and its fluence over that of the brightest one, in (0, 1]; 0 = no data.
FLUENCE_CELL = _struct(("spectrum", SPECTRUM), ("weight", _f4))

#: A point of a table of columns: distance along the ray, integral of the relative density up to there [m].
KNOT = _struct(("distance", _f4), ("column", _f4))

#: An edge of an occluder beside a ray: distance along the ray at which it passes by, distance from the ray there [m], direction from
#: the ray to it, any length but 0.
EDGE = _struct(("depth", _f4), ("distance", _f4), ("towards", _f4, (3,)))

#: Where a probe ray meets a surface: see segment.find_edges.
PROBE_HIT = _struct(("distance", _f4), ("normal", _f4, (3,)), ("offset", _f4))

#: A straight piece of a photon's path that carries a light field, and the edges that it passes, edge_count of them, sorted by depth.
#: `knots` is an address: see Grid.deposit.
SEGMENT = _struct(
    ("origin", _f4, (3,)),
    ("length", _f4),
    ("power", _f4),
    ("unscattered", np.uint32),
    ("field", LIGHT_FIELD),
    ("edges", EDGE, (4,)),
    ("edge_count", np.uint32),
    ("knots", np.uintp),
    ("knot_count", np.uintp),
)

#: A photon beam: origin, unit direction, length, power per channel [W], unit normals (or 0) of the surfaces at its ends.
BEAM = _struct(
    ("origin", _f4, (3,)),
    ("direction", _f4, (3,)),
    ("length", _f4),
    ("power", _f4, (3,)),
    ("start_normal", _f4, (3,)),
    ("end_normal", _f4, (3,)),
)

#: One straight piece of an eye path inside one medium: origin, unit direction away from the eye, length (inf allowed).
EYE_RAY = _struct(("origin", _f4, (3,)), ("direction", _f4, (3,)), ("length", _f4))

#: What an eye ray has gathered: radiance [W/(m^2 sr)], accepted pairs, and sums over these: weight, weight x radius,
#: weight x bandwidth.
GATHERED = _struct(("radiance", _f4, (3,)), ("pairs", np.uint32), ("weight", _f4), ("radius", _f4), ("sigma", _f4))

#: Closest approach of an eye ray's line and a beam's line.
CROSSING = _struct(("ray_distance", _f4), ("beam_distance", _f4), ("gap", _f4), ("sin_theta", _f4), ("axis", _f4, (3,)))

#: A place where a beam comes within the kernel radius of an eye ray, for BeamMap.gather_shaded.
CONTACT = _struct(
    ("position", _f4, (3,)),
    ("ray", np.uint32),
    ("beam", np.uint32),
    ("ray_distance", _f4),
    ("beam_distance", _f4),
    ("cos_theta", _f4),
    ("kernel", _f4),
    ("radius", _f4),
    ("sigma", _f4),
)

#: Derivatives of a relative density, in world axes: gradient [1/m], hessian xx, yy, zz, xy, xz, yz [1/m^2].
DERIVATIVES = _struct(("gradient", _f4, (3,)), ("hessian", _f4, (6,)))

#: How much an eye ray changes from one pixel to the next: its origin [m/pixel], 0 for a pinhole, and its unit direction [1/pixel].
PIXEL_STEP = _struct(("origin", _f4, (3,)), ("direction", _f4, (3,)))

#: Covariance of the spectrum of the in-scattered light around a pixel [cycles^2/pixel^2], x to the right, y down; and the light on
#: the way, in the grid's relative unit: 0 = the grid has no opinion.
IMAGE_SPECTRUM = _struct(*((name, _f4) for name in ("xx", "xy", "yy", "weight")))

#: Covariance of a Gaussian reconstruction filter [pixels^2], x to the right, y down; all 0 is no filter.
IMAGE_FILTER = _struct(*((name, _f4) for name in ("xx", "xy", "yy")))

#: What one eye ray saw of what it was asked for: its pixel, x and y; 1 or 0 for whether it was asked for the fog before the first
#: surface, whose light is filtered, and for what lies beyond; the radiance of both [W/(m^2 sr)].
FILM_RAY = _struct(
    ("pixel", np.uint32, (2,)), ("has_volume", np.uint32), ("has_rest", np.uint32), ("volume", _f4, (3,)), ("rest", _f4, (3,))
)

#: A pixel of a picture: all light, and that of the fog before the first surface [W/(m^2 sr)]; squared standard error of the filtered
#: luminance, 0 where it is not known; luminance of the odd passes minus that of the even ones, of the light that is not filtered.
FILM_PIXEL = _struct(("radiance", _f4, (3,)), ("volume", _f4, (3,)), ("variance", _f4), ("difference", _f4))

#: One knot of the table along an eye ray: distance from its origin [m], light scattered to the eye a metre if nothing is in the way
#: [W/(m^3 sr)], deviation of the fluence's spectrum along the ray [cycles/m], share of the light that is expected to arrive. NaN:
#: not known.
MARCH_KNOT = _struct(*((name, _f4) for name in ("distance", "radiance", "deviation", "visibility")))

#: A place for a shadow ray: distance [m], weight [m] (0: no ray is needed), the visibility found; `mass` is the library's.
MARCH_SAMPLE = _struct(
    ("distance", _f4), ("weight", _f4), ("visibility", _f4), ("reserved", np.uint32), ("mass", np.float64)
)

#: Importance around a point: of a watt of beam on each metre [1/(W m)], of a watt that is scattered there, by the medium or by a
#: diffuse surface, and of one that arrives on surfaces, but for what they scatter [1/W].
IMPORTANCE_CELL = _struct(*((name, _f4) for name in ("beam", "scattered", "surface")))

#: What a watt that flies along a segment is worth as a beam, and by what the medium scatters of it [1/W]; what is left of it where it
#: leaves the voxels, or at its end if that is before.
SEGMENT_IMPORTANCE = _struct(*((name, _f4) for name in ("beam", "scattered", "transmittance")))
