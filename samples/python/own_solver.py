"""A custom solver in numpy: compares iterative back-propagation with the default solver."""

import numpy as np

import midair
from gallery import STAR, folder, plt, save

out = folder(__doc__)
COUNT = 50


def back_propagation(problem):
    """Keeps the points' phases in each iteration and resets their pressures to the targets."""
    p = problem.targets.astype(complex)
    q = np.zeros(problem.matrix.shape[1], complex)
    for _ in range(COUNT):
        if problem.stopped:
            break
        q = np.exp(1j * np.angle(problem.matrix.conj().T @ p))
        heard = problem.matrix @ q
        p = problem.targets * heard / np.abs(heard)
    return q


midair.register_solver("back-propagation", back_propagation)
figure, axes = plt.subplots(figsize=(7, 4))
for name in ("", "back-propagation"):
    scene = midair.Scene("octagon")
    scene["solver"] = name
    star = scene.add_file(str(STAR), size=0.08)
    star["sampling"] = "vertices"
    field = scene.solve()
    points = field.points
    print(f"{field.solver:18} rms error {100 * field.figures['rms']:5.2f} %, level {field.figures['level_Pa']:.0f} Pa")
    axes.plot(1e-3 * points["achieved_Pa"], "o-", label=field.solver)
axes.set(xlabel="vertex of the star", ylabel="pressure / kPa, peak")
axes.set_ylim(bottom=0)
axes.legend()
save(figure, out, "own_solver.png")
