"""covbeam_rays as the extension uses it: gathers on many threads are covbeam's own, long calls stop when they are told
to, and what is wrong is refused. Needs the covbeam and covbeam_rays wheels and numpy; no Blender."""

import gc
import time
import unittest

import covbeam as cb
import covbeam_rays as rays
import numpy as np
from covbeam import light_field

FOG = cb.Medium(scattering=0.2)
LAYOUT = cb.GridLayout((-2, -2, -2), (2, 2, 2), (8, 8, 8))
KERNEL = cb.Kernel(cb.KernelShape.EPANECHNIKOV, min_radius=0.02, max_radius=0.1, error=0.01)

#: After this long a user wonders whether the program has heard [s].
PATIENCE = 0.2


def directions(count, seed=1):
    d = np.random.default_rng(seed).normal(size=(count, 3)).astype(np.float32)
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def lamp_map(count=2000):
    beams = np.zeros(count, cb.BEAM)
    beams["direction"], beams["length"], beams["power"] = directions(count), 4, 1 / count
    beam_map = cb.BeamMap(FOG)
    beam_map.add(beams)
    beam_map.commit(KERNEL.max_radius)
    return beam_map


def lamp_grid():
    segments = np.zeros(500, cb.SEGMENT)
    segments["field"] = light_field.point(directions(500, 2))
    segments["length"], segments["power"], segments["unscattered"] = 4, 1 / 500, 1
    grid = cb.Grid(LAYOUT)
    grid.deposit(FOG, segments)
    grid.resolve()
    return grid


def eye_rays(count):
    eyes = np.zeros(count, cb.EYE_RAY)
    eyes["origin"] = directions(count, 3) * np.float32(1.5)
    eyes["direction"] = directions(count, 4)
    eyes["length"] = 4
    return eyes


def tasks(count, seed=5):
    """Starts of tasks of 0 to 60 rays."""
    sizes = np.random.default_rng(seed).integers(0, 60, size=count // 20)
    return np.unique(np.concatenate([[0], np.minimum(np.cumsum(sizes), count), [count]])).astype(np.intp)


def grid_mesh(side):
    """A wavy sheet of 2 side^2 triangles: positions, triangles."""
    x, y = np.meshgrid(np.linspace(-1, 1, side + 1), np.linspace(-1, 1, side + 1))
    positions = np.stack([x, y, 0.2 * np.sin(5 * x) * np.cos(4 * y)], -1).reshape(-1, 3).astype(np.float32)
    a = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1)
    b, c, d = a + 1, a + side + 2, a + side + 1
    return positions, np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).astype(np.int32)


def square(z=0.0, material=0):
    """A geometry with the square [-1, 1]^2 at z, seen from +z, built."""
    geometry = rays.Geometry()
    positions = np.array([[-1, -1, z], [1, -1, z], [1, 1, z], [-1, 1, z]], np.float32)
    mesh = geometry.add_mesh(positions, np.array([[0, 1, 2], [0, 2, 3]], np.int32), material)
    geometry.add_instance(mesh, np.eye(4), 7)
    geometry.build()
    return geometry


class Stop:
    """A poll that says no after a while, and knows when it did and how it was asked."""

    def __init__(self, after=0.05):
        self.begun, self.after, self.said_no, self.asked = time.perf_counter(), after, None, []

    def __call__(self):
        now = time.perf_counter()
        self.asked.append(now)
        if now - self.begun < self.after:
            return True
        self.said_no = now
        return False


class Threads(unittest.TestCase):
    def setUp(self):
        self.addCleanup(rays.threads, rays.threads())

    def test_a_gather_has_the_bits_of_covbeams_own_for_any_number_of_threads(self):
        beam_map, eyes = lamp_map(), eye_rays(5000)
        for grid in (lamp_grid(), None):
            expected = beam_map.gather(KERNEL, grid, eyes)
            self.assertGreater(expected["pairs"].sum(), 5000)
            gather = rays.Gather()
            for count in (1, 2, 3):
                self.assertEqual(rays.threads(count), count)
                for starts in (np.array([0, 5000]), tasks(5000), np.arange(5001)):
                    found = gather.gather(beam_map, KERNEL, grid, eyes, starts)
                    self.assertEqual(found.tobytes(), expected.tobytes(), f"{count} threads, {len(starts) - 1} tasks")

    def test_a_picture_has_the_bits_of_covbeams_own_for_any_number_of_threads(self):
        random = np.random.default_rng(6)
        with cb.Film(200, 100, 1.0) as film:
            spectra = np.zeros(len(film.nodes()), cb.IMAGE_SPECTRUM)
            spectra["xx"], spectra["yy"] = random.uniform(0, 1e-3, size=(2, len(spectra)))
            spectra["weight"] = 1
            film.plan(1, 0.1, 1000, spectra)
            film_rays = np.zeros(8000, cb.FILM_RAY)
            film_rays["pixel"] = random.integers(0, (200, 100), size=(8000, 2))
            film_rays["has_volume"] = 1
            film_rays["volume"] = random.uniform(size=(8000, 3))
            film.add(film_rays)
            gather = rays.Gather()
            with self.assertRaisesRegex(cb.Error, "film: not verified"):
                gather.picture(film)
            film.verify()
            expected = film.picture()
            self.assertGreater(expected["radiance"].max(), 0.1)
            for count in (1, 2, 3):
                rays.threads(count)
                self.assertEqual(gather.picture(film).tobytes(), expected.tobytes(), f"{count} threads")

    def test_the_number_of_threads_is_what_was_set_and_0_is_one_a_core(self):
        self.assertEqual(rays.threads(3), 3)
        self.assertEqual(rays.threads(), 3)
        self.assertGreaterEqual(rays.threads(0), 1)
        for wrong in (-1, 100_000):
            with self.assertRaisesRegex(ValueError, "count"):
                rays.threads(wrong)


class Cancel(unittest.TestCase):
    def test_a_gather_stops_soon_after_it_is_told_to_and_can_be_used_again(self):
        # One task, and thousands: one alone must stop, too. Every ray meets most beams: seconds of work.
        wide = cb.Kernel(cb.KernelShape.BOX, min_radius=1.0, max_radius=1.0, error=0.01)
        beams = np.zeros(200_000, cb.BEAM)
        beams["direction"], beams["length"], beams["power"] = directions(len(beams)), 4, 1
        beam_map = cb.BeamMap(FOG)
        beam_map.add(beams)
        beam_map.commit(wide.max_radius)
        eyes, gather = eye_rays(20_000), rays.Gather()
        for starts in (np.array([0, len(eyes)]), np.arange(0, len(eyes) + 1, 16)):
            poll = Stop()
            with self.assertRaises(rays.Cancelled):
                gather.gather(beam_map, wide, None, eyes, starts, poll=poll)
            self.assertLess(time.perf_counter() - poll.said_no, PATIENCE)
            gaps = np.diff([poll.begun, *poll.asked])
            # Asked every 50 ms, on a machine that does other things as well.
            self.assertLess(gaps.max(), PATIENCE)
            # Beam map and gatherer are free again.
            self.assertEqual(len(gather.gather(beam_map, wide, None, eyes[:1], [0, 1])), 1)

    def test_a_build_stops_soon_after_it_is_told_to(self):
        positions, triangles = grid_mesh(700)
        geometry = rays.Geometry()
        for number in range(3):
            geometry.add_instance(geometry.add_mesh(positions, triangles, 0), np.eye(4), number)
        poll = Stop(after=0)
        with self.assertRaises(rays.Cancelled):
            geometry.build(poll)
        self.assertLess(time.perf_counter() - poll.said_no, PATIENCE)
        # What threads still finish is in nobody's way.
        begun = time.perf_counter()
        square()
        self.assertLess(time.perf_counter() - begun, PATIENCE)
        with self.assertRaisesRegex(ValueError, "used after close"):
            geometry.cast(np.zeros((1, 3)), directions(1))

    def test_what_a_poll_raises_ends_the_call_and_is_raised_by_it(self):
        class Oops(Exception):
            pass

        def poll():
            raise Oops

        positions, triangles = grid_mesh(700)
        geometry = rays.Geometry()
        geometry.add_mesh(positions, triangles, 0)
        with self.assertRaises(Oops):
            geometry.build(poll)

    def test_short_calls_end_without_waiting_for_a_poll(self):
        beam_map, eyes, gather = lamp_map(100), eye_rays(10), rays.Gather()
        begun = time.perf_counter()
        for _ in range(20):
            gather.gather(beam_map, KERNEL, None, eyes, [0, 10])
        # 20 intervals between polls would take 0.8 s.
        self.assertLess(time.perf_counter() - begun, 0.4)

    def test_objects_can_be_dropped_at_any_moment(self):
        # Built in longer than it takes until the first question.
        positions, triangles = grid_mesh(700)
        for number in range(3):
            geometry = rays.Geometry()
            geometry.add_instance(geometry.add_mesh(positions, triangles, 0), np.eye(4), 0)
            if number == 1:
                # Closed inside its own build, which still ends as it should.
                self.assertRaises((rays.Cancelled, ValueError), geometry.build, lambda: geometry.close())
            if number == 2:
                geometry.build()
            geometry.close()
            geometry.close()
        del geometry
        gather = rays.Gather()
        gather.close()
        gather.close()
        with self.assertRaisesRegex(ValueError, "used after close"):
            gather.gather(lamp_map(10), KERNEL, None, eye_rays(1), [0, 1])
        gc.collect()


class Errors(unittest.TestCase):
    def test_a_failure_of_covbeam_is_raised_as_covbeam_raises_it(self):
        beam_map, gather = lamp_map(), rays.Gather()
        eyes = eye_rays(1000)
        eyes["length"][700] = np.nan
        with self.assertRaises(cb.Error) as own:
            beam_map.gather(KERNEL, None, eyes[700:701])
        with self.assertRaises(cb.Error) as threaded:
            gather.gather(beam_map, KERNEL, None, eyes, np.arange(1001))
        self.assertEqual(threaded.exception.status, own.exception.status)
        self.assertEqual(threaded.exception.message, own.exception.message)
        # Of several, the first.
        eyes["direction"][300] = 0
        with self.assertRaisesRegex(cb.Error, "length 1"):
            gather.gather(beam_map, KERNEL, None, eyes, np.arange(1001))

    def test_a_gather_refuses_what_covbeam_would_and_tasks_that_are_none(self):
        beam_map, gather, eyes = lamp_map(), rays.Gather(), eye_rays(10)
        with self.assertRaisesRegex(TypeError, "kernel"):
            gather.gather(beam_map, None, None, eyes, [0, 10])
        with self.assertRaises(TypeError):
            gather.gather("map", KERNEL, None, eyes, [0, 10])
        with self.assertRaisesRegex(TypeError, "rays.*origin"):
            gather.gather(beam_map, KERNEL, None, np.zeros(10, np.float32), [0, 10])
        for starts, what in (
            ([], "starts: empty"),
            ([0, 5, 3, 10], r"starts\[2\]"),
            ([1, 10], "starts: from 1"),
            ([0, 9], "to 9"),
            ([0, 11], "to 11"),
        ):
            with self.assertRaisesRegex(ValueError, what):
                gather.gather(beam_map, KERNEL, None, eyes, np.array(starts, np.intp))
        with self.assertRaisesRegex(TypeError, "out"):
            gather.gather(beam_map, KERNEL, None, eyes, [0, 10], out=np.zeros(10))
        with self.assertRaisesRegex(ValueError, "out"):
            gather.gather(beam_map, KERNEL, None, eyes, [0, 10], out=np.zeros(20, cb.GATHERED)[::2])
        out = np.zeros(10, cb.GATHERED)
        self.assertIs(gather.gather(beam_map, KERNEL, None, eyes, [0, 10], out=out), out)

    def test_one_gatherer_does_one_thing_at_a_time(self):
        wide = cb.Kernel(cb.KernelShape.BOX, min_radius=1.0, max_radius=1.0, error=0.01)
        beams = np.zeros(100_000, cb.BEAM)
        beams["direction"], beams["length"], beams["power"] = directions(len(beams)), 4, 1
        beam_map = cb.BeamMap(FOG)
        beam_map.add(beams)
        beam_map.commit(1.0)
        lamp = cb.BeamMap(FOG)
        lamp.commit(1.0)
        gather, eyes, errors = rays.Gather(), eye_rays(20_000), []

        def poll():
            # Inside a call: neither gatherer nor beam map may be used for another.
            for call in (lambda: gather.gather(lamp, wide, None, eyes[:1], [0, 1]), beam_map.clear):
                try:
                    call()
                except cb.Error as error:
                    errors.append(error.status)
            # The work outside goes on.
            return len(errors) < 4

        with self.assertRaises(rays.Cancelled):
            gather.gather(beam_map, wide, None, eyes, [0, len(eyes)], poll=poll)
        self.assertEqual(errors, [cb.Status.BUSY] * 4)

    # What else is refused, rays/tests/hostile.rs says; here, that it is raised, and what only Python can get wrong.
    def test_meshes_and_instances_that_are_wrong_are_refused_with_the_remedy(self):
        geometry = rays.Geometry()
        positions, triangles = grid_mesh(2)
        wrong = positions.copy()
        wrong[3, 1] = np.nan
        normals = np.tile(np.float32([0, 0, 1]), (len(triangles), 3, 1))
        for arguments, kind, what in (
            ((wrong, triangles, 0), ValueError, r"positions\[3\].*finite"),
            ((positions[:, :2], triangles, 0), ValueError, r"positions: shape \(9, 2\); give \(n, 3\)"),
            ((positions, triangles.astype(np.float32), 0), TypeError, "triangles.*integers"),
            ((positions, triangles.astype(np.int64) + 2**40, 0), ValueError, "triangles.*int32"),
            ((positions, triangles, 0, normals[:3]), ValueError, "normals: shape"),
        ):
            with self.assertRaisesRegex(kind, what):
                geometry.add_mesh(*arguments)
        mesh = geometry.add_mesh(positions, triangles.astype(np.uint32), np.arange(8), normals)
        with self.assertRaisesRegex(ValueError, "matrix: shape"):
            geometry.add_instance(mesh, np.eye(3), 0)
        with self.assertRaisesRegex(cb.Error, "not built"):
            geometry.bounds

    def test_rays_that_are_wrong_are_refused(self):
        geometry = square()
        origins, towards = np.zeros((4, 3), np.float32), directions(4)
        for arguments, what in (
            ((origins, towards[:3]), "directions: shape"),
            ((origins, 2 * towards), r"directions\[0\].*length 1"),
            ((origins, towards, [1, 2]), "lengths: shape"),
        ):
            with self.assertRaisesRegex(ValueError, what):
                geometry.cast(*arguments)
        with self.assertRaisesRegex(TypeError, "hits.*distance"):
            geometry.edges(origins, towards, np.zeros(4, np.float32))
        with self.assertRaisesRegex(ValueError, "out"):
            geometry.cast(origins, towards, out=np.zeros(3, rays.HIT))


class Hits(unittest.TestCase):
    def test_a_hit_and_a_miss_have_the_fields_of_the_contract(self):
        geometry = square(z=1.0, material=3)
        hit, miss = geometry.cast([[0.5, 0.25, 3], [5, 5, 3]], [[0, 0, -1], [0, 0, -1]])
        self.assertEqual(hit["distance"], 2)
        np.testing.assert_array_equal(hit["position"], (0.5, 0.25, 1))
        np.testing.assert_array_equal(hit["geometric_normal"], (0, 0, 1))
        np.testing.assert_array_equal(hit["normal"], (0, 0, 1))
        self.assertEqual([hit["curvature"][name] for name in ("along", "across", "twist")], [0, 0, 0])
        self.assertEqual((hit["material"], hit["object"]), (3, 7))
        # Some roundings of coordinates of 1.
        self.assertTrue(1e-7 < hit["offset"] < 1e-5)
        expected = np.zeros((), rays.HIT)
        expected["distance"], expected["material"], expected["object"] = np.inf, -1, -1
        self.assertEqual(miss.tobytes(), expected.tobytes())
        self.assertEqual(geometry.triangle_count, 2)
        self.assertGreater(geometry.memory, 0)

    def test_lengths_are_one_a_ray_or_one_for_all(self):
        geometry = square()
        origins, down = np.tile(np.float32([0.1, 0.2, 1]), (3, 1)), np.tile(np.float32([0, 0, -1]), (3, 1))
        found = np.isfinite(geometry.cast(origins, down, np.float32([2, 0.5, np.inf]))["distance"])
        self.assertEqual(found.tolist(), [True, False, True])
        self.assertFalse(np.isfinite(geometry.cast(origins, down, 0.5)["distance"]).any())

    def test_inputs_of_other_layouts_are_copied_and_out_is_filled(self):
        geometry = square()
        origins = np.float64([[0.1, 9, 0.2, 9, 1, 9]])[:, ::2]
        out = np.zeros(1, rays.HIT)
        self.assertIs(geometry.cast(origins, [(0, 0, -1)], out=out), out)
        self.assertEqual(out["distance"][0], 1)

    def test_no_rays_and_no_triangles_give_no_hits(self):
        geometry = square()
        self.assertEqual(len(geometry.cast(np.zeros((0, 3)), np.zeros((0, 3)))), 0)
        counts, edges = geometry.edges(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, rays.HIT))
        self.assertEqual((counts.shape, edges.shape), ((0,), (0, 4)))
        empty = rays.Geometry()
        empty.add_instance(empty.add_mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32), 0), np.eye(4), 0)
        empty.build()
        self.assertEqual(empty.cast([[0, 0, 0]], [[0, 0, 1]])["object"].tolist(), [-1])
        np.testing.assert_array_equal(empty.bounds, np.zeros((2, 3)))

    def test_the_edge_of_a_square_is_found_where_it_is(self):
        geometry = square()
        origins, down = np.float32([[0.8, 0.0, 4.0]]), np.float32([[0, 0, -1]])
        counts, edges = geometry.edges(origins, down, geometry.cast(origins, down))
        self.assertEqual(counts.tolist(), [1])
        nearest = edges[0, 0]
        # The search resolves 5 % of the tangent.
        self.assertAlmostEqual(float(nearest["distance"]), 0.2, delta=0.01)
        self.assertAlmostEqual(float(nearest["depth"]), 4.0, delta=0.02)
        self.assertGreater(nearest["towards"][0], 0.99)


class Memory(unittest.TestCase):
    def test_building_and_gathering_again_and_again_does_not_grow_the_process(self):
        def resident():
            with open("/proc/self/statm") as file:
                return int(file.read().split()[1]) * 4096

        positions, triangles = grid_mesh(150)
        beam_map, eyes = lamp_map(), eye_rays(500)

        def once(stop):
            geometry = rays.Geometry()
            geometry.add_instance(geometry.add_mesh(positions, triangles, 0), np.eye(4), 0)
            try:
                geometry.build(lambda: not stop)
                geometry.cast(eyes["origin"], eyes["direction"])
            except rays.Cancelled:
                pass
            gather = rays.Gather()
            gather.gather(beam_map, KERNEL, None, eyes, tasks(500))

        for _ in range(5):
            once(False)
        before = resident()
        for number in range(40):
            once(number % 2 == 1)
        # One geometry holds 5 MB: 40 of them would be 200.
        self.assertLess(resident() - before, 20e6)


if __name__ == "__main__":
    unittest.main()
