// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/util/math/random.h"
#include "physics/util/text_format.h"
#include "solver/prediction/exchange/targets/target_list.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// What CLO's file must have and a drape does not tell; CLO's own values.
constexpr double kCloThickness = 0.5e-3;  // [m]
constexpr double kCloFriction = 0.03, kCloDamping = 1e-4;

constexpr char kLosesThickness[] =
    "the thickness, which is not known: CLO's default of 0.5 mm is written, --thickness sets it";
constexpr char kLosesAnisotropy[] = "the difference of weft, warp and bias: means are left";

// A version 4 UUID that is a function of the text.
std::string UuidFor(const std::string& text) {
  uint64_t seed = 0xcbf29ce484222325;  // FNV-1a
  for (const unsigned char c : text) seed = (seed ^ c) * 0x100000001b3;
  const uint64_t high = SeedOfStream(seed, 0), low = SeedOfStream(seed, 1);
  const auto part = [](uint64_t bits, int shift, uint64_t mask) {
    return static_cast<unsigned long long>((bits >> shift) & mask);
  };
  return Format("%08llx-%04llx-4%03llx-%04llx-%012llx", part(high, 32, 0xffffffff),
                part(high, 16, 0xffff), part(high, 0, 0xfff), part(low, 48, 0x3fff) | 0x8000,
                part(low, 0, 0xffffffffffff));
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
  // Ratio 0: bending stays linear, so that these stiffnesses have no effect.
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
    json[key] = record.source.name;
  return json;
}

}  // namespace

ExportedMaterial ExportClo(const ExchangeRecord& record) {
  const Json json = {{"qsFabricName", record.source.name},
                     {"qsFabricNameUTF8", record.source.name},
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
      .verified = false,
      .evidence =
          "units as Unreal's importer of CLO files reads them (g/s2, g mm2/s2, g/mm2, "
          "mm); whether bending is by hinge or by length, a factor of up to 1.15, is "
          "not known; not run in CLO"};
  if (!record.thickness) exported.lost.emplace_back(kLosesThickness);
  return exported;
}

ExportedMaterial ExportUnreal(const ExchangeRecord& record) {
  const LinearFabric& m = record.material;
  // ½·k·θ² of a hinge by k in kg·cm²/(rad²·s²), on equilateral triangles: 1e4·2·D·l/(h0 + h1).
  const double per_rigidity = 1e4 * 2.0 / std::sqrt(3.0);
  const Json json = {{"BendingStiffnessWeft", per_rigidity * m.bend_weft},
                     {"BendingStiffnessWarp", per_rigidity * m.bend_warp},
                     {"BendingStiffnessBias", per_rigidity * m.bend_bias},
                     {"StretchStiffnessWeft", m.c11},
                     {"StretchStiffnessWarp", m.c22},
                     {"StretchStiffnessBias", m.shear},
                     {"Density", m.density}};
  LinearFabric meaning = m;
  meaning.c12 = 0.0;
  return {.file = "unreal.json",
          .text = json.dump(2) + "\n",
          .tables = TablesFrom(meaning),
          .use =
              "copy the numbers into the anisotropic bending and stretch nodes of a Chaos Cloth "
              "dataflow; they are of equilateral triangles",
          .lost = {kLosesCoupling, kLosesTables,
                   "independence of the mesh: bending holds for nearly equilateral triangles"},
          .verified = false,
          .evidence = "units as stated in the headers of Chaos Cloth; not run in Unreal"};
}

ExportedMaterial ExportU3m(const ExchangeRecord& record) {
  constexpr char kTime[] = "1970-01-01T00:00:00.000Z";  // the same file for the same fabric
  Json physics = {{"weight", 1e3 * record.material.density}};
  if (record.thickness) physics["thickness"] = 1e3 * *record.thickness;
  const Json json = {{"schema", "1.1"},
                     {"material",
                      {{"id", UuidFor(RecordJson(record).dump())},
                       {"name", record.source.name},
                       {"description", "exported by drapefit"},
                       {"created", kTime},
                       {"modified", kTime},
                       {"front", nullptr},
                       {"back", nullptr},
                       {"side", nullptr},
                       {"physics", physics}}},
                     {"custom", {{"drapefit", RecordJson(record)}}}};
  return {.file = "fabric.u3m",
          .text = json.dump(2) + "\n",
          .tables = TablesFrom(record.material),
          .use =
              "a U3M 1.1 material with weight and thickness; the stiffnesses are in its section "
              "custom.drapefit",
          .lost = {"all stiffnesses for programs that do not read custom.drapefit: U3M has no "
                   "field for them, only measured strips of one device"},
          .verified = false,
          .evidence = "written by the published schema; not opened in a program"};
}

ExportedMaterial ExportUsda(const ExchangeRecord& record) {
  const LinearFabric& m = record.material;
  LinearFabric meaning = WithMeanRigidity(m);
  meaning.c11 = meaning.c22 = (m.c11 + m.c22) / 2.0;
  meaning.c12 = 0.0;
  std::string text = "#usda 1.0\n(\n    defaultPrim = \"Fabric\"\n    metersPerUnit = 1\n";
  text +=
      "    kilogramsPerUnit = 1\n    doc = \"Experimental: the schema of deformable surfaces "
      "is a proposal and changes. Units: N/m, N m, kg/m2, m.\"\n)\n\n";
  text +=
      "def Material \"Fabric\" (\n    displayName = " + QuotedText(record.source.name) + "\n)\n{\n";
  const auto add = [&](const char* name, double value) {
    text += std::string("    custom float ") + name + " = " + NumberText(value) + "\n";
  };
  add("physics:surfaceStretchStiffness", meaning.c11);
  add("physics:surfaceShearStiffness", meaning.shear);
  add("physics:surfaceBendStiffness", meaning.bend_weft);
  add("physics:density", m.density);
  if (record.thickness) add("physics:thickness", *record.thickness);
  for (const RecordedNumber& number : record.numbers)
    add(("drapefit:" + number.key).c_str(), number.value);
  text += "}\n";
  return {.file = "fabric.usda",
          .text = text,
          .tables = TablesFrom(meaning),
          .use =
              "reference the material in a USD stage; the attributes drapefit:* have all "
              "directions",
          .lost = {kLosesAnisotropy, kLosesCoupling, kLosesTables},
          .verified = false,
          .evidence =
              "experimental: custom attributes under the names of a proposal, which no "
              "released schema has; not opened in a program"};
}

}  // namespace drape
