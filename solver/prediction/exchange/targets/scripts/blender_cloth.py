# SPDX-License-Identifier: Apache-2.0
"""A fabric for the cloth of Blender. Select the mesh and run it.

Exported by drapefit. Units: kg/m2, N/m, N m.
bend_weft is the rigidity for bending along the weft, of hinges with edges along the warp.
"""
import bpy

FABRIC = {}

VERTEX_MASS = 0.3  # kg, Blender's default: only its ratio to the stiffnesses decides the shape
QUALITY = 40  # steps a frame, at least: with fewer, fine meshes do not come to rest


def measure(obj):
    """What the stiffnesses depend on, of the mesh at rest in metres."""
    mesh, world = obj.data, obj.matrix_world
    points = [world @ v.co for v in mesh.vertices]
    sides = {}
    area = 0.0
    for polygon in mesh.polygons:
        corners = [points[i] for i in polygon.vertices]
        centre = sum(corners[1:], corners[0]) / len(corners)
        size = sum(
            (b - corners[0]).cross(c - corners[0]).length / 2.0
            for b, c in zip(corners[1:], corners[2:])
        )
        area += size
        for key in polygon.edge_keys:
            sides.setdefault(key, []).append((centre, size, len(corners)))
    length = hinge = lever = 0.0
    for (i, j), faces in sides.items():
        edge = points[j] - points[i]
        length += edge.length
        if len(faces) != 2:
            continue
        heights = sum((2.0 if n == 3 else 1.0) * size for _, size, n in faces) / edge.length
        arms = sum(edge.cross(centre - points[i]).length for centre, _, _ in faces) / edge.length
        hinge += edge.length / heights
        lever += edge.length * arms / 2.0
    quads = sum(len(p.vertices) == 4 for p in mesh.polygons)
    return {
        "area": area,
        "vertices": len(points),
        "spring": length / len(sides),
        "hinge": hinge / lever,
        "quads": 2 * quads > len(mesh.polygons),
    }


def apply(obj):
    """Adds a cloth of this fabric to the object, or sets the one that it has."""
    mesh = measure(obj)
    cloth = next((m for m in obj.modifiers if m.type == "CLOTH"), None)
    if cloth is None:
        cloth = obj.modifiers.new("Cloth", "CLOTH")
    # Blender takes a thousandth of gravity, so a thousandth of all stiffnesses, and gives all
    # vertices one mass.
    scale = 1e-3 * VERTEX_MASS * mesh["vertices"] / (FABRIC["density"] * mesh["area"])
    stretch = (FABRIC["c11"] + FABRIC["c22"]) / 2.0
    bend = (FABRIC["bend_weft"] + 2.0 * FABRIC["bend_bias"] + FABRIC["bend_warp"]) / 4.0
    # The diagonals of quads resist stretch too; triangles have none.
    threads = max(stretch - FABRIC["shear"], 0.0) if mesh["quads"] else 0.866 * stretch
    settings = cloth.settings
    settings.mass = VERTEX_MASS
    settings.quality = max(settings.quality, QUALITY)
    settings.bending_model = "ANGULAR"
    settings.tension_stiffness = scale * threads * mesh["spring"]
    settings.compression_stiffness = settings.tension_stiffness
    settings.shear_stiffness = scale * FABRIC["shear"] * mesh["spring"]
    settings.bending_stiffness = 20.0 * scale * bend * mesh["hinge"]
    print(
        "%s: %s, tension %.4g, shear %.4g, bending %.4g"
        % (
            obj.name,
            FABRIC["name"],
            settings.tension_stiffness,
            settings.shear_stiffness,
            settings.bending_stiffness,
        )
    )
    return cloth


if __name__ == "__main__":
    selected = [o for o in bpy.context.selected_objects if o.type == "MESH"]
    if not selected:
        raise SystemExit("select the mesh of the cloth first")
    for selected_object in selected:
        apply(selected_object)
