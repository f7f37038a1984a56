"""What the scripts of this folder share: their options, and figures that are written and not shown."""

import argparse
import os
import pathlib

import matplotlib

if not os.environ.get("MPLBACKEND"):
    matplotlib.use("Agg")  # files alone: no display is needed
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

STAR = pathlib.Path(__file__).resolve().parents[1] / "models" / "star.obj"
AMBER = "#c86400"


def folder(description):
    """Reads --out, makes that folder and returns it."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--out", default="out", type=pathlib.Path, help="folder for the figure")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    return out


def plane(half_m, count, y_m=0.0):
    """Places of a square in the array's cross-section: (count * count, 3), and the axis in mm."""
    axis = np.linspace(-half_m, half_m, count)
    x, z = np.meshgrid(axis, axis)
    return np.column_stack([x.ravel(), np.full(x.size, y_m), z.ravel()]), 1e3 * axis


def slice_of(axes, field, half_m=0.05, count=120, y_m=0.0):
    """Draws the pressure that is felt in a cross-section of the array."""
    places, axis = plane(half_m, count, y_m)
    image = axes.pcolormesh(axis, axis, 1e-3 * field.felt(places).reshape(count, count), shading="auto", cmap="magma")
    axes.figure.colorbar(image, ax=axes, label="pressure / kPa, peak")
    axes.set(xlabel="x / mm", ylabel="z / mm", aspect="equal")


def save(figure, out, name):
    """Writes a figure and says where it is."""
    path = out / name
    figure.savefig(path, dpi=120, bbox_inches="tight")
    plt.close(figure)
    print("written to", path)
