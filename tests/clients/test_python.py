"""The Python module: what it computes, what it refuses, what it never copies, and that its structs are those of the header.

COVBEAM_INCLUDE names the folder of covbeam.h; CC the C compiler (cc).
"""

import copy
import ctypes
import functools
import gc
import importlib.util
import math
import os
import pickle
import platform
import re
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import tracemalloc
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import covbeam as cb
import covbeam.session as cs
from covbeam import _abi, _arrays, _library, _session_abi, image, light_field, march, spectrum

REPOSITORY = Path(__file__).resolve().parents[2]
FOG = cb.Medium(scattering=0.2)
LAYOUT = cb.GridLayout((-2, -2, -2), (2, 2, 2), (8, 8, 8))
KERNEL = cb.Kernel(cb.KernelShape.EPANECHNIKOV, min_radius=0.02, max_radius=0.1, error=0.01)


def directions(count, seed=1):
    d = np.random.default_rng(seed).normal(size=(count, 3)).astype(np.float32)
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def lamp_beams(count, power=1.0, seed=1):
    beams = np.zeros(count, cb.BEAM)
    beams["direction"], beams["length"], beams["power"] = directions(count, seed), 4, power / count
    return beams


def lamp_segments(count, power=1.0, seed=2):
    segments = np.zeros(count, cb.SEGMENT)
    segments["field"] = light_field.point(directions(count, seed))
    segments["length"], segments["power"], segments["unscattered"] = 4, power / count, 1
    return segments


def eye_rays(count, distance=1.0):
    """Rays that all pass the lamp at one distance, from all sides."""
    towards = directions(count, 3)
    across = np.cross(towards, directions(count, 4)).astype(np.float32)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    rays = np.zeros(count, cb.EYE_RAY)
    rays["origin"] = across * np.float32(distance) - towards * np.float32(2)
    rays["direction"], rays["length"] = towards, 4
    return rays


def committed(count=2000, medium=FOG):
    beams = cb.BeamMap(medium)
    beams.add(lamp_beams(count))
    beams.commit(KERNEL.max_radius)
    return beams


def resolved():
    grid = cb.Grid(LAYOUT)
    grid.deposit(FOG, lamp_segments(500))
    grid.resolve()
    return grid


class Picture(unittest.TestCase):
    def test_a_lamp_in_fog_is_as_bright_as_the_integral_along_the_ray_says(self):
        power, count = 100.0, 40_000
        with cb.Grid(LAYOUT) as grid, cb.BeamMap(FOG) as beams, cb.Scratch() as scratch:
            grid.deposit(FOG, lamp_segments(2000, power))
            grid.resolve()
            beams.add(lamp_beams(count, power))
            beams.commit(KERNEL.max_radius)
            self.assertEqual(beams.count, count)
            gathered = beams.gather(KERNEL, grid, eye_rays(256), scratch=scratch)
        # Single scattering, isotropic, lamp of `power` watts: the ray is 4 m long and passes at 1 m. The beams are 4 m long: all of it
        # is within their reach.
        s = (np.arange(4000) + 0.5) * 1e-3
        d = np.hypot(s - 2, 1.0)
        expected = np.sum(0.2 / (4 * np.pi) * power / (4 * np.pi * d**2) * np.exp(-0.2 * (d + s))) * 1e-3
        radiance = gathered["radiance"][:, 1].astype(float)
        error = radiance.std(ddof=1) / math.sqrt(len(radiance))
        # Beams are shared by rays, but those from all sides hardly share any; the bias that the kernel accepts is 1 %.
        self.assertLess(error, 0.01 * expected)
        self.assertLess(abs(radiance.mean() - expected), 4 * error + KERNEL.error * expected)
        self.assertTrue((gathered["pairs"] > 0).all())
        # The grid widens kernels: light at 1 m from a lamp is smooth.
        self.assertGreater((gathered["radius"] / gathered["weight"]).mean(), 1.5 * KERNEL.min_radius)

    def test_shading_by_the_same_formula_gives_the_same_picture(self):
        beams, rays, seen = committed(), eye_rays(64), []

        def shade(contacts, values):
            seen.append(len(contacts))
            self.assertFalse(contacts.flags.writeable)
            optical_depth = 0.2 * (contacts["ray_distance"] + contacts["beam_distance"])
            values[:] = (0.2 / (4 * np.pi) * np.exp(-optical_depth))[:, np.newaxis]

        plain = beams.gather(KERNEL, None, rays)
        shaded = beams.gather_shaded(KERNEL, None, rays, shade)
        np.testing.assert_array_equal(shaded["pairs"], plain["pairs"])
        self.assertEqual(sum(seen), plain["pairs"].sum())
        # A few roundings of single precision each, a hundred pairs a ray.
        np.testing.assert_allclose(shaded["radiance"], plain["radiance"], rtol=1e-5)

    def test_pairs_one_by_one_give_what_the_map_gives(self):
        beams, rays = lamp_beams(2000), eye_rays(4)
        whole = committed().gather(KERNEL, None, rays)
        for ray, expected in zip(rays.reshape(4, 1), whole):
            gathered = np.zeros((), cb.GATHERED)
            accepted = cb.gather_pair(ray, beams, 0.0, 4.0, FOG, KERNEL, None, gathered)
            self.assertEqual(accepted.sum(), expected["pairs"])
            self.assertTrue(cb.filter_beams(ray, beams, KERNEL.max_radius)[accepted].all())
            # The same numbers, added in another order.
            np.testing.assert_allclose(gathered["radiance"], expected["radiance"], rtol=1e-5)

    def test_a_medium_tells_what_it_was_made_of(self):
        medium = cb.Medium((0.25, 0.5, 1.0), 0.125, cb.Phase.henyey_greenstein(0.5))
        self.assertEqual(medium.scattering, (0.25, 0.5, 1.0))
        self.assertEqual(medium.absorption, (0.125,) * 3)
        self.assertEqual(medium.phase.evaluate(0.3), cb.Phase.henyey_greenstein(0.5).evaluate(0.3))
        self.assertEqual(cb.Medium(1).phase.evaluate(0.3), cb.Phase.isotropic().evaluate(0.3))

    def test_tables_of_columns_of_my_own_give_what_the_library_makes_itself(self):
        values = np.random.default_rng(5).random((8, 8, 8), np.float32)
        density = cb.Density(LAYOUT, values)
        smoke = cb.Medium(0.2, density=density)
        segments = lamp_segments(20)
        tables = [smoke.tabulate(s["origin"].copy(), s["field"]["direction"].copy(), s["length"]) for s in segments]
        # The contract wants distances that grow; the library's own tables may have equal neighbours.
        self.assertTrue(all((np.diff(table["distance"]) > 0).all() for table in tables))
        table = np.concatenate(tables)
        mine = segments.copy()
        starts = np.cumsum([0] + [len(t) for t in tables[:-1]])
        mine["knots"] = table.ctypes.data + starts * cb.KNOT.itemsize
        mine["knot_count"] = [len(t) for t in tables]
        with cb.Grid(LAYOUT) as one, cb.Grid(LAYOUT) as other:
            one.deposit(smoke, segments)
            other.deposit(smoke, mine, knots=table)
            self.assertEqual(one.save(), other.save())
            with self.assertRaisesRegex(ValueError, "element 0 points at knots outside"):
                other.deposit(smoke, mine)
            for field, change in [("knots", -8), ("knots", 4), ("knot_count", len(table))]:
                wrong = mine.copy()
                wrong[field][19] += np.array(change).astype(np.uintp)
                with self.assertRaisesRegex(ValueError, "element (19|0) points at knots outside"):
                    other.deposit(smoke, wrong, knots=table[1:] if change == -8 else table)
        column = smoke.column((0, 0, 0), (0, 0, 1), smoke.tabulate((0, 0, 0), (0, 0, 1), 2.0))
        same = cb.Column.of_knots(smoke.tabulate((0, 0, 0), (0, 0, 1), 2.0))
        at = np.linspace(0, 2, 50, dtype=np.float32)
        np.testing.assert_array_equal(column.at(at), same.at(at))
        self.assertAlmostEqual(float(column.distance_at(column.at(1.5))), 1.5, places=5)

    def test_a_saved_grid_is_read_back(self):
        grid = resolved()
        for data in (grid.save(), bytearray(grid.save()), memoryview(grid.save())):
            with cb.Grid.load(data) as again:
                self.assertEqual(again.layout, LAYOUT)
                np.testing.assert_array_equal(again.cells, grid.cells)
        for data in (b"", b"nonsense", grid.save()[:-1]):
            with self.assertRaises(cb.Error) as raised:
                cb.Grid.load(data)
            self.assertEqual(raised.exception.status, cb.Status.BAD_DATA)

    def test_grids_of_shares_merge_to_what_one_grid_holds(self):
        segments = lamp_segments(100)
        with cb.Grid(LAYOUT) as all, cb.Grid(LAYOUT) as first, cb.Grid(LAYOUT) as second:
            all.deposit(FOG, segments)
            first.deposit(FOG, segments[:50])
            second.deposit(FOG, segments[50:])
            first.merge([second])
            # Sums in f64, in another order.
            np.testing.assert_allclose(first.cells["weight"], all.cells["weight"], rtol=1e-13)
            with self.assertRaises(cb.Error):
                first.merge([first])

    def test_the_example_of_the_readme_runs(self):
        blocks = re.findall(r"```python\n(.*?)```", (REPOSITORY / "README.md").read_text(encoding="utf-8"), re.S)
        self.assertTrue(blocks, "README.md has no ```python block")
        for block in blocks:
            names = {}
            exec(compile(block, "README.md", "exec"), names)
        picture = names["picture"]
        self.assertTrue(np.isfinite(picture).all() and (picture > 0).mean() > 0.9)
        # The lamp is in the middle.
        centre = picture[24:40, 24:40].mean()
        self.assertGreater(centre, 3 * np.concatenate([picture[:8], picture[-8:]]).mean())


class Pool(unittest.TestCase):
    """examples/python/pool.py."""

    def setUp(self):
        sys.path.insert(0, str(REPOSITORY / "examples" / "python"))
        self.addCleanup(sys.path.pop, 0)
        import pool

        self.pool = pool

    def test_the_water_is_a_closed_mesh_that_holds_as_much_as_its_height_says(self):
        for waves in (0.0, 0.08):
            positions, triangles, normals = self.pool.tank(waves)
            edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
            self.assertEqual(len(np.unique(edges, axis=0)), len(edges), "each edge once in this direction")
            np.testing.assert_array_equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0), "and once in the other")
            a, b, c = (positions[triangles[:, i]].astype(float) for i in range(3))
            # Divergence theorem; inside is what lies behind all triangles.
            volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
            x, z = (np.arange(2000) + 0.5) / 2000, (np.arange(1000) + 0.5)[:, None] / 1000
            height = sum(
                share * np.sin(np.pi * nx * x) * np.sin(np.pi * nz * z) for nx, nz, share in ((3, 2, 0.4), (7, 4, 0.3), (11, 5, 0.2), (6, 9, 0.1))
            ).mean()
            # Triangles are a thousandth of a wave lower.
            self.assertAlmostEqual(volume, np.prod(self.pool.SIZE) + waves * height * self.pool.SIZE[0] * self.pool.SIZE[2], delta=2e-4)
            self.assertGreater(np.einsum("ij,ij->i", normals[:, 0].astype(float), np.cross(b - a, c - a)).min(), 0, "on the outer side")

    def test_still_water_is_a_box_of_it(self):
        size = 48
        made = self.pool.scene(size, 0.0)
        with mock.patch.object(cs, "Scene", functools.partial(self.boxed, cs.Scene)):
            boxed = self.pool.scene(size, 0.0)
        pictures = []
        for scene in (made, boxed):
            session = cs.Session(scene, seed=1)
            session.until(passes=8)
            pictures.append(session.picture())
        # The same random numbers: where light goes the same ways, noise goes with it. Eight passes know each mean to half a percent.
        regions = [picture.reshape(3, 12, 4, 12, 3).mean(axis=(1, 3)) for picture in pictures]
        np.testing.assert_allclose(*(picture.mean(axis=(0, 1)) for picture in pictures), rtol=0.005)
        np.testing.assert_allclose(*regions, rtol=0.05)

    def boxed(self, make, geometry, materials, camera, lights, volumes, *, world_volume, shapes, object_volumes, object_closed):
        """The same scene with a box in place of the mesh."""
        box = np.zeros(1, cs.SHAPE)
        box["kind"], box["material"], box["volume"] = cs.ShapeKind.BOX, self.pool.WATER, object_volumes[0]
        box["a"], box["b"] = self.pool.SIZE * [-0.5, 0, -0.5], self.pool.SIZE * [0.5, 1, 0.5]
        return make(None, materials, camera, lights, volumes, world_volume, shapes=np.concatenate([shapes, box]))


class Example(unittest.TestCase):
    """examples/python/shadow.py."""

    def setUp(self):
        sys.path.insert(0, str(REPOSITORY / "examples" / "python"))
        self.addCleanup(sys.path.pop, 0)
        import shadow

        self.shadow = shadow

    def scattered_once(self, size):
        """The light that homogeneous fog scatters once from a point to the example's camera, with the shadow of its ball: (h, w), by the
        midpoint rule in the angle at the lamp. Shares nothing with the code under test."""
        eye, lamp, ball, s, a, g = np.array([0, 0.5, -5]), np.array([0, 2.5, 0]), 0.5, 0.2, 0.05, 0.4
        forward = -eye / np.linalg.norm(eye)
        right = np.cross(forward, (0, 1, 0)) / np.linalg.norm(np.cross(forward, (0, 1, 0)))
        at = ((np.arange(size) + 0.5) * 2 / size - 1) * math.tan(math.radians(17.5))
        d = forward + at[None, :, None] * right - at[:, None, None] * np.cross(right, forward)
        d = d.reshape(-1, 3) / np.linalg.norm(d.reshape(-1, 3), axis=1, keepdims=True)

        def ball_at(origin, direction):
            middle = -np.sum(origin * direction, axis=-1)
            rest = ball**2 - np.sum(origin * origin, axis=-1) + middle**2
            return np.where((rest > 0) & (middle > 0), middle - np.sqrt(np.maximum(rest, 0)), np.inf)

        end = np.minimum(ball_at(eye, d), 200)
        foot = d @ (lamp - eye)
        aside = np.linalg.norm(eye + foot[:, None] * d - lamp, axis=1)
        low, high = np.arctan(-foot / aside), np.arctan((end - foot) / aside)
        total, steps = np.zeros(len(d)), 1500
        for i in range(steps):
            far = foot + aside * np.tan(low + (i + 0.5) / steps * (high - low))
            light = eye + far[:, None] * d - lamp
            length = np.linalg.norm(light, axis=1)
            light /= length[:, None]
            cosine = -np.sum(light * d, axis=1)
            phase = (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * cosine) ** 1.5)
            # dt = (aside^2 + t^2) / aside d(angle), and the lamp's 1/d^2 cancels the bracket.
            arrives = np.where(ball_at(lamp, light) < length, 0, np.exp(-(s + a) * (far + length)))
            total += phase * arrives * (high - low) / (steps * aside)
        return (25 * s * total).reshape(size, size)

    def test_the_shadow_of_a_ball_is_that_of_its_integral(self):
        size = 32
        runs = [self.shadow.render(size, 4, 20_000, seed)[0] for seed in range(12)]
        expected = self.scattered_once(size)

        def regions(picture):
            return picture.reshape(8, 4, 8, 4).mean(axis=(1, 3))

        values = np.array([regions(run) for run in runs]) / regions(expected)
        error = values.std(axis=0, ddof=1) / 12**0.5
        # Kernels may err by 1 %, at borders of the shadow by more, where the light bends most.
        np.testing.assert_array_less(np.abs(values.mean(axis=0) - 1), 0.02 + 5 * error)
        self.assertLess(np.median(error), 0.01, "noise hides nothing")
        self.assertLess(abs(np.mean([run.sum() for run in runs]) / expected.sum() - 1), 0.01)

    def test_beams_are_narrow_where_the_shadow_has_its_border(self):
        _, radii = self.shadow.render(48, 4, 20_000)
        # Below the ball: across both borders of its shadow, and in its middle.
        below = radii[24:36].mean(axis=0)
        border = below[[12, 13, 14, 15, 32, 33, 34, 35]].mean()
        self.assertLess(border, 0.9 * below[22:26].mean())


class Segments(unittest.TestCase):
    def test_a_segment_with_edges_is_the_same_one_cut_by_hand(self):
        whole = lamp_segments(50)
        whole["edges"]["depth"], whole["edges"]["distance"] = (-1, 0.5, 0.75, 2), 0.2
        whole["edges"]["towards"], whole["edge_count"] = directions(200, 5).reshape(50, 4, 3), 4
        pieces, at = [], 0.0
        for edge in (1, 2, 3, None):
            piece = lamp_segments(50)
            piece["origin"] = np.float32(at) * piece["field"]["direction"]
            piece["power"] *= np.float32(math.exp(-0.2 * at))
            if pieces:
                piece["field"] = field
            end = 4.0 if edge is None else float(whole["edges"]["depth"][0, edge])
            piece["length"] = end - at
            field = piece["field"].copy()
            if edge is not None:
                light_field.travel(field, end - at)
                light_field.occlude(field, whole["edges"]["towards"][:, edge].copy(), 0.2)
            pieces.append(piece)
            at = end
        with cb.Grid(LAYOUT) as grid, cb.Grid(LAYOUT) as by_hand, cb.Grid(LAYOUT) as plain:
            grid.deposit(FOG, whole)
            for piece in pieces:
                by_hand.deposit(FOG, piece)
            plain.deposit(FOG, lamp_segments(50))
            cells, expected, other = (g.cells["sum"].reshape(-1, 6).copy() for g in (grid, by_hand, plain))
        # Roundings of f32 in places and powers; a voxel's border may lie on the other side of one.
        np.testing.assert_allclose(cells, expected, rtol=1e-4, atol=1e-5 * np.abs(expected).max())
        self.assertGreater(np.abs(cells - other).max(), 0.01 * np.abs(other).max())
        found = cb.segment.field_at(whole, FOG, 3.0)
        light_field.travel(field, 1.0)
        np.testing.assert_array_equal(found, field)

    def test_edges_that_are_not_sound_are_refused(self):
        for name, value in (("depth", (1, 0.5, 2, 3)), ("depth", np.nan), ("distance", -1), ("towards", 0)):
            segments = lamp_segments(3)
            segments["edges"]["towards"], segments["edge_count"] = 1, 4
            segments["edges"][name] = value
            with self.assertRaisesRegex(cb.Error, "segments"):
                cb.segment.field_at(segments, FOG, 1.0)

    def ball(self, center, radius):
        """Casts rays from the origin at a ball."""

        def probe(direction):
            direction = direction.astype(float)
            along = center @ direction
            half2 = radius**2 - center @ center + along**2
            if half2 <= 0 or along <= 0:
                return None
            distance = along - math.sqrt(half2)
            return distance, distance * direction - center, 1e-6

        return probe

    def test_the_silhouette_of_a_ball_lies_where_its_tangents_touch(self):
        for offset in (-0.1, -0.02, 0.02, 0.1):
            angle = math.asin(0.2) + offset
            probe = self.ball(np.array([5 * math.sin(angle), 0, 5 * math.cos(angle)]), 1.0)
            towards = np.array([0, 0, 1], np.float32)
            hit = probe(towards)
            edges = cb.segment.find_edges(towards, probe, hit)
            nearest = edges[edges["distance"].argmin()]
            depth = math.sqrt(24) if hit is None else hit[0]
            self.assertAlmostEqual(nearest["depth"] / depth, 1, delta=0.05)
            # Half the last bracket, 2.5 %; between two azimuths the silhouette is taken as straight, 8 %.
            self.assertAlmostEqual(nearest["distance"] / (depth * math.tan(abs(offset))), 1, delta=0.12)
            self.assertGreater(nearest["towards"][0] * math.copysign(1, offset), 0.92)
        self.assertEqual(len(cb.segment.find_edges((0, 0, 1), lambda direction: None)), 0)

    def test_what_a_probe_raises_or_makes_no_sense_ends_the_search(self):
        def raising(direction):
            raise Boom(str(direction))

        calls = []

        def late(direction):
            calls.append(direction)
            if len(calls) == 5:
                raise Boom("late")

        with self.assertRaises(Boom):
            cb.segment.find_edges((0, 0, 1), raising)
        with self.assertRaises(Boom):
            cb.segment.find_edges((0, 0, 1), late)
        self.assertEqual(len(calls), 5)
        for answer in (3, "far", (1.0, (0, 0, 1)), (1.0, 2.0, 3.0)):
            with self.assertRaisesRegex(TypeError, "probe: returned"):
                cb.segment.find_edges((0, 0, 1), lambda direction: answer)
        for answer in ((-1, (0, 0, 1), 0), (math.nan, (0, 0, 1), 0), (1, (0, 0, 0), 0), (1, (0, 0, 1), -1)):
            with self.assertRaisesRegex(cb.Error, "probe"):
                cb.segment.find_edges((0, 0, 1), lambda direction: answer)
        for wrong in (None, 3):
            with self.assertRaisesRegex(TypeError, "probe"):
                cb.segment.find_edges((0, 0, 1), wrong)

    def test_the_first_numbers_of_paths_fill_their_dimensions_evenly(self):
        paths = np.arange(512, dtype=np.uint32)
        for dimension in range(cb.emission.EMISSION_DIMENSIONS):
            numbers = cb.path_numbers(3, 1, paths, dimension)
            self.assertEqual(len(np.unique((512 * numbers).astype(int))), 512)
        for wrong in ((-1, 0, paths, 0), (0, 1 << 32, paths, 0), (0, 0, paths, -1)):
            with self.assertRaises(ValueError):
                cb.path_numbers(*wrong)
        with self.assertRaises(TypeError):
            cb.path_numbers(0, 0, paths.astype(np.uint64), 0)


class ImageSpace(unittest.TestCase):
    def test_pixels_need_fewer_rays_where_the_grid_says_that_light_is_smooth(self):
        # Parallel rays that pass the lamp at 0.1 to 1.5 m; a pixel is 1 cm wide, to the right and down.
        rays = np.zeros(15, cb.EYE_RAY)
        rays["origin"][:, 0], rays["origin"][:, 2] = np.linspace(0.1, 1.5, 15), -2
        rays["direction"], rays["length"] = (0, 0, 1), 4
        steps = np.zeros(2, cb.PIXEL_STEP)
        steps["origin"][0, 0] = steps["origin"][1, 1] = 0.01
        spectra = image.along(resolved(), FOG, rays, steps)
        self.assertTrue((spectra["weight"] > 0).all())
        filters = image.filters(spectra, 0.01, 50.0)
        densities = image.densities(filters)
        self.assertTrue(((densities > 0) & (densities <= 1)).all())
        self.assertLess(densities[-1], 0.5 * densities[0])
        pixels = image.pixels(16, 16)
        chosen = image.thresholds(1, 0, pixels) < densities[-1]
        # The pattern strays from its share by 7.4 of 256 at most.
        self.assertLess(abs(chosen.sum() - 256 * densities[-1]), 7.5)

    def test_light_does_not_bleed_across_a_silhouette(self):
        width, height = 48, 48
        right = np.tile(np.arange(width) >= 24, height)
        regions = image.regions(width, height, np.where(right, 5, 2).astype(np.float32))
        self.assertEqual(set(regions.reshape(height, width)[2].tolist()), {0, 1, 26})
        pixels = image.pixels(width, height)
        for labels in (regions, None):
            with cb.Film(width, height, 1.0, labels) as film:
                nodes = film.nodes()
                # As smooth as can be: the widest filters.
                spectra = np.zeros(len(nodes), cb.IMAGE_SPECTRUM)
                spectra["weight"] = 1
                for pass_ in range(1, 9):
                    film.plan(pass_, 0.1, 100, spectra, poll=lambda: True)
                    chosen = image.thresholds(pass_, 0, pixels) < film.densities()
                    rays = np.zeros(chosen.sum(), cb.FILM_RAY)
                    rays["pixel"], rays["has_volume"] = pixels[chosen], 1
                    rays["volume"] = np.where(right, 8, 1)[chosen, np.newaxis]
                    film.add(rays)
                with self.assertRaises(cb.Cancelled):
                    film.verify(poll=lambda: False)
                with self.assertRaisesRegex(cb.Error, "not verified"):
                    film.picture()
                film.verify(poll=lambda: True)
                found = film.picture()
                np.testing.assert_array_equal(found[8 * width : 24 * width], film.picture(8, 16))
                if labels is None:
                    # Where a filter of three pixels reaches over the edge: a mean of both.
                    edge = found["volume"].reshape(height, width, 3)[24, 23:25, 0]
                    self.assertTrue((1.2 < edge).all() and (edge < 7.8).all(), edge)
                else:
                    whole = regions > 0
                    np.testing.assert_allclose(found["volume"][whole, 0], np.where(right, 8, 1)[whole], rtol=1e-5)
                errors = image.errors(width, height, found)
                self.assertTrue((errors >= 0).all() and errors.max() < 8)
                self.assertGreater(film.memory, 60 * width * height)
        with self.assertRaisesRegex(cb.Error, "used after close"):
            film.verify()

    def test_what_is_no_picture_is_refused(self):
        film = cb.Film(4, 3, 1)
        spectra = np.zeros(4, cb.IMAGE_SPECTRUM)
        with self.assertRaisesRegex(cb.Error, "no pass is planned"):
            film.densities()
        with self.assertRaisesRegex(cb.Error, "count: 5, but the nodes"):
            film.plan(1, 0.1, 0, np.zeros(5, cb.IMAGE_SPECTRUM))
        film.plan(1, 0.1, 0, spectra)
        rays = np.zeros(2, cb.FILM_RAY)
        rays["pixel"][1] = 4, 0
        with self.assertRaisesRegex(cb.Error, r"rays\[1\].pixel: .4, 0. is outside of the picture"):
            film.add(rays)
        rays["pixel"], rays["rest"] = 0, np.nan
        with self.assertRaisesRegex(cb.Error, "rays.0..rest: NaN is not >= 0"):
            film.add(rays)
        with self.assertRaisesRegex(TypeError, "rays: dtype"):
            film.add(np.zeros(2, cb.EYE_RAY))
        film.add(rays[:0])
        film.verify()
        with self.assertRaisesRegex(cb.Error, "first_row: 1 is no multiple of 8"):
            film.picture(1)
        self.assertEqual(film.picture()["radiance"].max(), 0)
        with self.assertRaisesRegex(cb.Error, "count: 11"):
            cb.Film(4, 3, 1, np.ones(11, np.uint32))
        for size in ((0, 3), (65537, 1)):
            with self.assertRaisesRegex(cb.Error, "is not in 1 to 65536"):
                cb.Film(*size, 1)
        with self.assertRaisesRegex(ValueError, "width: -1"):
            cb.Film(-1, 3, 1)
        with self.assertRaisesRegex(cb.Error, "typical_radiance: 0 is not > 0"):
            cb.Film(4, 3, 0)


class Marching(unittest.TestCase):
    def test_a_lamp_beside_the_ray_with_a_shadow_is_as_bright_as_its_integral(self):
        lamp = (1.0, 0.0, 3.0)
        radiance = lambda z: 1 / (1 + (z - 3) ** 2)
        knots = march.lay((0, 0, 0), (0, 0, 1), 0, 8, lamp)
        self.assertTrue(np.isnan(knots["deviation"]).all())
        knots["radiance"] = radiance(knots["distance"])
        random = np.random.default_rng(5)
        with cb.March() as table:
            table.update(knots)
            first_rays = table.first_round(32)
            self.assertTrue(0 < first_rays < 32)
            self.assertGreater(table.expected()[1], 0)
            estimates = []
            for _ in range(200):
                first = table.place(random.random(first_rays, np.float32))
                first["visibility"] = first["distance"] < 4
                second = table.refine(first, random.random(32 - first_rays, np.float32))
                lit = second["distance"] < 4
                estimates.append((second["weight"] * radiance(second["distance"]))[lit].sum())
        expected = math.atan(1) + math.atan(3)
        # The table is linear between 97 knots: within 1e-3.
        error = np.std(estimates, ddof=1) / math.sqrt(len(estimates))
        self.assertLess(error, 0.002 * expected)
        self.assertLess(abs(np.mean(estimates) - expected), 4 * error + 1e-3 * expected)

    def test_a_table_that_is_none_is_refused(self):
        table = cb.March()
        with self.assertRaisesRegex(cb.Error, "call covbeam_march_update first"):
            table.place(np.zeros(3, np.float32))
        knots = np.zeros(3, cb.MARCH_KNOT)
        knots["distance"] = (0, 2, 1)
        with self.assertRaisesRegex(cb.Error, r"knots\[2\].distance: 1 is below"):
            table.update(knots)
        with self.assertRaisesRegex(ValueError, "light"):
            march.lay((0, 0, 0), (0, 0, 1), 0, 1, (1, 2))


class Arrays(unittest.TestCase):
    def test_strided_views_give_the_bits_of_contiguous_arrays(self):
        d, lengths = directions(300), np.linspace(0.1, 3, 300, dtype=np.float32)
        apart = np.zeros((300, 2), cb.LIGHT_FIELD)
        light_field.point(d, out=apart[:, 1])
        together = light_field.point(d)
        beams = lamp_beams(900)
        beams["length"][::3] = lengths
        for fields, lengths in [(apart[:, 1], beams["length"][::3]), (together, lengths)]:
            light_field.travel(fields, lengths)
        self.assertEqual(apart[:, 1].tobytes(), together.tobytes())
        self.assertFalse(apart.view(np.uint8).reshape(300, 2, -1)[:, 0].any(), "the elements between were written")

        columns = np.zeros((300, 4, 3), np.float32)
        light_field.slice(apart[:, 1], out=columns[:, 2])
        self.assertEqual(columns[:, 2].tobytes(), light_field.slice(together).tobytes())

        one, other = cb.BeamMap(FOG), cb.BeamMap(FOG)
        one.add(beams[::3])
        other.add(beams[::3].copy())
        rays, out = np.repeat(eye_rays(32), 2), np.zeros((32, 2), cb.GATHERED)
        for m in (one, other):
            m.commit(KERNEL.max_radius)
        grid = resolved()
        one.gather(KERNEL, grid, rays[::2], out=out[:, 1])
        expected = other.gather(KERNEL, grid, rays[::2].copy())
        self.assertEqual(out[:, 1].tobytes(), expected.tobytes())
        self.assertGreater(expected["pairs"].sum(), 0)

    def test_a_field_of_a_record_of_my_own_is_passed_in_place(self):
        mine = np.zeros(10, np.dtype([("id", np.int64), ("field", cb.LIGHT_FIELD), ("distance", np.float32)], align=True))
        light_field.point(directions(10), out=mine["field"])
        expected = mine["field"].copy()
        mine["distance"] = np.arange(10)
        light_field.travel(mine["field"], mine["distance"])
        light_field.travel(expected, np.arange(10, dtype=np.float32))
        self.assertEqual(mine["field"].tobytes(), expected.tobytes())

    def test_single_values_serve_all_elements(self):
        fields = light_field.point(directions(5))
        each = fields.copy()
        light_field.occlude(fields, (1, 0, 0), 0.5)
        light_field.occlude(each, np.tile(np.float32([1, 0, 0]), (5, 1)), np.full(5, 0.5, np.float32))
        self.assertEqual(fields.tobytes(), each.tobytes())
        one = light_field.point((0, 0, 1))
        self.assertEqual(one.shape, ())
        self.assertIsInstance(light_field.variance_along_ray(one, 0.1), np.float32)
        self.assertEqual(light_field.slice(one).shape, (3,))
        # A broadcast view has a stride of 0.
        light_field.travel(each, np.broadcast_to(np.float32(2), 5))
        light_field.travel(fields, 2)
        self.assertEqual(fields.tobytes(), each.tobytes())

    def test_no_elements_are_no_work(self):
        light_field.travel(np.zeros(0, cb.LIGHT_FIELD), 1.0)
        self.assertEqual(light_field.point(np.zeros((0, 3), np.float32)).shape, (0,))
        committed().gather(KERNEL, None, np.zeros(0, cb.EYE_RAY))

    def test_large_arrays_are_not_copied(self):
        count = 100_000
        fields, segments, beams, rays = light_field.point(directions(count)), lamp_segments(count), lamp_beams(count), eye_rays(count)
        segments["length"] = 1e-3
        rays["origin"] += 100
        out, map = np.zeros(count, cb.GATHERED), committed(10)
        calls = {
            "travel": lambda: light_field.travel(fields, 1.0),
            "fluence": lambda: light_field.fluence(fields[::2], np.inf, out=spectra),
            "deposit": lambda: grid.deposit(FOG, segments),
            "add": lambda: cb.BeamMap(FOG).add(beams),
            "gather": lambda: map.gather(KERNEL, None, rays, out=out),
            "cells": lambda: big.cells,
        }
        spectra, grid = np.zeros(count // 2, cb.SPECTRUM), cb.Grid(LAYOUT)
        big = cb.Grid(LAYOUT._replace(cells=(64, 64, 64)))
        for name, call in calls.items():
            with self.subTest(name):
                tracemalloc.start()
                call()
                _, peak = tracemalloc.get_traced_memory()
                tracemalloc.stop()
                # The smallest of these arrays has 1.2 MB. What deposit checks about knots is a few masks of a byte and of 8 bytes.
                self.assertLess(peak, 100_000 * 8 * 6 if name == "deposit" else 100_000)

    def test_the_library_gets_the_address_of_the_array(self):
        array = lamp_beams(10)[2:]
        words = []
        _arrays.elementwise(lambda *got: words.extend(got) or 0, _arrays.COUNT, _arrays.given("beams", array[::2], _arrays.Kind(cb.BEAM)))
        self.assertEqual(words, [4, array.ctypes.data, 128])

    def test_cells_are_views_of_the_grid(self):
        grid = cb.Grid(LAYOUT._replace(cells=(2, 3, 4)))
        cells = grid.cells
        self.assertEqual(cells.shape, (4, 3, 2))
        self.assertTrue(np.shares_memory(cells, grid.cells))
        self.assertFalse(cells.flags.writeable)
        with self.assertRaises(ValueError):
            cells.flags.writeable = True
        with self.assertRaisesRegex(cb.Error, "resolve"):
            grid.means
        self.assertFalse(cells["weight"].any())
        inside = np.float32([[1.9, -1.9, -1.9]])
        grid.deposit_spectra(inside, np.ones(1, cb.SPECTRUM), 5.0)
        self.assertEqual(cells["weight"][0, 0, 1], 5.0)
        grid.resolve()
        self.assertEqual(grid.means["weight"][0, 0, 1], 1.0)

    def test_a_grid_in_my_memory_works_there(self):
        cells, means = np.zeros((8, 8, 8), cb.GRID_CELL), np.zeros(512, cb.FLUENCE_CELL)
        mine, theirs = cb.Grid.new_in(LAYOUT, cells, means), resolved()
        mine.deposit(FOG, lamp_segments(500))
        mine.resolve()
        np.testing.assert_array_equal(cells, theirs.cells)
        np.testing.assert_array_equal(means.reshape(8, 8, 8), theirs.means)
        self.assertTrue(np.shares_memory(mine.cells, cells) and np.shares_memory(mine.means, means))
        address = cells.ctypes.data
        del cells, means
        gc.collect()
        # The grid keeps the memory: it still is what it was.
        self.assertEqual(mine.cells.ctypes.data, address)
        np.testing.assert_array_equal(mine.cells, theirs.cells)

    def test_what_cannot_be_passed_is_refused_by_name(self):
        field, d = light_field.point(directions(4)), directions(4)
        travel, f4, zeros = light_field.travel, np.float32, np.zeros
        unaligned = zeros(4 * 64 + 1, np.uint8)[1:].view(cb.LIGHT_FIELD)
        odd = np.ndarray(4, f4, buffer=bytearray(64), strides=(6,))
        read_only = field.copy()
        read_only.flags.writeable = False
        swapped = field.astype(cb.LIGHT_FIELD.newbyteorder("S"))
        packed = np.dtype([("a", np.uint8), ("field", cb.LIGHT_FIELD)])
        cells, means = zeros(512, cb.GRID_CELL), zeros(512, cb.FLUENCE_CELL)
        cases = [
            (TypeError, "fields: a list; give a numpy array", lambda: travel([1.0], 1.0)),
            (TypeError, "fields: a void", lambda: travel(field[0], 1.0)),
            (TypeError, "fields: dtype float32", lambda: travel(zeros(4, f4), 1.0)),
            (TypeError, "fields: .*other order; use .astype", lambda: travel(swapped, 1.0)),
            (ValueError, "fields: shape .2, 2. is neither .. nor .n,.", lambda: travel(field.reshape(2, 2), 1.0)),
            (ValueError, "fields: the array is read-only", lambda: travel(read_only, 1.0)),
            (ValueError, "fields: runs backwards .stride -64.; use np.ascontiguous", lambda: travel(field[::-1], 1.0)),
            (ValueError, "fields: elements are not aligned", lambda: travel(unaligned, 1.0)),
            (ValueError, "fields: elements are not aligned", lambda: travel(zeros(4, packed)["field"], 1.0)),
            (TypeError, "distances: dtype float64 .*float32", lambda: travel(field, zeros(4))),
            (TypeError, "distances: dtype int64 .*float32", lambda: travel(field, zeros(4, np.int64))),
            (TypeError, "distances: dtype >f4 .*other order", lambda: travel(field, zeros(4, ">f4"))),
            (TypeError, "distances: a str; give a number", lambda: travel(field, "1")),
            (TypeError, "distances: a NoneType", lambda: travel(field, None)),
            (TypeError, "distances: a list", lambda: travel(field, [1.0] * 4)),
            (ValueError, "distances: 3 elements, but fields has 4", lambda: travel(field, zeros(3, f4))),
            (ValueError, "distances: elements are not aligned", lambda: travel(field, odd)),
            (ValueError, "fields: one element, but distances has 4", lambda: travel(field[0, ...], zeros(4, f4))),
            (TypeError, "directions: dtype float64", lambda: light_field.point(zeros((4, 3)))),
            (ValueError, "directions: shape .4, 2. is neither .3,. nor .n, 3.", lambda: light_field.point(zeros((4, 2), f4))),
            (ValueError, "directions: the 3 numbers .* 16 bytes apart", lambda: light_field.point(zeros((3, 4), f4).T)),
            (ValueError, r"directions: \(1, 2\) is not 3 numbers", lambda: light_field.point((1, 2))),
            (TypeError, "directions: a float; give a tuple", lambda: light_field.point(1.0)),
            (TypeError, "out: dtype float64", lambda: light_field.slice(field, out=zeros((4, 3)))),
            (ValueError, "out: shape", lambda: light_field.slice(field, out=zeros((4, 2), f4))),
            (ValueError, "out: 5 elements, but fields has 4", lambda: light_field.slice(field, out=zeros((5, 3), f4))),
            (ValueError, "out: the array is read-only", lambda: light_field.slice(field, out=np.broadcast_to(d[0], (4, 3)))),
            (TypeError, "curvatures: a tuple; give a numpy array of records", lambda: light_field.reflect(field, d, (0,) * 6)),
            (TypeError, "medium: a float; give a Medium", lambda: light_field.carry(field, 0.2, d, 1.0)),
            (TypeError, "kernel: a float; give a Kernel", lambda: committed().gather(0.1, None, eye_rays(1))),
            (TypeError, "a str where an object", lambda: committed().gather(KERNEL, "grid", eye_rays(1))),
            (TypeError, "rays: dtype", lambda: committed().gather(KERNEL, None, lamp_beams(1))),
            (ValueError, "ray: 2 elements, but one is wanted", lambda: cb.cross(eye_rays(2), lamp_beams(2))),
            (TypeError, "out: the call has two results", lambda: cb.cross(eye_rays(1), lamp_beams(2), out=zeros(2))),
            (TypeError, "beam_columns.1.: a int; give a Column", lambda: cb.gather_pair(
                eye_rays(1), lamp_beams(2), 0.0, 1.0, FOG, KERNEL, None, zeros(1, cb.GATHERED),
                beam_columns=[cb.Column.of_knots(zeros(0, cb.KNOT)), 1])),
            (TypeError, "layout: a tuple; give a GridLayout", lambda: cb.Grid(tuple(LAYOUT))),
            (ValueError, "layout: cells", lambda: cb.Grid(LAYOUT._replace(cells=(-1, 1, 1)))),
            (ValueError, r"values: shape \(8, 8, 9\) is not \(nz, ny, nx\)", lambda: cb.Density(LAYOUT, zeros((8, 8, 9), f4))),
            (ValueError, "values: the voxels are not evenly spaced", lambda: cb.Density(LAYOUT, zeros((8, 8, 8), f4).T)),
            (ValueError, "cells: 511 elements, but the layout has 512", lambda: cb.Grid.new_in(LAYOUT, cells[1:], means)),
            (ValueError, "cells: elements are 112 bytes apart, not packed", lambda: cb.Grid.new_in(
                LAYOUT, zeros(1024, cb.GRID_CELL)[::2], means)),
            (ValueError, "means: shares memory", lambda: cb.Grid.new_in(
                LAYOUT, cells, cells.view(np.uint8)[: 512 * 28].view(cb.FLUENCE_CELL))),
            (TypeError, "scattering: 'x' is neither", lambda: cb.Medium("x")),
            (TypeError, "density: a float", lambda: cb.Medium(1.0, density=1.0)),
            (ValueError, r"weights: give a numpy array of shape \(side, side\)", lambda: cb.emission_guide_fill(zeros((2, 3), f4), 0.1)),
            (ValueError, "weights: the numbers are not side by side", lambda: cb.emission_guide_fill(zeros((3, 3), f4).T[:2, :2], 0.1)),
            (TypeError, "weights: dtype float64", lambda: cb.emission_guide_fill(zeros((3, 3)), 0.1)),
            (ValueError, r"guide: give a numpy array of shape \(side . 1, side\)", lambda: cb.emission_guide_warp(
                zeros((3, 3), f4), zeros((1, 2), f4))),
            (TypeError, "paths: dtype", lambda: cb.Importance(LAYOUT).add_paths(FOG, lamp_beams(1), 1.0)),
            (ValueError, "pass_: 4294967297", lambda: cb.kernel.error_bound(0.1, 2**32 + 1)),
        ]
        before = field.copy()
        for kind, message, call in cases:
            with self.subTest(message), self.assertRaisesRegex(kind, message):
                call()
        self.assertEqual(field.tobytes(), before.tobytes())

    def test_what_the_library_refuses_is_an_error_with_its_message(self):
        field = light_field.point(directions(4))
        before = field.copy()
        distances = np.float32([1, 2, np.nan, 3])
        with self.assertRaisesRegex(cb.Error, r"distances\[2\]: NaN is not finite \(INVALID_VALUE\)") as raised:
            light_field.travel(field, distances)
        self.assertEqual(raised.exception.status, cb.Status.INVALID_VALUE)
        self.assertEqual(raised.exception.message, "distances[2]: NaN is not finite")
        self.assertEqual(field.tobytes(), before.tobytes())
        again = pickle.loads(pickle.dumps(raised.exception))
        self.assertEqual((again.status, str(again)), (raised.exception.status, str(raised.exception)))
        for status, call in [
            (cb.Status.WRONG_ORDER, lambda: cb.BeamMap(FOG).gather(KERNEL, None, eye_rays(1))),
            (cb.Status.WRONG_ORDER, lambda: cb.Grid(LAYOUT).look_up((0, 0, 0))),
            (cb.Status.WRONG_ORDER, lambda: cb.Importance(LAYOUT).at((0, 0, 0))),
            (cb.Status.INVALID_VALUE, lambda: cb.emission_guide_fill(np.ones((2, 2), np.float32), 0.0)),
            (cb.Status.INVALID_VALUE, lambda: cb.weight_window(np.float32([1, np.nan]), 0.5)),
            (cb.Status.MISMATCH, lambda: cb.Grid(LAYOUT).merge([cb.Grid(LAYOUT._replace(cells=(1, 1, 1)))])),
            (cb.Status.INVALID_HANDLE, lambda: cb.Grid(LAYOUT).merge([cb.Scratch()])),
            (cb.Status.INVALID_ARRAY, lambda: spectrum.variance_along(
                np.zeros(4, cb.SPECTRUM), (0, 0, 1), out=np.lib.stride_tricks.as_strided(np.zeros(4, np.float32), strides=(0,)))),
        ]:
            with self.assertRaises(cb.Error) as raised:
                call()
            self.assertEqual(raised.exception.status, status)


class Boom(Exception):
    pass


class Callbacks(unittest.TestCase):
    def setUp(self):
        # What a callback raises must never end here.
        swallowed = []
        patch = mock.patch("sys.unraisablehook", swallowed.append)
        patch.start()
        self.addCleanup(lambda: (patch.stop(), self.assertEqual(swallowed, [])))

    def calls(self):
        """Long calls with a poll."""
        beams, rays = committed(50_000), eye_rays(2000)
        one, other = np.zeros(2000, cb.GATHERED), np.zeros(2000, cb.GATHERED)
        shade = lambda contacts, values: values.fill(1)
        adding = cb.BeamMap(FOG)
        adding.add(lamp_beams(200_000))
        yield lambda poll: adding.commit(0.1, poll=poll), adding
        yield lambda poll: beams.gather(KERNEL, None, rays, out=one, poll=poll), one
        yield lambda poll: beams.gather_shaded(KERNEL, None, rays, shade, out=other, poll=poll), other

    def test_a_poll_that_says_no_cancels(self):
        for call, changed in self.calls():
            asked = []
            with self.assertRaises(cb.Cancelled) as raised:
                call(lambda: asked.append(1) or len(asked) < 3)
            self.assertEqual(raised.exception.status, cb.Status.CANCELLED)
            self.assertEqual(len(asked), 3)
            if isinstance(changed, np.ndarray):
                self.assertFalse(changed.view(np.uint8).any(), "a cancelled gather wrote")
            else:
                self.assertEqual(changed.count, 200_000)
            # And nothing is stuck.
            call(lambda: True)

    def test_a_deposit_stops_between_segments(self):
        asked, grid, whole, segments = [], cb.Grid(LAYOUT), cb.Grid(LAYOUT), lamp_segments(2000)
        with self.assertRaises(cb.Cancelled):
            grid.deposit(FOG, segments, poll=lambda: asked.append(1) or len(asked) < 3)
        self.assertEqual(len(asked), 3)
        whole.deposit(FOG, segments, poll=lambda: True)
        some, all = grid.cells["weight"].sum(), whole.cells["weight"].sum()
        self.assertTrue(0 < some < all)
        grid.clear()
        grid.deposit(FOG, segments)
        np.testing.assert_array_equal(grid.cells, whole.cells)

    def test_what_a_poll_raises_is_raised_by_the_call(self):
        for call, _ in self.calls():
            for raised in (Boom("here"), KeyboardInterrupt(), SystemExit(3)):
                asked = []

                def poll():
                    asked.append(1)
                    if len(asked) == 2:
                        raise raised
                    return True

                with self.assertRaises(type(raised)) as caught:
                    call(poll)
                self.assertIs(caught.exception, raised)
                self.assertEqual(len(asked), 2)
            with self.assertRaisesRegex(TypeError, "poll: returned None"):
                call(lambda: None)

    def test_ctrl_c_ends_a_call_even_if_it_comes_outside_of_python(self):
        def interrupt(*_):
            raise KeyboardInterrupt

        before = signal.signal(signal.SIGALRM, interrupt)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        for call, _ in self.calls():
            for delay in (0.004, 0.007, 0.011, 0.013, 0.017):
                deadline = time.monotonic() + 10
                with self.assertRaises(KeyboardInterrupt):
                    # In here: on a busy machine it may ring at once.
                    signal.setitimer(signal.ITIMER_REAL, delay)
                    while time.monotonic() < deadline:
                        try:
                            call(lambda: True)
                        except cb.Error as error:
                            # The map has been committed in time: again, until the signal comes.
                            self.assertEqual(error.status, cb.Status.WRONG_ORDER)

    def test_ctrl_c_at_the_door_of_shade_is_not_lost(self):
        beams, rays = committed(50_000), eye_rays(500)
        before = signal.signal(signal.SIGALRM, mock.Mock(side_effect=Boom))
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        for step in range(60):
            deadline = time.monotonic() + 10
            with self.assertRaises(Boom):
                signal.setitimer(signal.ITIMER_REAL, 0.001 + 0.0003 * step)
                while time.monotonic() < deadline:
                    beams.gather_shaded(KERNEL, None, rays, lambda contacts, values: None)

    def test_what_shade_raises_is_raised_by_the_call(self):
        beams, rays, out = committed(), eye_rays(64), np.zeros(64, cb.GATHERED)
        seen = []

        def shade(contacts, values):
            seen.append(len(contacts))
            raise Boom

        with self.assertRaises(Boom):
            beams.gather_shaded(KERNEL, None, rays, shade, out=out)
        self.assertEqual(len(seen), 1)
        self.assertFalse(out.view(np.uint8).any())
        with self.assertRaisesRegex(TypeError, "shade: returned something"):
            beams.gather_shaded(KERNEL, None, rays, lambda contacts, values: values)
        for shade in (None, 3):
            with self.assertRaisesRegex(TypeError, "shade: "):
                beams.gather_shaded(KERNEL, None, rays, shade)

    def test_contacts_that_are_kept_stay_readable(self):
        beams, kept = committed(), []
        beams.gather_shaded(KERNEL, None, eye_rays(64), lambda contacts, values: kept.append((contacts, values)))
        beams.close()
        gc.collect()
        for contacts, values in kept:
            self.assertTrue(np.isfinite(contacts["position"]).all() and np.isfinite(values).all())

    def test_a_callback_cannot_change_the_objects_of_its_call(self):
        beams, grid, scratch = committed(50_000), resolved(), cb.Scratch()
        for change in (beams.clear, grid.resolve, grid.clear, lambda: beams.gather(KERNEL, grid, eye_rays(1), scratch=scratch)):
            with self.assertRaisesRegex(cb.Error, "busy, another call on this") as raised:
                beams.gather(KERNEL, grid, eye_rays(500), scratch=scratch, poll=lambda: change() or True)
            self.assertEqual(raised.exception.status, cb.Status.BUSY)
        # To read them, or to close them, is fine.
        asked = []
        poll = lambda: asked.append(beams.count) or True
        beams.gather(KERNEL, grid, eye_rays(500), scratch=scratch, poll=poll)
        self.assertEqual(set(asked), {50_000})
        done = beams.gather(KERNEL, grid, eye_rays(500), scratch=scratch, poll=lambda: (beams.close(), grid.close(), True)[2])
        self.assertGreater(done["pairs"].sum(), 0)


class Objects(unittest.TestCase):
    def test_use_after_close_is_an_error(self):
        density = cb.Density(LAYOUT, np.ones((8, 8, 8), np.float32))
        grid, beams, scratch = resolved(), committed(), cb.Scratch()
        for thing in (density, grid, beams, scratch):
            thing.close()
            thing.close()
        for call in [
            lambda: grid.resolve(),
            lambda: grid.cells,
            lambda: grid.save(),
            lambda: cb.Grid(LAYOUT).merge([grid]),
            lambda: beams.count,
            lambda: beams.add(lamp_beams(1)),
            lambda: committed().gather(KERNEL, grid, eye_rays(1)),
            lambda: committed().gather(KERNEL, None, eye_rays(1), scratch=scratch),
            lambda: cb.Medium(0.1, density=density),
        ]:
            with self.assertRaisesRegex(cb.Error, "used after close") as raised:
                call()
            self.assertEqual(raised.exception.status, cb.Status.INVALID_HANDLE)

    def test_objects_live_as_long_as_something_needs_them(self):
        grid = resolved()
        cells, means = grid.cells, grid.means
        expected = cells.copy(), means.copy()
        with cb.Density(LAYOUT, np.full((8, 8, 8), 2, np.float32)) as density:
            smoke = cb.Medium(0.1, density=density)
        grid.close()
        del grid, density
        gc.collect()
        # Memory that has been freed would be in use by these.
        others = [cb.Grid(LAYOUT) for _ in range(20)]
        np.testing.assert_array_equal(cells, expected[0])
        np.testing.assert_array_equal(means, expected[1])
        self.assertEqual(smoke.density_at((0, 0, 0)), 2)
        del others

    def test_a_handle_is_freed_exactly_once(self):
        for make in (lambda: cb.Grid(LAYOUT), lambda: cb.BeamMap(FOG), cb.Scratch, lambda: cb.Density(LAYOUT, np.ones(512, np.float32))):
            thing, freed = make(), []
            owner = thing._owner
            free, owner._free = owner._free, freed.append
            handle = owner.handle
            del owner
            twin = copy.copy(thing)
            thing.close()
            self.assertEqual(freed, [])
            twin.close()
            del thing, twin
            gc.collect()
            self.assertEqual(freed, [handle])
            free(handle)
        for duplicate in (copy.deepcopy, pickle.dumps):
            with self.assertRaisesRegex(TypeError, "cannot be copied or pickled"):
                duplicate(cb.Grid(LAYOUT))

    def test_nothing_leaks(self):
        layout, values = LAYOUT._replace(cells=(1, 1, 1)), np.ones(1, np.float32)
        one, field = np.zeros(1, cb.BEAM), light_field.point((0, 0, 1))
        one["direction"], one["length"] = (0, 0, 1), 1
        ray = np.zeros(1, cb.EYE_RAY)
        ray["direction"], ray["length"] = (0, 1, 0), 1

        def round():
            with cb.Grid(layout) as grid, cb.Density(layout, values) as density, cb.Scratch() as scratch:
                with cb.BeamMap(cb.Medium(0.1, density=density)) as beams:
                    grid.resolve()
                    grid.cells
                    beams.add(one)
                    beams.commit(0.1, poll=lambda: True)
                    beams.gather_shaded(KERNEL, grid, ray, lambda c, v: None, scratch=scratch, poll=lambda: True)
            light_field.travel(field, 0.0)

        def resident():
            gc.collect()
            return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

        # 25,000 rounds make and free 100,000 objects. The first fill the allocators' pools.
        for _ in range(2000):
            round()
        before = resident()
        for _ in range(25_000):
            round()
        # The smallest allocation is 16 bytes; every object of the library has 64 or more: a leak of one kind is 1.6 MB. Pools come and
        # go by a few pages.
        self.assertLess(resident() - before, 1 << 20)

    def test_threads_share_what_they_read_and_are_kept_from_what_one_changes(self):
        beams, grid, rays = committed(50_000), resolved(), eye_rays(800)
        expected = beams.gather(KERNEL, grid, rays)
        results = {}

        def work(name):
            results[name] = beams.gather(KERNEL, grid, rays).tobytes()

        threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(set(results.values()), {expected.tobytes()})
        beams.clear()


def linux(machine):
    """The start of a library for Linux."""
    return b"\x7fELF\x02\x01".ljust(18, b"\0") + struct.pack("<H", machine)


def windows(machine):
    """The start of a library for Windows."""
    return b"MZ".ljust(60, b"\0") + struct.pack("<I", 64) + b"PE\0\0" + struct.pack("<H", machine)


def macos(machine=0x0100000C, minimum=(11, 0), command=0x32):
    """The start of a library for macOS: its second load command has the oldest version."""
    version = minimum[0] << 16 | minimum[1] << 8
    words = (1, version) if command == 0x32 else (version, 0)
    return b"\xcf\xfa\xed\xfe" + struct.pack("<7I", machine, 0, 6, 2, 40, 0, 0) + struct.pack("<8I", 0x1B, 16, 0, 0, command, 24, *words)


def build_hook():
    """The build hook of wheels, as a module."""
    spec = importlib.util.spec_from_file_location("hatch_build", REPOSITORY / "ffi" / "python" / "hatch_build.py")
    hook = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(hook)
    return hook


class Library(unittest.TestCase):
    def compiled(self, path, source, *options):
        path.with_suffix(".c").write_text(source)
        subprocess.run([os.environ.get("CC", "cc"), *options, str(path.with_suffix(".c")), "-o", str(path)], check=True)
        return path

    def test_a_library_that_does_not_fit_is_refused_with_the_remedy(self):
        with tempfile.TemporaryDirectory() as folder:
            newer = self.compiled(
                Path(folder, "newer.so"),
                'unsigned covbeam_abi_version(void) { return 999; } const char *covbeam_version(void) { return "7.8.9"; }',
                "-shared", "-fPIC",
            )
            with self.assertRaisesRegex(ImportError, rf"version 7\.8\.9\) has ABI 999, this module is for ABI {cb.ABI_VERSION}. .*one covbeam wheel"):
                _library.load(newer)
            text = Path(folder, "text.so")
            text.write_text("not a library")
            with self.assertRaisesRegex(ImportError, "text.so cannot be loaded on .*COVBEAM_LIBRARY"):
                _library.load(text)
            whole = Path(_library.lib._name).read_bytes()
            # The library itself, for a SPARC; libraries of Windows and macOS, as far as their headers; less than a header.
            for data in (whole[:18] + b"\x02\x00" + whole[20:], windows(0x8664), macos(), whole[:60]):
                other = Path(folder, f"other{len(data)}.so")
                other.write_bytes(data)
                with self.assertRaisesRegex(ImportError, r"other\d+.so cannot be loaded on .*Install the covbeam wheel for this machine"):
                    _library.load(other)
            older = self.compiled(
                Path(folder, "older.so"),
                f'unsigned covbeam_abi_version(void) {{ return {cb.ABI_VERSION}; }} const char *covbeam_version(void) {{ return "0.0.1"; }}',
                "-shared", "-fPIC",
            )
            with self.assertRaisesRegex(ImportError, r"older.so has no covbeam_\w+, though its ABI is .*Install the covbeam wheel"):
                _library.load(older)
            another = self.compiled(Path(folder, "another.so"), "int f(void) { return 0; }", "-shared", "-fPIC")
            with self.assertRaisesRegex(ImportError, "is not libcovbeam"):
                _library.load(another)
            with mock.patch.object(_library, "FILE_NAME", "nowhere.so"), mock.patch.dict(os.environ):
                os.environ["COVBEAM_LIBRARY"] = str(Path(folder, "gone.so"))
                with self.assertRaisesRegex(ImportError, "gone.so', where there is no file"):
                    _library.find()
                os.environ["COVBEAM_LIBRARY"] = str(text)
                self.assertEqual(_library.find(), text)
                del os.environ["COVBEAM_LIBRARY"]
                with self.assertRaisesRegex(ImportError, "no nowhere.so beside the module, and COVBEAM_LIBRARY is not set"):
                    _library.find()

    def test_the_tag_of_a_wheel_is_what_the_library_says_of_itself(self):
        hook = build_hook()
        with tempfile.TemporaryDirectory() as folder:
            library = Path(folder, "library")

            def said(data):
                library.write_bytes(data)
                return hook.platform_of(library)

            glibc = b"\0GLIBC_2.5\0GLIBC_2.28\0GLIBC_2.9\0"
            self.assertEqual(said(linux(62) + glibc), ("manylinux_2_28_x86_64", "lib{}.so", "x86_64-unknown-linux-gnu"))
            self.assertEqual(said(linux(183) + b"GLIBC_2.2"), ("manylinux_2_17_aarch64", "lib{}.so", "aarch64-unknown-linux-gnu"))
            self.assertEqual(said(windows(0x8664)), ("win_amd64", "{}.dll", "x86_64-pc-windows-msvc"))
            self.assertEqual(said(windows(0xAA64)), ("win_arm64", "{}.dll", "aarch64-pc-windows-msvc"))
            self.assertEqual(said(macos()), ("macosx_11_0_arm64", "lib{}.dylib", "aarch64-apple-darwin"))
            # From 11 on pip asks for whole versions: what needs 12.3 does not run on all of 12.
            self.assertEqual(said(macos(minimum=(12, 3)))[0], "macosx_13_0_arm64")
            self.assertEqual(said(macos(0x01000007, (10, 12), 0x24))[::2], ("macosx_10_12_x86_64", "x86_64-apple-darwin"))
            refused = {
                "asks for no glibc": linux(62),
                "no tag is known": linux(2) + glibc,
                "Windows on x86-64": windows(0x14C),
                "several processors": b"\xca\xfe\xba\xbe" + bytes(60),
                "which macOS": macos(0x01000012),
                "MACOSX_DEPLOYMENT_TARGET": macos(command=0x19),
                "cut off": macos()[:40],
                "no shared library": b"text",
            }
            for words, data in refused.items():
                with self.assertRaisesRegex(hook.Unfit, f"^{library}.*{words}.*\\.$"):
                    said(data)
        machine = {"x86_64": "x86_64", "aarch64": "aarch64", "arm64": "arm64", "AMD64": "amd64"}[platform.machine()]
        self.assertTrue(hook.platform_of(Path(_library.lib._name))[0].endswith("_" + machine))

    def header(self):
        return re.sub(r"/\*.*?\*/", "", "".join(header.read_text() for header in Path(os.environ["COVBEAM_INCLUDE"]).glob("*.h")), flags=re.S)

    def test_structs_and_constants_are_those_of_the_header_as_the_compiler_sees_it(self):
        header = self.header()
        structs = {}
        for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\}", header, re.S):
            structs[name] = re.findall(r"(\w+)(?:\[\w+\])*;", body)
        # What materials ask is asked of hosts in C.
        constants = re.findall(r"\b(COVBEAM_(?!ASKS_)[A-Z_]+) = \d+", header) + ["COVBEAM_ABI_VERSION"]
        lines = []
        for name, fields in structs.items():
            lines.append(f'printf("{name} %zu %zu\\n", sizeof({name}), _Alignof({name}));')
            for field in fields:
                place = f"offsetof({name}, {field}), sizeof((({name} *)0)->{field})"
                lines.append(f'printf("{name}.{field} %zu %zu\\n", {place});')
        lines += [f'printf("{name} %ld 0\\n", (long){name});' for name in constants]
        source = '#include "covbeam_extra.h"\n#include "covbeam_session.h"\n#include <stdio.h>\nint main(void) {\n' + "\n".join(lines) + "\nreturn 0; }"
        with tempfile.TemporaryDirectory() as folder:
            program = self.compiled(Path(folder, "layout"), source, "-std=c11", "-I", os.environ["COVBEAM_INCLUDE"])
            output = subprocess.run([program], check=True, stdout=subprocess.PIPE, text=True).stdout
        compiler = {name: (int(a), int(b)) for name, a, b in map(str.split, output.splitlines())}

        python = {}
        for name in cb.dtypes.__dict__:
            dtype = getattr(cb.dtypes, name)
            if isinstance(dtype, np.dtype):
                struct = "covbeam_" + name.lower()
                python[struct] = (dtype.itemsize, dtype.alignment)
                for field, (of, offset, *_) in dtype.fields.items():
                    python[f"{struct}.{field}"] = (offset, of.itemsize)
        everything = (vars(_abi) | vars(_session_abi)).values()
        for struct in (s for s in everything if isinstance(s, type) and issubclass(s, ctypes.Structure)):
            name = "covbeam_" + re.sub(r"(?<=[a-z])(?=[A-Z])", "_", struct.__name__).lower()
            python[name] = (ctypes.sizeof(struct), ctypes.alignment(struct))
            for field, _ in struct._fields_:
                descriptor = getattr(struct, field)
                python[f"{name}.{field}"] = (descriptor.offset, descriptor.size)
        python |= {f"COVBEAM_{status.name}": (status.value, 0) for status in cb.Status}
        python |= {f"COVBEAM_KERNEL_{shape.name}": (shape.value, 0) for shape in cb.KernelShape}
        kinds = ("ISOTROPIC", "HENYEY_GREENSTEIN", "RAYLEIGH")
        python |= {f"COVBEAM_PHASE_{kind}": (getattr(cb.Phase, kind), 0) for kind in kinds}
        densities = [cb.Medium(1), cb.Medium(1, density=cb.Exponential((0, 0, 0), (0, 0, 1), 1))]
        densities.append(cb.Medium(1, density=cb.Density(LAYOUT, np.ones(512, np.float32))))
        for kind, medium in zip(("UNIFORM", "EXPONENTIAL", "VOXELS"), densities):
            python[f"COVBEAM_DENSITY_{kind}"] = (medium._struct.density, 0)
        enums = {"SHAPE": cs.ShapeKind, "LIGHT": cs.LightKind, "PROJECTION": cs.Projection, "METHOD": cs.Method, "END": cs.End, "LAYER": cs.Layer}
        python |= {f"COVBEAM_{of}_{one.name}": (one.value, 0) for of, enum in enums.items() for one in enum}
        for dtype, name in ((cs.MATERIAL, "material"), (cs.SHAPE, "shape"), (cs.HIT, "surface_hit")):
            python[f"covbeam_{name}"] = (dtype.itemsize, python[f"covbeam_{name}"][1])
            python |= {f"covbeam_{name}.{field}": (at, of.itemsize) for field, (of, at) in dtype.fields.items()}
        python["COVBEAM_ABI_VERSION"] = (cb.ABI_VERSION, 0)
        # Nothing missing on either side: a new struct, field or constant of the header fails here.
        self.assertEqual(python, compiler)
        self.assertGreater(len(structs), 15)
        self.assertEqual(_library.lib.covbeam_abi_version(), cb.ABI_VERSION)


if __name__ == "__main__":
    unittest.main()
