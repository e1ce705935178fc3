# SPDX-License-Identifier: Apache-2.0
"""Loads all cloths and bodies of drape_garment with their motion, those of each folder 1.5 m aside.

usage: blender --python load_in_blender.py -- FOLDER...
"""

import pathlib
import struct
import sys

import bpy

scene = bpy.context.scene
scene.render.fps, scene.frame_start, scene.frame_end = 25, 1, 1
for mesh in [each for each in bpy.data.objects if each.type == "MESH"]:
    bpy.data.objects.remove(mesh)  # the cube of Blender's first scene
folders = [pathlib.Path(each).resolve() for each in sys.argv[sys.argv.index("--") + 1:]]
for i, folder in enumerate(sorted({cache.parent for each in folders for cache in each.rglob("*.pc2")})):
    for cache in folder.glob("*.pc2"):
        bpy.ops.wm.obj_import(filepath=str(cache.with_suffix(".obj")), forward_axis="Y", up_axis="Z")
        bpy.ops.object.shade_smooth()
        loaded = bpy.context.object
        loaded.name, loaded.location.x = f"{folder.name} {cache.stem}", 1.5 * i
        motion = loaded.modifiers.new("motion", "MESH_CACHE")
        motion.cache_format, motion.filepath, motion.frame_start = "PC2", str(cache), scene.frame_start
        frames, = struct.unpack("<i", cache.read_bytes()[28:32])
        scene.frame_end = max(scene.frame_end, frames)
