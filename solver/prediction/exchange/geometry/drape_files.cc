// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/geometry/drape_files.h"

#include <glog/logging.h>

#include <cmath>
#include <variant>

#include "physics/util/atomic_file.h"

namespace drape {
namespace {

DeformationGradient<double> Gradient(const Face& face, const Eigen::VectorXd& x) {
  Vec3<double> edge[2];
  for (int k = 0; k < 2; ++k)
    edge[k] = LoadVec3(x.data(), face.vertex[k + 1]) - LoadVec3(x.data(), face.vertex[0]);
  const double* inverse = face.inverse_rest;
  return {inverse[0] * edge[0] + inverse[2] * edge[1], inverse[1] * edge[0] + inverse[3] * edge[1]};
}

std::vector<double> MeanRigidities(const ClothModel& model, const MaterialField& material) {
  const Mesh& mesh = model.mesh;
  std::vector<double> sum(mesh.num_faces(), 0.0);
  std::vector<int> count(mesh.num_faces(), 0);
  for (int i = 0; i < mesh.num_hinges(); ++i) {
    const Hinge& hinge = mesh.hinges[i];
    const double kappa = std::visit(
        [&](const auto& bend) { return HingeStiffness(bend, hinge, material.bend_of(i), 0.0); },
        model.law.bend);
    for (const int face : hinge.face) {
      sum[face] += kappa / HingeFactor(hinge) / kBendPerRigidity;
      ++count[face];
    }
  }
  for (int f = 0; f < mesh.num_faces(); ++f)
    if (count[f] > 0) sum[f] /= count[f];
  return sum;
}

constexpr int kTriangle = 5;  // of VTK's cell types

std::string Header(const std::string& type) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type +
         "\" version=\"0.1\" byte_order=\"LittleEndian\">\n";
}

template <class Value>
std::string List(int count, Value value) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    AppendNumber(text, value(i));
    text += i % 12 == 11 ? '\n' : ' ';
  }
  return text;
}

std::string Array(const std::string& type, const std::string& name, int components,
                  const std::string& more, const std::string& list) {
  return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
         std::to_string(components) + "\" format=\"ascii\"" + more + ">\n" + list +
         "\n</DataArray>\n";
}

std::string FieldArray(const FaceField& field) {
  std::string more;
  for (size_t i = 0; i < field.components.size(); ++i)
    more += " ComponentName" + std::to_string(i) + "=\"" + field.components[i] + "\"";
  const auto count = static_cast<int>(field.values.size());
  return Array("Float64", field.name + " [" + field.unit + "]",
               static_cast<int>(field.components.size()), more,
               List(count, [&](int i) { return field.values[i]; }));
}

std::string Cells(const Mesh& mesh) {
  const int faces = mesh.num_faces();
  const auto corner = [&](int i) { return mesh.faces[i / 3].vertex[i % 3]; };
  return "<Cells>\n" + Array("Int32", "connectivity", 1, "", List(3 * faces, corner)) +
         Array("Int32", "offsets", 1, "", List(faces, [](int i) { return 3 * (i + 1); })) +
         Array("UInt8", "types", 1, "", List(faces, [](int) { return kTriangle; })) + "</Cells>\n";
}

}  // namespace

std::vector<FaceField> ComputeFaceFields(const ClothModel& model, const MaterialField& material,
                                         const Eigen::VectorXd& x) {
  CHECK_EQ(x.size(), model.num_dofs());
  std::vector<FaceField> fields = {
      {.name = "strain", .components = {"uu", "vv", "uv"}, .unit = "1", .values = {}},
      {.name = "tension", .components = {"uu", "vv", "uv"}, .unit = "N/m", .values = {}},
      {.name = "stiffness",
       .components = {"c11", "c12", "c22", "c33"},
       .unit = "N/m",
       .values = {}},
      {.name = "rigidity",
       .components = {"D"},
       .unit = "N m",
       .values = MeanRigidities(model, material)}};
  for (int f = 0; f < model.mesh.num_faces(); ++f) {
    const GreenStrain<double> G = Green(Gradient(model.mesh.faces[f], x));
    const auto k =
        std::visit([&](const auto& law) { return EvaluateStretch(law, G, material.stretch_of(f)); },
                   model.law.stretch);
    const StretchStress<double> S = Stress(k, G);
    for (const double value : {G.uu, G.vv, G.uv}) fields[0].values.push_back(value);
    for (const double value : {S.uu, S.vv, S.uv}) fields[1].values.push_back(value);
    for (const double value : {k.c11, k.c12, k.c22, k.c33}) fields[2].values.push_back(value);
  }
  return fields;
}

void WriteVtu(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& x,
              const std::vector<FaceField>& fields) {
  CHECK_EQ(x.size(), 3 * mesh.num_vertices());
  const int numbers = 3 * mesh.num_vertices();
  const auto rest = [&](int i) { return i % 3 < 2 ? mesh.uv(i % 3, i / 3) : 0.0; };
  std::string text =
      Header("UnstructuredGrid") + "<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
      std::to_string(mesh.num_vertices()) + "\" NumberOfCells=\"" +
      std::to_string(mesh.num_faces()) + "\">\n<Points>\n" +
      Array("Float64", "position", 3, "", List(numbers, [&](int i) { return x[i]; })) +
      "</Points>\n" + Cells(mesh) + "<PointData>\n" +
      Array("Float64", "rest", 3, "", List(numbers, rest)) + "</PointData>\n<CellData>\n";
  for (const FaceField& field : fields) text += FieldArray(field);
  text += "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  WriteFileAtomically(path, text);
}

void WritePvd(const std::string& path, const std::vector<TimedFile>& files) {
  std::string text = Header("Collection") + "<Collection>\n";
  for (const TimedFile& file : files) {
    text += "<DataSet timestep=\"";
    AppendNumber(text, file.time);
    text += "\" part=\"0\" file=\"" + file.file + "\"/>\n";
  }
  WriteFileAtomically(path, text + "</Collection>\n</VTKFile>\n");
}

}  // namespace drape
