// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include "physics/util/atomic_file.h"
#include "solver/prediction/exchange/geometry/drape_files.h"

namespace drape {
namespace {

constexpr char kHeader[] =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"%s\" version=\"0.1\" byte_order=\"LittleEndian\">\n";
constexpr int kTriangle = 5;  // of VTK's cell types

std::string Header(const std::string& type) {
  std::string text = kHeader;
  return text.replace(text.find("%s"), 2, type);
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
