"""The wheel that a build makes: unpacked, or installed by pip where there is one, it is the module with all that it needs."""

import base64
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zipfile

FOLDER = pathlib.Path(os.environ["MIDAIR_WHEEL"])
PROGRAM = """
import importlib.metadata, pathlib, midair
here = pathlib.Path(midair.__file__).parent
assert str(here).startswith(FOLDER), here
scene = midair.Scene("ultraino64")
scene.add_points([0.0, 0.0, 0.1])["material"] = "rubber"
assert scene.solve().figures["level_Pa"] > 100
libraries = {line.split()[-1] for line in open("/proc/self/maps") if "libmidair" in line}
assert len(libraries) == 1 and libraries.pop().startswith(FOLDER), libraries
assert importlib.metadata.version("midair") == midair.__version__
assert (here / "py.typed").is_file() and (here / "__init__.pyi").is_file()
print(len(scene))
"""


class Wheel(unittest.TestCase):
    def setUp(self):
        wheels = list(FOLDER.glob("*.whl"))
        self.assertEqual(len(wheels), 1, wheels)
        self.wheel = wheels[0]

    def runs(self, folder):
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("OSG_MIDAIR", "LD_"))}
        environment["PYTHONPATH"] = folder
        program = f"FOLDER = {folder!r}\n" + PROGRAM
        ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, env=environment, cwd=folder)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertGreater(int(ended.stdout), 10)

    def test_unpacked_it_is_the_module(self):
        with tempfile.TemporaryDirectory() as folder:
            zipfile.ZipFile(self.wheel).extractall(folder)
            self.runs(folder)

    def test_its_record_is_right(self):
        with zipfile.ZipFile(self.wheel) as wheel:
            name = next(name for name in wheel.namelist() if name.endswith("RECORD"))
            rows = [row.rsplit(",", 2) for row in wheel.read(name).decode().splitlines()]
            self.assertEqual([row[0] for row in rows], wheel.namelist())
            for path, digest, size in rows[:-1]:
                content = wheel.read(path)
                wanted = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
                self.assertEqual((digest, size), ("sha256=" + wanted, str(len(content))), path)

    def test_pip_installs_it(self):
        if subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True).returncode != 0:
            self.skipTest("there is no pip")
        with tempfile.TemporaryDirectory() as folder:
            ended = subprocess.run(
                [sys.executable, "-m", "pip", "install", "--no-index", "--no-deps", "--target", folder, str(self.wheel)],
                capture_output=True, text=True, timeout=300)
            self.assertEqual(ended.returncode, 0, ended.stderr)
            self.runs(folder)


if __name__ == "__main__":
    unittest.main()
