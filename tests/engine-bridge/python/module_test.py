"""The Python module: the bytes of midair-solve, errors for wrong arguments, memory that stays, threads."""

import gc
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import midair

ROOT = pathlib.Path(os.environ["MIDAIR_ROOT"])
STAR = str(ROOT / "samples" / "models" / "star.obj")
BEGIN = time.monotonic()
SOLVE = str(pathlib.Path(os.environ["MIDAIR_BIN"]) / "midair-solve")


def focus(array="board"):
    scene = midair.Scene(array)
    return scene, scene.add_points([0.0, 0.0, 0.15])


def says(scene, words):
    return any(words in message.text for message in scene.messages)


def updates_until(scene, reached):
    end = time.monotonic() + 20
    while (now := time.monotonic()) < end:
        scene.update(now - BEGIN)
        if reached():
            return True
        time.sleep(0.005)
    return False


class Caps(unittest.TestCase):
    def test_variables_hold_while_it_plays(self):
        scene, _ = focus()
        scene.play("sim:")
        self.assertTrue(updates_until(scene, lambda: scene.state["state"] == "playing"), scene.messages)
        for name, value in (("PRESSURE", "loud"), ("AMPLITUDE", "2")):
            self.silences(scene, "OSG_MIDAIR_MAX_" + name, value)
        self.silences(scene, "OSG_MIDAIR_EAR_LIMIT", "quiet")
        self.silences(scene, "OSG_MIDAIR_EAR_POINTS", "0 0 0.6;;0.3 0 0.6")
        with self.assertRaises(midair.Error):
            scene["earPoints"] = "0 0 0.6;;0.3 0 0.6"

    def silences(self, scene, variable, value):
        os.environ[variable] = value
        try:
            with self.assertRaisesRegex(midair.Error, f'{variable} is "{value}", should be '):
                updates_until(scene, lambda: False)
            self.assertNotEqual(scene.state["state"], "playing")
            texts = [message.text for message in scene.active_messages]
            self.assertTrue(any(f'{variable} is "{value}", should be ' in text for text in texts), texts)
        finally:
            del os.environ[variable]
        self.assertTrue(updates_until(scene, lambda: scene.state["state"] == "playing"), variable)


class EveryDay(unittest.TestCase):
    def test_a_field_is_waited_for(self):
        scene, points = focus()
        with self.assertRaises(midair.Error) as caught:
            scene.wait_field(1e6)
        self.assertEqual(caught.exception.status, "not yet")
        scene.play("sim:")
        for k in range(3):
            points.move_vertices([[0.01 * k, 0.0, 0.15]])
            scene.update(0.1 * k)
            field = scene.wait_field(timeout=60.0)
            self.assertAlmostEqual(field.points["position"][0][0], 0.01 * k)
        scene.stop()
        with self.assertRaises(midair.Error):
            scene.wait_field(1e6)

    def test_how_far_the_seen_is_from_the_felt_is_told(self):
        scene, _ = focus()
        self.assertEqual(len(scene.coincidence), 0)
        with self.assertRaises(midair.Error):
            scene.set_display("no such file")
        scene["extrapolate"] = False
        scene["airError"] = "1 C"
        scene.play("sim:")
        self.assertTrue(updates_until(scene, lambda: len(scene.coincidence) == 1))
        told = scene.coincidence[0]
        self.assertEqual(told["state"].tolist(), [2, 0, 0, 0, 1, 1, 2, 0])
        self.assertEqual(told["unknown"], b"no display is known")
        self.assertEqual(told["largest"], b"air")
        self.assertGreater(told["median_m"][4], 0.0)
        scene.stop()

    def test_a_head_is_set_and_listened_at(self):
        scene, _ = focus()
        self.assertIsNone(scene.head)
        with self.assertRaisesRegex(midair.Error, r"did you mean openxr\?"):
            scene.open_head("opnxr:")
        for wrong in ([0.0, 0.0], "here"):
            with self.assertRaises((TypeError, ValueError)):
                scene.set_head(wrong)
        with self.assertRaisesRegex(midair.Error, "must be within 1000 m"):
            scene.set_head([0.0, 0.0, 2000.0])

        class Seat:
            def head(self, now):
                return [0.0, -0.3, 0.2], [0.0, 0.0, 0.0, 1.0]

        midair.register_head("seat", lambda options: Seat())
        scene.open_head("seat:")
        scene.play("sim:")
        self.assertTrue(updates_until(scene, lambda: len(scene.ears) == 2))
        np.testing.assert_allclose(scene.ears["position"], [[-0.08, -0.3, 0.2], [0.08, -0.3, 0.2]])
        position, orientation = scene.head
        np.testing.assert_allclose(position, [0.0, -0.3, 0.2])
        np.testing.assert_allclose(orientation, [0.0, 0.0, 0.0, 1.0])
        scene.open_head("none")
        scene.set_head(None)
        self.assertTrue(updates_until(scene, lambda: scene.head is None and len(scene.ears) == 0))

    def test_each_ear_has_its_level(self):
        scene, _ = focus()
        scene.set_ears([[0.0, 0.0, 0.16], [0.4, 0.0, 0.3]])
        self.assertEqual(scene.ears.shape, (0,))
        scene.play("sim:")
        self.assertTrue(updates_until(scene, lambda: scene.state["state"] == "playing" and len(scene.ears) == 2))
        ears = scene.ears
        np.testing.assert_allclose(ears["position"][1], [0.4, 0.0, 0.3])
        self.assertGreater(ears["level_dB"][0], ears["level_dB"][1] + 10)
        with self.assertRaises(midair.Error):
            scene.set_ears([[0.0, 0.0, np.nan]])
        with self.assertRaises(ValueError):
            scene.set_ears([[0.0, 0.0]])
        scene.set_ears([])

    def test_reflectors_are_set_and_refused(self):
        scene, _ = focus()
        free = scene.solve().activations()
        plate = (
            '{"reflectors": [{"position_m": [0.2, 0, 0], "normal": [1, 0, 0], "along": [0, 0, 1],'
            ' "size_m": [0.4, 0.4], "accuracy_mm": 0.2}]}'
        )
        scene.set_reflectors(plate)
        self.assertGreater(np.abs(scene.solve().activations() - free).mean(), 0.01)
        with self.assertRaises(midair.Error):
            scene.set_reflectors("{}")
        scene.set_reflectors("")
        np.testing.assert_array_equal(scene.solve().activations(), free)

    def test_in_a_child_all_is_closed(self):
        scene, points = focus()
        scene.play("sim:")
        self.assertTrue(updates_until(scene, lambda: scene.state["state"] == "playing"))
        child = os.fork()
        if child == 0:
            code = 1
            try:
                closed = scene.state["state"] == "closed" and says(scene, "has forked")
                field = scene.solve()
                own, _ = focus()
                right = closed and field.figures["level_Pa"] > 100 and own.solve().figures["level_Pa"] > 100
                scene.stop()
                scene.close()
                code = 0 if right else 2
            finally:
                # As at the end of Python, with what it calls then; not the end of this test program.
                midair.Scene("board").close()
                os._exit(code)
        self.assertEqual(self.ended(child), 0)
        self.assertEqual(scene.state["state"], "playing")
        sent = scene.state["sent"]
        points.move_vertices([[0.02, 0.0, 0.15]])
        self.assertTrue(updates_until(scene, lambda: scene.state["sent"] > sent))

    def test_a_child_of_a_playing_program_exits(self):
        program = """
import os, midair, time
scene = midair.Scene("board")
scene.add_points([0.0, 0.0, 0.15])
scene.play("sim:")
begin = time.monotonic()
while scene.state["state"] != "playing":
    scene.update(time.monotonic() - begin)
child = os.fork()
if child == 0:
    raise SystemExit(7)
end = time.monotonic() + 30
while (ended := os.waitpid(child, os.WNOHANG))[0] == 0:
    if time.monotonic() > end:
        os.kill(child, 9)
    time.sleep(0.01)
print(os.waitstatus_to_exitcode(ended[1]), scene.state["state"])
"""
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.stdout.split(), ["7", "playing"], done.stderr)

    def ended(self, child):
        end = time.monotonic() + 30
        while True:
            pid, status = os.waitpid(child, os.WNOHANG)
            if pid:
                return os.waitstatus_to_exitcode(status)
            if time.monotonic() > end:
                os.kill(child, 9)
            time.sleep(0.01)


class Bytes(unittest.TestCase):
    def compare(self, options, settings=(), properties=()):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([SOLVE, STAR, "--size", "0.08", "--out", folder, *options.split()], check=True, capture_output=True)
            scene = midair.Scene("octagon")
            star = scene.add_file(STAR, size=0.08)
            for name, value in settings:
                scene[name] = value
            for name, value in properties:
                star[name] = value
            field = scene.solve()
            own = pathlib.Path(folder) / "own.csv"
            for k in range(field.fields):
                theirs = "drive.csv" if field.fields == 1 else f"drive_{k + 1:02}.csv"
                field.write_drive(str(own), k)
                self.assertEqual(own.read_bytes(), (pathlib.Path(folder) / theirs).read_bytes())
            return field

    def test_one_field(self):
        field = self.compare("")
        self.assertGreater(field.figures["level_Pa"], 1000)
        self.assertGreater(field.figures["fingertipForce_N"], 1e-4)
        self.assertIn(field.feeling, ("faint", "clear", "strong"))
        self.assertEqual(self.compare("--feel-threshold 1", [("feelThreshold", "1 N")]).feeling, "too weak to feel")

    def test_settings_and_properties(self):
        self.compare("--sampling vertices --max-pressure 300", [("maxPressure", "300 Pa")], [("sampling", "vertices")])

    def test_one_focus_is_asked_about_and_no_louder_than_a_point_of_the_whole(self):
        levels = {}
        for size in (0.1, 4e-5):
            scene = midair.Scene("octagon")
            scene.add_file(STAR, size=size)
            levels[size] = scene.solve().figures["level_Pa"]
            told = any("under half a wavelength" in message.text for message in scene.messages)
            self.assertEqual(told, size < 0.01)
        self.assertLess(levels[4e-5], levels[0.1])
        self.assertGreater(levels[4e-5], 100)

    def test_a_cycle(self):
        self.assertEqual(self.compare("--cycle 3", [("cycle", 3)]).fields, 3)


class Arguments(unittest.TestCase):
    def fails(self, status, call, *arguments):
        with self.assertRaises(midair.Error) as caught:
            call(*arguments)
        self.assertEqual(caught.exception.status, status, str(caught.exception))
        self.assertGreater(len(str(caught.exception)), 5)

    def test_wrong_values(self):
        scene, points = focus()
        self.fails("refused", midair.Array, "nosuch")
        self.fails("unknown", scene.__setitem__, "cycel", 2)
        self.fails("invalid", scene.__setitem__, "cycle", 1000)
        self.fails("invalid", scene.add_points, [[0.0, np.nan, 0.1]])
        self.fails("invalid", scene.add_points, [[0.0, 0.0, 0.1]], [-5.0], True)
        self.fails("invalid", points.set_pose, 2.0 * np.eye(4))
        self.fails("invalid", scene.add_mesh, np.zeros((3, 3)), [[0, 1, 3]])
        self.fails("refused", scene.add_file, "/nosuch.obj")
        self.fails("not yet", scene.update, 0.0)
        self.fails("not yet", scene.newest_field)
        self.fails("refused", scene.play, "no uri")
        self.fails("invalid", scene.solve().pressures, [[np.inf, 0.0, 0.0]])
        self.fails("unknown", scene.solve().activations, 7)

    def test_wrong_shapes_and_types(self):
        scene, points = focus()
        for call, arguments in (
            (scene.add_points, ([[0.0, 0.0]],)),
            (scene.add_points, (np.zeros((2, 3)), [1.0])),
            (scene.add_mesh, (np.zeros((3, 3)), [0, 1, 2])),
            (scene.add_mesh, (np.zeros((3, 3)), [[0, 1, 2]], [1.0])),
            (points.set_pose, (np.eye(3),)),
            (scene.solve().felt, (np.zeros((2, 2)),)),
            (midair.hand, (0, [0.0, 0.0])),
        ):
            with self.assertRaises(ValueError, msg=str(call)):
                call(*arguments)
        with self.assertRaises((TypeError, ValueError)):
            scene.add_points("points")
        with self.assertRaises(TypeError):
            scene.set_hands(None)
        with self.assertRaises(TypeError):
            midair.Scene(None)

    def test_closed_ones(self):
        scene, points = focus()
        field = scene.solve()
        solver = midair.Solver(scene, midair.Array("board"))
        field.close()
        solver.close()
        scene.close()
        scene.close()
        for call in (scene.solve, scene.cancel, scene.stop, lambda: scene["cycle"], lambda: points["side"], points.remove,
                     field.activations, lambda: field.figures, lambda: field.points, lambda: scene.state,
                     lambda: solver.solve([0.0, 0.0, 0.1], [1.0])):
            self.fails("closed", call)

    def test_silence_is_no_error(self):
        scene, points = focus()
        scene["maxPressure"] = "0.01 Pa"
        field = scene.solve()
        self.assertTrue(field.silent)
        self.assertIn("maxPressure", field.why)
        self.assertFalse(field.activations().any())

    def test_settings_are_listed(self):
        names = [name for name, _ in midair.settings()]
        self.assertIn("maxPressure", names)
        self.assertIn("material", [name for name, _ in midair.properties()])
        scene, points = focus()
        for name in names:
            scene[name]  # each can be read


class Memory(unittest.TestCase):
    def test_a_view_outlives_its_field(self):
        scene, _ = focus()
        field = scene.solve()
        view = field.activations()
        self.assertFalse(view.flags.owndata)
        self.assertFalse(view.flags.writeable)
        kept = view.copy()
        field.close()
        del field
        scene.close()
        gc.collect()
        focus()[0].solve()
        np.testing.assert_array_equal(view, kept)
        self.assertTrue(np.isfinite(view).all())

    def test_arguments_are_copied(self):
        scene = midair.Scene("board")
        places = np.array([[0.0, 0.0, 0.15], [0.02, 0.0, 0.15]])
        scene.add_points(places)
        first = scene.solve().activations().copy()
        places[:] = np.nan
        np.testing.assert_array_equal(scene.solve().activations(), first)

    def test_strided_and_other_numbers_are_converted(self):
        wide = np.zeros((2, 6), np.float32)
        wide[:, 4] = 0.15  # every second column: 0, 0, 0.15
        scene = midair.Scene("board")
        scene.add_points(wide[:1, ::2])
        self.assertAlmostEqual(scene.solve().points["position"][0][2], 0.15, 6)

    def test_pressures_are_the_model(self):
        scene, _ = focus()
        field = scene.solve()
        p = field.pressures([[0.0, 0.0, 0.15]])
        self.assertEqual(p.dtype, np.complex64)
        self.assertAlmostEqual(abs(p[0]) / field.points["achieved_Pa"][0], 1.0, 3)
        self.assertAlmostEqual(float(field.felt([0.0, 0.0, 0.15])[0]) / abs(p[0]), 1.0, 5)


class Many(unittest.TestCase):
    def test_solve_many(self):
        k, n = 30, 3
        across = np.linspace(-0.01, 0.01, k)[:, None] + np.array([-0.02, 0.0, 0.02])
        positions = np.stack([across, np.zeros((k, n)), np.full((k, n), 0.15)], axis=2)
        scene = midair.Scene("board")
        phases, levels, figures = scene.solve_many(positions, figures=True)
        self.assertEqual((phases.shape, phases.dtype, levels), ((k, 249), np.uint8, 256))
        self.assertEqual(figures.shape, (k,))
        self.assertLess(figures["rms"].max(), 0.011)
        # By the formula alone, without directivity and air.
        places = midair.Array("board").transducers["position"]
        r = np.linalg.norm(positions[-1][:, None] - places[None], axis=2)
        p = np.abs((np.exp(2j * np.pi * (phases[-1] / levels - r * 40e3 / 343.2)) / r).sum(axis=1))
        self.assertLess(p.std() / p.mean(), 0.05)
        self.assertGreater(p.min(), 0.4 * (1 / r).sum(axis=1).mean() / np.sqrt(n))
        # Independent fields are the same in any order; no figures, no array of them.
        alone, _, none = scene.solve_many(positions[:1], path=1)
        self.assertIsNone(none)
        np.testing.assert_array_equal(alone[0], phases[0])
        fading = np.linspace(1.0, 0.0, k)[:, None] * [1, 0, 0] + [0, 1, 1]
        _, _, figures = scene.solve_many(positions, fading, tolerance=0.003, phase_step=1.0, seed=3, figures=True)
        self.assertLess(figures["phase_step_rad"].max(), 1.0)

    def test_wrong_arguments(self):
        scene = midair.Scene("board")
        good = np.full((2, 3, 3), 0.1) + 0.01 * np.arange(3)
        for positions in (good[0], good[..., :2], 5.0):
            with self.assertRaises(ValueError):
                scene.solve_many(positions)
        for targets in (np.ones(2), np.ones((3, 3)), np.ones((2, 3, 1))):
            with self.assertRaises(ValueError):
                scene.solve_many(good, targets)
        for wrong in ({"tolerance": 1.0}, {"phase_step": 0.01}, {"targets": [1, -1, 1]}, {"targets": [0, 0, 0]}):
            with self.assertRaises(midair.Error) as raised:
                scene.solve_many(good, **wrong)
            self.assertEqual(raised.exception.status, "invalid")
        with self.assertRaises(midair.Error):
            scene.solve_many(np.zeros((0, 3, 3)))
        with self.assertRaises(midair.Error):
            scene.solve_many(good * np.nan)


class Extending(unittest.TestCase):
    def test_solver(self):
        problems = []

        def conjugate(problem):
            problems.append(problem)
            return np.exp(-1j * np.angle(problem.matrix[0]))

        midair.register_solver("conjugate", conjugate)
        scene, _ = focus()
        scene["solver"] = "conjugate"
        field = scene.solve()
        self.assertAlmostEqual(field.figures["loudness"], 1.0, 2)
        self.assertEqual(problems[0].matrix.shape, (1, 249))
        self.assertTrue(problems[0].stopped)  # and is no dangling pointer
        np.testing.assert_allclose(problems[0].positions, [[0.0, 0.0, 0.15]])
        with self.assertRaises(midair.Error):
            midair.register_solver("conjugate", conjugate)
        with self.assertRaises(TypeError):
            midair.register_solver("nothing", 5)

    def test_a_scene_that_plays_says_what_its_solver_raised(self):
        midair.register_solver("raising", lambda problem: 1 / 0)
        scene, _ = focus()
        scene["solver"] = "raising"
        scene.play("sim:")
        self.assertTrue(updates_until(scene, lambda: says(scene, "ZeroDivisionError: division by zero")), scene.messages)
        self.assertTrue(updates_until(scene, lambda: scene.state["state"] == "silent"), scene.state)
        field = scene.newest_field()
        self.assertTrue(field.silent)
        self.assertIn('solver "raising" has failed: ZeroDivisionError', field.why)
        scene.close()

    def test_devices_and_hands_that_raise_are_named(self):
        class Broken:
            def play(self, phases, amplitudes):
                raise OSError("no power")

            def silence(self):
                pass

            def hands(self, now):
                return np.zeros(3)

        midair.register_device("broken", lambda path, options, boards: Broken())
        midair.register_hands("broken", lambda options: Broken())
        scene, _ = focus()
        scene["reach"] = "2 cm"
        scene.open_hands("broken:")
        scene.play("broken:")
        self.assertTrue(updates_until(
            scene, lambda: says(scene, "what hands() returns has to be an array of midair.hand_dtype, not an array of float64")),
            scene.messages)
        scene["reach"] = 0
        scene.open_hands("none")
        self.assertTrue(updates_until(scene, lambda: says(scene, "OSError: no power")), scene.messages)
        scene.close()

    def test_device_and_hands(self):
        played = []

        class Device:
            def play(self, phases, amplitudes):
                played.append((phases, amplitudes))

            def silence(self):
                played.append(None)

        class Still:
            def hands(self, now):
                return midair.hand(0, [0.0, 0.0, 0.151])

        midair.register_device("pyboard", lambda path, options, boards: Device(), phase_levels=32)
        midair.register_hands("still", lambda options: Still() if options == "here" else None)
        with midair.Scene("board") as scene:
            scene.add_points([0.0, 0.0, 0.15])
            scene["reach"] = "2 cm"
            with self.assertRaises(midair.Error):
                scene.open_hands("still:there")
            scene.open_hands("still:here")
            scene.play("pyboard:one")
            self.assertTrue(updates_until(scene, lambda: any(played)), scene.messages)
            self.assertTrue(updates_until(scene, lambda: len(scene.hands) == 1), scene.messages)
            self.assertEqual(scene.hands.dtype, midair.hand_dtype)
            self.assertEqual(scene.hands["id"][0], 0)
        fields = [one for one in played if one]
        self.assertLess(fields[0][0].max(), 32)
        self.assertIsNone(played[-1])  # silent at the end


class Messages(unittest.TestCase):
    """A message is active until what it says has ended."""

    def test_of_mistakes_that_are_mended(self):
        def far(z):
            pose = np.eye(4)
            pose[2, 3] = z
            return pose

        for code, make, mend in (
            ("settings.silenced", lambda s, p: s.__setitem__("maxPressure", "loud"), lambda s, p: s.__setitem__("maxPressure", 0)),
            ("property.silenced", lambda s, p: p.__setitem__("enabled", "loud"), lambda s, p: p.__setitem__("enabled", "true")),
            ("object.unreachable", lambda s, p: p.set_pose(far(40.0)), lambda s, p: p.set_pose(far(0.0))),
            ("solver.unknown", lambda s, p: s.__setitem__("solver", "nosuch"), lambda s, p: s.__setitem__("solver", "gauss-newton")),
        ):
            with self.subTest(code), focus()[0] as scene:
                points = scene.add_points([0.0, 0.0, 0.01])
                told = {}
                scene.on_message(lambda message, told=told: told.__setitem__(message.code, message.active))
                scene.play("sim:")
                plays = lambda: scene.state["state"] == "playing"
                self.assertTrue(updates_until(scene, plays), scene.messages)
                self.assertEqual(scene.active_messages, [])
                try:
                    make(scene, points)
                except midair.Error:
                    pass
                self.assertTrue(self.updates_until(scene, lambda: told.get(code) is True), scene.messages)
                self.assertEqual([message.code for message in scene.active_messages], [code])
                mend(scene, points)
                self.assertTrue(updates_until(scene, lambda: told[code] is False and plays()))
                self.assertEqual(scene.active_messages, [])
                kept = [message for message in scene.messages if message.code == code]
                self.assertEqual(len(kept), 1)
                self.assertFalse(kept[0].active)
                self.assertLessEqual(kept[0].since, kept[0].until)
                self.assertLessEqual(kept[0].until, time.monotonic())
                self.assertIn(code, repr(kept[0]))
                scene.clear_messages()
                self.assertEqual(scene.messages, [])
                scene.on_message(None)

    def updates_until(self, scene, reached):
        """As updates_until(), where an update may fail."""
        for _ in range(4000):
            try:
                scene.update(time.monotonic() - BEGIN)
            except midair.Error as error:
                self.assertIn("loud", str(error))
            if reached():
                return True
            time.sleep(0.005)
        return False


class Sensations(unittest.TestCase):
    """What designers draw plays when the program says so."""

    def test_one_plays_and_stops(self):
        with midair.Scene("board") as scene:
            circle = scene.add_sensation("circle?radius=10mm")
            circle["pressure"], circle["trigger"], circle["parameters"] = "500 Pa", "program", "radius=8"
            pose = np.eye(4)
            pose[2, 3] = 0.15
            circle.set_pose(pose)
            scene.play("sim:")
            now = 0.0

            def comes(reached):
                nonlocal now
                for _ in range(4000):
                    now += 0.01
                    scene.update(now)
                    if reached(scene.sensations):
                        return True
                    time.sleep(0.005)
                return False

            self.assertTrue(comes(lambda all: len(all) == 1 and not all[0]["playing"]))
            circle.play()
            self.assertTrue(comes(lambda all: all[0]["intensity"] >= 1.0), scene.messages)
            place = scene.sensations[0]["position"]
            self.assertAlmostEqual(np.hypot(place[0], place[1]), 0.008, places=6)
            circle.stop()
            self.assertTrue(comes(lambda all: not all[0]["playing"]))
            with self.assertRaises(midair.Error) as refused:
                scene.add_sensation("cirle")
            self.assertIn("circle", str(refused.exception))


class Forces(unittest.TestCase):
    """A touch has a force while the array plays, and at no other time."""

    def setUp(self):
        self.scene = midair.Scene("octagon")
        corners = 0.03 * np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], dtype=float)
        plate = self.scene.add_mesh(corners, [[0, 2, 1], [0, 3, 2]])
        plate["touchEvents"] = True
        plate["spacing"] = "15 mm"
        self.hand = midair.hand(1, [0, 0.005, 0], orientation=[-np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
        self.now = 0.0

    def tearDown(self):
        self.scene.close()

    def update(self):
        self.now += 0.01
        self.scene.set_hands(self.hand)
        self.scene.update(self.now)
        time.sleep(0.005)

    def force(self):
        touches = [touch for touch in self.scene.touches if touch["touching"]]
        return max((touch["force_N"] for touch in touches), default=-1.0)

    def comes(self, reached):
        for _ in range(4000):
            self.update()
            if reached():
                return True
        return False

    def test_none_while_it_is_silent(self):
        self.scene.play("sim:")
        for name, silent, loud in ("mute", True, False), ("maxAmplitude", 0, 1), ("maxPressure", "0.01 Pa", 0):
            self.assertTrue(self.comes(lambda: self.force() > 0), self.scene.messages)
            change = self.scene.mute if name == "mute" else lambda value, name=name: self.scene.__setitem__(name, value)
            change(silent)
            for _ in range(5):
                self.update()
                self.assertEqual(self.force(), 0.0, name)
            change(loud)
        self.assertTrue(self.comes(lambda: self.force() > 0))
        with self.assertRaises(midair.Error):
            self.scene["maxPressure"] = "loud"
        with self.assertRaises(midair.Error):
            self.update()
        self.assertEqual(self.force(), -1.0, "safety silences it: nothing is touched")

    def test_none_without_an_array(self):
        for device, state in ("record:/nosuch/folder/file", "closed"), ("sim:?drop=1", "fault"):
            self.scene.play(device)
            self.assertTrue(self.comes(lambda: self.force() >= 0 and self.scene.state["state"] == state), device)
            for _ in range(50):
                self.update()
                self.assertEqual(self.force(), 0.0, device)


class Threads(unittest.TestCase):
    def test_python_runs_while_a_field_is_solved(self):
        scene = midair.Scene("octagon")
        scene.add_file(STAR, size=0.08)
        scene["solver"] = "slow"
        begun, turned = threading.Event(), threading.Event()
        outcomes = []

        def solve(problem):
            begun.set()
            outcomes.append(turned.wait(60))
            return np.ones(problem.matrix.shape[1])

        midair.register_solver("slow", solve)
        thread = threading.Thread(target=scene.solve)
        thread.start()
        self.assertTrue(begun.wait(60))
        self.assertTrue(thread.is_alive())
        turned.set()
        thread.join(60)
        self.assertTrue(outcomes and all(outcomes), "this thread went on in the middle of the solve")

    def test_scenes_from_many_threads(self):
        scene, points = focus()
        failures = []

        def work(number):
            try:
                for k in range(5):
                    scene["temperature"] = 15 + (number + k) % 10
                    scene.solve().activations().sum()
                    scene.state
            except Exception as failure:  # what fails here would be lost
                failures.append(failure)

        threads = [threading.Thread(target=work, args=(number,)) for number in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failures, [])

    def test_python_ends_while_a_scene_plays(self):
        program = (
            "import midair, time, numpy as np\n"
            "midair.register_solver('own', lambda p: np.ones(p.matrix.shape[1]))\n"
            "s = midair.Scene('board'); s.add_points([0.0, 0.0, 0.15]); s['solver'] = 'own'; s.play('sim:')\n"
            "for k in range(200):\n"
            "    s.update(0.01 * k); time.sleep(0.01)\n"
            "    if s.state['state'] == 'playing': break\n"
            "print(s.state['state'])\n"
        )
        ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertEqual(ended.stdout.strip(), "playing")


if __name__ == "__main__":
    unittest.main()
