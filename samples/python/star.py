"""Solves for the paper's star in an octagonal array of 3984 transducers: drive, figures, and a slice of the field."""

import midair
from gallery import STAR, folder, plt, save, slice_of

out = folder(__doc__)

# The drive is byte-identical to that of "midair-solve star.obj --size 0.08".
scene = midair.Scene("octagon")
star = scene.add_file(str(STAR), size=0.08)
star["sampling"] = "surface"
field = scene.solve()
field.write_drive(str(out / "drive.csv"))
points = field.points
for name in ("points", "rms", "level_Pa", "loudness"):
    print(f"{name:10} {field.figures[name]:.4g}")
print(f"ears       {field.figures['exposure.level_dB']:.1f} dB at the loudest place around the array")
print(f"weakest    {points['achieved_Pa'].min():.0f} Pa, strongest {points['achieved_Pa'].max():.0f} Pa")

figure, axes = plt.subplots(1, 2, figsize=(11, 4.5))
slice_of(axes[0], field)
axes[0].set_title("cross-section through the middle")
axes[1].scatter(1e3 * points["position"][:, 0], 1e3 * points["position"][:, 2], c=1e-3 * points["achieved_Pa"])
axes[1].set(xlabel="x / mm", ylabel="z / mm", aspect="equal", title=f"{len(points)} control points, colour: pressure")
save(figure, out, "star.png")
