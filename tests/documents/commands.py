"""Whether a command that isn't run could be: its program exists, and knows the options that are given to it."""

import functools
import os
import pathlib
import re
import shlex
import subprocess

# Shell words and programs whose options aren't the project's to know.
OTHERS = {"cd", "export", "printf", "echo", "mkdir", "cp", "cat", "sudo", "curl", "git", "apt-get", "apt", "dpkg", "systemctl", "udevadm", "adduser",
          "parallel", "sbatch", "gcc", "g++", "pkg-config", "python3", "ssh", "usermod", "xvfb-run", "env"}


class Commands:
    """root: the sources. bin: a folder of the programs that were built."""

    def __init__(self, root, bin):
        self.root = pathlib.Path(root)
        self.bin = pathlib.Path(bin)

    def program(self, word):
        """The file that a word stands for; None if it is no program of ours."""
        name = pathlib.Path(word).name
        if word.startswith("build/bin/") or word.startswith("midair-"):
            return self.bin / word.removeprefix("build/bin/")
        if word.startswith("./") or word.startswith(("samples/", "tests/", ".ci/")):
            return self.root / word.removeprefix("./") if name.endswith((".sh", ".py")) or word == ".ci/run" else None
        return None

    @functools.cache
    def help(self, program, *subcommand):
        environment = dict(os.environ, DISPLAY="")
        ended = subprocess.run([str(program), *subcommand, "--help"], capture_output=True, text=True, timeout=300, env=environment)
        return ended.stdout + ended.stderr if ended.returncode == 0 else ""

    def known_options(self, program, words):
        if program.suffix in (".sh", ".py") or program.name == "run":
            # Read and not run: not each script knows --help.
            text = program.read_text() + (self.help(self.bin / "midair-demo") if program == self.root / "samples/run.sh" else "")
            return set(re.findall(r"(?<![\w-])--?[A-Za-z][-A-Za-z0-9]*", text))
        text = self.help(program)
        for word in words[:1]:
            if re.fullmatch(r"[a-z][-a-z0-9]*", word):  # a subcommand, or what is taken for one
                text += self.help(program, word)
                text += "".join(self.help(program, word, each) for each in words[1:2] if re.fullmatch(r"[a-z][a-z0-9]*", each))
        return set(re.findall(r"(?<![\w-])--?[A-Za-z][-A-Za-z0-9]*", text))

    def problem(self, command):
        """What is wrong with one command, as a sentence; empty: nothing."""
        try:
            words = shlex.split(command, comments=True)
        except ValueError as error:
            return f"{command}: {error}"
        while words and re.fullmatch(r"[A-Za-z_]+=.*", words[0]):
            name = words.pop(0).split("=")[0]
            if name.startswith(("OSG_MIDAIR_", "MIDAIR_")) and not self.mentions(name):
                return f"no source knows the variable {name}"
        if not words:
            return ""
        if words[0] in ("sudo", "xvfb-run", "env"):
            return self.problem(" ".join(shlex.quote(each) for each in words[1:]).lstrip("- ")) if len(words) > 1 else ""
        program = self.program(words[0])
        if program is None:
            found = subprocess.run(["sh", "-c", f"command -v {shlex.quote(words[0])}"], capture_output=True).returncode == 0
            # What only root, a service manager or a queue has need not be on this machine.
            return "" if found or words[0] in OTHERS else f"there is no program {words[0]}"
        if program.is_dir() and len(words) == 1:
            return ""
        if not program.is_file():
            return f"there is no program {words[0]}"
        if not os.access(program, os.X_OK) and len(words) > 1:
            return f"{words[0]} can't be run"
        known = self.known_options(program, words[1:]) if any(each.startswith("-") for each in words[1:]) else set()
        for word in words[1:]:
            if word == "--":
                break
            if re.match(r"--?[A-Za-z]", word) and word.split("=")[0] not in known and not word.startswith("--gtest_"):
                return f"{words[0]} knows no {word.split('=')[0]}"
        return ""

    @functools.cache
    def mentions(self, name):
        ended = subprocess.run(["grep", "-rqE", f"{name}|{name.removeprefix('OSG_MIDAIR_').replace('_', '').lower()}", "--include=*.cpp",
                                "--include=*.h", "--include=*.sh", "-i", str(self.root / "haptics"), str(self.root / "device"),
                                str(self.root / "engine-bridge"), str(self.root / "plugin"), str(self.root / "samples"), str(self.root / "tests")])
        return ended.returncode == 0


def lines_of(text):
    """The commands of a block, with continued lines as one, and without comments."""
    joined = re.sub(r"\\\n\s*", " ", text)
    return [line.strip() for line in joined.split("\n") if line.strip() and not line.strip().startswith("#")]
