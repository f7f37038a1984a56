#!/usr/bin/python3
"""What blocks.py has to find fault with. usage: blocks_test.py SOURCES BUILD"""

import argparse
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from blocks import Documents, Failure  # noqa: E402
from commands import Commands  # noqa: E402
from markdown import blocks_of  # noqa: E402

ROOT, BUILD = sys.argv[1:3]


def documents():
    return Documents(argparse.Namespace(root=ROOT, build=BUILD, prefix=None, long=False))


def done(text):
    """What is done with the only block of a document."""
    with tempfile.TemporaryDirectory() as folder:
        return documents().one(blocks_of("a.md", text)[0], pathlib.Path(folder))


class Blocks(unittest.TestCase):
    def test_no_known_language(self):
        for text in ("```\nls\n```\n", "```fortran\nEND\n```\n", "```cmake\nproject(a)\n```\n"):
            with self.assertRaises(Failure):
                done(text)

    def test_without_a_fence_or_an_end(self):
        for text in ("Do this:\n\n    ls\n", "```sh\nls\n"):
            with self.assertRaises(ValueError):
                blocks_of("a.md", text)
        self.assertEqual(blocks_of("a.md", "- a list\n\n    goes on\n"), [])

    def test_what_fails(self):
        for text in ("```sh\nfalse\n```\n", "```sh\nno-such-program\n```\n", "```json\n{1}\n```\n", "```csv\na,b\n1\n```\n",
                     "```ini\nno value\n```\n"):
            with self.assertRaises((Failure, ValueError)):
                done(text)
        self.assertEqual(done("```sh\ntrue\n```\n"), "run")

    def test_comments(self):
        self.assertEqual(done("<!-- not run: it is late -->\n```sh\n./samples/run.sh --help\n```\n"), "not run: it is late")
        self.assertEqual(done("<!-- file: a.json -->\n```json\n{}\n```\n"), "is a.json")
        with self.assertRaises(ValueError):
            blocks_of("a.md", "<!-- not run: -->\n```sh\nls\n```\n")

    def test_what_is_not_run_has_to_exist(self):
        commands = Commands(ROOT, pathlib.Path(BUILD) / "bin")
        self.assertEqual(commands.problem("build/bin/midair-solve a.obj --size 0.08"), "")
        self.assertEqual(commands.problem("MIDAIR_TIME_FACTOR=3 ./tests/run.sh --long"), "")
        self.assertIn("knows no --sise", commands.problem("build/bin/midair-solve a.obj --sise 0.08"))
        self.assertIn("knows no --nosuch", commands.problem("./tests/run.sh --nosuch"))
        self.assertIn("no program", commands.problem("build/bin/midair-nosuch"))
        self.assertIn("no source knows", commands.problem("OSG_MIDAIR_NOSUCHTHING=1 osgviewer a.osgt"))

    def test_fragments_of_cpp(self):
        some = documents()
        for text, is_right in (("scene->setMuted(true);", True), ("scene->setNothing(true);", False)):
            some.fragments = blocks_of("a.md", f"```cpp\n{text}\n```\n")
            if is_right:
                some.compile_fragments()
            else:
                self.assertRaises(Failure, some.compile_fragments)

    def test_pictures(self):
        name = "a picture"
        self.assertIn("isn't there", documents().prose("README.md", f"![{name}](samples/pictures/nosuch.png)")[0])
        self.assertIn("no script", documents().prose("README.md", f"![{name}](samples/pictures/star.png)")[0])
        self.assertEqual(documents().prose("README.md", f"`samples/pictures/make.sh`: ![{name}](samples/pictures/star.png)"), [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
