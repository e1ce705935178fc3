// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/obj_io.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "physics/mesh/obj_parser.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr std::string_view kComment = "# ";

using Triangles = std::vector<std::array<int, 3>>;

ObjContent Load(const std::string& path, const ObjOptions& options) {
  ObjContent content = ParseObj(ReadWholeFile(path), path, options.round_to_float);
  if (content.faces.empty()) throw InputError(path, "the file has no faces");
  if (options.first_vt_is_dummy && !content.vt.empty()) {
    content.vt.erase(content.vt.begin());
  }
  return content;
}

template <typename Numbers>
void AppendLine(const char* key, const Numbers& numbers, std::string* text) {
  *text += key;
  for (const double number : numbers) AppendNumber(*text += ' ', number);
  *text += '\n';
}

void AppendVertices(const Eigen::VectorXd& x, std::string* text) {
  for (Eigen::Index i = 0; i < x.size(); i += 3) AppendLine("v", x.segment<3>(i), text);
}

ObjSurface MakeSurface(const ObjContent& content) {
  ObjSurface surface;
  surface.x.resize(3 * content.v.size());
  for (size_t i = 0; i < content.v.size(); ++i) surface.x.segment<3>(3 * i) = content.v[i];
  for (const ObjFace& face : content.faces) {
    surface.triangles.push_back({face.corner[0].v, face.corner[1].v, face.corner[2].v});
  }
  return surface;
}

// The vt of each vertex if each vertex has exactly one value; otherwise std::nullopt and the cause
// in `reason`.
std::optional<Eigen::Matrix2Xd> UvFromVt(const ObjContent& content, std::string& reason) {
  Eigen::Matrix2Xd uv = Eigen::Matrix2Xd::Zero(2, content.v.size());
  std::vector<bool> known(content.v.size(), false);
  for (const ObjFace& face : content.faces) {
    for (const ObjCorner& corner : face.corner) {
      const auto line = [&] { return " (line " + std::to_string(face.line) + ")"; };
      if (corner.vt < 0 || corner.vt >= static_cast<int>(content.vt.size())) {
        reason = "a corner has no vt" + line();
        return std::nullopt;
      }
      if (known[corner.v] && uv.col(corner.v) != content.vt[corner.vt]) {
        reason = "vertex " + std::to_string(corner.v + 1) + " has two different vt" + line();
        return std::nullopt;
      }
      uv.col(corner.v) = content.vt[corner.vt];
      known[corner.v] = true;
    }
  }
  return uv;
}

bool IsFlat(const ObjContent& content) {
  for (const Eigen::Vector3d& v : content.v) {
    if (v.z() != content.v[0].z()) return false;
  }
  return true;
}

Eigen::Matrix2Xd UvFromXy(const ObjContent& content) {
  Eigen::Matrix2Xd uv(2, content.v.size());
  for (size_t i = 0; i < content.v.size(); ++i) uv.col(i) = content.v[i].head<2>();
  return uv;
}

Eigen::Matrix2Xd MaterialCoordinates(const ObjContent& content, const std::string& path) {
  std::string reason;
  if (auto uv = UvFromVt(content, reason)) return *std::move(uv);
  if (IsFlat(content)) return UvFromXy(content);
  throw InputError(path, "no material coordinates: " + reason +
                             ", and z is not constant; expected one vt per vertex or a flat mesh");
}

// Rejects texture coordinates in 0 … 1, which would otherwise be read as a cloth of one metre.
void CheckUvIsInMetres(const ObjContent& content, const Eigen::Matrix2Xd& uv,
                       const std::string& path) {
  double length_uv = 0, length_v = 0;
  for (const ObjFace& face : content.faces) {
    for (int k = 0; k < 3; ++k) {
      const int a = face.corner[k].v, b = face.corner[(k + 1) % 3].v;
      length_uv += (uv.col(b) - uv.col(a)).norm();
      length_v += (content.v[b] - content.v[a]).norm();
    }
  }
  if (length_uv <= 2 * length_v && length_v <= 2 * length_uv) return;
  const double edges = 3.0 * content.faces.size();
  throw InputError(path, "vt is not in metres: its mean edge is " +
                             std::to_string(length_uv / edges) + ", that of v is " +
                             std::to_string(length_v / edges));
}

// Turns over a mesh that is clockwise throughout. A mixed orientation is an error at the line of
// the first face that differs.
void OrientCounterClockwise(const ObjContent& content, const Eigen::Matrix2Xd& uv,
                            const std::string& path, Triangles& triangles) {
  std::optional<bool> clockwise;
  for (size_t f = 0; f < triangles.size(); ++f) {
    const auto& t = triangles[f];
    const Eigen::Vector2d e1 = uv.col(t[1]) - uv.col(t[0]), e2 = uv.col(t[2]) - uv.col(t[0]);
    const double det = e1.x() * e2.y() - e2.x() * e1.y();
    if (det == 0) continue;  // BuildMesh reports it
    if (clockwise.value_or(det < 0) != (det < 0)) {
      throw InputError(path + ":" + std::to_string(content.faces[f].line),
                       "the face is oriented opposite to the first one in material coordinates");
    }
    clockwise = det < 0;
  }
  if (!clockwise.value_or(false)) return;
  for (auto& t : triangles) std::swap(t[1], t[2]);
}

}  // namespace

ObjSurface ReadObjSurface(const std::string& path, const ObjOptions& options) {
  return MakeSurface(Load(path, options));
}

void RequireClosed(const ObjSurface& surface, const std::string& where) {
  std::map<std::pair<int, int>, int> faces;
  for (size_t f = 0; f < surface.triangles.size(); ++f) {
    const auto& t = surface.triangles[f];
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (!faces.try_emplace({a, b}, static_cast<int>(f)).second)
        throw InputError(where,
                         Format("face %zu: edge %d-%d runs as in another face, expected two "
                                "faces at each edge, which traverse it in opposite directions",
                                f + 1, a + 1, b + 1));
    }
  }
  for (const auto& [edge, face] : faces)
    if (!faces.count({edge.second, edge.first}))
      throw InputError(where, Format("face %d: edge %d-%d has no second face, expected a closed "
                                     "surface",
                                     face + 1, edge.first + 1, edge.second + 1));
}

void RequireSolid(const ObjSurface& surface, const std::string& where) {
  const auto vertex = [&](int i) -> Eigen::Vector3d { return surface.x.segment<3>(3 * i); };
  double volume = 0;
  for (const auto& t : surface.triangles)
    volume += vertex(t[0]).dot(vertex(t[1]).cross(vertex(t[2])));
  if (!(volume > 0))
    throw InputError(where, Format("the volume is %g m³, expected > 0: faces counter-clockwise as "
                                   "seen from outside",
                                   volume / 6));
  const auto found = FindSelfIntersections(surface.triangles, surface.x);
  if (found.empty()) return;
  const Eigen::Vector3d place = vertex(surface.triangles[found[0].first][0]);
  throw InputError(
      where, Format("faces %d and %d intersect near (%.4g, %.4g, %.4g), expected a "
                    "surface that does not intersect itself",
                    found[0].first + 1, found[0].second + 1, place.x(), place.y(), place.z()));
}

Mesh ReadObj(const std::string& path, const ObjOptions& options) {
  const ObjContent content = Load(path, options);
  const Eigen::Matrix2Xd uv = MaterialCoordinates(content, path);
  CheckUvIsInMetres(content, uv, path);
  ObjSurface surface = MakeSurface(content);
  OrientCounterClockwise(content, uv, path, surface.triangles);
  return BuildMesh(surface.x, uv, surface.triangles, path);
}

void WriteObj(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& x,
              const std::optional<DrapeDiscs>& discs) {
  CHECK_EQ(x.size(), 3 * mesh.num_vertices());
  std::string text = "# drapefit cloth, metres\n";
  if (discs) text += std::string(kComment) + DiscsLine(*discs) + "\n";
  AppendVertices(x, &text);
  for (int i = 0; i < mesh.num_vertices(); ++i) AppendLine("vt", mesh.uv.col(i), &text);
  for (const Face& face : mesh.faces) {
    text += 'f';
    for (const int vertex : face.vertex) {
      const std::string index = std::to_string(vertex + 1);
      text += ' ' + index + '/' + index;
    }
    text += '\n';
  }
  WriteFileAtomically(path, text);
}

void WriteObj(const std::string& path, const ObjSurface& surface) {
  std::string text = "# drapefit surface, metres\n";
  AppendVertices(surface.x, &text);
  for (const auto& [a, b, c] : surface.triangles)
    text += Format("f %d %d %d\n", a + 1, b + 1, c + 1);
  WriteFileAtomically(path, text);
}

std::optional<DrapeDiscs> ReadObjDiscs(const std::string& path) {
  std::istringstream lines(ReadWholeFile(path));
  for (std::string line; std::getline(lines, line) && line.starts_with('#');)
    if (line.starts_with(kComment))
      if (const auto discs = ParseDiscsLine(line.substr(kComment.size()))) return discs;
  return std::nullopt;
}

}  // namespace drape
