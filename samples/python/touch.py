"""A finger slides over a plate while the simulator plays foci on its skin: plots place, depth and pressure of the contact."""

import time

import numpy as np

import midair
from gallery import AMBER, folder, plt, save

out = folder(__doc__)
vertices = 0.03 * np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], dtype=float)
rows = []
with midair.Scene("octagon") as scene:
    plate = scene.add_mesh(vertices, [[0, 2, 1], [0, 3, 2]])
    plate["touchEvents"] = True
    scene["render"] = "contact"
    scene.play("sim:")
    while scene.state["state"] == "opening":
        time.sleep(0.01)
    begin = time.monotonic()
    while (now := time.monotonic() - begin) < 2.0:
        # An open hand, fingers down: the index fingertip moves to and fro; the longer middle finger is deeper.
        tip = [0.02 * np.sin(2 * np.pi * 0.5 * now), 0.006 - 0.002 * np.sin(2 * np.pi * now), 0.0]
        scene.set_hands(midair.hand(1, tip, orientation=[-np.sqrt(0.5), 0, 0, np.sqrt(0.5)]))
        scene.update(now)
        for contact in scene.contacts:
            rows.append((now, *contact["centre"], contact["depth_m"], contact["pressure_Pa"], contact["object"] == plate.number))
        time.sleep(0.01)
    print(scene.state["played"], "fields played;", *(message.text for message in scene.active_messages))

rows = np.array(rows)
print(f"{len(rows)} contacts seen, {100 * rows[:, 6].mean():.0f} % with the plate; deepest {1e3 * rows[:, 4].max():.1f} mm")
figure, axes = plt.subplots(3, 1, figsize=(7, 6), sharex=True)
for axis, column, factor, label in zip(axes, (1, 4, 5), (1e3, 1e3, 1e-3), ("x / mm", "depth / mm", "wanted / kPa")):
    axis.plot(rows[:, 0], factor * rows[:, column], ".", color=AMBER, markersize=3)
    axis.set_ylabel(label)
axes[-1].set_xlabel("time / s")
save(figure, out, "touch.png")
