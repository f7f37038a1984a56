"""The cost of a point: plots pressure and error against the number of points on a ring, for three loudnesses."""

import numpy as np

import midair
from gallery import folder, plt, save

out = folder(__doc__)
numbers = [1, 2, 4, 8, 16, 32]
figure, axes = plt.subplots(1, 2, figsize=(11, 4))
for loudness in (0.5, 1.0, 1.5):
    levels, errors = [], []
    for n in numbers:
        angle = 2 * np.pi * np.arange(n) / n
        scene = midair.Scene("octagon")
        scene["loudness"] = loudness
        scene.add_points(np.column_stack([0.04 * np.cos(angle), 0 * angle, 0.04 * np.sin(angle)]))
        field = scene.solve()
        levels.append(field.figures["level_Pa"])
        errors.append(100 * field.figures["rms"])
    if loudness == 1.0:
        full = 1e-3 * levels[0]
    axes[0].loglog(numbers, 1e-3 * np.array(levels), "o-", label=f"loudness {loudness:g}")
    axes[1].semilogx(numbers, errors, "o-", label=f"loudness {loudness:g}")
    print(f"loudness {loudness:g}: " + ", ".join(f"{n} points {l:.0f} Pa" for n, l in zip(numbers, levels)))
axes[0].loglog(numbers, full / np.sqrt(numbers), "k:", label="one focus' energy, shared")
axes[0].set(xlabel="points on a ring of 80 mm", ylabel="pressure / kPa, peak")
axes[1].set(xlabel="points on a ring of 80 mm", ylabel="rms error / %")
axes[0].legend()
save(figure, out, "loudness.png")
