// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/targets/export_material.h"

#include <glog/logging.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "physics/material/material_scaling.h"
#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"

namespace drape {

// The files of the folder scripts as they were when the library was built. They run inside another
// program; where a stiffness depends on the mesh, they measure it there.
extern const char *const kNewtonScript, *const kStyle3dScript, *const kBlenderScript;

namespace {

using Json = nlohmann::ordered_json;

// Factor of the bending energy of ppf-contact-solver: ½·kPpfBend·bend·ρ·l²/(A0 + A1)·θ² [m⁴/s²].
constexpr double kPpfBend = 1.28e-5;

// CLO's own values of what its file must have and a drape does not tell.
constexpr double kCloThickness = 0.5e-3;  // [m]
constexpr double kCloFriction = 0.03, kCloDamping = 1e-4;

constexpr char kLosesThickness[] =
    "the thickness, which is not known: CLO's default of 0.5 mm is written, --thickness sets it";
constexpr char kLosesTables[] =
    "the change of stiffness with strain and curvature: one number for each direction is left";
constexpr char kLosesCoupling[] = "c12, the coupling of the two thread directions";
constexpr char kSameEnergies[] =
    "not run in the program: its hinge and membrane energies, written again from its source as a "
    "test, are those of drapefit";
constexpr char kLosesUncertainty[] = "the standard deviations of the posterior";

// The shortest text that reads back as this number.
std::string NumberText(double value) {
  std::string text;
  AppendNumber(text, value);
  return text;
}

// A name as text between quotes in JSON, TOML and Python.
std::string QuotedText(const std::string& text) {
  std::string quoted = Json(text).dump();
  for (std::size_t at; (at = quoted.find('\x7f')) != std::string::npos;)  // TOML has no such byte
    quoted.replace(at, 1, "\\u007f");
  return quoted;
}

Json CloPhysical(const ExchangeRecord& record) {
  const LinearFabric& m = record.material;
  const double per_membrane = 1e3, per_rigidity = 1e9, per_density = 1e-3, per_metre = 1e3;
  Json json = {{"enFabricType", 0},
               {"fSuK", per_membrane * m.c11},
               {"fSvK", per_membrane * m.c22},
               {"fHK", per_membrane * m.shear},
               {"fBuK", per_rigidity * m.bend_weft},
               {"fBvK", per_rigidity * m.bend_warp},
               {"fBhK", per_rigidity * m.bend_bias}};
  // A ratio of 0 keeps bending linear: these stiffnesses have no effect.
  for (const char* key : {"fBuLR", "fBvLR", "fBhLR"}) json[key] = 0;
  for (const char* key : {"fBucklingStiffnessU", "fBucklingStiffnessV", "fBucklingStiffnessH"})
    json[key] = 0;
  json["fDensity"] = per_density * m.density;
  json["fThickness"] = per_metre * record.thickness.value_or(kCloThickness);
  json["fFriction"] = kCloFriction;
  json["fIDS"] = kCloDamping;
  for (const char* key : {"listNonlinearSuK", "listNonlinearSvK", "listNonlinearHK"})
    json[key] = Json::array();
  for (const char* key : {"qsPhysicalPropertyName", "qsPhysicalPropertyNameUTF8"})
    json[key] = record.source.material.name;
  return json;
}

// The fabric as a Python dictionary.
std::string FabricText(const ExchangeRecord& record,
                       const std::vector<std::pair<std::string, double>>& more) {
  std::string text = "FABRIC = {\n    \"name\": " + QuotedText(record.source.material.name) + ",\n";
  const auto add = [&](const std::string& key, double value) {
    text += "    \"" + key + "\": " + NumberText(value) + ",\n";
  };
  add("density", record.material.density);
  for (const LinearNumber& number : LinearNumbers()) add(number.key, record.material.*number.value);
  for (const auto& [key, value] : more) add(key, value);
  return text + "}\n";
}

// The script with its empty dictionary replaced by the fabric, without the line of the licence.
std::string ScriptText(std::string script, const ExchangeRecord& record,
                       const std::vector<std::pair<std::string, double>>& more = {}) {
  constexpr char kEmpty[] = "FABRIC = {}\n";
  script.erase(0, script.find('\n') + 1);
  const size_t at = script.find(kEmpty);
  CHECK_NE(at, std::string::npos);
  return script.replace(at, sizeof(kEmpty) - 1, FabricText(record, more));
}

ExportedMaterial ExportArcsim(const ExchangeRecord& record) {
  const MaterialField& tables = record.source.material.field;
  const Json json = {{"density", tables.density},
                     {"stretching", tables.stretch[0].c},
                     {"bending", tables.bend[0].b}};
  return {.file = "arcsim.json",
          .text = json.dump(2) + "\n",
          .tables = tables,
          .use =
              "name the file as \"data\" in the materials of an ARCSim scene, with density, "
              "stretching and bending multipliers of 1",
          .lost = {},
          .evidence =
              "not run in ARCSim: drapefit's reader of ARCSim materials finds the same numbers"};
}

ExportedMaterial ExportClo(const ExchangeRecord& record) {
  const Json json = {{"qsFabricName", record.source.material.name},
                     {"qsFabricNameUTF8", record.source.material.name},
                     {"uiFabricVersion", 100},
                     {"uiVersion", 100},
                     {"mapPhysical", CloPhysical(record)}};
  LinearFabric meaning = record.material;
  meaning.c12 = 0.0;
  ExportedMaterial exported = {
      .file = "clo.jfab",
      .text = json.dump(2) + "\n",
      .tables = TablesFrom(meaning),
      .use = "Add Fabric in CLO or Marvelous Designer; friction and damping are CLO's defaults",
      .lost = {kLosesCoupling, kLosesTables},
      .evidence =
          "not run in CLO: how its meshes bend is not known, so drapes may be off by 20 points of "
          "DC; units as Unreal's importer of CLO files reads them (g/s2, g mm2/s2, g/mm2, mm)"};
  if (!record.thickness) exported.lost.emplace_back(kLosesThickness);
  return exported;
}

ExportedMaterial ExportJson(const ExchangeRecord& record) {
  return {
      .file = "fabric.json",
      .text = RecordJson(record).dump(2) + "\n",
      .tables = TablesFrom(record.material),
      .use = "the neutral record: linear numbers with their uncertainty, and the whole tables",
      .lost =
          {"the change of stiffness with strain and curvature, for readers of \"linear\" alone"},
      .evidence = "no program: the numbers that the other targets are computed from"};
}

ExportedMaterial ExportPpf(const ExchangeRecord& record) {
  LinearFabric material = record.material;
  const double rho = material.density, c = (material.c11 + material.c22) / 2.0;
  const double m = c / rho, L = material.shear / rho, bend = 1.0 / (kPpfBend * rho);
  // The part that all directions share; the others are added to it.
  const double least = std::min(material.bend_weft, material.bend_warp);
  std::string text = "# ppf-contact-solver, presets of its Blender add-on (SI units).\n";
  text += "# bend_warp and bend_weft need a UV map whose U runs along the warp; meshes of\n";
  text += "# drapefit have U along the weft: exchange the two numbers for them.\n";
  text += "[" + QuotedText(record.source.material.name) + "]\n";
  text += "description = \"exported by drapefit\"\n";
  text += "object_type = \"SHELL\"\n";
  text += "shell_model = \"BARAFF_WITKIN\"\n";
  text += "shell_density = " + NumberText(rho) + "\n";
  text += "shell_young_modulus = " + NumberText(m * (3.0 * L + 2.0 * m) / (L + m)) + "\n";
  text += "young_mod_density_normalized = true\n";
  text += "shell_poisson_ratio = " + NumberText(L / (2.0 * (L + m))) + "\n";
  text += "bend = " + NumberText(bend * least) + "\n";
  text += "bend_warp = " + NumberText(bend * (material.bend_warp - least)) + "\n";
  text += "bend_weft = " + NumberText(bend * (material.bend_weft - least)) + "\n";
  text += "enable_strain_limit = false\n";
  material.c11 = material.c22 = c;
  material.c12 = 0.0;
  material.bend_bias = (material.bend_weft + material.bend_warp) / 2.0;
  return {.file = "ppf.toml",
          .text = text,
          .tables = TablesFrom(material),
          .use =
              "append the table to presets/materials.toml of the add-on; the Python interface "
              "has the same numbers under young-mod, poiss-rat, bend, bend-warp and bend-weft",
          .lost = {"the difference of c11 and c22: their mean is left", kLosesCoupling,
                   "the rigidity along the bias, which is the mean of weft and warp there",
                   kLosesTables},
          .evidence = kSameEnergies};
}

ExportedMaterial ExportNewton(const ExchangeRecord& record, IsotropicChoice keep) {
  const IsotropicSheet sheet = MakeIsotropic(record.material, keep);
  return {.file = "newton.py",
          .text = ScriptText(kNewtonScript, record, {{"mu", sheet.mu}, {"lambda", sheet.lambda}}),
          .tables = TablesFrom(WithIsotropicMembrane(record.material, sheet)),
          .use =
              "import it, pass cloth_arguments(\"vbd\") to add_cloth_mesh, and call apply(model, "
              "uv) after finalize()",
          .lost = {"the anisotropy of the membrane: it is isotropic, with --isotropic=" +
                       std::string(ToString(keep)) +
                       Format(" a shear rigidity of %.3g in place of %.3g N/m", sheet.mu,
                              record.material.shear),
                   kLosesTables},
          .evidence = kSameEnergies};
}

ExportedMaterial ExportStyle3d(const ExchangeRecord& record) {
  LinearFabric meaning = record.material;
  meaning.c12 = 0.0;
  return {.file = "newton_style3d.py",
          .text = ScriptText(kStyle3dScript, record),
          .tables = TablesFrom(meaning),
          .use = "import it and pass **cloth_arguments() to newton.solvers.style3d.add_cloth_mesh",
          .lost = {kLosesCoupling, kLosesTables},
          .evidence = kSameEnergies};
}

ExportedMaterial ExportBlender(const ExchangeRecord& record, FaceKind faces) {
  LinearFabric meaning = WithMeanRigidity(record.material);
  meaning.c11 = meaning.c22 = (meaning.c11 + meaning.c22) / 2.0;
  meaning.c12 = meaning.shear;  // of the diagonals
  if (faces == FaceKind::kTriangles) {
    // Springs of stiffness k along the edges of equilateral triangles: c11 = 3√3/4·k, c12 = G =
    // √3/4·k; the script gives k = √3/2·c11.
    meaning.c12 = meaning.shear = 0.375 * meaning.c11;
    meaning.c11 = meaning.c22 = 3.0 * meaning.c12;
  }
  return {
      .file = "blender_cloth.py",
      .text = ScriptText(kBlenderScript, record),
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
          "in Blender 3.4.1 discs of 300 to 1,200 vertices drape like the fabric, 23 of 24 within "
          "three points of DC, so do three on a ball, and a cantilever of quads bends by its "
          "rigidity to 2 %"};
}

ExportedMaterial Dispatch(ExportTarget target, const ExchangeRecord& record,
                          const ExportOptions& options) {
  switch (target) {
    case ExportTarget::kArcsim:
      return ExportArcsim(record);
    case ExportTarget::kClo:
      return ExportClo(record);
    case ExportTarget::kNewton:
      return ExportNewton(record, options.keep);
    case ExportTarget::kStyle3d:
      return ExportStyle3d(record);
    case ExportTarget::kPpf:
      return ExportPpf(record);
    case ExportTarget::kBlender:
      return ExportBlender(record, options.faces);
    case ExportTarget::kJson:
      return ExportJson(record);
  }
  LOG(FATAL) << "no such target";
}

}  // namespace

bool BendsAtHinges(ExportTarget target) {
  return target != ExportTarget::kClo && target != ExportTarget::kJson;
}

ExportedMaterial ExportMaterial(ExportTarget target, const ExchangeRecord& record,
                                const ExportOptions& options) {
  ExchangeRecord given = record;
  if (BendsAtHinges(target)) {
    given.source.material.field = Scaled(record.source.material.field, 1.0, options.bend_factor);
    for (double LinearFabric::*bend :
         {&LinearFabric::bend_weft, &LinearFabric::bend_warp, &LinearFabric::bend_bias})
      given.material.*bend *= options.bend_factor;
  }
  ExportedMaterial exported = Dispatch(target, given, options);
  if (record.source.posterior && target != ExportTarget::kJson)
    exported.lost.emplace_back(kLosesUncertainty);
  if (!record.source.material.warp_known)
    exported.lost.push_back(
        "which direction is the warp, which the fit does not know: here it is "
        "the " +
        record.directions.warp + " one");
  return exported;
}

}  // namespace drape
