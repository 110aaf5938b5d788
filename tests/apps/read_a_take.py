"""Prints what apps/python/floatstage.py reads, a line a thing: `read_a_take.py MODULE-FOLDER WHAT PATH…`."""

import hashlib
import sys

sys.path.insert(0, sys.argv[1])
import floatstage  # noqa: E402
import numpy as np  # noqa: E402


def digest(array):
    return "x".join(map(str, array.shape)) + " " + hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()


def take(folder):
    opened = floatstage.Take(folder)
    print("take", len(opened.cameras), opened.instants, int(opened.complete))
    for serial in opened.cameras:
        at_once = dict(opened.photographs(serial))
        for frame in range(opened.instants):
            picture, matte = opened.photograph(serial, frame), opened.matte(serial, frame)
            both = [at_once.get(frame), picture]
            if not np.array_equal(*both) if both[0] is not None and both[1] is not None else both[0] is not both[1]:
                print("photographs() differs from photograph() at", serial, frame)
            print("photograph", serial, frame, "gap" if picture is None else digest(picture))
            if matte is not None:
                print("matte", serial, frame, digest(matte))
    for frame in range(opened.instants):
        mesh = opened.mesh(frame)
        if mesh is not None:
            print("mesh", frame, digest(mesh[0].astype("<f4")), digest(mesh[1].astype("<i4")))


def rig(path):
    points = np.array([[x, y, z] for x in (-0.4, 0.1) for y in (-0.3, 0.2) for z in (0.4, 1.6)]
                      + [[0, -5, 1], [0, 5, 1]])
    for serial, camera in floatstage.read_rig(path).items():
        pixels, front = camera.project(points)
        for (x, y), before in zip(pixels, front):
            print("pixel", serial, repr(float(x)) if before else "-", repr(float(y)) if before else "-")


def extras(folder):
    opened = floatstage.Take(folder)
    for serial in opened.cameras:
        print("added", serial, opened.added(serial))
    for name, track in opened.sounds.items():
        samples, rate = opened.sound(name)
        print("sound", name, rate, track.bits, digest(np.ascontiguousarray(samples, dtype="<i4")))
        for stamp in opened.stamps(name):
            print("stamp", stamp.sample, stamp.studio_time_ns, stamp.run)


def png(path):
    print("png", digest(floatstage.read_png(path)))


try:
    {"take": take, "extras": extras, "rig": rig, "png": png}[sys.argv[2]](*sys.argv[3:])
except floatstage.BadTake as error:
    print("BadTake:", error)
