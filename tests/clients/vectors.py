"""Runs tests/vectors.txt through the Python module: `vectors.py FILE`. The same bits as from Rust, C and C++.

Every line is called alone. Lines whose function takes arrays are called once more all together, as strided views of one
matrix. The format is described in tests/src/vectors/mod.rs.
"""

import re
import sys
from pathlib import Path

import numpy as np

import covbeam as cb
from covbeam import image, kernel, light_field, march, spectrum

LEAST_CALLS, LEAST_NAMES = 500, 40


class Difference(Exception):
    """A call answered something else than the file."""


def changing(function):
    """An operator in place: what it returns (if anything), then the object."""

    def call(fields, *arguments):
        returned = function(fields, *arguments)
        return (fields,) if returned is None else (returned, fields)

    return call


def medium_of(words, script):
    numbers = words.view(np.float32)
    density = None
    if words[8] == 1:
        density = cb.Exponential(tuple(numbers[9:12]), tuple(numbers[12:15]), numbers[15])
    elif words[8] == 2:
        density = script.density
    return cb.Medium(numbers[0:3], numbers[3:6], phase_of(words[6:8]), density)


def phase_of(words, _script=None):
    return cb.Phase(int(words[0]), words.view(np.float32)[1])


def kernel_of(words):
    numbers = words.view(np.float32)
    return cb.Kernel(int(words[0]), numbers[1], numbers[2], numbers[3])


def layout_of(words):
    numbers = words.view(np.float32)
    return cb.GridLayout(tuple(numbers[0:3]), tuple(numbers[3:6]), tuple(int(n) for n in words[6:9]))


FIELD, NUMBER = cb.LIGHT_FIELD, 1


def field_calls():
    """What is called of light_field, from the kinds of the parameters."""
    dtypes = {"field": FIELD, "curvature": cb.CURVATURE}
    calls = Path(__file__).with_name("hostile").joinpath("calls.h").read_text()
    for operator, described in re.findall(r'\(covbeam_light_fields_(\w+), "count n; (.*?)"', calls):
        kinds = [parameter.split(" ")[1] for parameter in described.split("; ") if not parameter.endswith("_stride s")]
        if "<medium" in kinds:
            continue
        function = getattr(light_field, operator)
        # "<f:ddd" are three numbers.
        parts = [dtypes.get(kind[1:].rstrip("?")) or len(kind) - 3 for kind in kinds if kind[0] != ">"]
        yield "light_field_" + operator, (changing(function) if "=field" in kinds else function, parts)


# name: (function, what its arguments are: a dtype, or how many floats)
PLAIN = dict(field_calls()) | {
    "image_spectrum_filter": (image.filters, [cb.IMAGE_SPECTRUM, NUMBER, NUMBER]),
    "image_filter_density": (image.densities, [cb.IMAGE_FILTER]),
    "spectrum_variance_along": (spectrum.variance_along, [cb.SPECTRUM, 3]),
    "spectrum_add_along": (changing(spectrum.add_along), [cb.SPECTRUM, 3, NUMBER]),
}

# name: (words of the object, how it is made, method, arguments)
METHODS = {
    "phase_evaluate": (2, phase_of, cb.Phase.evaluate, [NUMBER]),
    "phase_sample": (2, phase_of, cb.Phase.sample, [3, 2]),
    "phase_sample_cosine": (2, phase_of, cb.Phase.sample_cosine, [NUMBER]),
    "medium_density_at": (16, medium_of, cb.Medium.density_at, [3]),
    "medium_derivatives_at": (16, medium_of, cb.Medium.derivatives_at, [3]),
    "medium_column_at": (16, medium_of, cb.Medium.column_at, [3, 3, NUMBER]),
    "medium_distance_at": (16, medium_of, cb.Medium.distance_at, [3, 3, NUMBER, NUMBER]),
    "medium_transmittance": (16, medium_of, cb.Medium.transmittance, [3, 3, NUMBER]),
    "medium_column_transmittance": (16, medium_of, cb.Medium.column_transmittance, [NUMBER]),
    "medium_reach": (16, medium_of, cb.Medium.reach, [3, 3]),
}


def columns_of(matrix, parts):
    """The arguments as views of the words: row i holds those of call i."""
    views, at = [], 0
    for part in parts:
        width = part if isinstance(part, int) else part.itemsize // 4
        words = matrix[:, at : at + width]
        at += width
        views.append(words.view(np.float32 if isinstance(part, int) else part))
        if part == NUMBER or not isinstance(part, int):
            views[-1] = views[-1][:, 0]
    if at != matrix.shape[1]:
        raise Difference(f"{matrix.shape[1]} input words instead of {at}")
    return views


def words_of(result, rows):
    """The words of what came back: one row a call."""
    result = np.asarray(result)
    if result.dtype == np.bool_:
        result = result.astype(np.uint32)
    return np.ascontiguousarray(result).reshape(rows, -1).view(np.uint32).reshape(rows, -1)


def flat(results, rows=1):
    return np.hstack([words_of(result, rows) for result in (results if isinstance(results, tuple) else (results,))])


def segment_of(words):
    """A segment from the front of the words, and the words after it."""
    segment = np.zeros((), cb.SEGMENT)
    numbers = segment.reshape(1).view(np.uint32)
    # All fields but the two about knots.
    numbers[:22] = words[:22]
    count = segment["edge_count"] = words[22]
    numbers[22 : 22 + 5 * count] = words[23 : 23 + 5 * count]
    return segment, words[23 + 5 * count :]


class Script:
    """What the lines act on."""

    def __init__(self):
        self.density = self.grid = self.map = self.film = self.importance = None
        self.march = cb.March()
        # (function, key of what the calls share) -> rows of input and of output words
        self.together = {}

    def later(self, name, shared, function, parts, words, expected):
        group = self.together.setdefault((name, shared), (function, parts, [], []))
        group[2].append(words)
        group[3].append(expected)

    def run_together(self):
        """Once the state changes, and at the end."""
        for (name, _), (function, parts, rows, expected) in self.together.items():
            matrix = np.array(rows)
            compare(flat(function(*columns_of(matrix, parts)), len(rows)), np.array(expected), f"{len(rows)} calls of {name} at once")
        self.together.clear()

    def alone(self, name, shared, function, parts, words, expected):
        views = columns_of(words.copy()[np.newaxis], parts)
        results = function(*[view[0, ...] for view in views])
        self.later(name, shared, function, parts, words, expected)
        return flat(results)

    def call(self, name, words, expected):
        numbers = words.view(np.float32)
        if name in PLAIN:
            function, parts = PLAIN[name]
            return self.alone(name, None, function, parts, words, expected)
        if name in METHODS:
            width, make, method, parts = METHODS[name]
            owner = make(words[:width], self)
            call = lambda *arguments: method(owner, *arguments)
            return self.alone(name, words[:width].tobytes(), call, parts, words[width:], expected)
        if name == "light_field_carry":
            medium = medium_of(words[16:32], self)
            call = changing(lambda fields, origins, distances: light_field.carry(fields, medium, origins, distances))
            rest = np.concatenate([words[:16], words[32:]])
            return self.alone(name, words[16:32].tobytes(), call, [FIELD, 3, NUMBER], rest, expected)
        if name == "kernel_radius_at":
            grid, narrowed = self.grid if words[0] else None, kernel_of(words[1:5])
            call = lambda positions, axes: narrowed.radius_at(grid, positions, axes)
            return self.alone(name, words[:5].tobytes(), call, [3, 3], words[5:], expected)
        if name == "cross":
            ray = words[:7].copy().view(cb.EYE_RAY)
            call = lambda beams: cb.cross(ray, beams)[::-1]
            return self.alone(name, words[:7].tobytes(), call, [cb.BEAM], words[7:], expected)
        if name == "image_spectrum_along":
            medium = medium_of(words[:16], self)
            call = lambda rays, steps: image.along(self.grid, medium, rays, steps_of(steps))
            return self.alone(name, words[:16].tobytes(), call, [cb.EYE_RAY, 12], words[16:], expected)
        method = getattr(self, name, None)
        if method is None:
            raise Difference(f"{name} is no function that this client knows")
        return np.atleast_1d(np.asarray(method(words, numbers))).reshape(1, -1)

    def phase_angular_variance(self, words, _):
        return flat(np.float32(phase_of(words).angular_variance()))

    def progressive_radius(self, words, numbers):
        return flat(np.float32(kernel.progressive_radius(numbers[0], numbers[1], int(words[2]))))

    def error_bound(self, words, numbers):
        return flat(np.float32(kernel.error_bound(numbers[0], int(words[1]))))

    def kernel_evaluate(self, words, numbers):
        return flat(np.float32(kernel.evaluate(int(words[0]), numbers[1], numbers[2])))

    def kernel_second_moment(self, words, _):
        return flat(np.float32(kernel.second_moment(int(words[0]))))

    def kernel_radius_from_error(self, words, numbers):
        return flat(np.float32(kernel.radius_from_error(int(words[0]), numbers[1], numbers[2])))

    def schedule_kernel(self, words, numbers):
        k = cb.Schedule(int(words[0]), *numbers[1:5]).kernel(int(words[5]))
        return flat((np.uint32(k.shape), np.float32(k.min_radius), np.float32(k.max_radius), np.float32(k.error)))

    def medium_step(self, words, _):
        return flat(np.float32(medium_of(words, self).step()))

    def medium_opaque_column(self, words, _):
        return flat(np.float32(medium_of(words, self).opaque_column()))

    def medium_knots(self, words, numbers):
        return flat(medium_of(words[:16], self).knots(numbers[16:19], numbers[19:22], *numbers[22:25]))

    def medium_tabulate(self, words, numbers):
        return flat(medium_of(words[:16], self).tabulate(numbers[16:19], numbers[19:22], numbers[22]))

    def density_new(self, words, numbers):
        self.run_together()
        self.density = cb.Density(layout_of(words[:9]), numbers[9:])
        return NOTHING

    def grid_new(self, words, _):
        self.run_together()
        self.grid = cb.Grid(layout_of(words))
        return NOTHING

    def grid_deposit(self, words, _):
        self.run_together()
        segments, rest = [], words[16:]
        while len(rest):
            segment, rest = segment_of(rest)
            segments.append(segment)
        self.grid.deposit(medium_of(words[:16], self), np.stack(segments))
        return NOTHING

    def segment_field_at(self, words, _):
        self.run_together()
        segment, rest = segment_of(words)
        medium, distance = medium_of(rest[:16], self), rest[16:].view(np.float32)
        return flat(cb.segment.field_at(segment, medium, distance))

    def path_number(self, words, _):
        return flat(cb.path_numbers(int(words[0]), int(words[1]), words[2:3], int(words[3])))

    def grid_deposit_spectra(self, words, numbers):
        self.run_together()
        self.grid.deposit_spectra(numbers[0:3], words[3:9].view(cb.SPECTRUM), numbers[9:10])
        return NOTHING

    def grid_resolve(self, _words, _numbers):
        self.run_together()
        self.grid.resolve()
        return NOTHING

    def grid_look_up(self, _, numbers):
        positions = numbers.reshape(-1, 3)
        spectra, found = self.grid.look_up(positions)
        return flat((found, spectra), len(positions))

    def grid_save(self, _words, _numbers):
        data = self.grid.save()
        # What is loaded saves the same.
        with cb.Grid.load(data) as grid:
            if grid.save() != data:
                raise Difference("grid_load and grid_save give other bytes")
        return np.array([len(data), fnv(data)], np.uint64)

    def beam_map_new(self, words, _):
        self.run_together()
        self.map = cb.BeamMap(medium_of(words, self))
        return NOTHING

    def beam_map_clear(self, _words, _numbers):
        self.map.clear()
        return NOTHING

    def beam_map_add(self, words, _):
        self.map.add(words.view(cb.BEAM))
        return NOTHING

    def beam_map_commit(self, _, numbers):
        self.map.commit(numbers[0])
        return NOTHING

    def beam_map_gather(self, words, _):
        return flat(self.map.gather(kernel_of(words[1:5]), self.grid if words[0] else None, words[5:].view(cb.EYE_RAY)))

    def pixel_threshold(self, words, _):
        return flat(image.thresholds(words[0], words[1], words[2:4]))

    def film_regions(self, words, numbers):
        return flat(image.regions(words[0], words[1], numbers[2:]))

    def film_new(self, words, numbers):
        self.film = cb.Film(words[0], words[1], numbers[2], words[3:])
        return NOTHING

    def film_nodes(self, _words, _numbers):
        return flat(self.film.nodes().reshape(1, -1))

    def film_plan(self, words, numbers):
        self.film.plan(words[0], numbers[1], words[2], words[3:].copy().view(cb.IMAGE_SPECTRUM))
        return NOTHING

    def film_density(self, _words, _numbers):
        return flat(self.film.densities())

    def film_add(self, words, _):
        self.film.add(words.copy().view(cb.FILM_RAY))
        return NOTHING

    def film_picture(self, _words, _numbers):
        self.film.verify()
        return flat(self.film.picture())

    def film_errors(self, words, numbers):
        pixels = np.zeros(len(words) // 2 - 1, cb.FILM_PIXEL)
        pixels["variance"], pixels["difference"] = numbers[2:].reshape(-1, 2).T
        return flat(image.errors(words[0], words[1], pixels))

    def march_lay(self, words, numbers):
        knots = march.lay(numbers[0:3], numbers[3:6], numbers[6], numbers[7], numbers[8:11], int(words[11]))
        return flat(np.ascontiguousarray(knots["distance"]))

    def march_update(self, words, _):
        self.march.update(words.view(cb.MARCH_KNOT))
        return NOTHING

    def march_get_expected(self, _words, _numbers):
        return flat(tuple(np.float32(number) for number in self.march.expected()))

    def march_get_first_round(self, words, _):
        return flat(np.uint32(self.march.first_round(int(words[0]))))

    def march_place(self, _, numbers):
        return flat(self.march.place(numbers))

    def march_refine(self, words, numbers):
        count = 1 + 6 * int(words[0])
        # An f64 is among them, so that the words must lie on its boundary.
        firsts = words[1:count].copy().view(cb.MARCH_SAMPLE)
        return flat(self.march.refine(firsts, numbers[count:]))

    def importance_new(self, words, _):
        self.importance = cb.Importance(layout_of(words))
        return NOTHING

    def importance_add_eye_rays(self, words, numbers):
        return self.add_pieces(cb.Importance.add_eye_rays, words)

    def importance_add_paths(self, words, numbers):
        return self.add_pieces(cb.Importance.add_paths, words)

    def add_pieces(self, add, words):
        rows = words[16:].reshape(-1, 8)
        add(self.importance, medium_of(words[:16], self), *columns_of(rows, [cb.EYE_RAY, NUMBER]))
        return NOTHING

    def importance_add_surfaces(self, words, _):
        self.importance.add_surfaces(*columns_of(words.reshape(-1, 4), [3, NUMBER]))
        return NOTHING

    def importance_resolve(self, _words, _numbers):
        self.importance.resolve()
        return NOTHING

    def importance_at(self, _, numbers):
        return flat(self.importance.at(numbers.reshape(-1, 3)))

    def importance_of_segments(self, words, _):
        return flat(self.importance.of_segments(medium_of(words[:16], self), words[16:].view(cb.EYE_RAY)))

    def weight_window(self, _, numbers):
        factors = numbers[:-1].copy()
        cb.weight_window(factors, numbers[-1])
        return flat(factors)

    def emission_guide_fill(self, words, numbers):
        side = int(words[0])
        return flat(cb.emission_guide_fill(numbers[1:-1].reshape(side, side), numbers[-1]))

    def emission_guide_warp(self, words, numbers):
        side = int(words[0])
        size = side * (side + 1)
        points = numbers[1 + size :].reshape(-1, 2)
        places, densities = cb.emission_guide_warp(numbers[1 : 1 + size].reshape(side + 1, side), points)
        return flat((places, densities), len(points))

    def gather_pair(self, words, numbers):
        gathered = np.zeros(1, cb.GATHERED)
        medium, narrowed = medium_of(words[1:17], self), kernel_of(words[17:21])
        ray, beam = words[23:30].view(cb.EYE_RAY), words[30:46].view(cb.BEAM)
        # The words stand by type, the parameters in the order of the header.
        grid = self.grid if words[0] else None
        accepted = cb.gather_pair(ray, beam, numbers[21], numbers[22], medium, narrowed, grid, gathered)
        return flat((accepted, gathered))

    def filter_beams(self, words, numbers):
        return flat(cb.filter_beams(words[:7].view(cb.EYE_RAY), words[7:-1].view(cb.BEAM), numbers[-1]))


NOTHING = np.zeros(0, np.uint32)


def steps_of(numbers):
    """Two PIXEL_STEP a row of 12 floats."""
    return numbers.view(cb.PIXEL_STEP)


def fnv(data):
    """FNV-1a of 64 bits."""
    value = 0xCBF29CE484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return value


def compare(found, expected, what):
    expected = expected.reshape(found.shape) if found.size == expected.size else expected
    if found.shape != expected.shape:
        raise Difference(f"{what}: {found.size} words instead of {expected.size}")
    rows = np.flatnonzero((found != expected).any(axis=-1))
    if len(rows):
        row = rows[0]
        hexadecimal = lambda words: " ".join(f"{int(word):0{2 * words.itemsize}x}" for word in words)
        raise Difference(f"{what}, row {row}:\n  expected {hexadecimal(expected[row])}\n  found    {hexadecimal(found[row])}")


def numbers_of(words):
    digits = {len(word) for word in words}
    if digits - {8, 16} or len(digits) > 1:
        raise Difference(f"words of {sorted(digits)} digits")
    return np.array([int(word, 16) for word in words], np.uint64 if digits == {16} else np.uint32)


def main(path):
    script, calls, names, number = Script(), 0, set(), 0
    try:
        with open(path, encoding="ascii") as lines:
            for number, line in enumerate(lines, 1):
                words = line.partition("#")[0].split()
                if not words:
                    continue
                arrow = words.index("->")
                name, expected = words[0], numbers_of(words[arrow + 1 :])
                compare(script.call(name, numbers_of(words[1:arrow]), expected).reshape(1, -1), expected, name)
                calls += 1
                names.add(name)
        script.run_together()
    except (Difference, cb.Error, TypeError, ValueError) as error:
        print(f"{path}:{number}: {type(error).__name__}: {error}")
        return 1
    if calls < LEAST_CALLS or len(names) < LEAST_NAMES:
        print(f"{path}: only {calls} calls of {len(names)} names; {LEAST_CALLS} of {LEAST_NAMES} are wanted at least")
        return 1
    print(f"{calls} calls, {len(names)} names, all equal")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
