#!/usr/bin/env python3
"""Packs a take into one file, a seed of take_fuzz: pack_take.py TAKE > corpus/take/NAME"""
import os
import sys

take = sys.argv[1]
names = [os.path.relpath(os.path.join(folder, file), take) for folder, _, files in os.walk(take) for file in files]
for name in sorted(names, key=lambda n: (n not in ("take.json", "rig.json"), ".csv" not in n, n)):
    with open(os.path.join(take, name), "rb") as opened:
        sys.stdout.buffer.write(b"\n@@F %s\n%s" % (name.encode(), opened.read()))
