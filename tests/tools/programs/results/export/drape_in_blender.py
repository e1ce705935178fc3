# SPDX-License-Identifier: Apache-2.0
"""Drapes a flat cloth in Blender with the script that drape_export has written.

usage: blender -b --factory-startup --python drape_in_blender.py --
       SCRIPT FLAT.obj OUT.obj [--held=RADIUS] [--sphere=RADIUS] [--frames=N] [--start=N]
The cloth falls from FLAT.obj, whose hem has small waves at first, others by start 1, 2, … Held:
what is within this radius [m]. Sphere: the cloth falls on a sphere of this radius whose top is just
below its centre. Prints how far a vertex moved in the last frame [m].
"""
import math
import sys

import bpy

arguments = sys.argv[sys.argv.index("--") + 1:]
script, flat, out = [a for a in arguments if not a.startswith("--")]
options = dict(a[2:].split("=") for a in arguments if a.startswith("--"))
frames, start_number = int(options.get("frames", 180)), int(options.get("start", 1))
waves = 2e-3
FOLDS = range(2, 13)


def read(path):
    points, faces = [], []
    for line in open(path):
        kind, *values = line.split() or [""]
        if kind == "v":
            points.append([float(value) for value in values[:3]])
        if kind == "f":
            faces.append([int(value.split("/")[0]) - 1 for value in values])
    return points, faces


points, faces = read(flat)
bpy.ops.wm.read_factory_settings(use_empty=True)
mesh = bpy.data.meshes.new("cloth")
mesh.from_pydata(points, [], faces)
cloth = bpy.data.objects.new("cloth", mesh)
bpy.context.scene.collection.objects.link(cloth)
exported = {"__name__": "exported"}
exec(compile(open(script).read(), script, "exec"), exported)
modifier = exported["apply"](cloth)
modifier.settings.air_damping = 1.0
reach = max(math.hypot(x, y) for x, y, _ in points)
held = float(options.get("held", 0.0))
if held > 0.0:
    group = cloth.vertex_groups.new(name="held")
    group.add([i for i, (x, y, _) in enumerate(points) if math.hypot(x, y) <= held + 1e-9], 1.0,
              "REPLACE")
    modifier.settings.vertex_group_mass = "held"
if "sphere" in options:
    radius = float(options["sphere"])
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, segments=96, ring_count=48,
                                         location=(0, 0, -radius - 2e-3))
    sphere = bpy.context.object
    sphere.modifiers.new("Collision", "COLLISION")
    sphere.collision.thickness_outer = 1e-3
    sphere.collision.cloth_friction = 0.0
    modifier.collision_settings.distance_min = 1e-3
else:
    modifier.collision_settings.use_collision = False

# The start is a shape, so that the cloth is at rest where it is flat.
cloth.shape_key_add(name="flat")
start = cloth.shape_key_add(name="start")
for i, (x, y, z) in enumerate(points):
    r, angle = math.hypot(x, y), math.atan2(y, x)
    if r > held:
        wave = sum(math.cos(k * angle + start_number * k * k) for k in FOLDS) / math.sqrt(len(FOLDS))
        start.data[i].co = (x, y, z + waves * wave * (r - held) / (reach - held))
start.value = 1.0
modifier.settings.rest_shape_key = cloth.data.shape_keys.key_blocks["flat"]

scene = bpy.context.scene
scene.frame_end = modifier.point_cache.frame_end = frames + 1
before = points
for frame in range(1, frames + 2):
    scene.frame_set(frame)
    seen = cloth.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh().vertices
    now = [tuple(vertex.co) for vertex in seen]
    moved = max(math.dist(a, b) for a, b in zip(now, before))
    before = now
with open(out, "w") as file:
    file.writelines("v %.8g %.8g %.8g\n" % point for point in before)
    file.writelines("f " + " ".join(str(i + 1) for i in face) + "\n" for face in faces)
print("MOVED", moved)
