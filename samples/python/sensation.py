"""A heartbeat and a circle play on the palm of a hand that turns; a parameter changes on the way. Plots path, pressure and intensity."""

import time

import numpy as np

import midair
from gallery import AMBER, folder, plt, save

out = folder(__doc__)
rows = []
with midair.Scene("octagon") as scene:
    beat = scene.add_sensation("heartbeat")
    beat["attach"], beat["pressure"], beat["parameters"] = "hand:palm", "4 kPa", "rate=1.5"
    circle = scene.add_sensation("circle?radius=20mm")
    circle["pressure"], circle["trigger"], circle["priority"] = "3 kPa", "program", 1
    scene.play("sim:")
    while scene.state["state"] == "opening":
        time.sleep(0.01)
    begin = time.monotonic()
    played = False
    while (now := time.monotonic() - begin) < 2.0:
        # The circle has the higher priority: the heartbeat gives way to it for half a second.
        if not played and now > 1.0:
            circle.play()
            played = True
        if played and now > 1.5:
            circle.stop()
        beat["parameters"] = f"rate={1.0 + now:.3f}"
        angle = 0.3 * np.sin(np.pi * now)
        scene.set_hands(midair.hand(1, [0.0, 0.0, 0.05], orientation=[np.sin(angle / 2), 0, 0, np.cos(angle / 2)]))
        scene.update(now)
        for one in scene.sensations:
            rows.append((now, one["object"] == circle.number, *one["position"], one["intensity"], one["pressure_Pa"]))
        time.sleep(0.01)
    print(scene.state["played"], "fields played;", *(message.text for message in scene.active_messages))

rows = np.array(rows, dtype=float)
felt = rows[rows[:, 6] > 0]
print(f"{len(felt)} places seen, {100 * felt[:, 1].mean():.0f} % of the circle; at most {1e-3 * felt[:, 6].max():.1f} kPa")
figure, (path, course) = plt.subplots(1, 2, figsize=(9, 4))
for which, color, name in ((0, AMBER, "heartbeat"), (1, "black", "circle")):
    own = felt[felt[:, 1] == which]
    path.plot(1e3 * own[:, 2], 1e3 * own[:, 4], ".", color=color, markersize=3, label=name)
    course.plot(own[:, 0], 1e-3 * own[:, 6], ".", color=color, markersize=3)
path.set(xlabel="x / mm", ylabel="z / mm", aspect="equal")
path.legend()
course.set(xlabel="time / s", ylabel="pressure / kPa")
save(figure, out, "sensation.png")
