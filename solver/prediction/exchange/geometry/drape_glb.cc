// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "solver/prediction/exchange/geometry/drape_files.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// Numbers of the glTF 2.0 specification.
constexpr uint32_t kMagic = 0x46546C67, kVersion = 2, kJsonChunk = 0x4E4F534A,
                   kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;

void AppendWord(std::string* bytes, uint32_t word) {
  for (int shift = 0; shift < 32; shift += 8)
    bytes->push_back(static_cast<char>((word >> shift) & 0xff));
}

// The one buffer of the file, and what lies where in it.
struct Buffer {
  std::string bytes;
  Json views = Json::array(), accessors = Json::array();

  int Add(const Eigen::MatrixXf& columns, const char* type, bool with_bounds) {
    const size_t begin = bytes.size();
    for (const float value : columns.reshaped()) AppendWord(&bytes, std::bit_cast<uint32_t>(value));
    Json accessor = {{"bufferView", views.size()},
                     {"componentType", kFloat},
                     {"count", columns.cols()},
                     {"type", type}};
    if (with_bounds) {
      const Eigen::VectorXf low = columns.rowwise().minCoeff(), high = columns.rowwise().maxCoeff();
      accessor["min"] = std::vector<float>(low.begin(), low.end());
      accessor["max"] = std::vector<float>(high.begin(), high.end());
    }
    return AddView(begin, kArrayBuffer, accessor);
  }
  int AddIndices(const Mesh& mesh) {
    const size_t begin = bytes.size();
    for (const Face& face : mesh.faces)
      for (const int vertex : face.vertex) AppendWord(&bytes, static_cast<uint32_t>(vertex));
    return AddView(begin, kElementBuffer,
                   {{"bufferView", views.size()},
                    {"componentType", kUnsignedInt},
                    {"count", 3 * mesh.num_faces()},
                    {"type", "SCALAR"}});
  }
  int AddView(size_t begin, int target, Json accessor) {
    views.push_back({{"buffer", 0},
                     {"byteOffset", begin},
                     {"byteLength", bytes.size() - begin},
                     {"target", target}});
    accessors.push_back(std::move(accessor));
    return static_cast<int>(accessors.size()) - 1;
  }
};

Eigen::MatrixXf Normals(const Mesh& mesh, const Eigen::MatrixXf& points) {
  Eigen::MatrixXf normals = Eigen::MatrixXf::Zero(3, points.cols());
  for (const Face& face : mesh.faces) {
    const Eigen::Vector3f a = points.col(face.vertex[0]), b = points.col(face.vertex[1]),
                          c = points.col(face.vertex[2]);
    for (const int vertex : face.vertex) normals.col(vertex) += (b - a).cross(c - a);
  }
  for (auto normal : normals.colwise())
    normal = normal.norm() > 0.0f ? Eigen::Vector3f(normal.normalized()) : Eigen::Vector3f::UnitZ();
  return normals;
}

Eigen::MatrixXf VertexValues(const Mesh& mesh, const std::vector<double>& face_values) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.num_vertices()), area = sum;
  for (int f = 0; f < mesh.num_faces(); ++f)
    for (const int vertex : mesh.faces[f].vertex) {
      sum[vertex] += mesh.faces[f].area * face_values[f];
      area[vertex] += mesh.faces[f].area;
    }
  return sum.cwiseQuotient(area).cast<float>().transpose();
}

// From blue over white to red.
Eigen::MatrixXf Colours(const Eigen::MatrixXf& values) {
  std::vector<double> sorted(values.reshaped().begin(), values.reshaped().end());
  std::sort(sorted.begin(), sorted.end());
  const auto most = static_cast<float>(std::max(1e-12, sorted[(sorted.size() - 1) * 98 / 100]));
  Eigen::MatrixXf colours(3, values.cols());
  for (Eigen::Index i = 0; i < values.cols(); ++i) {
    const float t = std::clamp(values(0, i) / most, 0.0f, 1.0f);
    const float rise = std::min(1.0f, 2.0f * t), fall = std::min(1.0f, 2.0f - 2.0f * t);
    colours.col(i) << 0.1f + 0.9f * rise, 0.1f + 0.9f * std::min(rise, fall), 0.1f + 0.9f * fall;
  }
  return colours;
}

void AppendChunk(std::string* file, uint32_t type, std::string content, char padding) {
  while (content.size() % 4 != 0) content.push_back(padding);
  AppendWord(file, static_cast<uint32_t>(content.size()));
  AppendWord(file, type);
  *file += content;
}

}  // namespace

void WriteGlb(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& x,
              const std::string& name, const std::vector<double>& face_values) {
  CHECK_EQ(x.size(), 3 * mesh.num_vertices());
  CHECK_EQ(static_cast<int>(face_values.size()), mesh.num_faces());
  const Eigen::MatrixXf points = x.reshaped(3, mesh.num_vertices()).cast<float>();
  const Eigen::MatrixXf values = VertexValues(mesh, face_values);
  Buffer buffer;
  const Json attributes = {{"POSITION", buffer.Add(points, "VEC3", true)},
                           {"NORMAL", buffer.Add(Normals(mesh, points), "VEC3", false)},
                           {"TEXCOORD_0", buffer.Add(mesh.uv.cast<float>(), "VEC2", false)},
                           {"COLOR_0", buffer.Add(Colours(values), "VEC3", false)},
                           {"_VALUE", buffer.Add(values, "SCALAR", true)}};
  const int indices = buffer.AddIndices(mesh);
  const double half = std::sqrt(0.5);
  const Json json = {
      {"asset",
       {{"version", "2.0"},
        {"generator", "drapefit"},
        {"extras", {{"_VALUE", name}, {"TEXCOORD_0", "rest coordinates (weft, warp) in metres"}}}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", {{{"name", "drape"}, {"mesh", 0}, {"rotation", {-half, 0.0, 0.0, half}}}}},
      {"meshes",
       {{{"name", "cloth"},
         {"primitives", {{{"attributes", attributes}, {"indices", indices}, {"material", 0}}}}}}},
      {"materials",
       {{{"name", "fabric"},
         {"doubleSided", true},
         {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.9}}}}}},
      {"buffers", {{{"byteLength", buffer.bytes.size()}}}},
      {"bufferViews", buffer.views},
      {"accessors", buffer.accessors}};
  std::string chunks;
  AppendChunk(&chunks, kJsonChunk, json.dump(), ' ');
  AppendChunk(&chunks, kBinaryChunk, buffer.bytes, '\0');
  std::string file;
  AppendWord(&file, kMagic);
  AppendWord(&file, kVersion);
  AppendWord(&file, static_cast<uint32_t>(12 + chunks.size()));
  WriteFileAtomically(path, file + chunks);
}

}  // namespace drape
