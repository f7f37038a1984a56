"""Solves the star once with the installed module, and compares its figures with what a hand needs."""
import midair

scene = midair.Scene("octagon")
scene.add_file("/usr/share/osgMidair/samples/models/star.obj", size=0.08)
field = scene.solve()
assert field.figures["level_Pa"] > 1000.0, field.figures
print(f"== Python: {midair.__file__} plays the star with {field.figures['level_Pa']:.0f} Pa")
