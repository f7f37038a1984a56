"""Fields in turn: compares the pressure between the points of a plate for one field and for eight."""

import numpy as np

import midair
from gallery import folder, plt, save

out = folder(__doc__)
half_m = 0.02
vertices = half_m * np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], dtype=float)
triangles = [[0, 2, 1], [0, 3, 2]]
axis = np.linspace(-half_m, half_m, 60)
x, z = np.meshgrid(axis, axis)
places = np.column_stack([x.ravel(), 0 * x.ravel(), z.ravel()])

figure, axes = plt.subplots(1, 2, figsize=(11, 4.5))
for number, count in enumerate((1, 8)):
    scene = midair.Scene("octagon")
    scene["cycle"] = count
    plate = scene.add_mesh(vertices, triangles)
    field = scene.solve()
    felt = field.felt(places).reshape(x.shape)
    spread = np.std(felt**2) / np.mean(felt**2)
    print(f"{field.fields} field(s): {len(field.points)} points, spread of the felt power {spread:.2f} of its mean")
    image = axes[number].pcolormesh(1e3 * axis, 1e3 * axis, 1e-3 * felt, shading="auto", cmap="magma", vmin=0)
    axes[number].set(xlabel="x / mm", ylabel="z / mm", aspect="equal", title=f"{field.fields} field(s): spread {spread:.2f}")
    figure.colorbar(image, ax=axes[number], label="felt / kPa, peak")
save(figure, out, "cycle.png")
