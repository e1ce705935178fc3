// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "physics/util/text_format.h"
#include "solver/prediction/exchange/targets/target_list.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// Factor of the bending energy of ppf-contact-solver: ½·kPpfBend·bend·ρ·l²/(A0 + A1)·θ² [m⁴/s²].
constexpr double kPpfBend = 1.28e-5;

template <int kRows, int kCols>
Json Rows(const double (&table)[kRows][kCols]) {
  Json rows = Json::array();
  for (int r = 0; r < kRows; ++r)
    for (int c = 0; c < kCols; ++c) rows[r][c] = table[r][c];
  return rows;
}

}  // namespace

ExportedMaterial ExportArcsim(const ExchangeRecord& record) {
  const MaterialField& tables = record.source.tables;
  const Json json = {{"density", tables.density},
                     {"stretching", Rows(tables.stretch[0].c)},
                     {"bending", Rows(tables.bend[0].b)}};
  return {.file = "arcsim.json",
          .text = json.dump(2) + "\n",
          .tables = tables,
          .use =
              "name the file as \"data\" in the materials of an ARCSim scene, with density, "
              "stretching and bending multipliers of 1",
          .lost = {},
          .verified = true,
          .evidence =
              "read back by drapefit's reader of ARCSim materials, it drapes to the same "
              "bytes; not run in ARCSim"};
}

ExportedMaterial ExportJson(const ExchangeRecord& record) {
  return {
      .file = "fabric.json",
      .text = RecordJson(record).dump(2) + "\n",
      .tables = TablesFrom(record.material),
      .use = "the neutral record: linear numbers with their uncertainty, and the whole tables",
      .lost =
          {"the change of stiffness with strain and curvature, for readers of \"linear\" alone"},
      .verified = true,
      .evidence = "the numbers are those that the other targets are computed from"};
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
  text += "[" + QuotedText(record.source.name) + "]\n";
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
          .verified = false,
          .evidence =
              "its hinge and membrane energies, written again from its source as a test, "
              "are those of drapefit; not run in the program"};
}

}  // namespace drape
