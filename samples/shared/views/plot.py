"""Draws a plot, described in JSON on the standard input, into the file of its argument: .png, .svg, .pdf.

The programs embed this text (Plot.cpp.in). It needs Debian's python3-matplotlib.
"""

import json
import logging
import math
import sys

try:
    import matplotlib

    logging.disable()  # matplotlib logs its search for fonts
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.collections import EllipseCollection, LineCollection
    from matplotlib.colors import LinearSegmentedColormap, Normalize
    from matplotlib.lines import Line2D
    from matplotlib.ticker import FuncFormatter, MaxNLocator
except ImportError as error:
    sys.exit(f"{error}: apt-get install python3-matplotlib")

INK = "#1a1a1e"
# Colours that colour-blind people can distinguish (Okabe, Ito 2008).
COLORS = ["#0073b3", "#d65e00", "#009e73", "#cc78a6", "#57b5e8", "#8c730d"]
PHASES = LinearSegmentedColormap.from_list("phases", ["#145aaa", "#f7f7f7", "#c85f0a"])
FULL_COLOR_DEG = 45.0
PARTS = {"FINE": ("as most", "#4a90c2"), "REVERSED": ("reversed", "#e0a040")}
DOT = 0.3  # size of the mark of reversed transducers

plt.rcParams.update({
    "font.size": 12, "text.color": INK, "axes.edgecolor": INK, "axes.labelcolor": INK, "xtick.color": INK, "ytick.color": INK,
    "axes.grid": True, "axes.axisbelow": True, "grid.color": "#dbdee0", "axes.xmargin": 0, "lines.markersize": 7,
    "legend.frameon": False, "legend.labelcolor": "linecolor", "legend.columnspacing": 1.2,
    "legend.borderpad": 0.0, "text.parse_math": False, "figure.constrained_layout.w_pad": 0.15,
    "figure.constrained_layout.h_pad": 0.1, "svg.fonttype": "none", "svg.hashsalt": "midair",
})


def limit(axis, panel):
    """Sets the limits of the axes: the given ones, else those of the curves, and 0 for y. Returns the lowest y."""
    curves = panel["curves"]
    first = min(curve["x"][0] for curve in curves) if panel["xLow"] is None else panel["xLow"]
    last = max(curve["x"][-1] for curve in curves) if panel["xHigh"] is None else panel["xHigh"]
    axis.set_xlim(first, last if last > first else first + 1)
    top = max(max(curve["y"]) for curve in curves)
    if panel["logarithmic"]:
        decade = math.ceil(math.log10(top)) if top > 0 else 0
        bottom = 10.0 ** (decade - max(panel["decades"], 1))
        axis.set_yscale("log")
        axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_ylim(bottom, 10.0**decade)
        return bottom
    bottom = min(0.0, min(min(curve["y"]) for curve in curves))
    top = top if top > bottom else bottom + 1
    axis.set_ylim(bottom, bottom + 1.05 * (top - bottom) if panel["yHigh"] is None else panel["yHigh"])
    return bottom


def draw_panel(axis, panel):
    bottom = limit(axis, panel)
    for band in panel["bands"]:
        fill, line = (axis.axvspan, axis.axvline) if band["isOfX"] else (axis.axhspan, axis.axhline)
        color = COLORS[band["color"] % len(COLORS)]
        fill(band["low"], band["high"], color=color, alpha=0.18, linewidth=0)
        if band["middle"] is not None:
            line(band["middle"], color=color, linewidth=1.3)
    names = []
    for index, curve in enumerate(panel["curves"]):
        color = COLORS[(index if curve["color"] < 0 else curve["color"]) % len(COLORS)]
        shown = np.maximum(curve["y"], bottom) if panel["logarithmic"] else curve["y"]
        (line,) = axis.plot(
            curve["x"], shown, color=color, linewidth=1.3, linestyle="-" if curve["isJoined"] else "none", clip_on=curve["isJoined"],
            marker=None if curve["mark"] == "NONE" else "o", markerfacecolor="white" if curve["mark"] == "RING" else color, zorder=3)
        if curve["name"]:
            names.append((line, curve["name"]))
    names += [(Line2D([], [], color=COLORS[band["color"] % len(COLORS)]), band["name"]) for band in panel["bands"] if band["name"]]
    if names:
        axis.legend(*zip(*names), loc="lower left", bbox_to_anchor=(0, 1.01), ncol=len(names), borderaxespad=0, handlelength=1.2)
    if panel["xTicks"]:
        axis.set_xticks(*zip(*panel["xTicks"]))
        axis.grid(False, axis="x")
    else:
        axis.xaxis.set_major_locator(MaxNLocator(10, steps=[1, 2, 5, 10]))
    axis.set(xlabel=panel["xName"], ylabel=panel["yName"])


def curves(plot):
    """Draws panels from top to bottom."""
    panels = plot["panels"]
    figure, axes = plt.subplots(len(panels), squeeze=False, figsize=(10.4, 0.65 + 3.8 * len(panels)), layout="constrained")
    for axis, panel in zip(axes.flat, panels):
        draw_panel(axis, panel)
    figure.align_ylabels()
    figure.suptitle(plot["title"], x=0.09, ha="left")
    figure.supxlabel(plot["caption"], x=0.09, ha="left", fontsize="medium")
    return figure


def sides_of(positions, normals):
    """Groups transducers by direction: direction, indices, and places, x right and y up, seen from the emission side."""
    sides, rest = [], np.arange(len(positions))
    while rest.size:
        normal = normals[rest[0]]
        same = normals[rest] @ normal > 0.999
        which, rest = rest[same], rest[~same]
        right = np.array([1.0, 0.0, 0.0]) - normal[0] * normal if abs(normal[1]) > 0.9 else np.cross([0.0, 1.0, 0.0], normal)
        right /= np.linalg.norm(right)
        sides.append((normal, which, positions[which] @ np.column_stack([right, np.cross(normal, right)])))
    return sides


def pitch_of(sides):
    """Returns the distance of nearest neighbours, from a sample."""
    nearest = [10.0]
    for _, _, at in sides:
        for place in at[:: max(1, len(at) // 8)]:
            apart = np.linalg.norm(at - place, axis=1)
            nearest.extend(apart[apart > 1e-3])
    return min(nearest[1:], default=nearest[0])


def circles(axis, at, size, **how):
    return axis.add_collection(EllipseCollection([size], [size], [0], units="xy", offsets=at, transOffset=axis.transData, **how))


def draw_side(axis, at, phases, states, size):
    """Draws the transducers of a side, in mm. Returns the artist with the phases' colours."""
    plays = np.isin(states, list(PARTS))
    colored = circles(axis, at[plays], size, array=phases[plays], cmap=PHASES, norm=Normalize(-FULL_COLOR_DEG, FULL_COLOR_DEG),
                      edgecolor="#b8bbc0", linewidth=0.4)
    circles(axis, at[states == "REVERSED"], DOT * size, color=INK)
    circles(axis, at[~plays & (states != "DEAD")], size, facecolor="none", edgecolor="#606468", linestyle=":")
    dead, half = at[states == "DEAD"], 0.5 * size
    axis.add_collection(LineCollection([[place - half * way, place + half * way] for place in dead for way in np.array([[1, 1], [1, -1]])],
                                       color="#c00020", linewidth=2))
    return colored


def draw_bars(axis, values, states, low, high, name):
    """Draws stacked bars of normal and reversed transducers; the end bars include all values beyond."""
    axis.hist([np.clip(values[states == part], low, high) for part in PARTS], bins=60, range=(low, high), stacked=True,
              label=[name for name, _ in PARTS.values()], color=[color for _, color in PARTS.values()])
    axis.set(xlabel=name, ylabel="transducers")
    axis.legend(labelcolor=INK, fontsize=10)


def tuning(plot):
    """Draws a map of the array, each side seen from its emission side, and histograms of phases and gains."""
    states, phases = np.array(plot["states"]), np.array(plot["phase_deg"])
    sides = sides_of(1e3 * np.array(plot["positions_m"]), np.array(plot["normals"]))
    pitch = pitch_of(sides)
    across = min(4, len(sides))
    down = -(-len(sides) // across)
    widest, tallest = np.max([np.ptp(at, axis=0) + pitch for _, _, at in sides], axis=0)
    maps_in = down * (min(tallest * 11.0 / (across * widest), 8.0) + 0.7)
    figure = plt.figure(figsize=(12, maps_in + 4.7), layout="constrained")
    above, key, below = figure.subfigures(3, 1, height_ratios=[maps_in + 1.0, 0.5, 3.0])
    axes = above.subplots(down, across, squeeze=False)
    for axis in axes.flat[len(sides):]:
        axis.set_visible(False)
    for axis, (normal, which, at) in zip(axes.flat, sides):
        colored = draw_side(axis, at, phases[which], states[which], 0.84 * pitch)
        (left, low), (right, high) = at.min(axis=0) - 0.5 * pitch, at.max(axis=0) + 0.5 * pitch
        axis.set(xlim=(left, right), ylim=(low, high), aspect="equal")
        axis.set_title("facing ({:.2g}, {:.2g}, {:.2g})".format(*(np.round(normal, 2) + 0.0)), fontsize=10, loc="left")
        axis.tick_params(labelsize=9)
        axis.grid(False)
    above.suptitle(plot["caption"], fontsize="medium")
    above.supxlabel("mm, in the plane of the side", fontsize=10)
    above.colorbar(colored, ax=axes, label="phase, polarity aside (degrees)", extend="both", aspect=30)
    marks = [("as most", {"marker": "o", "markerfacecolor": "#f7f7f7", "color": "#b8bbc0"}),
             ("reversed", {"marker": "o", "markersize": 4, "color": INK}),
             ("dead", {"marker": "x", "markeredgewidth": 2, "color": "#c00020"}),
             ("not measured, or in noise", {"marker": "o", "fillstyle": "none", "color": "#606468"})]
    key.legend([Line2D([], [], linestyle="none", **how) for _, how in marks], [name for name, _ in marks], loc="center", ncol=4,
               labelcolor=INK)
    by_phase, by_gain = below.subplots(1, 2)
    draw_bars(by_phase, phases, states, -90, 90, "phase, polarity aside (degrees)")
    by_phase.set_xticks(range(-90, 91, 30))
    draw_bars(by_gain, np.array(plot["gain"]), states, 0, 1.5, "gain (the median is 1)")
    figure.suptitle(plot["title"])
    return figure


plot = json.load(sys.stdin)
for said in ("title", "caption"):
    plot[said] = "".join(letter for letter in plot[said] if letter.isprintable())
figure = {"curves": curves, "tuning": tuning}[plot["kind"]](plot)
try:
    figure.savefig(sys.argv[1], dpi=100, metadata={"Date": None} if sys.argv[1].endswith(".svg") else {})
except (OSError, ValueError) as error:
    sys.exit(getattr(error, "strerror", None) or str(error))
