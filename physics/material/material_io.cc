// SPDX-License-Identifier: Apache-2.0
#include "physics/material/material_io.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "physics/material/material.h"
#include "physics/material/material_scaling.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using nlohmann::json;

constexpr char kMaterialFormat[] = "drapefit-material";
constexpr int kVersion = 1;
constexpr const char* kColumns[kStretchCols] = {"c11", "c12", "c22", "c33"};
// Settings of ARCSim beside the tables, and the moduli of another bending law [Feng 2022]; none of
// them changes the meaning of the tables.
const std::vector<std::string> kIgnoredArcsimKeys = {"damping",          "strain_min",
                                                     "strain_max",       "strain_limits",
                                                     "weakening",        "yield_curv",
                                                     "plastic_flow",     "plastic_limit",
                                                     "toughness",        "fracture_bend_thickness",
                                                     "pcb_bending_weft", "pcb_bending_warp",
                                                     "pcb_bending_bias"};
constexpr char kHowToRaise[] =
    "only the reference law accepts a negative stiffness; --min_relative_stiffness=0.1, where a "
    "program has it, raises such entries";

// The largest numbers that files of materials may hold, in the mechanical convention: at least 1e3
// times the stiffness of fabrics.
constexpr double kMinDensity = 1e-5, kMaxDensity = 1e3;  // [kg/m²]
constexpr double kMaxMembraneStiffness = 1e8;            // [N/m]
constexpr double kMaxRigidity = 100.0;                   // [N·m]

// The value in a file is the table entry × this factor.
double StretchFactor(Convention c) { return c == Convention::kMechanical ? kMembranePerEntry : 1; }
double BendFactor(Convention c) { return c == Convention::kMechanical ? 1 / kBendPerRigidity : 1; }
const char* ConventionName(Convention c) {
  return c == Convention::kMechanical ? "mechanical" : "arcsim";
}

// Notes a value that no fabric has, and the unit in which one would have it.
void NoteUnlikeFabrics(const std::string& where, double value, const std::string& unit,
                       double least, double most) {
  if (value >= least && value <= most) return;
  NoteInput(where,
            Format("found %g %s, of fabrics expected %g … %g", value, unit.c_str(), least, most) +
                UnitHint(value, unit, least, most));
}

double ReadDensity(const JsonInput& input) {
  constexpr double kLight = 0.01, kHeavy = 1.5;  // of fabrics
  const double density = input.Number();
  if (density < kMinDensity || density > kMaxDensity)
    input.Fail(Format("%g to %g kg/m²", kMinDensity, kMaxDensity) +
               UnitHint(density, "kg/m2", kLight, kHeavy));
  NoteUnlikeFabrics(input.Name(), density, "kg/m2", kLight, kHeavy);
  return density;
}

// Notes tables in other units: the largest entry of each kind is unlike a fabric's.
void NoteUnlikelyTables(const JsonInput& input, const MaterialField& field) {
  double membrane = 0.0, rigidity = 0.0;
  for (const StretchTable& table : field.stretch)
    for (const auto& row : table.c)
      for (const double entry : row) membrane = std::max(membrane, entry * kMembranePerEntry);
  for (const BendTable& table : field.bend)
    for (const auto& row : table.b)
      for (const double entry : row) rigidity = std::max(rigidity, entry / kBendPerRigidity);
  NoteUnlikeFabrics(input.Name() + ": largest stretching stiffness", membrane, "N/m", 1, 1e6);
  NoteUnlikeFabrics(input.Name() + ": largest bending rigidity", rigidity, "N*m", 1e-9, 0.1);
}

// most: the largest size of the entry, in its unit.
double ReadEntry(const JsonInput& input, double most, const MaterialPolicy& policy) {
  const double number = input.Number();
  if (number < 0 && policy.rejects()) input.Fail(std::string("≥ 0 (") + kHowToRaise + ")");
  if (std::abs(number) > most) input.Fail(Format("at most %g, far above any fabric's", most));
  return number;
}

void ExpectString(const JsonInput& value, const std::string& expected) {
  if (value.String() != expected) value.Fail('"' + expected + '"');
}

// The file that a path names, where it is the folder of a fit.
std::string FindMaterialFile(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored)) {
    const bool is_number = !path.empty() && path.find_first_not_of("0123456789-,") == path.npos;
    if (is_number && !std::filesystem::exists(path, ignored))
      throw InputError(path, "no such file; a fabric of the data set is named by --data_fabric");
    return path;
  }
  std::string file = path + "/material.json";
  if (!std::filesystem::exists(file, ignored))
    throw InputError(path, "found no material.json, expected the results of drape_fit");
  return file;
}

// Raises small entries as the policy says.
void RaiseEntries(const std::string& path, const MaterialPolicy& policy, Material* material) {
  if (policy.min_relative_stiffness == 0.0) return;
  const int raised = RaiseSmallEntries(material->field, policy.min_relative_stiffness);
  if (raised > 0)
    material->warnings.push_back(
        Format("%d entries of ", raised) + path +
        Format(" were raised to %g of their column's largest", policy.min_relative_stiffness));
}

// The member "warp" of a file, which is there only where the warp is not known.
bool KnowsWarp(const JsonInput& input) {
  if (!input.Has("warp")) return true;
  ExpectString(input.At("warp"), "unknown");
  return false;
}
std::string WarpText(const Material& material) {
  return material.warp_known ? "" : "\"warp\": \"unknown\", ";
}

// Reads one fabric from its object in the file.
class EntryReader {
 public:
  EntryReader(const JsonInput& input, const MaterialPolicy& policy)
      : input_(input), policy_(policy) {
    material_.field.stretch.resize(1);
    material_.field.bend.resize(1);
  }

  Material Read() {
    if (input_.Has("format")) {
      ReadOurs();
    } else if (input_.Has("c11")) {
      ReadPublished();
    } else {
      ReadArcsim();
    }
    material_.field.density = ReadDensity(input_.At("density"));
    RefuseNegatives();
    NoteUnlikelyTables(input_, material_.field);
    return std::move(material_);
  }

 private:
  void ReadOurs() {
    input_.ExpectKeys({"format", "version", "name", "units", "source", "convention", "warp",
                       "density", "stretch", "bend"});
    ExpectString(input_.At("format"), kMaterialFormat);
    if (input_.At("version").Integer() != kVersion) input_.At("version").Fail("1");
    if (input_.Has("units")) ExpectString(input_.At("units"), "SI");
    if (input_.Has("name")) material_.name = input_.At("name").String();
    if (input_.Has("source")) material_.source = input_.At("source").String();
    material_.warp_known = KnowsWarp(input_);
    const Convention convention = ReadConvention();
    ReadStretch("stretch", StretchFactor(convention));
    ReadBend("bend", BendFactor(convention));
    material_.source_convention = ConventionName(convention);
  }

  void ReadPublished() {
    input_.ExpectKeys({"density", "c11", "c12", "c22", "c33", "bending", "density_prior_std",
                       "c11_prior_std", "c12_prior_std", "c22_prior_std", "c33_prior_std",
                       "bending_prior_std"});
    for (int col = 0; col < kStretchCols; ++col) {
      const JsonInput column = input_.At(kColumns[col]).ExpectArray(kStretchRows);
      for (int row = 0; row < kStretchRows; ++row) {
        material_.field.stretch[0].c[row][col] =
            Entry(column.At(row), kMaxMembraneStiffness / kMembranePerEntry);
      }
    }
    ReadBend("bending", 1);
    material_.source_convention = ConventionName(Convention::kArcsim);
  }

  void ReadArcsim() {
    std::vector<std::string> allowed = {"density", "stretching", "bending"};
    allowed.insert(allowed.end(), kIgnoredArcsimKeys.begin(), kIgnoredArcsimKeys.end());
    input_.ExpectKeys(allowed);
    for (const std::string& key : kIgnoredArcsimKeys) {
      if (input_.Has(key)) material_.warnings.push_back("ARCSim's key '" + key + "' is ignored");
    }
    ReadStretch("stretching", 1);
    ReadBend("bending", 1);
    material_.source_convention = ConventionName(Convention::kArcsim);
  }

  Convention ReadConvention() {
    const JsonInput value = input_.At("convention");
    for (const Convention c : {Convention::kMechanical, Convention::kArcsim}) {
      if (value.String() == ConventionName(c)) return c;
    }
    value.Fail("\"mechanical\" or \"arcsim\"");
  }

  // Reads a table whose values in the file are its entries times `factor`.
  template <int Rows, int Cols>
  void ReadTable(const char* key, double most, double factor, double (&table)[Rows][Cols]) {
    const JsonInput rows = input_.At(key).ExpectArray(Rows);
    for (int row = 0; row < Rows; ++row) {
      const JsonInput values = rows.At(row).ExpectArray(Cols);
      for (int col = 0; col < Cols; ++col)
        table[row][col] = Entry(values.At(col), most * factor) / factor;
    }
  }
  void ReadStretch(const char* key, double factor) {
    ReadTable(key, kMaxMembraneStiffness / kMembranePerEntry, factor, material_.field.stretch[0].c);
  }
  void ReadBend(const char* key, double factor) {
    ReadTable(key, kMaxRigidity * kBendPerRigidity, factor, material_.field.bend[0].b);
  }

  double Entry(const JsonInput& value, double most) {
    const double number = ReadEntry(value, most, {NegativeEntries::kWarn});
    if (number >= 0) return number;
    negatives_.emplace_back(value.Name(), value.value().dump());
    if (policy_.warns())
      material_.warnings.push_back(value.Name() + " = " + value.value().dump() +
                                   " is negative and kept");
    return number;
  }

  // All of them in one message: a measured table often has several.
  void RefuseNegatives() const {
    if (negatives_.empty() || !policy_.rejects()) return;
    const auto& [first, value] = negatives_.front();
    std::string others;
    for (std::size_t i = 1; i < negatives_.size(); ++i) {
      const std::string& name = negatives_[i].first;
      const std::size_t key = name.rfind("key '") + 5;
      others += (i > 1 ? ", " : "; also negative: ") + name.substr(key, name.size() - 1 - key) +
                " = " + negatives_[i].second;
    }
    throw InputError(first, "found " + value + ", expected ≥ 0 (" + kHowToRaise + ")" + others);
  }

  const JsonInput& input_;
  const MaterialPolicy& policy_;
  Material material_;
  std::vector<std::pair<std::string, std::string>> negatives_;  // JsonInput::Name, value
};

bool IsEntry(const json& value) {
  return value.contains("format") || value.contains("c11") || value.contains("stretching");
}

// The names of the fabrics in a file of several; keys that begin with '_' are notes.
std::vector<std::string> EntryNames(const json& file) {
  std::vector<std::string> names;
  for (const auto& [key, value] : file.items()) {
    if (!key.starts_with('_') && value.is_object() && IsEntry(value)) names.push_back(key);
  }
  return names;
}

std::string Joined(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

std::string PickedName(const json& file, const std::string& path, const std::string& pick) {
  const std::vector<std::string> names = EntryNames(file);
  if (names.empty()) {
    throw InputError(path,
                     "no fabric found, expected key 'format' (drapefit-material), 'c11' "
                     "(published tables) or 'stretching' (ARCSim)");
  }
  if (pick.empty() && names.size() == 1) return names[0];
  if (pick.empty()) {
    throw InputError(path, "holds several fabrics, select one with '#name': " + Joined(names));
  }
  if (std::find(names.begin(), names.end(), pick) == names.end()) {
    throw InputError(path, "has no fabric '" + pick + "', found: " + Joined(names));
  }
  return pick;
}

// One fabric of a file. `pick`: its name in a file of several.
Material ReadOneFabric(const json& file, const std::string& path, const std::string& pick,
                       const MaterialPolicy& policy) {
  const JsonInput root(file, path);
  root.ExpectObject();
  const bool is_entry = IsEntry(file);
  const std::string name = is_entry ? "" : PickedName(file, path, pick);
  Material material = EntryReader(is_entry ? root : root.At(name), policy).Read();
  if (material.name.empty()) {
    material.name = is_entry ? std::filesystem::path(path).stem().string() : name;
  }
  if (is_entry && !pick.empty() && pick != material.name) {
    throw InputError(path, "has no fabric '" + pick + "', found: " + material.name);
  }
  return material;
}

Material ReadFile(const std::string& path, const MaterialPolicy& policy) {
  if (path == kBuiltInName) return ParseMaterial(kBuiltInFabric, kBuiltInName, policy);
  const auto [file, pick] = SplitMaterialPath(FindMaterialFile(path));
  const json document = ParseJson(ReadWholeFile(file, pick.empty() ? "" : "#" + pick), file);
  if (document.is_object() && document.value("format", json()) == kMaterialFieldFormat)
    throw InputError(path,
                     "found a table for each element, expected one table for the fabric, as "
                     "models homogeneous and bayes have it");
  return ReadOneFabric(document, file, pick, policy);
}

template <int kRows, int kCols>
void AppendTable(std::string& text, const double (&table)[kRows][kCols], double factor) {
  text += "[";
  for (int row = 0; row < kRows; ++row) {
    text += row == 0 ? "\n    [" : ",\n    [";
    for (int col = 0; col < kCols; ++col) {
      if (col > 0) text += ", ";
      AppendNumber(text, table[row][col] * factor);
    }
    text += "]";
  }
  text += "\n  ]";
}

// Appends the entries of each table as one row, in the convention of the file: entry × factor.
template <class Table>
void AppendTables(std::string& text, const std::vector<Table>& tables, double factor) {
  const int entries = sizeof(Table) / sizeof(double);
  text += '[';
  for (std::size_t e = 0; e < tables.size(); ++e) {
    for (int k = 0; k < entries; ++k) {
      text += k > 0 ? ", " : e > 0 ? "],\n[" : "\n[";
      AppendNumber(text, tables[e].entries()[k] * factor);
    }
  }
  text += "]]";
}

void AppendPoints(std::string& text, const Eigen::Matrix2Xd& points) {
  text += '[';
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    AppendNumber(text += i > 0 ? "], [" : "[", points(0, i));
    AppendNumber(text += ", ", points(1, i));
  }
  text += "]]";
}

Eigen::Matrix2Xd ReadPoints(const JsonInput& input) {
  Eigen::Matrix2Xd points(2, input.ExpectArray().Size());
  if (points.cols() == 0) input.Fail("at least one element");
  for (int i = 0; i < points.cols(); ++i) points.col(i) = input.At(i).Vector(2);
  return points;
}

template <class Table>
std::vector<Table> ReadTables(const JsonInput& input, int count, double factor, double most,
                              const MaterialPolicy& policy) {
  const int entries = sizeof(Table) / sizeof(double);
  std::vector<Table> tables(input.ExpectArray(count).Size());
  for (int e = 0; e < count; ++e) {
    const JsonInput table = input.At(e).ExpectArray(entries);
    for (int k = 0; k < entries; ++k)
      tables[e].entries()[k] = ReadEntry(table.At(k), most, policy) / factor;
  }
  return tables;
}

// Returns, for each requested position, the table of the nearest element of the file.
template <class Table>
std::vector<Table> Nearest(const std::vector<Table>& tables, const Eigen::Matrix2Xd& places,
                           const Eigen::Matrix2Xd& wanted) {
  std::vector<Table> nearest;
  for (const auto& place : wanted.colwise()) {
    Eigen::Index at;
    (places.colwise() - place).colwise().squaredNorm().minCoeff(&at);
    nearest.push_back(tables[at]);
  }
  return nearest;
}

Material ReadField(const Mesh& mesh, const JsonInput& input, const MaterialPolicy& policy) {
  input.ExpectKeys({"format", "version", "name", "units", "source", "convention", "warp", "density",
                    "face_centres", "stretch", "hinge_centres", "bend"});
  if (input.At("version").Integer() != 1) input.At("version").Fail("1");
  if (input.Has("units")) ExpectString(input.At("units"), "SI");
  ExpectString(input.At("convention"), "mechanical");
  Material material;
  if (input.Has("name")) material.name = input.At("name").String();
  if (input.Has("source")) material.source = input.At("source").String();
  material.warp_known = KnowsWarp(input);
  material.source_convention = "mechanical";
  material.field.density = ReadDensity(input.At("density"));
  const Eigen::Matrix2Xd faces = ReadPoints(input.At("face_centres"));
  const Eigen::Matrix2Xd hinges = ReadPoints(input.At("hinge_centres"));
  const auto stretch = ReadTables<StretchTable>(input.At("stretch"), static_cast<int>(faces.cols()),
                                                kMembranePerEntry, kMaxMembraneStiffness, policy);
  const auto bend = ReadTables<BendTable>(input.At("bend"), static_cast<int>(hinges.cols()),
                                          1 / kBendPerRigidity, kMaxRigidity, policy);
  material.field.stretch = Nearest(stretch, faces, FaceCentres(mesh));
  material.field.bend = Nearest(bend, hinges, HingeCentres(mesh));
  NoteUnlikelyTables(input, material.field);
  return material;
}

}  // namespace

MaterialPath SplitMaterialPath(const std::string& path) {
  std::error_code ignored;
  const size_t hash = path.rfind('#');
  const bool is_file = hash == std::string::npos || std::filesystem::exists(path, ignored) ||
                       path.find('/', hash) != std::string::npos;
  if (is_file) return {path, ""};
  return {path.substr(0, hash), path.substr(hash + 1)};
}

std::string MaterialLabel(const std::string& path) {
  const MaterialPath split = SplitMaterialPath(path);
  return std::filesystem::path(split.file).stem().string() +
         (split.name.empty() ? "" : "#" + split.name);
}

Material ReadMaterial(const std::string& path, const MaterialPolicy& policy) {
  Material material = ReadFile(path, policy);
  RaiseEntries(path, policy, &material);
  return material;
}

Material ParseMaterial(const std::string& text, const std::string& where,
                       const MaterialPolicy& policy) {
  return ReadOneFabric(ParseJson(text, where), where, "", policy);
}

std::string MaterialText(const Material& material, Convention convention) {
  CHECK_EQ(material.field.stretch.size(), 1u);
  CHECK_EQ(material.field.bend.size(), 1u);
  std::string text = "{\n  \"format\": " + json(kMaterialFormat).dump() + ",\n  \"version\": 1,\n";
  text += "  \"name\": " + json(material.name).dump() + ",\n  \"units\": \"SI\",\n";
  if (!material.source.empty()) text += "  \"source\": " + json(material.source).dump() + ",\n";
  text += "  " + WarpText(material) + "\"convention\": " + json(ConventionName(convention)).dump() +
          ",\n  \"density\": ";
  AppendNumber(text, material.field.density);
  AppendTable(text += ",\n  \"stretch\": ", material.field.stretch[0].c, StretchFactor(convention));
  AppendTable(text += ",\n  \"bend\": ", material.field.bend[0].b, BendFactor(convention));
  return text += "\n}\n";
}

void WriteMaterial(const std::string& path, const Material& material, Convention convention) {
  WriteFileAtomically(path, MaterialText(material, convention));
}

void WriteMaterialField(const std::string& path, const Material& material, const Mesh& mesh) {
  const MaterialField& field = material.field;
  CHECK_EQ(field.stretch.size(), static_cast<std::size_t>(mesh.num_faces()));
  CHECK_EQ(field.bend.size(), static_cast<std::size_t>(mesh.num_hinges()));
  std::string text = "{\"format\": " + json(kMaterialFieldFormat).dump() +
                     ", \"version\": 1, \"name\": " + json(material.name).dump() +
                     ", \"units\": \"SI\",\n\"source\": " + json(material.source).dump() + ",\n" +
                     WarpText(material) + "\"convention\": \"mechanical\", \"density\": ";
  AppendNumber(text, field.density);
  AppendPoints(text += ",\n\"face_centres\": ", FaceCentres(mesh));
  AppendTables(text += ",\n\"stretch\": ", field.stretch, kMembranePerEntry);
  AppendPoints(text += ",\n\"hinge_centres\": ", HingeCentres(mesh));
  AppendTables(text += ",\n\"bend\": ", field.bend, 1 / kBendPerRigidity);
  WriteFileAtomically(path, text += "}\n");
}

Material ReadMaterialFor(const Mesh& mesh, const std::string& path, const MaterialPolicy& policy) {
  const std::string file = FindMaterialFile(path);
  const bool may_be_field = path != kBuiltInName && SplitMaterialPath(file).name.empty();
  if (!may_be_field) return ReadMaterial(path, policy);
  const json document = ReadJsonFile(file);
  if (!document.is_object() || document.value("format", json()) != kMaterialFieldFormat)
    return ReadMaterial(path, policy);
  Material material = ReadField(mesh, JsonInput(document, file), policy);
  RaiseEntries(path, policy, &material);
  return material;
}

}  // namespace drape
