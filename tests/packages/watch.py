"""watch.py [--within S] [--still] [--maps NAME] --png FILE COMMAND..: runs a program on a screen of its own (Xvfb) and looks at the
screen. The program has to show a field: coloured pixels in the middle, which, unless it is --still, change. Prints how long that took
from the command on, keeps the picture, and fails after --within seconds (60). NAME is a library of the system that the program has to
have loaded."""
import argparse
import os
import subprocess
import sys
import tempfile
import time
import zlib

import numpy

SIZE = (1400, 960)
COLOURED = 2000  # pixels; the star and its array alone have none in the middle


def screen(path):
    """The pixels of Xvfb's screen, height x width x 3, from its file in the format XWD."""
    data = numpy.fromfile(path, dtype=numpy.uint8)
    header = data[:100].view(">u4")
    size, width, height, line, colours = (int(header[i]) for i in (0, 4, 5, 12, 19))
    pixels = data[size + 12 * colours:][:height * line].reshape(height, line)[:, :4 * width].reshape(height, width, 4)
    return pixels[:, :, 2::-1]


def field_of(pixels):
    """Which pixels in the middle of the window have a colour of the map of pressures: purple to green, far from grey."""
    height, width = pixels.shape[:2]
    middle = pixels[height // 3:height * 2 // 3, width // 3:width * 2 // 3].astype(int)
    return numpy.where((middle.max(axis=2) - middle.min(axis=2) > 40)[:, :, None], middle, 0)


def write_png(path, pixels):
    def chunk(name, data):
        return len(data).to_bytes(4, "big") + name + data + zlib.crc32(name + data).to_bytes(4, "big")
    height, width = pixels.shape[:2]
    lines = b"".join(b"\0" + row.tobytes() for row in pixels)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", width.to_bytes(4, "big") + height.to_bytes(4, "big") + b"\x08\x02\0\0\0") +
                   chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b""))


def processor_s(pid):
    """Processor time that a program has taken so far, in all its threads and in the programs that it waited for."""
    with open(f"/proc/{pid}/stat") as stat:
        fields = stat.read().rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def watch(options, frame_buffer, program, begin_s):
    first = None
    while time.monotonic() - begin_s < options.within:
        if program.poll() is not None:
            return f"{options.command[0]} ended with {program.returncode}"
        field = field_of(screen(frame_buffer))
        seen_s = time.monotonic() - begin_s
        if numpy.count_nonzero(field.any(axis=2)) > COLOURED:
            if first is None:
                first = field
                print(f"{options.command[0]}: a field after {seen_s:.2f} s", flush=True)
            if options.still or numpy.count_nonzero((field != first).any(axis=2)) > COLOURED:
                print(f"{options.command[0]}: {'' if options.still else 'moving '}on the screen after {seen_s:.2f} s, "
                      f"in which it took {processor_s(program.pid):.2f} s of processors", flush=True)
                return None
        time.sleep(0.05)
    return f"no {'' if options.still else 'moving '}field is on the screen after {options.within} s"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--within", type=float, default=60.0)
    parser.add_argument("--still", action="store_true")
    parser.add_argument("--maps", default="")
    parser.add_argument("--png", required=True)
    parser.add_argument("command", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        display, told = os.pipe()
        server = subprocess.Popen(["Xvfb", "-displayfd", str(told), "-screen", "0", f"{SIZE[0]}x{SIZE[1]}x24", "-fbdir", folder,
                                   "-nolisten", "tcp"], pass_fds=[told], stderr=subprocess.DEVNULL)
        os.close(told)
        with os.fdopen(display) as number:
            name = f":{number.readline().strip()}"
        frame_buffer = os.path.join(folder, "Xvfb_screen0")
        begin_s = time.monotonic()
        program = subprocess.Popen(options.command, env=dict(os.environ, DISPLAY=name))
        problem = watch(options, frame_buffer, program, begin_s)
        if not problem and options.maps:
            with open(f"/proc/{program.pid}/maps") as maps:
                if not any(options.maps in line and line.split()[-1].startswith("/usr/lib/") for line in maps):
                    problem = f"{options.command[0]} hasn't loaded {options.maps} of the system"
        time.sleep(1.0)  # figures and overlays of the next frames, for the picture
        write_png(options.png, screen(frame_buffer))
        program.terminate()
        program.wait(20)
        server.terminate()
        server.wait(20)
    if problem:
        sys.exit(problem)


main()
