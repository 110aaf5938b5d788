# blender --background --factory-startup --python rendered_stage.py -- STAGE OUT WIDTH SAMPLES [CAMERAS [lectern|rail]]
# A performer on a stage that the synthetic studio does not have, path traced: noise of light, soft shadows, light
# that walls throw on clothes. STAGE is one of
#   tarpaulin  blue cloth on the floor and on three of four walls, striped plaster elsewhere, stands
#   workshop   concrete, wooden walls, crates of all colours; no cloth
#   lounge     a patterned carpet, sofas and pictures along six walls; no cloth
#   cyclorama  white all around, so bright that skin is nearly white, too
#   corner     green cloth on the floor and on one wall, dark bricks elsewhere, two colours of light
#   theatre    black floor, dark curtains, a spot from either side
#   gym        a wooden floor that mirrors, lines on it, benches of all colours
#   garden     grass, hedges of all heights before an even sky, sun
#   yard       concrete, striped walls and crates, sun under a blue sky
#   court      green ground with lines, walls around it, a lower sun
#   beach      sand, a low fence, a sun that is lower still
#   spot       a wooden floor under one small lamp
#   greens     green cloth all around, and a shirt of its colour
#   asphalt    a grey floor before grey walls, grey clothes, a high sun
# Writes OUT/sparse (CAMERAS, or eight, as a COLMAP model), OUT/pictures/<serial>/000000.png,
# OUT/plates/<serial>.png of the empty stage and OUT/truth/<serial>/000000.png, whose alpha is the performer.
# With a lectern (and a stand) or a rail (and an armchair) beside the performer, OUT/occluders/<serial>.png has them and
# OUT/whole is the truth without them.
import math
import os
import random
import sys

import bpy
from mathutils import Matrix, Vector

given = sys.argv[sys.argv.index("--") + 1:]
stage, out, width, samples, cameras = (given + ["8"])[:5]
beside = given[5] if len(given) > 5 else None
width, samples, cameras = int(width), int(samples), int(cameras)
height, focal = width * 3 // 4, width * 0.875
# By stage: what the dice of this file begin with, and the performer's shirt.
seed, shirt = {
    "tarpaulin": (3, ((0.1, 0.35, 0.3), "ShaderNodeTexVoronoi", 16, (0.7, 0.6, 0.2))),
    "workshop": (2, ((0.8, 0.8, 0.78), "ShaderNodeTexWave", 6, (0.1, 0.1, 0.3))),
    "lounge": (1, ((0.15, 0.2, 0.35), "ShaderNodeTexNoise", 20, (0.5, 0.5, 0.55))),
    "cyclorama": (5, ((0.45, 0.1, 0.08), "ShaderNodeTexChecker", 12, (0.2, 0.2, 0.22))),
    "corner": (9, ((0.7, 0.7, 0.1), "ShaderNodeTexNoise", 10, (0.6, 0.3, 0.5))),
    "theatre": (10, ((0.5, 0.3, 0.25), "ShaderNodeTexVoronoi", 12, (0.7, 0.6, 0.6))),
    "gym": (8, ((0.1, 0.15, 0.5), "ShaderNodeTexChecker", 5, (0.8, 0.8, 0.8))),
    "yard": (21, ((0.2, 0.3, 0.5), "ShaderNodeTexNoise", 12, (0.6, 0.6, 0.55))),
    "court": (24, ((0.7, 0.7, 0.65), "ShaderNodeTexWave", 8, (0.2, 0.2, 0.5))),
    "beach": (32, ((0.6, 0.55, 0.45), "ShaderNodeTexWave", 9, (0.2, 0.25, 0.5))),
    "spot": (23, ((0.15, 0.4, 0.3), "ShaderNodeTexVoronoi", 14, (0.5, 0.5, 0.3))),
    "greens": (44, ((0.07, 0.3, 0.08), "ShaderNodeTexNoise", 6, (0.05, 0.22, 0.06))),
    "asphalt": (41, ((0.35, 0.35, 0.36), "ShaderNodeTexNoise", 9, (0.25, 0.25, 0.27))),
    "garden": (7, ((0.6, 0.2, 0.1), "ShaderNodeTexNoise", 14, (0.8, 0.7, 0.3))),
}[stage]
dice = random.Random(seed)
scene = bpy.context.scene
for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing, do_unlink=True)


def material(color, roughness=0.8, texture=None, scale=5.0, other=None):
    """A matt surface of a colour, perhaps with a texture between it and another (default: a third of it)."""
    made = bpy.data.materials.new("m")
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    surface = nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*color, 1)
    surface.inputs["Roughness"].default_value = roughness
    surface.inputs["Specular"].default_value = 0.2
    if texture:
        pattern, ramp, place = nodes.new(texture), nodes.new("ShaderNodeValToRGB"), nodes.new("ShaderNodeTexCoord")
        pattern.inputs["Scale"].default_value = scale
        ramp.color_ramp.elements[0].color = (*color, 1)
        ramp.color_ramp.elements[1].color = (*(other or [c / 3 for c in color]), 1)
        links.new(place.outputs["Object"], pattern.inputs["Vector"])
        links.new(pattern.outputs["Fac" if "Fac" in pattern.outputs else "Distance"], ramp.inputs["Fac"])
        links.new(ramp.outputs["Color"], surface.inputs["Base Color"])
    return made


def box(center, size, of, turn=0.0):
    bpy.ops.mesh.primitive_cube_add(size=1, location=center, rotation=(0, 0, turn))
    bpy.context.object.scale = size
    bpy.context.object.data.materials.append(of)


def pole(center, radius, length, of):
    bpy.ops.mesh.primitive_cylinder_add(radius=radius, depth=length, location=center)
    bpy.context.object.data.materials.append(of)


def light(center, watts, size, color=(1, 1, 1)):
    bpy.ops.object.light_add(type="AREA", location=center)
    lamp = bpy.context.object
    lamp.data.energy, lamp.data.size, lamp.data.color = watts, size, color
    lamp.rotation_euler = (Vector((0, 0, 0.8)) - Vector(center)).to_track_quat("-Z", "Y").to_euler()


def sun(rotation, energy):
    bpy.ops.object.light_add(type="SUN", location=(0, 0, 5), rotation=rotation)
    bpy.context.object.data.energy, bpy.context.object.data.angle = energy, 0.01


def sky(color, strength):
    inputs = scene.world.node_tree.nodes["Background"].inputs
    inputs[0].default_value, inputs[1].default_value = (*color, 1), strength


def floor(of):
    bpy.ops.mesh.primitive_plane_add(size=14)
    bpy.context.object.data.materials.append(of)


def around(turn, radius, z):
    return (radius * math.cos(turn), radius * math.sin(turn), z)


def walls(of, sides=4, radius=5.0, tall=3.2):
    for k in range(sides):
        turn = 2 * math.pi * k / sides + 0.3
        box(around(turn, radius, tall / 2), (0.1, 2 * radius * math.tan(math.pi / sides) + 0.2, tall), of, turn)


def random_color():
    return (dice.random(), dice.random(), dice.random())


def tarpaulin():
    cloth = material((0.06, 0.16, 0.5), 0.7, "ShaderNodeTexNoise", 1.5, (0.05, 0.12, 0.42))
    floor(cloth)
    walls(material((0.7, 0.68, 0.65), 0.9, "ShaderNodeTexBrick", 3, (0.5, 0.47, 0.44)))
    for k in range(3):
        turn = 2 * math.pi * k / 4 + 0.3
        box(around(turn, 4.8, 1.2), (0.06, 8, 2.4), cloth, turn)
    for _ in range(4):
        pole(around(dice.uniform(0, 6.28), 4.2, 1.2), 0.04, 2.4, material((0.02, 0.02, 0.02)))
    light((1.5, -2.5, 3), 200, 1.2)
    light((-2.5, 1, 3), 120, 0.8)


def workshop():
    floor(material((0.35, 0.34, 0.32), 0.6, "ShaderNodeTexNoise", 3, (0.22, 0.21, 0.2)))
    walls(material((0.5, 0.42, 0.3), 0.9, "ShaderNodeTexWave", 2, (0.3, 0.22, 0.14)))
    for _ in range(14):
        tall = dice.uniform(0.4, 1.9)
        texture = dice.choice(["ShaderNodeTexNoise", "ShaderNodeTexChecker", "ShaderNodeTexBrick", None])
        crate = material([0.6 * c for c in random_color()], 0.7, texture, dice.uniform(2, 9))
        box(around(dice.uniform(0, 6.28), dice.uniform(3.9, 4.6), tall / 2),
            (dice.uniform(0.3, 0.9), dice.uniform(0.3, 0.9), tall), crate, dice.uniform(0, 3))
    for _ in range(6):
        pole(around(dice.uniform(0, 6.28), 4.4, 0.5), 0.25, 1, material(random_color()))
    light((2, -2, 3.1), 180, 1.5)
    light((-2, 1.5, 3.1), 140, 1.2, (1, 0.9, 0.75))


def lounge():
    floor(material((0.4, 0.12, 0.1), 0.95, "ShaderNodeTexVoronoi", 4, (0.2, 0.05, 0.1)))
    walls(material((0.75, 0.72, 0.6), 0.9), 6, 5.2)
    for k in range(5):
        turn = 2 * math.pi * k / 5 + 0.7
        box(around(turn, 4.5, 0.4), (0.9, 1.8, 0.8),
            material([0.5 * c for c in random_color()], 0.9, "ShaderNodeTexNoise", 8), turn)
    for k in range(6):
        turn = 2 * math.pi * k / 6 + 0.2
        texture = dice.choice(["ShaderNodeTexVoronoi", "ShaderNodeTexWave", "ShaderNodeTexChecker"])
        picture = material(random_color(), 0.5, texture, dice.uniform(3, 12), random_color())
        box(around(turn, 5.0, 1.9), (0.05, 1.2, 0.8), picture, turn)
    light((0, -3, 3), 160, 2, (1, 0.95, 0.85))
    light((2.5, 2.5, 2.8), 90, 0.6)
    light((-2.8, 1.5, 2.5), 70, 0.5, (0.8, 0.9, 1))


def cyclorama():
    white = material((0.8, 0.8, 0.8), 0.9)
    floor(white)
    walls(white, 24, 5.0)
    light((2, -2.5, 3.1), 220, 2.0)
    light((-2.5, 0, 3.1), 160, 1.5)
    light((0.5, 2.8, 3.0), 130, 1.5)


def corner():
    cloth = material((0.08, 0.35, 0.09), 0.8)
    floor(cloth)
    walls(material((0.15, 0.15, 0.16), 0.9, "ShaderNodeTexBrick", 2, (0.3, 0.28, 0.26)), 6, 5.0)
    box(around(0.3, 4.2, 1.4), (0.06, 5, 2.8), cloth, 0.3)
    for _ in range(6):
        pole(around(dice.uniform(0, 6.28), 4.3, 1.3), 0.05, 2.6, material((0.02, 0.02, 0.02)))
    light((1.5, -2.5, 3), 200, 1.2, (1, 0.85, 0.7))
    light((-2.5, 1, 3), 150, 0.8, (0.75, 0.85, 1))


def theatre():
    floor(material((0.03, 0.03, 0.03), 0.4))
    walls(material((0.05, 0.03, 0.03), 0.9, "ShaderNodeTexWave", 3, (0.02, 0.01, 0.01)), 10, 5.0)
    light((1.0, -3.5, 3.2), 300, 0.6, (1, 0.9, 0.8))
    light((-2.5, 2.5, 3.2), 120, 0.6, (0.7, 0.8, 1))
    sky((0.5, 0.5, 0.55), 0.02)


def gym():
    floor(material((0.55, 0.35, 0.17), 0.35, "ShaderNodeTexWave", 4, (0.45, 0.27, 0.12)))
    walls(material((0.65, 0.65, 0.6), 0.9), 4, 7.0, 4.5)
    for k in range(12):
        box(around(dice.uniform(0, 6.28), 6.4, 0.25), (0.4, 2.0, 0.5 + 0.1 * (k % 5)), material(random_color()),
            dice.uniform(0, 3))
    for _ in range(3):
        box((dice.uniform(-2, 2), dice.uniform(-2, 2), 0.003), (0.06, 5, 0.004), material((0.9, 0.9, 0.9)),
            dice.uniform(0, 3))
    for x in (-3, 0, 3):
        light((x, 1, 4.4), 180, 1.0)
        light((x, -2, 4.4), 140, 1.0)


def garden():
    floor(material((0.12, 0.25, 0.05), 0.95, "ShaderNodeTexNoise", 25, (0.05, 0.13, 0.02)))
    for k in range(40):
        tall = dice.uniform(1.0, 2.2)
        leaves = material((0.06, 0.2 * dice.uniform(0.6, 1.4), 0.04), 0.9, "ShaderNodeTexVoronoi", dice.uniform(8, 20))
        box(around(2 * math.pi * k / 40, dice.uniform(4.6, 5.4), tall / 2), (0.8, 0.9, tall), leaves,
            dice.uniform(0, 3))
    sun((0.7, 0.3, 0.5), 3.0)
    sky((0.35, 0.55, 0.9), 0.9)


def yard():
    floor(material((0.45, 0.43, 0.4), 0.9, "ShaderNodeTexNoise", 12, (0.25, 0.24, 0.22)))
    walls(material((0.45, 0.2, 0.15), 0.9, "ShaderNodeTexBrick", 3, (0.3, 0.28, 0.26)), 6, 5.5, 2.5)
    for _ in range(5):
        tall = dice.uniform(0.4, 1.2)
        box(around(dice.uniform(0, 6.28), 4.6, tall / 2), (0.6, 0.6, tall), material(random_color()), dice.uniform(0, 3))
    sun((0.9, 0.1, 1.5), 3.5)
    sky((0.4, 0.6, 0.95), 0.6)


def court():
    floor(material((0.15, 0.35, 0.2), 0.9, "ShaderNodeTexNoise", 40, (0.11, 0.28, 0.15)))
    for _ in range(4):
        box((dice.uniform(-2, 2), dice.uniform(-2, 2), 0.003), (0.06, 5, 0.004), material((0.9, 0.9, 0.9)),
            dice.uniform(0, 3))
    walls(material((0.12, 0.25, 0.15), 0.9, "ShaderNodeTexChecker", 6, (0.05, 0.1, 0.06)), 4, 6.5, 3.0)
    sun((1.05, 0.0, -0.7), 4.0)
    sky((0.45, 0.6, 0.9), 0.7)


def beach():
    floor(material((0.6, 0.5, 0.36), 0.95, "ShaderNodeTexNoise", 30, (0.5, 0.42, 0.3)))
    walls(material((0.2, 0.4, 0.6), 0.9), 12, 6.5, 1.0)
    sun((1.2, 0.0, 2.5), 3.5)
    sky((0.45, 0.65, 0.95), 0.9)


def spot():
    floor(material((0.4, 0.25, 0.12), 0.7, "ShaderNodeTexWave", 3, (0.3, 0.17, 0.08)))
    walls(material((0.4, 0.42, 0.5), 0.9, "ShaderNodeTexNoise", 4, (0.3, 0.3, 0.36)), 5, 5.0)
    light((2.5, -2.0, 3.1), 350, 0.15, (1, 0.9, 0.75))
    sky((0.5, 0.5, 0.55), 0.35)


def greens():
    cloth = material((0.07, 0.3, 0.08), 0.85)
    floor(cloth)
    walls(cloth, 8, 5.0)
    light((2, -2.5, 3.1), 220, 1.6)
    light((-2.5, 0, 3.1), 160, 1.2)
    light((0.5, 2.8, 3.0), 120, 1.2)


def asphalt():
    floor(material((0.2, 0.2, 0.21), 0.9, "ShaderNodeTexNoise", 30, (0.13, 0.13, 0.14)))
    walls(material((0.3, 0.3, 0.31), 0.9, "ShaderNodeTexBrick", 2, (0.25, 0.25, 0.26)), 5, 6.0, 2.0)
    sun((0.45, 0.1, 0.8), 4.0)
    sky((0.5, 0.65, 0.95), 0.8)


def performer():
    """Somebody in shirt and trousers with both arms raised, a skin over joints."""
    joints = {"pelvis": (0, 0, 0.95, 0.15), "spine": (0, 0, 1.15, 0.135), "chest": (0, -0.02, 1.38, 0.155),
              "neck": (0, 0, 1.53, 0.06), "head": (0, -0.03, 1.68, 0.105), "top": (0, -0.02, 1.8, 0.085)}
    bones = [("pelvis", "spine"), ("spine", "chest"), ("chest", "neck"), ("neck", "head"), ("head", "top")]
    stride = math.sin(7 * seed / 3)
    for side, which in ((1, "l"), (-1, "r")):
        lift = 0.35 * (1 + math.sin(2 * seed + side))
        swing = -0.15 * side * stride
        joints.update({
            "hip" + which: (side * 0.1, 0, 0.88, 0.11),
            "knee" + which: (side * 0.12, -0.12 * max(0, side * stride) - 0.02, 0.5, 0.07),
            "ankle" + which: (side * 0.13, swing + 0.05, 0.1, 0.05),
            "toe" + which: (side * 0.14, swing - 0.13, 0.05, 0.045),
            "shoulder" + which: (side * 0.2, 0, 1.45, 0.075),
            "elbow" + which: (side * (0.27 + 0.2 * lift), -0.05, 1.2 + 0.25 * lift, 0.05),
            "wrist" + which: (side * (0.3 + 0.25 * lift), -0.25, 1.15 + 0.5 * lift, 0.035),
            "hand" + which: (side * (0.31 + 0.27 * lift), -0.33, 1.17 + 0.6 * lift, 0.045)})
        for chain in (["pelvis", "hip", "knee", "ankle", "toe"], ["chest", "shoulder", "elbow", "wrist", "hand"]):
            chain = [chain[0]] + [name + which for name in chain[1:]]
            bones += list(zip(chain, chain[1:]))
    names = list(joints)
    sticks = bpy.data.meshes.new("sticks")
    sticks.from_pydata([joints[n][:3] for n in names], [(names.index(a), names.index(b)) for a, b in bones], [])
    body = bpy.data.objects.new("body", sticks)
    scene.collection.objects.link(body)
    bpy.context.view_layer.objects.active = body
    body.modifiers.new("skin", "SKIN")
    body.modifiers.new("smooth", "SUBSURF").levels = 2
    for vertex, name in zip(sticks.skin_vertices[0].data, names):
        vertex.radius = (joints[name][3], joints[name][3])
    sticks.skin_vertices[0].data[0].use_root = True
    skin = bpy.data.meshes.new_from_object(body.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(body, do_unlink=True)
    trousers = dice.choice([(0.1, 0.13, 0.25), (0.3, 0.25, 0.2), (0.08, 0.08, 0.08)])
    for of in (material((0.75, 0.48, 0.36), 0.6), material((0.05, 0.03, 0.02), 0.5), material(shirt[0], 0.9, *shirt[1:]),
               material(trousers, 0.9, "ShaderNodeTexNoise", 30), material((0.05, 0.04, 0.04), 0.5)):
        skin.materials.append(of)
    bare = [Vector(joints[part + which][:3]) for part in ("hand", "wrist") for which in "lr"]
    for face in skin.polygons:
        face.use_smooth = True
        c = face.center
        hair = c.z > 1.74 or (c.z > 1.58 and c.y > 0.02)
        bare_skin = c.z > 1.52 or min((c - joint).length for joint in bare) < 0.12
        face.material_index = 1 if hair else 0 if bare_skin else 2 if c.z > 0.93 else 3 if c.z > 0.1 else 4
    made = bpy.data.objects.new("performer", skin)
    scene.collection.objects.link(made)
    made.location, made.rotation_euler = (0.1, 0.15, 0), (0, 0, seed)
    return made


def lectern():
    """And a stand: from some sides before the performer."""
    box((0.75, 0.1, 0.5), (0.45, 0.6, 1.0), material((0.3, 0.18, 0.1), 0.6, "ShaderNodeTexWave", 4, (0.2, 0.1, 0.06)), 0.4)
    yield bpy.context.object
    pole((-0.1, -0.75, 0.8), 0.03, 1.6, material((0.03, 0.03, 0.03)))
    yield bpy.context.object


def rail():
    """And an armchair."""
    wood = material((0.3, 0.18, 0.1), 0.6)
    for z in (0.45, 0.95):
        box((0, -0.8, z), (3.0, 0.05, 0.06), wood, 0.2)
        yield bpy.context.object
    for x in (-1.2, 0, 1.2):
        pole((x, -0.8 + 0.2 * x, 0.5), 0.03, 1.0, wood)
        yield bpy.context.object
    for center, size in (((-0.6, 0.5, 0.25), (0.6, 0.6, 0.5)), ((-0.6, 0.85, 0.6), (0.6, 0.1, 0.7)),
                         ((-0.3, 0.5, 0.4), (0.1, 0.6, 0.4)), ((-0.9, 0.5, 0.4), (0.1, 0.6, 0.4))):
        box(center, size, wood)
        yield bpy.context.object


def ring_of_cameras():
    ring = []
    for k in range(cameras):
        turn = 2 * math.pi * k / cameras + dice.uniform(-0.15, 0.15)
        lens = bpy.data.cameras.new("lens")
        lens.sensor_width, lens.lens = 36, focal / width * 36
        camera = bpy.data.objects.new("camera", lens)
        scene.collection.objects.link(camera)
        camera.location = around(turn, dice.uniform(3.0, 3.5), dice.uniform(0.9, 2.3))
        aim = Vector((dice.uniform(-0.1, 0.1), dice.uniform(-0.1, 0.1), 0.92)) - camera.location
        camera.rotation_euler = aim.to_track_quat("-Z", "Y").to_euler()
        ring.append(camera)
    bpy.context.view_layer.update()
    return ring


def write_model(ring):
    os.makedirs(out + "/sparse", exist_ok=True)
    open(out + "/sparse/points3D.txt", "w").close()
    with open(out + "/sparse/cameras.txt", "w") as lenses, open(out + "/sparse/images.txt", "w") as poses:
        for k, camera in enumerate(ring):
            lenses.write(f"{k + 1} PINHOLE {width} {height} {focal} {focal} {width / 2} {height / 2}\n")
            # Blender's cameras look along -z with y up.
            cam_from_world = (camera.matrix_world.to_3x3() @ Matrix(((1, 0, 0), (0, -1, 0), (0, 0, -1)))).transposed()
            q, t = cam_from_world.to_quaternion(), -(cam_from_world @ camera.location)
            poses.write(f"{k + 1} {q.w} {q.x} {q.y} {q.z} {t.x} {t.y} {t.z} {k + 1} cam{k:02d}.png\n\n")


def render(ring, name, first_seed):
    for k, camera in enumerate(ring):
        scene.camera, scene.cycles.seed = camera, first_seed + k
        scene.render.filepath = f"{out}/{name.format(k)}"
        bpy.ops.render.render(write_still=True)


scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", samples, False
scene.cycles.max_bounces = 4
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
scene.view_settings.view_transform = "Standard"
scene.render.image_settings.file_format = "PNG"
scene.render.image_settings.color_mode = "RGB"
scene.world = bpy.data.worlds.new("world")
scene.world.use_nodes = True
sky((0.5, 0.5, 0.55), 0.25)

{"tarpaulin": tarpaulin, "workshop": workshop, "lounge": lounge, "cyclorama": cyclorama, "corner": corner,
 "theatre": theatre, "gym": gym, "garden": garden, "yard": yard, "court": court, "beach": beach,
 "spot": spot, "greens": greens, "asphalt": asphalt}[stage]()
scenery = [thing for thing in scene.objects if thing.type == "MESH"]
standing = list({None: list, "lectern": lectern, "rail": rail}[beside]())
views = ring_of_cameras()
write_model(views)
render(views, "plates/cam{:02d}.png", 1000)
somebody = performer()
render(views, "pictures/cam{:02d}/000000.png", 0)
for thing in scenery:
    thing.hide_render = True
for thing in standing:
    thing.is_holdout = True
scene.render.film_transparent = True
scene.render.image_settings.color_mode = "RGBA"
render(views, "truth/cam{:02d}/000000.png", 0)
if standing:
    somebody.hide_render = True
    for thing in standing:
        thing.is_holdout = False
    render(views, "occluders/cam{:02d}.png", 0)
    for thing in standing:
        thing.hide_render = True
    somebody.hide_render = False
    render(views, "whole/cam{:02d}/000000.png", 0)
