"""covbeam.session as the extension uses it: long calls stop when they are told to, what is wrong is refused by its name, and memory comes back.
Needs the covbeam wheel and numpy; no Blender."""

import gc
import time
import unittest
from types import SimpleNamespace

import numpy as np
from covbeam import Cancelled, Error, Status
from covbeam.session import HIT, MATERIAL, Geometry, Layer, Scene, Session
from process_memory import in_use

#: After this long a user wonders whether the program has heard [s].
PATIENCE = 0.2


def grid_mesh(side):
    """A wavy sheet of 2 side^2 triangles: positions, triangles."""
    x, y = np.meshgrid(np.linspace(-1, 1, side + 1), np.linspace(-1, 1, side + 1))
    positions = np.stack([x, y, 0.2 * np.sin(5 * x) * np.cos(4 * y)], -1).reshape(-1, 3).astype(np.float32)
    a = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1)
    b, c, d = a + 1, a + side + 2, a + side + 1
    return positions, np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).astype(np.int32)


def sheet(side=8):
    """A geometry with such a sheet, built."""
    geometry = Geometry()
    geometry.add_instance(geometry.add_mesh(*grid_mesh(side), 0), np.eye(4), 0)
    geometry.build()
    return geometry


def volume(**values):
    """Fog."""
    grey, zero = np.ones(3), np.zeros(3)
    fields = {"scattering": 0.2 * grey, "absorption": 0.1 * grey, "phase": 0, "asymmetry": 0.0, "min": zero, "max": grey}
    return SimpleNamespace(**fields | {"density": None, "glow": None, "parts": ()} | values)


def light(**values):
    """A lamp that shines all around."""
    vectors = dict.fromkeys(("axis", "u", "v", "radiance", "irradiance"), np.zeros(3))
    numbers = dict.fromkeys(("radius", "cosine", "blend", "spread", "angle"), 0.0)
    fields = {"kind": 0, "position": np.array([0.3, 0.2, 2.0]), "intensity": np.full(3, 10.0), "soft": False, "round": False}
    arrays = {"triangles": np.zeros((0, 3, 3)), "pattern": None, "sky": None, "turn": np.eye(3)}
    return SimpleNamespace(**vectors | numbers | fields | arrays | values)


def camera(**values):
    """Looks down at the sheet."""
    _, y, z = np.eye(3)
    plane = {"projection": 0, "left": -0.4, "top": 0.4, "step": (0.05, 0.05), "widest": 0.0}
    fields = {"position": 4 * z, "up": y, "forward": -z, "width": 16, "height": 16, "near": 0.0, "aperture": None}
    return SimpleNamespace(**fields | plane | values)


def scene(geometry=None, **values):
    """Fog without end above the sheet."""
    given = {"materials": np.zeros(1, MATERIAL), "object_volumes": [-1], "object_closed": [False], "volumes": [volume()], "world_volume": 0}
    return Scene(geometry or sheet(), **given | {"lights": [light()], "camera": camera(), "fog_alone": True} | values)


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


class Cancel(unittest.TestCase):
    def test_a_build_stops_soon_after_it_is_told_to(self):
        positions, triangles = grid_mesh(700)
        geometry = Geometry()
        for number in range(3):
            geometry.add_instance(geometry.add_mesh(positions, triangles, 0), np.eye(4), number)
        poll = Stop(after=0)
        with self.assertRaises(Cancelled):
            geometry.build(poll)
        self.assertLess(time.perf_counter() - poll.said_no, PATIENCE)
        # What threads still finish is in nobody's way.
        begun = time.perf_counter()
        sheet()
        self.assertLess(time.perf_counter() - begun, PATIENCE)
        with self.assertRaisesRegex(Error, "used after close"):
            geometry.bounds

    def test_a_session_stops_soon_after_it_is_told_to_and_goes_on_as_if_nothing_had_been(self):
        made = scene()
        poll = Stop(after=0)
        with self.assertRaises(Cancelled):
            Session(scene(camera=camera(width=2000, height=2000)), poll=poll)
        self.assertLess(time.perf_counter() - poll.said_no, PATIENCE)
        session = Session(made, photons=200_000)
        for call in (session.render_pass, session.render_pass):
            poll = Stop()
            with self.assertRaises(Cancelled):
                call(poll)
            self.assertLess(time.perf_counter() - poll.said_no, PATIENCE)
            # Asked every 50 ms, on a machine that does other things as well.
            self.assertLess(np.diff([poll.begun, *poll.asked]).max(), PATIENCE)
            self.assertEqual(session.passes, 0)
        session.restart(500)
        session.render_pass()
        other = Session(made, photons=500)
        other.render_pass()
        np.testing.assert_array_equal(session.picture(), other.picture())

    def test_what_a_poll_raises_ends_the_call_and_is_raised_by_it(self):
        class Oops(Exception):
            pass

        def poll():
            raise Oops

        geometry = Geometry()
        geometry.add_mesh(*grid_mesh(700), 0)
        with self.assertRaises(Oops):
            geometry.build(poll)
        session = Session(scene(), photons=200_000)
        with self.assertRaises(Oops):
            session.render_pass(poll)
        self.assertEqual(session.passes, 0)

    def test_a_session_does_one_thing_at_a_time(self):
        session, errors = Session(scene(), photons=100_000), []
        session.render_pass()

        def poll():
            # Inside a call.
            for call in (session.render_pass, session.picture, lambda: session.restart(10)):
                try:
                    call()
                except Error as error:
                    errors.append(error.status)
            return False

        with self.assertRaises(Cancelled):
            session.render_pass(poll)
        self.assertEqual(errors, [Status.BUSY] * 3)

    def test_objects_can_be_dropped_at_any_moment(self):
        # Built in longer than it takes until the first question.
        positions, triangles = grid_mesh(700)
        for number in range(3):
            geometry = Geometry()
            geometry.add_instance(geometry.add_mesh(positions, triangles, 0), np.eye(4), 0)
            if number == 1:
                # Closed inside its own build, which still ends as it should.
                geometry.build(lambda: geometry.close() or True)
            if number == 2:
                geometry.build()
            geometry.close()
            geometry.close()
        made = scene()
        session = Session(made, photons=100_000)
        made.close()
        # The same inside its own pass.
        with self.assertRaises(Cancelled):
            session.render_pass(lambda: session.close() or False)
        session.close()
        self.assertEqual((session.passes, session.photons), (0, 100_000))
        for call in (session.render_pass, session.picture, lambda: session.restart(1), lambda: Session(made)):
            with self.assertRaisesRegex(Error, "used after close"):
                call()
        del geometry, session
        gc.collect()


class Errors(unittest.TestCase):
    # What else is refused, ffi/src/session/tests says; here, that it is raised, and what only Python can get wrong.
    def test_meshes_and_instances_that_are_wrong_are_refused_with_the_remedy(self):
        geometry = Geometry()
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
        for arguments, what in (
            ((mesh, np.eye(3), 0), "matrix: shape"),
            ((mesh + 1, np.eye(4), 0), "mesh: 1"),
            ((2**33, np.eye(4), 0), "mesh: 8589934592"),
            ((mesh, np.eye(4), 2**40), "object"),
        ):
            with self.assertRaisesRegex(ValueError, what):
                geometry.add_instance(*arguments)
        with self.assertRaisesRegex(Error, "not built"):
            geometry.bounds
        with self.assertRaisesRegex(Error, "not built"):
            scene(geometry)

    def test_scenes_that_are_wrong_are_refused_by_the_name_of_the_field(self):
        geometry = sheet()
        pattern = {"cells": np.ones((2, 4, 3)), "axes": np.eye(3), "reach": 3.0}
        voxels = {"min": np.zeros(3), "max": np.ones(3), "values": np.ones((2, 3, 4), np.float32)}

        of_two = np.ones((1, 2, 1, 3), np.float32)
        glow = {"min": np.zeros(3), "max": np.ones(3), "values": of_two}

        def of_light(**values):
            return {"lights": [light(), light(**values)]}

        def of_fog(**values):
            return {"volumes": [volume(), volume(**values)]}

        wrong = {
            r"materials: dtype": {"materials": np.zeros(1, np.float32)},
            r"object_volumes: dtype": {"object_volumes": [0.5]},
            r"object_closed: shape": {"object_closed": [True, False]},
            r"world_volume: 7": {"world_volume": 7},
            r"world_volume: 1e\+20": {"world_volume": 1e20},
            r"volumes\[1\].scattering: shape": of_fog(scattering=np.ones(4)),
            r"volumes\[1\].absorption: \[NaN": of_fog(absorption=np.full(3, np.nan)),
            r"volumes\[1\].density.values: shape": of_fog(density=SimpleNamespace(**voxels | {"values": np.ones(4)})),
            r"volumes\[1\].density.values\[0\]: inf": of_fog(density=SimpleNamespace(**voxels | {"values": np.full((1, 1, 1), 1e300)})),
            r"volumes\[1\].glow.values: shape": of_fog(glow=SimpleNamespace(**voxels)),
            r"volumes\[1\].glow.values\[1\]: \[-1": of_fog(glow=SimpleNamespace(**glow | {"values": of_two * np.float32([[[[1]], [[-1]]]])})),
            r"volumes\[0\].glow: .*no end": {"volumes": [volume(glow=SimpleNamespace(**glow))]},
            r"volumes\[1\].phase: -1": of_fog(phase=-1),
            r"volumes\[1\].parts": of_fog(parts=(1,)),
            r"lights\[1\].kind: 4294967296": of_light(kind=2**32),
            r"lights\[1\].intensity: \[inf": of_light(intensity=np.full(3, np.inf)),
            r"lights\[1\].radius: shape": of_light(radius=np.ones(2)),
            r"lights\[1\].triangles: shape": of_light(triangles=np.ones((3, 3))),
            r"lights\[1\].pattern.cells: shape": of_light(pattern=SimpleNamespace(**pattern | {"cells": np.ones((2, 4))})),
            r"lights\[1\].pattern.reach: NaN": of_light(pattern=SimpleNamespace(**pattern | {"reach": np.nan})),
            r"lights\[1\].turn: shape": of_light(kind=5, sky=np.ones((2, 4, 3)), turn=np.eye(2)),
            r"camera.width: -16": {"camera": camera(width=-16)},
            r"camera.width: 16.5": {"camera": camera(width=16.5)},
            r"camera.step: shape": {"camera": camera(step=(0.1,))},
            r"camera.aperture.focus: 0": {
                "camera": camera(aperture=SimpleNamespace(radius=0.1, focus=0.0, blades=0, rotation=0.0, ratio=1.0))
            },
        }
        for what, values in wrong.items():
            with self.subTest(what), self.assertRaisesRegex((ValueError, TypeError), what):
                scene(geometry, **values)
        sound = (of_light(pattern=SimpleNamespace(**pattern)), of_fog(density=SimpleNamespace(**voxels)), {"lights": [], "volumes": []})
        sound += (of_fog(glow=SimpleNamespace(**glow)),)
        for values in sound:
            scene(geometry, **{"world_volume": -1} | values)

    def test_settings_that_are_wrong_are_refused_by_their_name(self):
        made = scene()
        for name, value in (
            ("seed", -1),
            ("seed", 2**32),
            ("photons", -1),
            ("photons", 2**31),
            ("grid", 1000),
            ("radius", np.nan),
            ("radius", -1.0),
            ("quality", 0.0),
            ("bounces", -3),
            ("threads", 100_000),
        ):
            with self.subTest(name, value=value), self.assertRaisesRegex(ValueError, f"settings.{name}: "):
                Session(made, **{name: value})
        session = Session(made, photons=100)
        with self.assertRaisesRegex(Error, "a picture needs a pass"):
            session.picture()
        for photons in (-1, 2**32):
            with self.assertRaisesRegex(ValueError, "photons"):
                session.restart(photons)

    def test_a_picture_that_no_memory_holds_is_refused_before_it_is_begun(self):
        with self.assertRaisesRegex(MemoryError, "16384 x 16384 pixels with 268435456 light paths"):
            Session(scene(camera=camera(width=16384, height=16384)), photons=2**28)


class Pictures(unittest.TestCase):
    def test_a_session_tells_where_it_stands(self):
        begun = time.perf_counter()
        session = Session(scene(), photons=700, threads=1, first_apart=True)
        self.assertEqual((session.passes, session.photons, session.pairs), (0, 700, 0))
        for number in (1, 2):
            session.render_pass()
            self.assertEqual(session.passes, number)
        picture = session.picture()
        taken = time.perf_counter() - begun
        self.assertEqual(picture.shape, (16, 16, 3))
        self.assertGreater(picture.min(), 0)
        np.testing.assert_array_equal(picture, session.picture(Layer.FIRST))
        for layer in (Layer.RADIUS, Layer.BANDWIDTH, Layer.ERROR):
            values = session.picture(layer)
            self.assertEqual(values.shape, (16, 16))
            self.assertGreater(values.max(), 0)
        times = session.times
        self.assertGreater(min(times.values()), 0, times)
        # Parts of the time, of which what is before and after a task is little.
        self.assertLess(sum(times.values()), taken)
        self.assertGreater(sum(times.values()), 0.5 * taken)
        self.assertGreater(session.pairs, 100)
        self.assertGreater(session.memory, 1e6)

    def test_photons_that_nobody_has_chosen_are_the_scenes_own(self):
        session = Session(scene())
        self.assertGreater(session.photons, 500)
        session.restart(10**6)
        self.assertEqual(session.photons, Session(scene()).photons)


class Hits(unittest.TestCase):
    def test_a_hit_and_a_miss_have_the_fields_of_the_contract(self):
        geometry = Geometry()
        square = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], np.float32)
        mesh = geometry.add_mesh(square, np.array([[0, 1, 2], [0, 2, 3]], np.int32), 3)
        geometry.add_instance(mesh, np.eye(4), 7)
        geometry.build()
        # Inputs of other layouts are copied.
        hit, miss = geometry.cast(np.float64([[0.5, 0.25, 3, 9], [5, 5, 3, 9]])[:, :3], [[0, 0, -1], [0, 0, -1]])
        self.assertEqual(hit["distance"], 2)
        np.testing.assert_array_equal(hit["position"], (0.5, 0.25, 1))
        np.testing.assert_array_equal((hit["geometric_normal"], hit["normal"]), [(0, 0, 1)] * 2)
        self.assertEqual((hit["material"], hit["object"]), (3, 7))
        expected = np.zeros((), HIT)
        expected["distance"], expected["material"], expected["object"] = np.inf, -1, -1
        self.assertEqual(miss.tobytes(), expected.tobytes())
        self.assertEqual(geometry.triangle_count, 2)
        self.assertGreater(geometry.memory, 0)

    def test_rays_that_are_wrong_are_refused(self):
        geometry, origins, towards = sheet(), np.zeros((4, 3)), np.tile(np.eye(3)[2], (4, 1))
        for arguments, what in (
            ((origins, towards[:3]), "directions: shape"),
            ((origins, 2 * towards), r"directions\[0\].*length 1"),
            ((origins + np.array([[0], [0], [np.nan], [0]]), towards), r"origins\[2\].*finite"),
        ):
            with self.assertRaisesRegex(ValueError, what):
                geometry.cast(*arguments)


class Memory(unittest.TestCase):
    def test_building_and_rendering_again_and_again_does_not_grow_the_process(self):
        positions, triangles = grid_mesh(150)

        def once(stop):
            geometry = Geometry()
            geometry.add_instance(geometry.add_mesh(positions, triangles, 0), np.eye(4), 0)
            try:
                geometry.build(lambda: not stop)
                session = Session(scene(geometry), photons=500)
                session.render_pass(lambda: not stop)
            except Cancelled:
                pass

        for _ in range(5):
            once(False)
        before = in_use()
        for number in range(40):
            once(number % 2 == 1)
        # One geometry holds 5 MB, and a session as much. What Python keeps is 0.03 MB.
        self.assertLess(in_use() - before, 1e6)


if __name__ == "__main__":
    unittest.main()
