#!/usr/bin/python3
"""Pictures of what midair-bench measured: time against error, growth with the number of points, the surface between
the points, and what loudness beyond the accurate costs.

usage: plot.py RESULTS.csv OUT_FOLDER
"""
import csv
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def read(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        for key in ("n", "threads", "iterations", "iteration_limit"):
            row[key] = int(row[key])
        for key in ("radius_m", "time_ms", "cpu_ms", "rms", "max", "loudness", "roofline_ms", "loudness_option",
                    "surface_mean", "surface_cv", "p05", "p95", "contrast"):
            row[key] = float(row[key])
    return rows


def time_of(row):
    """Processor time where one thread worked: other programs on the machine don't lengthen it."""
    return row["cpu_ms"] if row["threads"] == 1 else row["time_ms"]


def curves(rows, mode, path):
    """One panel a problem size: error over time, a curve a solver by its iteration limit."""
    rows = [r for r in rows if r["case"] == "sphere" and r["mode"] == mode and r["rms"] > 0
            and r["loudness_option"] == 1]
    sizes = sorted({(r["n"], r["radius_m"]) for r in rows})
    if not sizes:
        return False
    solvers = list(dict.fromkeys(r["solver"] for r in rows))
    columns = min(3, len(sizes))
    lines = (len(sizes) + columns - 1) // columns
    figure, axes = plt.subplots(lines, columns, figsize=(4.6 * columns, 3.8 * lines), squeeze=False, sharey=True)
    for axis in axes.flat[len(sizes):]:
        axis.set_visible(False)
    for axis, (n, radius) in zip(axes.flat, sizes):
        cell = [r for r in rows if (r["n"], r["radius_m"]) == (n, radius)]
        for index, solver in enumerate(solvers):
            points = sorted((time_of(r), 100 * r["rms"]) for r in cell if r["solver"] == solver)
            if points:
                axis.plot(*zip(*points), marker="o", markersize=3.5, color=f"C{index}", label=solver,
                          linewidth=2.2 if index == 0 else 1.1)
        roofline = min(r["roofline_ms"] for r in cell)
        axis.axvline(roofline, color="0.6", linestyle=":", linewidth=1)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_title(f"{n} points, radius {1000 * radius:.0f} mm", fontsize=10)
        axis.grid(True, which="major", alpha=0.3)
        axis.set_xlabel("time, ms")
    for line in axes:
        line[0].set_ylabel("rms error of the played field, %")
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), frameon=False)
    isa = rows[0]["isa"]
    figure.suptitle(f"{'From nothing' if mode == 'cold' else 'After a move of 1 mm and 1 degree'}: time against error, "
                    f"one thread, {isa} (dotted: matrix built and read once)", fontsize=11)
    figure.tight_layout(rect=(0, 0.06, 1, 0.97))
    figure.savefig(path, dpi=120)
    return True


def growth(rows, path):
    """Time over the number of points, of every solver run to its own end."""
    rows = [r for r in rows if r["case"] == "sphere" and r["iteration_limit"] == 0 and r["loudness_option"] == 1]
    if not rows:
        return False
    figure, axis = plt.subplots(figsize=(8.0, 4.6))
    solvers = list(dict.fromkeys(r["solver"] for r in rows))
    for index, solver in enumerate(solvers):
        for mode, style in (("update", "-"), ("cold", "--")):
            points = sorted((r["n"], time_of(r)) for r in rows if r["solver"] == solver and r["mode"] == mode)
            if points:
                axis.plot(*zip(*points), style, marker="o", markersize=3.5, color=f"C{index}", label=f"{solver}, {mode}")
    roofline = [(n, min(r["roofline_ms"] for r in rows if r["n"] == n)) for n in sorted({r["n"] for r in rows})]
    axis.plot(*zip(*roofline), ":", color="0.4", label="matrix built and read once")
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel("control points")
    axis.set_ylabel("time, ms")
    axis.grid(True, which="both", alpha=0.25)
    axis.legend(fontsize=7, frameon=False, handlelength=4.0, bbox_to_anchor=(1.01, 1.0), loc="upper left")
    axis.set_title(f"Growth with the number of points (one thread, {rows[0]['isa']})", fontsize=11)
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    return True


def surface(rows, path):
    """What is felt between the points: mean, spread and contrast of the radiation pressure, of every solver's last field."""
    rows = [r for r in rows if r["case"] == "sphere" and r["mode"] == "cold" and r["iteration_limit"] == 0
            and r["loudness_option"] == 1 and r["surface_mean"] > 0]
    if not rows:
        return False
    sizes = sorted({(r["n"], r["radius_m"]) for r in rows})
    solvers = list(dict.fromkeys(r["solver"] for r in rows))
    figure, axes = plt.subplots(1, 3, figsize=(13.0, 4.0))
    for index, solver in enumerate(solvers):
        for axis, value in zip(axes, (lambda r: r["surface_mean"], lambda r: r["surface_cv"], lambda r: r["contrast"])):
            points = [(k, value(r)) for k, size in enumerate(sizes) for r in rows
                      if r["solver"] == solver and (r["n"], r["radius_m"]) == size]
            axis.plot(*zip(*points), marker="o", markersize=4, color=f"C{index}", label=solver,
                      linewidth=2.2 if index == 0 else 1.1)
    for axis, title in zip(axes, ("mean radiation pressure, Pa", "coefficient of variation", "contrast: mean on / off it")):
        axis.set_title(title, fontsize=10)
        axis.set_xticks(range(len(sizes)), [f"{n}\n{1000 * radius:.0f} mm" for n, radius in sizes])
        axis.set_ylim(bottom=0)
        axis.grid(True, alpha=0.3)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), frameon=False)
    figure.suptitle("The sphere's surface between n points, one field that is held", fontsize=11)
    figure.tight_layout(rect=(0, 0.08, 1, 0.97))
    figure.savefig(path, dpi=120)
    return True


def loudness(rows, path):
    """Loudness over error, a curve a problem size: what the option loudness from 1 to 2 trades."""
    solver = rows[0]["solver"]
    rows = [r for r in rows if r["case"] == "sphere" and r["mode"] == "update" and r["iteration_limit"] == 0
            and r["solver"] == solver]
    if not any(r["loudness_option"] > 1 for r in rows):
        return False
    figure, axis = plt.subplots(figsize=(7.0, 4.4))
    for n, radius in sorted({(r["n"], r["radius_m"]) for r in rows}):
        points = sorted((r["loudness_option"], 100 * r["rms"], r["loudness"]) for r in rows
                        if (r["n"], r["radius_m"]) == (n, radius))
        axis.plot([p[1] for p in points], [100 * (p[2] / points[0][2] - 1) for p in points], marker="o", markersize=3.5,
                  label=f"{n} points, {1000 * radius:.0f} mm")
    axis.set_xlabel("rms error of the played field, %")
    axis.set_ylabel("louder than it accurately can, %")
    axis.grid(True, alpha=0.3)
    axis.legend(fontsize=8, frameon=False)
    axis.set_title(f"{solver}, option loudness from 1 to 2", fontsize=11)
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    return True


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    rows = read(sys.argv[1])
    os.makedirs(sys.argv[2], exist_ok=True)
    for mode in ("update", "cold"):
        name = os.path.join(sys.argv[2], f"time_error_{mode}.png")
        if curves(rows, mode, name):
            print(name)
    for picture in (growth, surface, loudness):
        name = os.path.join(sys.argv[2], f"{picture.__name__}.png")
        if picture(rows, name):
            print(name)


if __name__ == "__main__":
    main()
