#!/usr/bin/python3
"""Draws a display file to scale, from the side and from above, with the sizes to cut and measure.

    draw.py FILE.display.json --out DRAWING.svg [--board MM] [--size MMxMM]

--board: depth of the array's board below the world's origin; --size: its width and depth. All sizes are in millimetres."""

import argparse
import json
import math

WIDE = 560   # pixels of a view
HIGH = 500
EDGE = 60    # pixels around what is drawn
INK = {"screen": "#1f5fa8", "optic": "#2a8f86", "picture": "#c0392b", "eye": "#555555", "board": "#7a6a3a", "light": "#e0a030"}


def mirrored(place, optic):
    normal = optic["normal"]
    length2 = sum(n * n for n in normal)
    away = sum(n * (p - q) for n, p, q in zip(normal, place, optic["point_m"])) / length2
    return [p - 2 * away * n for p, n in zip(place, normal)]


def between(a, b, t=0.5):
    return [p + t * (q - p) for p, q in zip(a, b)]


def distance_mm(a, b):
    return 1e3 * math.dist(a, b)


def corners_of(screen):
    low, right, up = screen["lowerLeft_m"], screen["lowerRight_m"], screen["upperLeft_m"]
    return [low, right, [r + u - l for r, u, l in zip(right, up, low)], up]


def on_plane(eye, place, optic):
    """Returns where the line of sight to a place crosses an optic's plane."""
    normal = optic["normal"]
    ahead = sum(n * (q - e) for n, q, e in zip(normal, optic["point_m"], eye))
    return between(eye, place, ahead / sum(n * (p - e) for n, p, e in zip(normal, place, eye)))


class View:
    """One view: two of the world's axes on paper."""

    def __init__(self, left, title, across, up, middle, scale):
        self.parts = [f'<text x="{left + 12}" y="26" class="title">{title}</text>']
        self.left, self.across, self.up, self.middle, self.scale = left, across, up, middle, scale

    def at(self, place):
        x = self.left + WIDE / 2 + self.scale * (place[self.across] - self.middle[self.across])
        y = HIGH / 2 + 20 - self.scale * (place[self.up] - self.middle[self.up])
        return f"{x:.1f}", f"{y:.1f}"

    def line(self, places, ink, width=1.0, dashes="", closed=False):
        points = " ".join(",".join(self.at(place)) for place in places)
        kind = "polygon" if closed else "polyline"
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        self.parts.append(f'<{kind} points="{points}" fill="none" stroke="{ink}" stroke-width="{width}"{dashed}/>')

    def dot(self, place, ink):
        x, y = self.at(place)
        self.parts.append(f'<circle cx="{x}" cy="{y}" r="4" fill="{ink}"/>')

    def text(self, place, words, ink, right=8, down=4):
        x, y = (float(v) for v in self.at(place))
        self.parts.append(f'<text x="{x + right:.1f}" y="{y + down:.1f}" fill="{ink}">{words}</text>')


def draw(view, display, board_mm, size_mm):
    screen = corners_of(display["screen"])
    optics = display.get("optics", [])
    picture = screen
    for optic in optics:
        picture = [mirrored(corner, optic) for corner in picture]
    view.line(screen, INK["screen"], 4, closed=True)
    if view.up == 2:
        view.text(max(screen, key=lambda c: c[1]), "screen", INK["screen"], 8, -4)
    else:
        view.text(between(screen[0], screen[2]), "screen", INK["screen"], -20, 4)
    for optic in optics:
        if "outline_m" in optic:
            view.line(optic["outline_m"], INK["optic"], 3, closed=True)
            view.text(between(optic["outline_m"][0], optic["outline_m"][1]), optic["kind"].replace("-", " "), INK["optic"], -20, 18)
    view.line(picture, INK["picture"], 2, "7 4", closed=True)
    view.text(max(picture, key=lambda c: (c[view.up], c[view.across])), "picture", INK["picture"], 8, -4)
    eye = eye_of(display)
    if eye:
        sides = ((0, 1), (2, 3)) if view.up == 2 else ((0, 3), (1, 2))
        for corner in (between(picture[a], picture[b]) for a, b in sides):
            if len(optics) == 1:
                met = on_plane(eye, corner, optics[0])
                view.line([eye, met, mirrored(corner, optics[0])], INK["light"], 1, "2 3")
                view.line([met, corner], INK["light"], 0.6, "1 4")
            else:
                view.line([eye, corner], INK["light"], 1, "2 3")
        view.dot(eye, INK["eye"])
        view.text(eye, "eye", INK["eye"], -8, -10)
    if board_mm is not None:
        board = board_at(board_mm, size_mm)
        view.line(board, INK["board"], 4, closed=True)
        view.text(board[1], "board", INK["board"], 8, 14)
    view.dot([0, 0, 0], INK["picture"])


def board_at(board_mm, size_mm):
    wide, deep, low = 5e-4 * size_mm[0], 5e-4 * size_mm[1], -1e-3 * board_mm
    return [[-wide, -deep, low], [wide, -deep, low], [wide, deep, low], [-wide, deep, low]]


def eye_of(display):
    words = display.get("eye", "").split()
    return [float(word) for word in words[1:4]] if words[:1] == ["fixed"] else None


def facts(display, board_mm, size_mm):
    """Returns the list of things to buy, cut and measure."""
    def list_of(place):
        return ", ".join(f"{1e3 * p:.0f}" for p in place)

    screen = corners_of(display["screen"])
    lines = [f"screen: picture of {distance_mm(screen[0], screen[1]):.0f} x {distance_mm(screen[0], screen[3]):.0f} mm, "
             f"corners (lower left, lower right, upper left) at ({list_of(screen[0])}), ({list_of(screen[1])}), ({list_of(screen[3])})"]
    picture = screen
    for optic in display.get("optics", []):
        picture = [mirrored(corner, optic) for corner in picture]
        normal = optic["normal"]
        lean = math.degrees(math.acos(abs(normal[2]) / math.sqrt(sum(n * n for n in normal))))
        words = f"{optic['kind'].replace('-', ' ')}: leans by {lean:.0f} degrees from the floor"
        if "outline_m" in optic:
            outline = optic["outline_m"]
            words += (f", {distance_mm(outline[0], outline[1]):.0f} x {distance_mm(outline[1], outline[2]):.0f} mm, corners at "
                      + ", ".join(f"({list_of(corner)})" for corner in outline))
        lines.append(words)
    middle = between(picture[0], picture[2])
    eye = eye_of(display)
    if eye:
        lines.append(f"eye: at ({list_of(eye)}), {distance_mm(eye, middle):.0f} mm from the picture's middle at ({list_of(middle)})")
    if board_mm is not None:
        lines.append(f"board: {size_mm[0]:g} x {size_mm[1]:g} mm, its face {board_mm:g} mm under the picture's middle, which is the world's origin")
    return lines


def drawing(display, board_mm, size_mm):
    screen = corners_of(display["screen"])
    places = screen + [corner for optic in display.get("optics", []) for corner in optic.get("outline_m", [])]
    for optic in display.get("optics", []):
        screen = [mirrored(corner, optic) for corner in screen]
    places += screen + [eye_of(display) or [0, 0, 0]] + board_at(board_mm or 0.0, size_mm)
    low, high = ([end(p[axis] for p in places) for axis in range(3)] for end in (min, max))
    scale = min((room - 2 * EDGE) / (high[axis] - low[axis]) for room, axis in ((WIDE, 1), (HIGH, 2), (WIDE, 0), (HIGH, 1)))
    views = [View(0, "from the side: y to the right, z up", 1, 2, between(low, high), scale),
             View(WIDE, "from above: x to the right, y up", 0, 1, between(low, high), scale)]
    lines = facts(display, board_mm, size_mm)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{2 * WIDE}" height="{HIGH + 40 + 20 * len(lines)}" font-family="sans-serif" font-size="13">',
             "<style>.title { font-size: 15px; font-weight: bold; }</style>", '<rect width="100%" height="100%" fill="white"/>']
    for view in views:
        draw(view, display, board_mm, size_mm)
        parts += view.parts
    parts += [f'<text x="12" y="{HIGH + 40 + 20 * i}" font-size="12">{line}</text>' for i, line in enumerate(lines)]
    return "\n".join(parts + ["</svg>", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("file")
    parser.add_argument("--out", required=True)
    parser.add_argument("--board", type=float, metavar="MM", help="how far the board is under the world's origin")
    parser.add_argument("--size", default="192x151", metavar="MMxMM", help="how wide and deep the board is")
    options = parser.parse_args()
    with open(options.file, encoding="utf-8") as file:
        display = json.load(file)
    with open(options.out, "w", encoding="utf-8") as out:
        out.write(drawing(display, options.board, [float(side) for side in options.size.split("x")]))


if __name__ == "__main__":
    main()
