#!/usr/bin/env python3
"""tests/tidy.py BUILD BASE: clang-tidy on all C++ files that differ from the commit BASE; BASE "": on all files.

BUILD is configured with compile commands and with CMake's unity builds: what is compiled as one is looked at as one, which takes
a tenth of the time of its files one by one. Only what is found in files that differ counts. A header is looked at through all
files that differ too, or else through the first that includes it. Prints what it found; ends with 1 if that is anything.
"""
import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# An include of a .cpp is what a unity is made of. A program reads its environment before it has threads. What is slow in a test
# is slow once.
NOT_OF_UNITIES = "-bugprone-suspicious-include"
NOT_OF_PROGRAMS = "-concurrency-mt-unsafe"
NOT_OF_TESTS = "-performance-*"
FOUND = re.compile(r"^(/[^:]+):\d+:\d+: (?:error|warning): ")


def git(*words):
    return subprocess.run(["git", "-C", ROOT, *words], check=True, capture_output=True, text=True).stdout


def files_that_differ(base):
    kinds = ["*.h", "*.cpp", "*/include/*"]
    if base:
        return set(git("diff", "--name-only", "--diff-filter=d", base, "--", *kinds).split())
    return set(git("ls-files", *kinds).split())


def text_of(file):
    with open(file, encoding="utf-8", errors="replace") as text:
        return text.read()


def units(build):
    """Returns what is compiled: of each file the sources that it holds, as paths in the tree."""
    all_units = {}
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as commands:
        for command in json.load(commands):
            file = os.path.normpath(os.path.join(command["directory"], command["file"]))
            names = re.findall(r'#include "(/[^"]+\.cpp)"', text_of(file)) if "/Unity/" in file else [file]
            sources = {os.path.relpath(name, ROOT) for name in names}
            if not any(source.startswith("..") for source in sources):
                all_units[file] = sources
    return all_units


def chosen(all_units, differing):
    """Returns the files to look at: those with a source that differs, and one for each header that none of these includes."""
    picked = {file for file, sources in all_units.items() if sources & differing}
    headers = {name for name in differing if not name.endswith(".cpp")}
    includes = {file: set(re.findall(r'#include ["<]([^">]+)[">]', "".join(text_of(os.path.join(ROOT, s)) for s in sources)))
                for file, sources in all_units.items()}

    def holders(header):
        name = header.split("/include/")[-1]
        return [file for file in sorted(all_units) if name in includes[file]]

    for header in sorted(headers):
        files = holders(header)
        if files and not picked & set(files):
            picked.add(files[0])
    return sorted(picked)


def look(build, file, sources):
    off = [NOT_OF_UNITIES]
    if all(source.startswith(("tests/", "samples/")) for source in sources):
        off.append(NOT_OF_PROGRAMS)
    if all(source.startswith("tests/") for source in sources):
        off.append(NOT_OF_TESTS)
    command = ["clang-tidy-14", f"--config-file={ROOT}/.clang-tidy", f"--checks={','.join(off)}", "--warnings-as-errors=-*", "-p", build,
               "--quiet", f"--header-filter=^{re.escape(ROOT)}/.*", file]
    return subprocess.run(command, capture_output=True, text=True)


def main():
    build, base = sys.argv[1:3]
    differing = files_that_differ(base)
    all_units = units(build)
    files = chosen(all_units, differing)
    print(f"clang-tidy on {len(differing)} files in {len(files)} compilations", flush=True)
    findings = set()
    failed = []
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        runs = {pool.submit(look, build, file, all_units[file]): file for file in files}
        for run in concurrent.futures.as_completed(runs):
            result = run.result()
            if result.returncode != 0:
                failed.append(f"{runs[run]}: {shlex.quote(result.stdout[-2000:])}{shlex.quote(result.stderr[-2000:])}")
            lines = result.stdout.splitlines()
            for i, line in enumerate(lines):
                match = FOUND.match(line)
                if match and os.path.relpath(os.path.realpath(match[1]), ROOT) in differing:
                    finding = "\n".join(lines[i:i + 2])
                    if finding not in findings:
                        print(finding, flush=True)
                    findings.add(finding)
    for failure in failed:
        print(f"clang-tidy: could not look at {failure}")
    print(f"clang-tidy found {len(findings) or 'nothing'}")
    return 1 if findings or failed else 0


if __name__ == "__main__":
    sys.exit(main())
