"""A host in numpy: a lamp in fog, and the shadow of a black ball. Light that the fog scatters once.

    python shadow.py shadow.pfm [--size 128] [--passes 16] [--photons 20000] [--seed 0]

It hands covbeam the photons and the eye rays, and writes what covbeam gathers. Copy it and change it: what is to be changed for other scenes is `Ball`.
"""

import argparse

import numpy as np

import covbeam as cb
from covbeam import light_field

#: A lamp that shines all around [W/sr], and fog: coefficients [1/m].
LAMP, INTENSITY = np.array([0, 2.5, 0], np.float32), 25.0
FOG = cb.Medium(scattering=0.2, absorption=0.05, phase=cb.Phase.henyey_greenstein(0.4))

#: The camera: where it is, the axes of its picture, and half its height at a distance of 1.
EYE = np.array([0, 0.5, -5], np.float32)
FORWARD = -EYE / np.linalg.norm(EYE)
RIGHT = np.cross(FORWARD, np.array([0, 1, 0], np.float32)) / np.linalg.norm(np.cross(FORWARD, [0, 1, 0]))
UP, HALF = np.cross(RIGHT, FORWARD), np.tan(np.radians(17.5))

#: Where spectra are kept: voxels around what the camera sees.
LAYOUT = cb.GridLayout((-3, -3, -5), (3, 3, 5), (24, 24, 40))

#: Beams end here [m]: e^-6 of the light is left.
FAR = np.float32(24)


class Ball:
    """A black ball around the origin. Rays are float32 arrays of origins and unit directions, (n, 3)."""

    radius = 0.5

    def distance(self, origins, directions):
        """How far the ball is along rays, inf where they miss it: (n,)."""
        along = -np.einsum("ij,ij->i", origins, directions)
        aside = origins + along[:, None] * directions
        inside = self.radius**2 - np.einsum("ij,ij->i", aside, aside)
        hits = (inside > 0) & (along > 0)
        return np.where(hits, along - np.sqrt(np.maximum(inside, 0)), np.inf).astype(np.float32)

    def normals(self, points):
        """Unit normals of the ball at points of it, (n, 3)."""
        return (points / np.linalg.norm(points, axis=1, keepdims=True)).astype(np.float32)

    def edges(self, origins, directions):
        """The ball's silhouette as seen from the origins, where it is nearest to each ray: covbeam.EDGE (n,).

        It lies on a circle, where tangents from the origin touch. `covbeam.segment.find_edges` finds it for any shape, by probe rays.
        """
        away = np.linalg.norm(origins, axis=1, keepdims=True)
        axis = -origins / away
        cosine = np.einsum("ij,ij->i", axis, directions)[:, None]
        # In the plane of the ray and the ball's middle: the ray's angle from the middle, and that of the silhouette.
        angle, border = np.arccos(np.clip(cosine, -1, 1)), np.arcsin(self.radius / away)
        tangent = np.sqrt(away**2 - self.radius**2)
        inwards = axis - cosine * directions
        inwards /= np.maximum(np.linalg.norm(inwards, axis=1, keepdims=True), 1e-12)
        edges = np.zeros(len(origins), cb.EDGE)
        edges["depth"] = np.maximum(tangent * np.cos(angle - border), 1e-6)[:, 0]
        edges["distance"] = np.abs(tangent * np.sin(angle - border))[:, 0]
        edges["towards"] = np.sign(angle - border) * inwards
        return edges


BALL = Ball()


#: Sequences of random numbers.
PHOTONS, PIXELS, FIELDS = 0, 1, 2


def emit(sequence, count, number, seed):
    """Origins and directions of the photons of a pass, evenly all around: the next `count` of a sequence that fills the sphere evenly."""
    index = np.arange((number - 1) * count, number * count, dtype=np.uint32)
    u, v = (cb.path_numbers(seed, sequence, index, dimension) for dimension in (0, 1))
    cosine, turn = 1 - 2 * u, np.float32(2 * np.pi) * v
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    directions = np.stack([sine * np.cos(turn), cosine, sine * np.sin(turn)], axis=1)
    return np.tile(LAMP, (count, 1)), directions.astype(np.float32)


def deposit(grid, origins, directions, power):
    """Leaves the light fields of photons in the grid: how fine the light is along their way, which the ball's silhouette cuts."""
    segments = np.zeros(len(origins), cb.SEGMENT)
    segments["origin"], segments["power"], segments["unscattered"] = origins, power, 1
    segments["field"] = light_field.point(directions)
    segments["length"] = np.minimum(BALL.distance(origins, directions), FAR)
    segments["edges"][:, 0], segments["edge_count"] = BALL.edges(origins, directions), 1
    # One behind the lamp is none.
    segments["edge_count"][np.einsum("ij,ij->i", directions, -origins) < 0] = 0
    grid.deposit(FOG, segments)


def beams(origins, directions, power):
    """The photons as beams, up to the ball."""
    reach = BALL.distance(origins, directions)
    found = np.zeros(len(origins), cb.BEAM)
    found["origin"], found["direction"], found["power"] = origins, directions, power
    found["length"] = np.minimum(reach, FAR)
    hits = np.isfinite(reach)
    found["end_normal"][hits] = BALL.normals(origins[hits] + reach[hits, None] * directions[hits])
    return found


def eye_rays(size, place):
    """One through a place in each pixel: EYE_RAY (size x size,)."""
    row, column = np.mgrid[0:size, 0:size].reshape(2, -1)
    across, up = (2 * (column + place[0]) / size - 1) * HALF, (1 - 2 * (row + place[1]) / size) * HALF
    directions = FORWARD + across[:, None] * RIGHT + up[:, None] * UP
    rays = np.zeros(size * size, cb.EYE_RAY)
    rays["direction"] = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    rays["origin"] = EYE
    rays["length"] = BALL.distance(rays["origin"], rays["direction"])
    return rays


def render(size, passes, photons, seed=0):
    """The picture's radiance [W/(m^2 sr)], (size, size), and the mean kernel radius of each pixel [m]."""
    schedule = cb.Schedule(cb.KernelShape.EPANECHNIKOV, radius=0.05, alpha=0.8, max_radius=0.3, error=0.003)
    grid, beam_map = cb.Grid(LAYOUT), cb.BeamMap(FOG)
    picture, weights, radii = np.zeros((3, size * size))
    power = 4 * np.pi * INTENSITY / photons
    # A tenth of the photons is enough for spectra. They have a sequence of their own: of one that fills the sphere evenly every tenth
    # point does not.
    fields = (photons + 9) // 10
    for number in range(1, passes + 1):
        carriers, others = emit(FIELDS, fields, number, seed), emit(PHOTONS, photons - fields, number, seed)
        origins, directions = (np.concatenate(both) for both in zip(carriers, others))
        deposit(grid, *carriers, power)
        grid.resolve()
        kernel = schedule.kernel(number)
        beam_map.clear()
        beam_map.add(beams(origins, directions, power))
        beam_map.commit(kernel.max_radius)
        place = [cb.path_numbers(seed, PIXELS, np.array([number], np.uint32), axis)[0] for axis in (0, 1)]
        gathered = beam_map.gather(kernel, grid, eye_rays(size, place))
        picture += gathered["radiance"][:, 0]
        weights += gathered["weight"]
        radii += gathered["radius"]
    return (picture / passes).reshape(size, size), (radii / np.maximum(weights, 1e-30)).reshape(size, size)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="where the picture goes: a portable float map, linear")
    for name, value in (("size", 128), ("passes", 16), ("photons", 20_000), ("seed", 0)):
        parser.add_argument(f"--{name}", type=int, default=value)
    options = parser.parse_args()
    picture, radii = render(options.size, options.passes, options.photons, options.seed)
    with open(options.file, "wb") as file:
        # Rows from the bottom; the minus says that the numbers are little-endian.
        file.write(f"Pf\n{options.size} {options.size}\n-1\n".encode() + picture[::-1].astype("<f4").tobytes())
    print(f"{options.file}: {options.passes} passes, beams {radii.min():.3f} to {radii.max():.3f} m wide")


if __name__ == "__main__":
    main()
