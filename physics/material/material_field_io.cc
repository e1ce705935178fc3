// SPDX-License-Identifier: Apache-2.0
#include "physics/material/material_field_io.h"

#include <glog/logging.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "physics/material/bending_table.h"
#include "physics/material/material.h"
#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

using nlohmann::json;

// Appends the entries of each table as one row, in the convention of the file: entry × factor.
template <class Table>
void AppendTables(std::string& text, const std::vector<Table>& tables, double factor) {
  const int entries = sizeof(Table) / sizeof(double);
  text += '[';
  for (std::size_t e = 0; e < tables.size(); ++e) {
    const double* entry = reinterpret_cast<const double*>(&tables[e]);
    for (int k = 0; k < entries; ++k) {
      text += k > 0 ? ", " : e > 0 ? "],\n[" : "\n[";
      AppendNumber(text, entry[k] * factor);
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
    for (int k = 0; k < entries; ++k) {
      reinterpret_cast<double*>(&tables[e])[k] = ReadEntry(table.At(k), most, policy) / factor;
    }
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

void ExpectString(const JsonInput& value, const std::string& expected) {
  if (value.String() != expected) value.Fail('"' + expected + '"');
}

Material ReadField(const Mesh& mesh, const JsonInput& input, const MaterialPolicy& policy) {
  input.ExpectKeys({"format", "version", "name", "units", "source", "convention", "density",
                    "face_centres", "stretch", "hinge_centres", "bend"});
  if (input.At("version").Integer() != 1) input.At("version").Fail("1");
  if (input.Has("units")) ExpectString(input.At("units"), "SI");
  ExpectString(input.At("convention"), "mechanical");
  Material material;
  if (input.Has("name")) material.name = input.At("name").String();
  if (input.Has("source")) material.source = input.At("source").String();
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
  return material;
}

}  // namespace

void WriteMaterialField(const std::string& path, const Material& material, const Mesh& mesh) {
  const MaterialField& field = material.field;
  CHECK_EQ(field.stretch.size(), static_cast<std::size_t>(mesh.num_faces()));
  CHECK_EQ(field.bend.size(), static_cast<std::size_t>(mesh.num_hinges()));
  std::string text = "{\"format\": " + json(kMaterialFieldFormat).dump() +
                     ", \"version\": 1, \"name\": " + json(material.name).dump() +
                     ", \"units\": \"SI\",\n\"source\": " + json(material.source).dump() +
                     ",\n\"convention\": \"mechanical\", \"density\": ";
  AppendNumber(text, field.density);
  AppendPoints(text += ",\n\"face_centres\": ", FaceCentres(mesh));
  AppendTables(text += ",\n\"stretch\": ", field.stretch, kMembranePerEntry);
  AppendPoints(text += ",\n\"hinge_centres\": ", HingeCentres(mesh));
  AppendTables(text += ",\n\"bend\": ", field.bend, 1 / kBendPerRigidity);
  WriteFileAtomically(path, text += "}\n");
}

Material ReadMaterialFor(const Mesh& mesh, const std::string& path, const MaterialPolicy& policy) {
  const std::string file = FindMaterialFile(path);
  const bool may_be_field = path != kBuiltInName && !SplitBendingRow(path) &&
                            !path.ends_with(".csv") && SplitMaterialPath(file).name.empty();
  if (!may_be_field) return ReadMaterial(path, policy);
  const json document = ReadJsonFile(file);
  if (!document.is_object() || document.value("format", json()) != kMaterialFieldFormat)
    return ReadMaterial(path, policy);
  Material material = ReadField(mesh, JsonInput(document, file), policy);
  RaiseEntries(path, policy, &material);
  return material;
}

}  // namespace drape
