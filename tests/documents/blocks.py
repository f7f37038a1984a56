#!/usr/bin/python3
"""Runs every fenced block of the project's documents, by its language, in a scratch folder that looks like the tree.

    blocks.py --root SOURCES --build BUILD [--long] [DOCUMENT..]
    blocks.py --root SOURCES --prefix PREFIX DOCUMENT..

sh: the blocks of a document one after the other, in one shell. cpp: whole programs are built and run, fragments compiled. c, python:
run. json, csv, ini: parsed. osgt: loaded by midair-check. text: left alone. Any other language, and a block without one, fails.

Comments right before a block say otherwise: <!-- not run: REASON -->, where its programs have to exist and to know the options;
<!-- long: REASON -->, the same without --long; <!-- given: COMMANDS --> makes what a reader has already; <!-- file: NAME --> writes the block
into a file for the commands that follow; <!-- ends: 0 or 2 --> says how its last command may end; <!-- where: tree --> and <!-- where: prefix -->.
Commands in the text (`build/bin/midair-.. --option`) have to exist, too, and each picture has to be there and to have its command named."""

import argparse
import concurrent.futures
import csv
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from commands import Commands, lines_of  # noqa: E402
from markdown import blocks_of, pictures_of, spans_of  # noqa: E402

FRAMES = "60"  # after which a viewer ends by itself (OSG_RUN_FRAME_COUNT)
SCENE = "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"


class Failure(Exception):
    pass


class Documents:
    def __init__(self, arguments):
        self.root = pathlib.Path(arguments.root).resolve()
        self.build = pathlib.Path(arguments.build).resolve() if arguments.build else None
        self.prefix = pathlib.Path(arguments.prefix).resolve() if arguments.prefix else None
        self.long = arguments.long
        self.commands = Commands(self.root, (self.prefix or self.build) / "bin")
        self.fragments = []

    # --- What a reader's shell has -----------------------------------------------------------------------------------------

    def environment(self, folder):
        home = folder / ".home"
        home.mkdir(exist_ok=True)
        found = {"PATH": "/usr/bin:/bin", "HOME": str(home), "LANG": "C.UTF-8", "OSG_RUN_FRAME_COUNT": FRAMES,
                 # Full screen without a window manager, OpenSceneGraph now and then loses its window.
                 "OSG_WINDOW": "0 0 320 240", "MPLCONFIGDIR": str(home),
                 "MPLBACKEND": "Agg", "PYTHONDONTWRITEBYTECODE": "1", "CCACHE_DIR": os.environ.get("CCACHE_DIR", os.path.expanduser("~/.ccache"))}
        found.update({name: os.environ[name] for name in ("DISPLAY", "XAUTHORITY", "CMAKE_CXX_COMPILER_LAUNCHER") if name in os.environ})
        if self.prefix: # as /usr/local is looked into by itself
            found["PKG_CONFIG_PATH"] = str(self.prefix / "lib/pkgconfig")
        if self.build:
            found["OSG_LIBRARY_PATH"] = str(self.build / "lib")
            found["PYTHONPATH"] = str(self.build / "lib/python")
            found["PATH"] = f"{self.build}/bin:" + found["PATH"]
        return found

    def scratch(self, folder):
        if self.prefix:
            return
        # Copies: what a document writes must not get into the sources.
        for name in ("samples", "haptics/array", "engine-bridge/c"):
            shutil.copytree(self.root / name, folder / name, ignore=shutil.ignore_patterns("pictures"))
        (folder / "build").symlink_to(self.build)

    def ran(self, block, command, folder, seconds=300, ends="0"):
        """Runs a command that may end with one of the numbers in ends; returns what it printed."""
        try:
            ended = subprocess.run(command, cwd=folder, env=self.environment(folder), capture_output=True, text=True, timeout=seconds,
                                   stdin=subprocess.DEVNULL)
        except subprocess.TimeoutExpired as expired:
            raise Failure(f"{block.place}: not done after {seconds} s: {expired.output or ''}") from None
        if str(ended.returncode) not in re.findall(r"\d+", ends):
            raise Failure(f"{block.place}: ended with {ended.returncode}\n{block.text}\n{ended.stdout[-3000:]}{ended.stderr[-3000:]}")
        return ended.stdout

    # --- Languages ---------------------------------------------------------------------------------------------------------

    def shell(self, block, folder):
        """Runs one block; what it exports and where it goes holds for the next ones."""
        state = folder / ".shell"
        text = block.text.replace("PREFIX=/usr/local", f"PREFIX={self.prefix}") if self.prefix else block.text
        script = f"[ ! -f {state} ] || . {state}\nset -ea\n{text}\nset +ea\n{{ export -p; echo cd \"'$PWD'\"; }} > {state}\n"
        self.ran(block, ["bash", "-c", script], folder, 1200 if "long" in block.marks else 300, block.marks.get("ends", "0"))

    def cplusplus(self, block, folder):
        if "int main(" not in block.text:
            self.fragments.append(block)
            return "compiled"
        for sample in sorted((self.root / "samples/features").glob("*.cpp")):
            if sample.read_text() == block.text:
                return f"is samples/features/{sample.name}"
        source = folder / "program.cpp"
        source.write_text(block.text)
        self.ran(block, [*self.compiler(), str(source), *self.linked(), "-o", str(folder / "program")], folder)
        self.ran(block, [str(folder / "program")], folder)
        return "built and run"

    def compiler(self):
        includes = [self.prefix / "include"] if self.prefix else [
            self.root / each for each in ("", "plugin/include", "plugin/extending/include", "plugin/overlays/include", "haptics/include",
                                          "engine-bridge/include")]
        return ["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", *(f"-I{each}" for each in includes), "-isystem", "/usr/include/bullet"]

    def linked(self):
        library = (self.prefix or self.build) / "lib"
        return [f"-L{library}", f"-Wl,-rpath,{library}", "-losgMidair", "-losgViewer", "-losgGA", "-losgDB", "-losgUtil", "-losg", "-lOpenThreads"]

    def compile_fragments(self):
        """All at once: reading the headers is what takes the time."""
        if not self.fragments:
            return
        text = f"#include \"{self.root}/tests/documents/preamble.h\"\n"
        text += "".join(sorted({line + "\n" for block in self.fragments for line in block.text.split("\n") if line.startswith("#include")}))
        for number, block in enumerate(self.fragments):
            body = re.sub(r"^#include.*", "", block.text, flags=re.MULTILINE)
            text += f"int fragment{number}(FRAGMENT_ARGUMENTS)\n{{\n{{\n#line {block.line + 1} \"{block.document}\"\n{body}}}\nreturn 0;\n}}\n"
        ended = subprocess.run([*self.compiler(), "-fsyntax-only", "-x", "c++", "-"], input=text, capture_output=True, text=True)
        if ended.returncode != 0:
            raise Failure(f"fragments of C++ aren't compiled:\n{ended.stderr[-4000:]}")

    def plain_c(self, block, folder):
        (folder / "program.c").write_text(block.text)
        library = (self.prefix or self.build) / "lib"
        header = self.prefix / "include/midair" if self.prefix else self.root / "engine-bridge/c"
        self.ran(block, ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{header}", "program.c", f"-L{library}", f"-Wl,-rpath,{library}",
                         "-lmidair", "-lm", "-o", "program-in-c"], folder)
        self.ran(block, ["./program-in-c"], folder)

    def python(self, block, folder):
        module = self.build / "lib/python" if self.build else self.prefix / "lib/python3/dist-packages"
        if not list(module.glob("midair/*.so")):
            return "not run: the Python module isn't built"
        self.ran(block, ["/usr/bin/python3", "-c", block.text], folder)
        return "run"

    def scene(self, block, folder):
        text = block.text
        if not text.startswith("#Ascii"):
            if "HapticScene {" not in text:
                text = "osgMidair::HapticScene { UniqueID 1 Children 1 {\n" + text + "} }\n"
            text = SCENE + text
        file = folder / "samples/scenes/block.osgt" if not self.prefix else folder / "block.osgt"
        file.write_text(text)
        self.ran(block, [str(self.commands.bin / "midair-check"), str(file)], folder)
        file.unlink()

    def data(self, block, folder):
        if block.language == "json":
            json.loads(block.text)
        elif block.language == "csv":
            rows = [row for row in csv.reader(io.StringIO(block.text)) if row]
            if len(rows) < 2 or len({len(row) for row in rows}) != 1:
                raise Failure(f"{block.place}: the rows have different numbers of columns")
        elif not all(re.fullmatch(r"\s*([\w.-]+\s*=\s*\S.*|\[.*\]|#.*)?", line) for line in block.text.split("\n")):
            raise Failure(f"{block.place}: a line isn't NAME = VALUE")

    # --- Blocks and documents ----------------------------------------------------------------------------------------------

    def one(self, block, folder):
        """Does with a block what its language and its comments say; returns what was done."""
        if block.language not in ("sh", "cpp", "c", "python", "osgt", "json", "csv", "ini", "cmake", "text"):
            raise Failure(f"{block.place}: no known language: \"{block.language}\"")
        if block.marks.get("where", "prefix" if self.prefix else "tree") != ("prefix" if self.prefix else "tree"):
            return f"only in the {block.marks['where']}"
        if "given" in block.marks:
            self.ran(block, ["bash", "-ec", block.marks["given"]], folder)
        if block.language in ("json", "csv", "ini"):
            self.data(block, folder)
        if "file" in block.marks:
            (folder / block.marks["file"]).write_text(block.text)
            return f"is {block.marks['file']}"
        if block.language == "cmake":
            raise Failure(f"{block.place}: no comment says which file it is")
        why = block.marks.get("not run") or (None if self.long else block.marks.get("long"))
        if why:
            if block.language == "sh":
                for line in lines_of(block.text):
                    for command in re.split(r" && | \|\| | ; | \| ", line):
                        if problem := self.commands.problem(command):
                            raise Failure(f"{block.place}: {problem}")
            return f"not run: {why}"
        done = {"sh": self.shell, "cpp": self.cplusplus, "c": self.plain_c, "python": self.python, "osgt": self.scene, "text": lambda *_: "left alone"}.get(block.language, self.data)(block, folder)
        return done or ("parsed" if block.language in ("json", "csv", "ini") else "run")

    def document(self, name):
        text = (self.root / name).read_text()
        said, failed = [], []
        with tempfile.TemporaryDirectory(prefix="midair-documents-") as made:
            folder = pathlib.Path(made)
            self.scratch(folder)
            for block in blocks_of(name, text):
                try:
                    said.append(f"{block.place}: {block.language}: {self.one(block, folder)}")
                except (Failure, ValueError, OSError) as failure:
                    failed.append(str(failure) if str(failure).startswith(name) else f"{block.place}: {failure}")
        if not self.prefix:
            failed += self.prose(name, text)
        return said, failed

    def prose(self, name, text):
        """What is wrong with commands in the text and with pictures, a sentence each."""
        failed = []
        for span in spans_of(text):
            words = span.split(" ")
            first = next((each for each in words if not re.fullmatch(r"[A-Z_]+=.*", each)), "")
            program = self.commands.program(first)
            if program is None or "*" in first or first.endswith("-") or not (first.startswith("build/bin/") or program.is_file() or len(words) > 1):
                continue
            if problem := self.commands.problem(span.replace("..", "")):
                failed.append(f"{name}: `{span}`: {problem}")
        scripts = {word for span in spans_of(text) for word in span.split(" ")}
        scripts = [self.root / each for each in scripts if each.endswith((".sh", ".py")) and (self.root / each).is_file()]
        for picture in pictures_of(text):
            file = (self.root / name).parent / picture
            if not file.is_file():
                failed.append(f"{name}: the picture {picture} isn't there")
            elif not any(file.stem in each.read_text() or f"{file.stem.rsplit('_', 1)[0]}_{{" in each.read_text() for each in scripts):
                failed.append(f"{name}: no script that it names makes the picture {picture}")
        return failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", required=True, help="the sources")
    parser.add_argument("--build", help="a build of them")
    parser.add_argument("--prefix", help="an installed prefix, in place of a build")
    parser.add_argument("--long", action="store_true", default=os.environ.get("MIDAIR_LONG_TESTS") == "1", help="run what takes minutes, too")
    parser.add_argument("documents", nargs="*", help="below the sources; all by default")
    arguments = parser.parse_args()
    if bool(arguments.build) == bool(arguments.prefix):
        parser.error("either --build or --prefix")
    documents = Documents(arguments)
    names = arguments.documents or sorted(
        str(each.relative_to(documents.root)) for each in documents.root.rglob("*.md")
        if not re.match(r"\.|build", str(each.relative_to(documents.root))))
    failures = []
    # The slowest first.
    names.sort(key=lambda name: -(documents.root / name).read_text().count("```sh"))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for name, future in [(name, pool.submit(documents.document, name)) for name in names]:
            try:
                said, failed = future.result()
                print("\n".join(said), flush=True)
                failures += failed
            except (ValueError, OSError) as failure:
                failures.append(str(failure) if str(failure).startswith(name) else f"{name}: {failure}")
    try:
        documents.compile_fragments()
    except Failure as failure:
        failures.append(str(failure))
    for failure in failures:
        print(f"FAILED {failure}", file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
