# blender --background --factory-startup --python in_blender.py -- IN.glb VIEW.json OUT
# Imports a GLB as a user of Blender does, and draws each frame of its animation from the camera in VIEW.json
# ({"world_from_cam": 4x4, x right, y down, z forward; "width", "height", "fy", "cx", "cy": px; "seconds": when})
# into OUT/0.png, …, with alpha. OUT/report.json says what Blender found.
import json
import math
import os
import sys

import bpy
from mathutils import Matrix

glb, view_file, out = sys.argv[sys.argv.index("--") + 1:]
view = json.load(open(view_file))

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=glb, import_shading="SMOOTH")  # the default falls over Debian 12's NumPy
meshes = sorted((o for o in bpy.data.objects if o.type == "MESH"), key=lambda o: o.name)

scene = bpy.context.scene
camera = bpy.data.objects.new("view", bpy.data.cameras.new("view"))
scene.collection.objects.link(camera)
scene.camera = camera
camera.matrix_world = Matrix(view["world_from_cam"]) @ Matrix.Diagonal((1, -1, -1, 1))  # y up, z backward
width, height = view["width"], view["height"]
camera.data.sensor_fit = "VERTICAL"
camera.data.angle_y = 2 * math.atan(height / 2 / view["fy"])
camera.data.shift_x = (width / 2 - view["cx"]) / height
camera.data.shift_y = (view["cy"] - height / 2) / height
camera.data.clip_start = 0.01

render = scene.render
render.engine = "CYCLES"
render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
render.film_transparent = True
render.image_settings.file_format = "PNG"
render.image_settings.color_mode = "RGBA"
scene.cycles.device = "CPU"
scene.cycles.samples = 8
scene.cycles.use_denoising = False
scene.cycles.pixel_filter_type = "BOX"  # as sharp as a photograph
scene.view_settings.view_transform = "Standard"  # what is unlit keeps its colour

report = {"meshes": [], "shown": []}
for o in meshes:
    report["meshes"].append({"name": o.name, "vertices": len(o.data.vertices), "faces": len(o.data.polygons),
                             "color_attributes": [a.name for a in o.data.color_attributes]})
for number, time in enumerate(view["seconds"]):
    frame = time * render.fps
    scene.frame_set(int(frame), subframe=frame - int(frame))
    report["shown"].append([o.name for o in meshes if min(o.matrix_world.to_scale()) > 0.5])
    render.filepath = os.path.join(out, "%d.png" % number)
    bpy.ops.render.render(write_still=True)
json.dump(report, open(os.path.join(out, "report.json"), "w"))
