"""Plays a scene by lines from stdin, on a recorder; OneEngineTest.cpp writes them and reads what is seen."""
import sys

import numpy as np

import midair


class Recorder:
    field = b""
    is_lost = False

    def open(self, path, options, boards):
        return self

    def play(self, phases, amplitudes):
        if Recorder.is_lost:
            return False
        Recorder.field = phases.tobytes() + amplitudes.tobytes()
        return True

    def silence(self):
        Recorder.field = b""

    def is_ready(self):
        return not Recorder.is_lost


STATES = ["closed", "opening", "silent", "playing", "muted", "lost", "fault"]
HALF = np.float32(0.02)
CORNERS = HALF * np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
                           [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], np.float32)
TRIANGLES = np.array([[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4],
                      [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]], np.uint32)


class Played:
    def __init__(self, array):
        Recorder.field = b""
        Recorder.is_lost = False
        self.scene = midair.Scene(array)
        self.scene["feelThreshold"] = 1e-6
        self.box = self.scene.add_mesh(CORNERS.astype(float), TRIANGLES)
        self.box["touchEvents"] = "true"
        self.hand_m = 0.0
        self.move(0.0)
        self.scene.play("onepython:")

    def move(self, x):
        pose = np.eye(4)
        pose[:3, 3] = [x, 0.0, 0.15]
        self.box.set_pose(pose)

    def frame(self, time):
        hands = midair.hand(1, [0.0, 0.0, self.hand_m])
        self.scene.set_hands(hands if self.hand_m > 0.0 else hands[:0])
        try:
            self.scene.update(time)
        except midair.Error:
            pass  # nothing may be played

    def seen(self):
        state = self.scene.state
        print("waiting", state["waiting"])
        print("sent", state["sent"])
        print("state", STATES.index(state["state"]))
        print("field", Recorder.field.hex())
        for touch in self.scene.touches:
            if touch["touching"]:
                print("touch %d %d %.6g m %.6g N"
                      % (touch["hand"], touch["finger"], touch["distance_m"], touch["force_N"]))
        for message in self.scene.messages:
            print("told", message.text)
        print(".", flush=True)


midair.register_device("onepython", lambda *of: Recorder())
played = None
for line in sys.stdin:
    word, _, rest = line.rstrip("\n").partition(" ")
    if word == "begin":
        played = Played(rest)
    elif word == "end":
        played.scene.close()
    elif word == "set":
        name, _, value = rest.partition("=")
        played.scene[name] = value
    elif word == "box":
        name, _, value = rest.partition("=")
        played.box[name] = value
    elif word == "move":
        played.move(float(rest))
    elif word == "hand":
        played.hand_m = float(rest)
    elif word == "plate":
        played.scene.set_reflectors(rest)
    elif word == "mute":
        played.scene.mute(rest == "1")
    elif word == "lost":
        Recorder.is_lost = rest == "1"
        if Recorder.is_lost:
            Recorder.field = b""
    elif word == "frame":
        played.frame(float(rest))
    elif word == "seen":
        played.seen()
