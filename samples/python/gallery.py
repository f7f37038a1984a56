"""Shared parts of the scripts in this folder: their options, and figures as files."""

import argparse
import os
import pathlib

import matplotlib

if not os.environ.get("MPLBACKEND"):
    matplotlib.use("Agg")  # needs no display
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

STAR = pathlib.Path(__file__).resolve().parents[1] / "models" / "star.obj"
AMBER = "#c86400"


def folder(description):
    """Parses --out, creates that folder and returns it."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--out", default="out", type=pathlib.Path, help="folder for the figure")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    return out


def plane(half_m, count, y_m=0.0):
    """Returns places of a square in the array's cross-section, (count * count, 3), and the axis in mm."""
    axis = np.linspace(-half_m, half_m, count)
    x, z = np.meshgrid(axis, axis)
    return np.column_stack([x.ravel(), np.full(x.size, y_m), z.ravel()]), 1e3 * axis


def slice_of(axes, field, half_m=0.05, count=120, y_m=0.0):
    """Draws the pressure in a cross-section of the array, averaged over fields in turn."""
    places, axis = plane(half_m, count, y_m)
    image = axes.pcolormesh(axis, axis, 1e-3 * field.felt(places).reshape(count, count), shading="auto", cmap="magma")
    axes.figure.colorbar(image, ax=axes, label="pressure / kPa, peak")
    axes.set(xlabel="x / mm", ylabel="z / mm", aspect="equal")


def save(figure, out, name):
    """Writes a figure and prints its path."""
    path = out / name
    figure.savefig(path, dpi=120, bbox_inches="tight")
    plt.close(figure)
    print("written to", path)
