"""Plots the width of a board's focus against the distance, with the main lobe of a circular aperture."""

import numpy as np

import midair
from gallery import AMBER, folder, plt, save

out = folder(__doc__)
WAVELENGTH_M = 343.2 / 40e3  # in air of 20 degrees Celsius

array = midair.Array("board")
extent = array.transducers["position"]
diameter_m = max(np.ptp(extent[:, 0]), np.ptp(extent[:, 1]))
distances = np.linspace(0.08, 0.3, 12)
widths = []
for distance in distances:
    scene = midair.Scene(array)
    scene.add_points([0.0, 0.0, distance])
    field = scene.solve()
    across = np.linspace(0.0, 0.03, 601)
    p = field.felt(np.column_stack([across, 0 * across, np.full_like(across, distance)]))
    widths.append(2e3 * across[np.argmax(p < 0.5 * p[0])])

# A disc's far field falls to half its pressure, 2 J1(u)/u = 1/2, at u = 2.215, so its width is 1.41 lambda z/D.
theory = 1e3 * 1.41 * WAVELENGTH_M * distances / diameter_m
for distance, width, ideal in zip(distances[::4], widths[::4], theory[::4]):
    print(f"{1e3 * distance:4.0f} mm: {width:.1f} mm wide at half the pressure, a disc's main lobe {ideal:.1f} mm")

figure, axes = plt.subplots(figsize=(6, 4))
axes.plot(1e3 * distances, widths, "o", color=AMBER, label="solved and measured")
axes.plot(1e3 * distances, theory, "k--", label=f"disc of {1e3 * diameter_m:.0f} mm")
axes.set(xlabel="distance / mm", ylabel="width at half the pressure / mm")
axes.legend()
save(figure, out, "focus.png")
