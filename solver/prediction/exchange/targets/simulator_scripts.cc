// SPDX-License-Identifier: Apache-2.0
#include "physics/util/text_format.h"
#include "solver/prediction/exchange/targets/target_list.h"

// Scripts that run inside another program. Where a stiffness depends on the mesh, they measure it
// there.

namespace drape {
namespace {

constexpr char kNewtonScript[] = R"py(

def cloth_arguments(solver="vbd"):
    """Arguments of ModelBuilder.add_cloth_mesh; solver: "vbd" or "semi_implicit".

    The two solvers give tri_ka another meaning. Bending: see apply().
    """
    mu, lame = FABRIC["mu"], FABRIC["lambda"]
    tri_ka = {"vbd": lame, "semi_implicit": lame + mu}[solver]
    return {"density": FABRIC["density"], "tri_ke": mu, "tri_ka": tri_ka, "edge_ke": 0.0}


def rigidity(du, dv):
    """Rigidity [N m] of a hinge whose edge has this direction along (weft, warp)."""
    row = 4.0 / math.pi * abs(math.atan2(dv, du))
    row = min(row, 4.0 - row)
    rows = (FABRIC["bend_warp"], FABRIC["bend_bias"], FABRIC["bend_weft"])
    first = 0 if row < 1.0 else 1
    return rows[first] + (row - first) * (rows[first + 1] - rows[first])


def edge_ke(points, edges, uv=None):
    """Stiffness [N] of each edge (opposite 0, opposite 1, end 0, end 1) of a cloth at rest.

    uv: coordinates (weft, warp) of each point; without them the mean of all directions.
    """
    mean = (FABRIC["bend_weft"] + 2.0 * FABRIC["bend_bias"] + FABRIC["bend_warp"]) / 4.0
    values = []
    for o0, o1, i, j in edges:
        if o0 < 0 or o1 < 0:  # the hem
            values.append(0.0)
            continue
        edge = [b - a for a, b in zip(points[i], points[j])]
        length2 = sum(e * e for e in edge)
        heights = 0.0
        for o in (o0, o1):
            arm = [b - a for a, b in zip(points[i], points[o])]
            along = sum(a * e for a, e in zip(arm, edge))
            heights += math.sqrt(sum(a * a for a in arm) - along * along / length2)
        bend = mean if uv is None else rigidity(uv[j][0] - uv[i][0], uv[j][1] - uv[i][1])
        values.append(2.0 * bend / heights)
    return values


def apply(model, uv=None):
    """Sets the bending of a finalized model whose particles are one cloth at rest."""
    properties = model.edge_bending_properties.numpy()
    edges = model.edge_indices.numpy().reshape(-1, 4)
    properties[:, 0] = edge_ke(model.particle_q.numpy(), edges, uv)
    model.edge_bending_properties.assign(properties)
)py";

constexpr char kStyle3dScript[] = R"py(

def cloth_arguments():
    """Arguments of newton.solvers.style3d.add_cloth_mesh beside the mesh and its panels.

    panel_verts are the coordinates (weft, warp) in metres, as the vt of drapefit's OBJ files.
    The energy of a hinge there is 3/2 k l^2 / (A0 + A1) theta^2, so k is a third of the rigidity.
    """
    import warp as wp

    return {
        "density": FABRIC["density"],
        "tri_aniso_ke": wp.vec3(*tri_aniso_ke()),
        "edge_aniso_ke": wp.vec3(*edge_aniso_ke()),
    }


def tri_aniso_ke():
    """Along weft, along warp, shear [N/m]."""
    return FABRIC["c11"], FABRIC["c22"], FABRIC["shear"]


def edge_aniso_ke():
    """For bending along weft, warp and bias [N m]."""
    return FABRIC["bend_weft"] / 3.0, FABRIC["bend_warp"] / 3.0, FABRIC["bend_bias"] / 3.0
)py";

constexpr char kBlenderScript[] = R"py(
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
)py";

// The fabric as a Python dictionary.
std::string FabricText(const ExchangeRecord& record,
                       const std::vector<std::pair<std::string, double>>& more) {
  std::string text = "FABRIC = {\n    \"name\": " + QuotedText(record.source.name) + ",\n";
  const auto add = [&](const std::string& key, double value) {
    text += "    \"" + key + "\": " + NumberText(value) + ",\n";
  };
  add("density", record.material.density);
  for (const LinearNumber& number : LinearNumbers()) add(number.key, record.material.*number.value);
  for (const auto& [key, value] : more) add(key, value);
  return text + "}\n";
}

std::string ScriptText(const char* doc, const char* imports, const ExchangeRecord& record,
                       const std::vector<std::pair<std::string, double>>& more,
                       const char* functions) {
  return std::string("\"\"\"") + doc +
         "\n\nExported by drapefit. Units: kg/m2, N/m, N m.\nbend_weft is the rigidity for bending "
         "along the weft, of hinges with edges along the warp.\n\"\"\"\n" +
         imports + FabricText(record, more) + functions;
}

}  // namespace

ExportedMaterial ExportNewton(const ExchangeRecord& record, IsotropicChoice keep) {
  const IsotropicSheet sheet = MakeIsotropic(record.material, keep);
  return {.file = "newton.py",
          .text = ScriptText("A fabric for Newton's SolverVBD and SolverSemiImplicit.",
                             "import math\n\n", record,
                             {{"mu", sheet.mu}, {"lambda", sheet.lambda}}, kNewtonScript),
          .tables = TablesFrom(WithIsotropicMembrane(record.material, sheet)),
          .use =
              "import it, pass cloth_arguments(\"vbd\") to add_cloth_mesh, and call apply(model, "
              "uv) after finalize()",
          .lost = {"the anisotropy of the membrane: it is isotropic, with --isotropic=" +
                       std::string(ToString(keep)) +
                       Format(" a shear rigidity of %.3g in place of %.3g N/m", sheet.mu,
                              record.material.shear),
                   kLosesTables},
          .verified = false,
          .evidence =
              "its hinge and membrane energies, written again from its source as a test, "
              "are those of drapefit; not run in the program"};
}

ExportedMaterial ExportStyle3d(const ExchangeRecord& record) {
  LinearFabric meaning = record.material;
  meaning.c12 = 0.0;
  return {
      .file = "newton_style3d.py",
      .text = ScriptText("A fabric for Newton's SolverStyle3D.", "", record, {}, kStyle3dScript),
      .tables = TablesFrom(meaning),
      .use = "import it and pass **cloth_arguments() to newton.solvers.style3d.add_cloth_mesh",
      .lost = {kLosesCoupling, kLosesTables},
      .verified = false,
      .evidence =
          "its hinge and membrane energies, written again from its source as a test, "
          "are those of drapefit; not run in the program"};
}

ExportedMaterial ExportBlender(const ExchangeRecord& record) {
  LinearFabric meaning = WithMeanRigidity(record.material);
  meaning.c11 = meaning.c22 = (meaning.c11 + meaning.c22) / 2.0;
  meaning.c12 = meaning.shear;  // of the diagonals
  return {
      .file = "blender_cloth.py",
      .text = ScriptText("A fabric for the cloth of Blender. Select the mesh and run it.",
                         "import bpy\n\n", record, {}, kBlenderScript),
      .tables = TablesFrom(meaning),
      .use =
          "select the mesh of the cloth and run the script in Blender's text editor; with "
          "another mesh run it again",
      .lost = {"the difference of weft, warp and bias: means are left",
               "c12, which the diagonals of quads set to the shear rigidity",
               "the shear rigidity on a mesh of triangles, which has no diagonals",
               "the mass of each vertex: all have the same, so the hem is too heavy", kLosesTables},
      .verified = true,
      .evidence =
          "a cantilever of quads in Blender 3.4.1 bends as a chain of links of this "
          "rigidity, to 2 % of the rigidity"};
}

}  // namespace drape
