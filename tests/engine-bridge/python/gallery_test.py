"""Each script of samples/python runs without a display, prints figures and writes its plot."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ["MIDAIR_ROOT"])
SCRIPTS = ROOT / "samples" / "python"
NAMES = ["star", "focus", "loudness", "cycle", "touch", "sensation", "own_solver"]


class Gallery(unittest.TestCase):
    def run_script(self, name):
        with tempfile.TemporaryDirectory() as folder:
            environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
            environment["MPLCONFIGDIR"] = folder
            ended = subprocess.run(
                [sys.executable, str(SCRIPTS / f"{name}.py"), "--out", folder],
                capture_output=True, text=True, timeout=300, env=environment,
            )
            self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)
            plot = pathlib.Path(folder) / f"{name}.png"
            self.assertGreater(plot.stat().st_size, 10000)
            self.assertEqual(plot.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            return ended.stdout

    def test_there_are_no_others(self):
        others = {script.stem for script in SCRIPTS.glob("*.py")} - {"gallery"}
        self.assertEqual(others, set(NAMES))


def add(name):
    setattr(Gallery, f"test_{name}", lambda self: self.assertGreater(len(self.run_script(name).splitlines()), 2))


for each in NAMES:
    add(each)

if __name__ == "__main__":
    unittest.main()
