"""The local light field: square root of the covariance of its spectrum, and what happens to it along a light path.

Every function works on one light field or on many: an array of shape () or (n,) with the dtype covbeam.LIGHT_FIELD. Arguments
are float32 arrays of shape (n,), vectors (n, 3); a number, or a tuple for a vector, serves all n. Operators change `fields` in
place; the others return a new array, or fill `out`, which may not share memory with an argument.

    field = light_field.point((0, 0, 1))         # one lamp
    light_field.travel(field, 2.0)
    many = light_field.point(directions)         # float32, (n, 3)
    light_field.travel(many[10:20], distances)   # a view: only these travel
"""

from math import pi

from ._arrays import COUNT, FLAG, FLOAT, HESSIAN, PAIR, VECTOR, Kind, changed, elementwise, given, made, optional, struct
from ._library import lib
from .dtypes import CURVATURE, LIGHT_FIELD, SPECTRUM
from .media import Medium

_FIELD = Kind(LIGHT_FIELD)

#: Angular variance of a point that shines evenly: 1/d^2 has a relative curvature of 2/d^2 across its rays.
EVEN_LAMP = 2 / (4 * pi**2)


def point(directions, angular_variances=EVEN_LAMP, *, out=None):
    """Light of an exact point source.

    - directions: of propagation, any length but 0.
    - angular_variances: of the emission [cycles^2/rad^2] >= 0; EVEN_LAMP for a lamp that shines evenly,
      because of the fall-off with the square of the distance; more where its intensity changes with the angle.
    """
    return elementwise(
        lib.covbeam_light_fields_point,
        COUNT,
        given("directions", directions, VECTOR),
        given("angular_variances", angular_variances, FLOAT),
        made("out", out, _FIELD),
    )


def disk(directions, normals, radii, angular_variances=0.0, *, out=None):
    """Light of a disk source, at its centre.

    - directions: of propagation, any length but 0.
    - normals: of the disk, any length, either sign.
    - radii: [m] >= 0; 0 is a point, inf a uniform field.
    - angular_variances: of the emission [cycles^2/rad^2] >= 0.
    """
    return elementwise(
        lib.covbeam_light_fields_disk,
        COUNT,
        given("directions", directions, VECTOR),
        given("normals", normals, VECTOR),
        given("radii", radii, FLOAT),
        given("angular_variances", angular_variances, FLOAT),
        made("out", out, _FIELD),
    )


def collimated(directions, radii, *, out=None):
    """Exactly parallel beams, such as sunlight or a laser.

    - directions: of propagation, any length but 0.
    - radii: of the beam [m] >= 0; inf for a uniform one.
    """
    return elementwise(
        lib.covbeam_light_fields_collimated,
        COUNT,
        given("directions", directions, VECTOR),
        given("radii", radii, FLOAT),
        made("out", out, _FIELD),
    )


def gaussian(directions, x_axes, spatial_variances, angular_variances, *, out=None):
    """Light fields without correlations. A Gaussian of standard deviation w has the variance 1/(4 pi^2 w^2).

    - directions: of propagation, any length but 0.
    - x_axes: their part across the direction is the x axis of the variances.
    - spatial_variances: (n, 2), along x and y [cycles^2/m^2] >= 0; 0 is uniform, inf a point or a line.
    - angular_variances: (n, 2), along x and y [cycles^2/rad^2] >= 0; 0 is isotropic, inf parallel.
    """
    return elementwise(
        lib.covbeam_light_fields_gaussian,
        COUNT,
        given("directions", directions, VECTOR),
        given("x_axes", x_axes, VECTOR),
        given("spatial_variances", spatial_variances, PAIR),
        given("angular_variances", angular_variances, PAIR),
        made("out", out, _FIELD),
    )


def travel(fields, distances):
    """Travel through vacuum or a homogeneous medium, in place.

    - distances: [m], finite; a negative one goes back.
    """
    elementwise(
        lib.covbeam_light_fields_travel,
        COUNT,
        changed("fields", fields, _FIELD),
        given("distances", distances, FLOAT),
    )


def carry(fields, medium, origins, distances):
    """Travel through a medium, in place: `travel`, with the attenuation that varies across the ray.

    - medium: a Medium.
    - origins: where the fields are [m].
    - distances: [m] >= 0, finite.
    """
    elementwise(
        lib.covbeam_light_fields_carry,
        COUNT,
        changed("fields", fields, _FIELD),
        struct("medium", medium, Medium),
        given("origins", origins, VECTOR),
        given("distances", distances, FLOAT),
    )


def rotate(fields, x_axes):
    """Turns the frame about the ray, in place, to read `slice` along given axes. The light stays what it is.

    - x_axes: their part across the ray becomes the x axis; along the ray: nothing changes.
    """
    elementwise(
        lib.covbeam_light_fields_rotate,
        COUNT,
        changed("fields", fields, _FIELD),
        given("x_axes", x_axes, VECTOR),
    )


def reflect(fields, normals, curvatures):
    """Reflection by a smooth mirror, in place.

    - normals: at the hit, any length, either side.
    - curvatures: CURVATURE on the side of the normal; None: planes.
    """
    elementwise(
        lib.covbeam_light_fields_reflect,
        COUNT,
        changed("fields", fields, _FIELD),
        given("normals", normals, VECTOR),
        optional("curvatures", curvatures, Kind(CURVATURE)),
    )


def refract(fields, normals, curvatures, etas, *, out=None):
    """Refraction through a smooth surface, in place. Returns bool: False on total reflection, where the field stays as it was.

    - normals: at the hit, any length, either side.
    - curvatures: CURVATURE on the side of the normal; None: planes.
    - etas: refractive index on the incoming side over that on the other, > 0.
    """
    return elementwise(
        lib.covbeam_light_fields_refract,
        COUNT,
        changed("fields", fields, _FIELD),
        given("normals", normals, VECTOR),
        optional("curvatures", curvatures, Kind(CURVATURE)),
        given("etas", etas, FLOAT),
        made("out", out, FLAG),
    )


def occlude(fields, towards_edges, distances):
    """Occlusion by an edge beside the ray, such as a silhouette that it passes, in place.

    - towards_edges: from the ray to the nearest point of the edge, any length; along the ray: nothing changes.
    - distances: between ray and edge [m] >= 0; inf is no edge.
    """
    elementwise(
        lib.covbeam_light_fields_occlude,
        COUNT,
        changed("fields", fields, _FIELD),
        given("towards_edges", towards_edges, VECTOR),
        given("distances", distances, FLOAT),
    )


def attenuate(fields, gradients, hessians):
    """Attenuation by a stretch of medium whose optical depth varies across the ray, in place. `carry` does this for a Medium.

    - gradients: of the optical depth of the stretch, in world axes [1/m].
    - hessians: (n, 6), xx, yy, zz, xy, xz, yz [1/m^2].
    """
    elementwise(
        lib.covbeam_light_fields_attenuate,
        COUNT,
        changed("fields", fields, _FIELD),
        given("gradients", gradients, VECTOR),
        given("hessians", hessians, HESSIAN),
    )


def narrow(fields, acrosses, angular_variances):
    """Narrowing of the directions across one axis, such as by the soft rim of a spot light, in place.

    - acrosses: in which the light falls off, any length; along the ray: nothing changes.
    - angular_variances: [cycles^2/rad^2] >= 0; 0 changes nothing, inf leaves one direction.
    """
    elementwise(
        lib.covbeam_light_fields_narrow,
        COUNT,
        changed("fields", fields, _FIELD),
        given("acrosses", acrosses, VECTOR),
        given("angular_variances", angular_variances, FLOAT),
    )


def scatter(fields, directions, angular_variances):
    """Scattering in a medium, or by a rough surface's lobe, into a new direction, in place.

    - directions: of propagation after the event, any length but 0.
    - angular_variances: of the lobe [cycles^2/rad^2] >= 0, see Phase.angular_variance; 0 is isotropic, inf does not blur.
    """
    elementwise(
        lib.covbeam_light_fields_scatter,
        COUNT,
        changed("fields", fields, _FIELD),
        given("directions", directions, VECTOR),
        given("angular_variances", angular_variances, FLOAT),
    )


def diffuse(fields, normals, directions):
    """Diffuse reflection or transmission into a new direction, in place.

    - normals: of the surface, any length, either sign.
    - directions: of propagation after the event, any length but 0.
    """
    elementwise(
        lib.covbeam_light_fields_diffuse,
        COUNT,
        changed("fields", fields, _FIELD),
        given("normals", normals, VECTOR),
        given("directions", directions, VECTOR),
    )


def slice(fields, *, out=None):
    """The spectrum of the fluence across the ray, along the frame's axes: (n, 3), xx, xy, yy [cycles^2/m^2]."""
    return elementwise(
        lib.covbeam_light_fields_slice,
        COUNT,
        given("fields", fields, _FIELD),
        made("out", out, VECTOR),
    )


def fluence(fields, limits, *, out=None):
    """The spectrum of the fluence around the ray, in world axes: SPECTRUM.

    - limits: largest deviation kept [cycles/m] > 0, such as the Nyquist frequency 1/(2h) of voxels of side h; inf keeps all.
    """
    return elementwise(
        lib.covbeam_light_fields_fluence,
        COUNT,
        given("fields", fields, _FIELD),
        given("limits", limits, FLOAT),
        made("out", out, Kind(SPECTRUM)),
    )


def variance_along_ray(fields, extinctions, *, out=None):
    """Variance of the fluence's spectrum along the ray [cycles^2/m^2], for light that has not been scattered.

    - extinctions: around the ray [1/m] >= 0.
    """
    return elementwise(
        lib.covbeam_light_fields_variance_along_ray,
        COUNT,
        given("fields", fields, _FIELD),
        given("extinctions", extinctions, FLOAT),
        made("out", out, FLOAT),
    )
