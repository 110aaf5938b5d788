# blender --background --factory-startup --python exr_in_blender.py -- IN.exr OUT.json
# Opens an EXR as a compositor's image, as a user of Blender does, and writes which layers it has there and what
# the matte of each is: {"type": ..., "layers": {name: [values, the lowest row first]}}.
import json
import os
import sys

import bpy

exr, out = sys.argv[sys.argv.index("--") + 1:]
scene = bpy.context.scene
scene.use_nodes = True
nodes, links = scene.node_tree.nodes, scene.node_tree.links
nodes.clear()
image = bpy.data.images.load(exr)
picture = nodes.new("CompositorNodeImage")
picture.image = image
writer = nodes.new("CompositorNodeOutputFile")
writer.base_path = os.path.dirname(out)
writer.format.file_format = "OPEN_EXR"
writer.format.color_depth = "32"
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = (*image.size, 100)
report = {"type": image.type, "layers": {}}
for number, socket in enumerate(s for s in picture.outputs if s.enabled):
    writer.file_slots[0].path = "layer-%d-" % number
    links.new(socket, writer.inputs[0])
    bpy.ops.render.render()
    written = bpy.data.images.load(os.path.join(writer.base_path, "layer-%d-0001.exr" % number))
    report["layers"][socket.name] = list(written.pixels)[0::4]
json.dump(report, open(out, "w"))
