"""What a program in Python meets: docstrings, types, words of errors, Ctrl-C, pickles."""

import ast
import inspect
import os
import pathlib
import pickle
import re
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import midair

ROOT = pathlib.Path(os.environ["MIDAIR_ROOT"])
STUB = ast.parse((pathlib.Path(midair.__file__).parent / "__init__.pyi").read_text())
SHAPE = re.compile(r"\([a-z0-9](, [a-z0-9])*,?\)")
UNIT = re.compile(r"\b(m|s|Pa|Hz|ms)\b")
PYTHONS = {"__module__", "__doc__", "__getstate__", "__setstate__"}


def focus(array="board"):
    scene = midair.Scene(array)
    return scene, scene.add_points([0.0, 0.0, 0.15])


def classes():
    return {name: one for name, one in vars(midair).items() if inspect.isclass(one)}


def functions():
    return {name: one for name, one in vars(midair).items() if inspect.isbuiltin(one)}


def members(one):
    """What a program can see of a class that this module has defined."""
    slot = type(object.__init__)
    return {name for name, member in vars(one).items() if name not in PYTHONS and not isinstance(member, slot)}


def stubs(kind, body=None):
    return {node.name: node for node in (STUB if body is None else body).body if isinstance(node, kind)}


def told(node):
    """Parameters of a function of the stub, with their defaults, as inspect says them."""
    names = [argument.arg for argument in node.args.args]
    defaults = [ast.unparse(default) for default in node.args.defaults]
    plain = names[: len(names) - len(defaults)]
    return plain + [f"{name}={default}" for name, default in zip(names[len(plain):], defaults)]


def found(function):
    return [
        name if one.default is inspect.Parameter.empty else f"{name}={one.default!r}"
        for name, one in inspect.signature(function).parameters.items()
    ]


class Types(unittest.TestCase):
    def test_the_stub_has_all_names_and_no_others(self):
        own = set(classes()) | set(functions())
        typing = {"State", "Device", "HandSource", "HeadSource"}
        self.assertEqual(set(stubs((ast.FunctionDef, ast.ClassDef))) - typing, own)
        for name, one in classes().items():
            if name != "Error":
                self.assertEqual(set(stubs(ast.FunctionDef, stubs(ast.ClassDef)[name])), members(one), name)
        self.assertTrue((pathlib.Path(midair.__file__).parent / "py.typed").is_file())

    def test_parameters_and_defaults_are_those_of_the_stub(self):
        looked = 0
        for name, node in stubs(ast.FunctionDef).items():
            self.assertEqual(told(node), found(getattr(midair, name)), name)
        for name, one in classes().items():
            for member, node in stubs(ast.FunctionDef, stubs(ast.ClassDef)[name]).items():
                if any(getattr(decorator, "id", "") == "property" for decorator in node.decorator_list):
                    self.assertIsInstance(inspect.getattr_static(one, member), property, f"{name}.{member}")
                else:
                    self.assertEqual(told(node), found(getattr(one, member)), f"{name}.{member}")
                looked += 1
        self.assertGreater(looked, 70)
        self.assertEqual(str(inspect.signature(midair.Scene)), "(array)")
        self.assertEqual(str(inspect.signature(focus()[0].solve)), "(raise_if_silent=False)")

    def test_the_states_are_those_of_all_languages(self):
        header = (ROOT / "engine-bridge" / "c" / "midair_play.h").read_text()
        kit = (ROOT / "engine-bridge" / "include" / "osgMidair" / "ArrayState").read_text()
        names = [name.lower() for name in re.findall(r"MIDAIR_STATE_([A-Z]+) = ", header)]
        self.assertEqual(names, [name.lower() for name in re.findall(r"^    ([A-Z]+),? +///<", kit, re.M)][: len(names)])
        literal = ast.unparse(stubs(ast.ClassDef)["State"].body[0].annotation)
        self.assertEqual(re.findall(r"'([a-z]+)'", literal), names)
        self.assertEqual(focus()[0].state["state"], names[0])


class Docstrings(unittest.TestCase):
    def documented(self):
        for name, one in functions().items():
            yield name, one, stubs(ast.FunctionDef)[name]
        for name, one in classes().items():
            self.assertGreater(len(one.__doc__ or ""), 30, name)
            for member, node in stubs(ast.FunctionDef, stubs(ast.ClassDef)[name]).items():
                yield f"{name}.{member}", inspect.getattr_static(one, member), node

    def test_each_member_has_one_with_shapes_and_units(self):
        for name, one, node in self.documented():
            doc = getattr(one, "__func__", one).__doc__ or ""
            self.assertGreater(len(doc), 15, name)
            self.assertNotRegex(doc, r"::|std|\(self", name)
            kinds = ast.unparse(node)
            if re.search("NDArray|ArrayLike", kinds):
                self.assertRegex(doc, SHAPE, name)
            if {argument.arg for argument in node.args.args} & {"places", "positions", "vertices", "matrix", "tip", "size", "time"}:
                self.assertRegex(doc, UNIT, name)

    def test_origins_are_told(self):
        for one in (midair.Array, midair.Scene):
            self.assertIn("the middle of its own plane", one.__doc__)
            self.assertIn("the centre of its workspace", one.__doc__)


class Words(unittest.TestCase):
    def test_reprs_have_what_matters(self):
        scene, points = focus()
        field = scene.solve()
        self.assertEqual(repr(midair.Array("board")), '<midair.Array "board", 249 transducers>')
        self.assertEqual(repr(scene), '<midair.Scene on "board", device closed>')
        self.assertRegex(repr(points), r'<midair.Object \d+ of a scene on "board">')
        self.assertRegex(repr(field), r"<midair.Field: 1 points, 249 transducers, 1 field, \d+ Pa, gauss-newton [a-z ]+>")
        self.assertEqual(repr(midair.Solver(scene, midair.Array("board"))), "<midair.Solver for 249 transducers>")
        points.remove()
        self.assertEqual(repr(scene.solve()), "<midair.Field: 0 points, 249 transducers, 1 field, silent: there are no control points>")
        field.close()
        scene.close()
        self.assertEqual([repr(one) for one in (field, scene)], ["<midair.Field, closed>", "<midair.Scene, closed>"])

    def test_errors_have_no_names_of_cpp(self):
        scene, points = focus()
        field = scene.solve()
        wrong = [
            (midair.Scene, None), (midair.Scene, 5), (midair.Array, 5), (midair.Array.make, "a", [1.0, 2.0]),
            (midair.Solver, scene, "board"), (midair.Field.from_bytes, "text"), (midair.hand, "left", [0, 0, 0]),
            (midair.register_solver, "x", 5), (midair.register_device, "x", 5), (midair.register_hands, "x", None),
            (midair.register_device, "x", print, "many"), (midair.register_device, "x", print, 256, "loud"),
            (scene.add_points, "points"), (scene.add_points, None), (scene.add_mesh, [[0, 0, 0]], "abc"),
            (scene.add_mesh, [[0, 0, 0]], [[0.0, 0.0, 0.0]]), (scene.add_file, 5), (scene.set_hands, None),
            (scene.set_hands, np.zeros(2)), (scene.update, "now"), (scene.mute, "yes"), (scene.play, 5), (scene.solve, 1, 2),
            (scene.__setitem__, 5, 5), (points.set_pose, "here"), (field.felt, None), (field.activations, 1.5), (field.write_drive, None),
        ]
        for call, *arguments in wrong:
            with self.assertRaises((TypeError, ValueError), msg=f"{call} {arguments}") as caught:
                call(*arguments)
            self.assertNotRegex(str(caught.exception), r"::|std|C\+\+|[Uu]nable to cast|midair_", call)

    def test_whole_numbers_are_looked_at_before_they_wrap(self):
        scene, _ = focus()
        corners = np.zeros((3, 3))
        for index in (-1, 2**32, 2**63):
            with self.assertRaisesRegex(midair.Error, f"an index of triangles is {index}; it must be 0 .. 4294967295"):
                scene.add_mesh(corners, np.array([[0, 1, index]], dtype=np.uint64 if index > 2**62 else np.int64))
        with self.assertRaisesRegex(midair.Error, "index is -1; it must be 0 .. "):
            scene.solve().activations(-1)
        with self.assertRaisesRegex(midair.Error, "id is 4294967296; it must be -2147483648 .. 2147483647"):
            midair.hand(2**32, [0.0, 0.0, 0.0])
        with self.assertRaisesRegex(midair.Error, "phase_levels is 65536; it must be 0 .. 256"):
            midair.register_device("wraps", print, phase_levels=65536)

    def test_shapes_are_told(self):
        scene, points = focus()
        for words, call, *arguments in (
            ("positions has to have the shape (n, 3), not (1, 2)", scene.add_points, [[0.0, 0.0]]),
            ("pressures has to have one number for each point, the shape (1,), not (1, 1)", scene.add_points, [0.0, 0.0, 0.1], [[1.0]]),
            ("triangles has to have the shape (n, 3), not (3,)", scene.add_mesh, np.zeros((3, 3)), [0, 1, 2]),
            ("matrix has to have the shape (4, 4), not (3, 3)", points.set_pose, np.eye(3)),
            ("tip has to have the shape (3,), not (1, 3)", midair.hand, 0, [[0.0, 0.0, 0.0]]),
        ):
            with self.assertRaises(ValueError) as caught:
                call(*arguments)
            self.assertEqual(str(caught.exception), words)


class Mappings(unittest.TestCase):
    def test_in_and_iteration(self):
        scene, points = focus()
        for one, names, known in (scene, midair.settings(), "maxPressure"), (points, midair.properties(), "pressure"):
            self.assertEqual(list(one), [name for name, _ in names])
            self.assertEqual(len(one), len(names))
            self.assertIn(known, one)
            self.assertNotIn("nosuch", one)
            self.assertNotIn(5, one)
            self.assertEqual(dict(one)[known], one[known])

    def test_paths(self):
        model = ROOT / "samples" / "models" / "star.obj"
        with tempfile.TemporaryDirectory() as folder:
            scene = midair.Scene(ROOT / "haptics" / "array" / "arrays" / "ultraino64.json")
            self.assertEqual(len(midair.Array(ROOT / "haptics" / "array" / "arrays" / "ultraino64.json")), 64)
            scene.add_file(model, size=0.05)
            scene.add_file(os.fsencode(model), size=0.05)
            drive = pathlib.Path(folder) / "drive.csv"
            scene.solve().write_drive(drive)
            self.assertGreater(drive.stat().st_size, 1000)


class Pickles(unittest.TestCase):
    def compare(self, field):
        again = pickle.loads(pickle.dumps(field))
        places = np.random.default_rng(1).uniform(-0.05, 0.05, (20, 3)) + [0.0, 0.0, 0.15]
        self.assertEqual(again.figures, field.figures)
        for k in range(field.fields):
            np.testing.assert_array_equal(again.activations(k), field.activations(k))
            np.testing.assert_array_equal(again.levels(k), field.levels(k))
            np.testing.assert_array_equal(again.pressures(places, k), field.pressures(places, k))
        np.testing.assert_array_equal(again.felt(places), field.felt(places))
        np.testing.assert_array_equal(again.points, field.points)
        for name in "fields transducers rate frame latency_ms playing solver stop message silent why".split():
            self.assertEqual(getattr(again, name), getattr(field, name), name)
        self.assertEqual(again.to_bytes(), field.to_bytes())
        self.assertEqual(pickle.loads(pickle.dumps(field.figures)), field.figures)
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(field.points)), field.points)

    def test_a_field(self):
        scene, _ = focus()
        scene.add_points([[0.02, 0.0, 0.16], [0.0, 0.02, 0.14]])
        scene["dead"] = "17"
        self.compare(scene.solve())

    def test_fields_in_turn_and_ears(self):
        scene = midair.Scene("octagon")
        scene.add_file(ROOT / "samples" / "models" / "star.obj", size=0.08)
        scene["cycle"] = 2
        scene["earPoints"] = "0 0.3 0.6"
        self.compare(scene.solve())

    def test_silence(self):
        self.compare(midair.Scene("board").solve())

    def test_what_is_no_field(self):
        data = focus()[0].solve().to_bytes()
        for wrong in (b"", b"nothing", data[:-1], data[: len(data) // 2], data.replace(b"midair_field", b"midair_fiend")):
            with self.assertRaisesRegex(midair.Error, "the bytes are not those of a field"):
                midair.Field.from_bytes(wrong)


class Failing(unittest.TestCase):
    def raises(self, name, solver, words):
        midair.register_solver(name, solver)
        for cycle in 1, 2:
            scene = midair.Scene("board")
            star = scene.add_file(ROOT / "samples" / "models" / "star.obj", size=0.05)
            star.set_pose([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.15], [0, 0, 0, 1]])
            scene["solver"] = name
            scene["cycle"] = cycle
            with self.assertRaisesRegex(midair.Error, words) as caught:
                scene.solve()
            self.assertEqual(caught.exception.status, "failed")
        scene, _ = focus()
        scene["solver"] = name
        one = midair.Solver(scene, midair.Array("board"))
        with self.assertRaisesRegex(midair.Error, words) as caught:
            one.solve([0.0, 0.0, 0.1], [1.0])
        self.assertEqual(caught.exception.status, "failed")

    def test_a_solver_that_raises_is_named(self):
        self.raises("divides", lambda problem: 1 / 0,
                    r'solver "divides" has failed: ZeroDivisionError: division by zero \(.*interface_test.py:\d+\)')

    def test_wrong_shapes_are_refused_by_shape(self):
        wrong = r"the solver returned an array of the shape \(%s\); it has to return the shape \(249,\), complex"
        self.raises("few", lambda problem: [1.0, 2.0], wrong % "2,")
        self.raises("column", lambda problem: np.ones((249, 1)), wrong % "249, 1")
        self.raises("none", lambda problem: None, "the solver returned a NoneType; it has to return")
        self.raises("words", lambda problem: "loud", "the solver returned a str; it has to return")
        self.raises("loud", lambda problem: np.full(249, 2.0), "its activation 0 is 2.0i; it must be finite".replace("2.0i", r"2\+0i"))

    def test_silence_raises_where_it_is_asked_to(self):
        scene, points = focus()
        points.remove()
        self.assertTrue(scene.solve().silent)
        self.assertTrue(scene.solve(raise_if_silent=False).silent)
        with self.assertRaisesRegex(midair.Error, "there are no control points") as caught:
            scene.solve(raise_if_silent=True)
        self.assertEqual(caught.exception.status, "silent")


class CtrlC(unittest.TestCase):
    TURNS = 10**9

    def interrupted(self, name, solve):
        """Presses Ctrl-C once a solver in Python is at work, which by itself would take hours."""
        begun = threading.Event()

        def presses():
            begun.wait(60)
            os.kill(os.getpid(), signal.SIGINT)

        turns = []

        def endless(problem):
            begun.set()
            for turn in range(self.TURNS):
                turns[:] = [turn]
                if solve == "looks" and problem.stopped:
                    break
            return np.ones(problem.matrix.shape[1])

        midair.register_solver(name, endless)
        scene, _ = focus()
        scene["solver"] = name
        call = scene.solve
        if solve == "solver":
            one = midair.Solver(scene, midair.Array("board"))
            call = lambda: one.solve([0.0, 0.0, 0.1], [1.0])  # noqa: E731
        thread = threading.Thread(target=presses)
        thread.start()
        with self.assertRaises(KeyboardInterrupt):
            call()
        thread.join()
        self.assertLess(turns[0], self.TURNS - 1, "it ended before the solve")
        scene["solver"] = "gs"
        self.assertFalse(scene.solve().silent, "and the next solve is one")

    def test_a_solver_that_looks_whether_it_is_stopped(self):
        self.interrupted("looks", "looks")

    def test_a_solver_that_does_not_look(self):
        self.interrupted("blind", "blind")

    def test_a_midair_solver(self):
        self.interrupted("blinder", "solver")

    def test_python_ends_after_one(self):
        program = (
            "import midair, os, signal, threading, numpy as np\n"
            "begun = threading.Event()\n"
            "def blind(problem):\n"
            "    begun.set()\n"
            "    for turn in range(10**9): pass\n"
            "    return np.ones(problem.matrix.shape[1])\n"
            "midair.register_solver('blind', blind)\n"
            "s = midair.Scene('board'); s.add_points([0.0, 0.0, 0.15]); s['solver'] = 'blind'\n"
            "threading.Thread(target=lambda: (begun.wait(), os.kill(os.getpid(), signal.SIGINT))).start()\n"
            "try: s.solve()\n"
            "except KeyboardInterrupt: print('broken off')\n"
        )
        ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
        self.assertEqual((ended.returncode, ended.stdout.strip(), ended.stderr), (0, "broken off", ""))

    def test_the_child_of_a_fork_solves(self):
        scene, _ = focus()
        scene.solve()  # on a thread that the child doesn't have
        child = os.fork()
        if child == 0:
            os._exit(0 if not focus()[0].solve().silent else 1)
        self.assertEqual(os.waitpid(child, 0)[1], 0)

    def test_a_wait_ends(self):
        begun = threading.Event()

        def never(problem):
            begun.set()
            while not problem.stopped:
                pass
            return np.ones(problem.matrix.shape[1])

        midair.register_solver("never", never)
        scene, _ = focus()
        scene["solver"] = "never"
        scene.play("sim:")
        scene.update(0.0)
        presses = threading.Thread(target=lambda: (begun.wait(60), os.kill(os.getpid(), signal.SIGINT)))
        with self.assertRaises(KeyboardInterrupt):
            presses.start()  # here, as the solver may be at work already
            scene.wait_field(3600)
        scene.close()

    def test_cancel_is_stopped(self):
        begun = threading.Event()

        def patient(problem):
            begun.set()
            while not problem.stopped:
                pass
            return np.ones(problem.matrix.shape[1])

        midair.register_solver("patient", patient)
        scene, _ = focus()
        scene["solver"] = "patient"
        outcomes = []

        def solves():
            try:
                scene.solve()
            except midair.Error as error:
                outcomes.append(error.status)

        thread = threading.Thread(target=solves)
        thread.start()
        begun.wait(60)
        scene.cancel()
        thread.join(60)
        self.assertEqual(outcomes, ["stopped"])


if __name__ == "__main__":
    unittest.main()
