// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/mesh.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <unordered_map>
#include <utility>
#include <vector>

#include "physics/util/errors.h"

namespace drape {
namespace {

using Triangle = std::array<int, 3>;

// An edge with its adjacent faces. The first of them traverses it from a to b.
struct Edge {
  int a, b;
  int face[2];      // face[1] = -1 on the boundary
  int opposite[2];  // the third vertex of each face
};

std::string Number(double value) {
  std::ostringstream out;
  out.precision(6);
  out << value;
  return out.str();
}

// Vertices and faces count from 1 in messages, as OBJ files do.
InputError FaceError(const std::string& where, int face, const std::string& problem) {
  return InputError(where, "face " + std::to_string(face + 1) + ": " + problem);
}

std::string EdgeName(int a, int b) {
  return "edge " + std::to_string(a + 1) + "-" + std::to_string(b + 1);
}

void CheckCoordinates(const Eigen::VectorXd& rest_x, const Eigen::Matrix2Xd& uv,
                      const std::string& where) {
  CHECK_EQ(rest_x.size(), 3 * uv.cols());
  for (Eigen::Index v = 0; v < uv.cols(); ++v) {
    if (!rest_x.segment<3>(3 * v).allFinite() || !uv.col(v).allFinite()) {
      throw InputError(where, "vertex " + std::to_string(v + 1) +
                                  ": a coordinate is not finite, expected numbers in metres");
    }
  }
}

void CheckIndices(const std::vector<Triangle>& triangles, int num_vertices,
                  const std::string& where) {
  std::set<Triangle> seen;
  for (size_t f = 0; f < triangles.size(); ++f) {
    for (int index : triangles[f]) {
      if (index < 0 || index >= num_vertices) {
        throw FaceError(where, f,
                        "vertex index " + std::to_string(index + 1) +
                            " is out of range, expected 1.." + std::to_string(num_vertices));
      }
    }
    Triangle sorted = triangles[f];
    std::sort(sorted.begin(), sorted.end());
    if (sorted[0] == sorted[1] || sorted[1] == sorted[2]) {
      throw FaceError(where, f, "a corner is repeated, expected three different vertices");
    }
    if (!seen.insert(sorted).second) {
      throw FaceError(where, f, "the same three vertices as an earlier face");
    }
  }
}

void CheckEachVertexIsUsed(const std::vector<Triangle>& triangles, int num_vertices,
                           const std::string& where) {
  std::vector<bool> used(num_vertices, false);
  for (const Triangle& t : triangles) {
    for (int index : t) used[index] = true;
  }
  const auto unused = std::find(used.begin(), used.end(), false);
  if (unused != used.end()) {
    throw InputError(where,
                     "vertex " + std::to_string(unused - used.begin() + 1) + " belongs to no face");
  }
}

std::vector<Face> BuildFaces(const Eigen::Matrix2Xd& uv, const std::vector<Triangle>& triangles,
                             const std::string& where) {
  std::vector<Face> faces;
  faces.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    const Eigen::Vector2d e1 = uv.col(t[1]) - uv.col(t[0]);
    const Eigen::Vector2d e2 = uv.col(t[2]) - uv.col(t[0]);
    const double det = e1.x() * e2.y() - e2.x() * e1.y();
    if (!(det > 0)) {
      throw FaceError(
          where, faces.size(),
          "UV area is " + Number(det / 2) + " m², expected > 0 (corners counter-clockwise)");
    }
    faces.push_back(
        {{t[0], t[1], t[2]}, det / 2, {e2.y() / det, -e2.x() / det, -e1.y() / det, e1.x() / det}});
  }
  return faces;
}

void AddSecondFace(Edge& edge, int a, int face, int opposite, const std::string& where) {
  if (edge.face[1] >= 0) {
    throw FaceError(where, face, EdgeName(edge.a, edge.b) + " has more than two faces");
  }
  if (edge.a == a) {
    throw FaceError(where, face,
                    EdgeName(edge.a, edge.b) + " runs the same way as in face " +
                        std::to_string(edge.face[0] + 1) + ", expected the opposite way");
  }
  edge.face[1] = face;
  edge.opposite[1] = opposite;
}

// Lists the edges in the order in which a loop over faces and corners 01, 12, 20 first meets them
// [MODEL, M2].
std::vector<Edge> CollectEdges(const std::vector<Triangle>& triangles, const std::string& where) {
  std::vector<Edge> edges;
  std::unordered_map<uint64_t, size_t> index_of;
  index_of.reserve(2 * triangles.size());
  for (int f = 0; f < static_cast<int>(triangles.size()); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = triangles[f][k], b = triangles[f][(k + 1) % 3];
      const int opposite = triangles[f][(k + 2) % 3];
      const uint64_t key = (static_cast<uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
      const auto [it, is_new] = index_of.try_emplace(key, edges.size());
      if (is_new) {
        edges.push_back({a, b, {f, -1}, {opposite, -1}});
      } else {
        AddSecondFace(edges[it->second], a, f, opposite, where);
      }
    }
  }
  return edges;
}

Hinge MakeHinge(const Edge& edge, const Eigen::Matrix2Xd& uv, const std::vector<Face>& faces) {
  const Eigen::Vector2d d = uv.col(edge.b) - uv.col(edge.a);
  const double octant = std::abs(std::atan2(d.y(), d.x())) * 4 / std::numbers::pi;  // 0..4
  return {{edge.a, edge.b, edge.opposite[0], edge.opposite[1]},
          {edge.face[0], edge.face[1]},
          d.norm(),
          faces[edge.face[0]].area + faces[edge.face[1]].area,
          octant > 2 ? 4 - octant : octant};
}

double LoopLength(const std::vector<int>& loop, const Eigen::Matrix2Xd& uv) {
  double length = 0;
  for (size_t i = 0; i < loop.size(); ++i) {
    length += (uv.col(loop[(i + 1) % loop.size()]) - uv.col(loop[i])).norm();
  }
  return length;
}

// next[v] is the boundary vertex after v, with the cloth on the left, and -1 for a vertex inside
// the cloth.
std::vector<int> BoundarySuccessors(const std::vector<Edge>& edges, int num_vertices,
                                    const std::string& where) {
  std::vector<int> next(num_vertices, -1);
  for (const Edge& edge : edges) {
    if (edge.face[1] >= 0) continue;
    if (next[edge.a] >= 0) {
      throw InputError(where, "vertex " + std::to_string(edge.a + 1) +
                                  ": two boundaries touch here, expected one");
    }
    next[edge.a] = edge.b;
  }
  return next;
}

std::vector<std::vector<int>> TraceLoops(std::vector<int> next, const Eigen::Matrix2Xd& uv) {
  std::vector<std::pair<double, std::vector<int>>> loops;
  for (int start = 0; start < static_cast<int>(next.size()); ++start) {
    std::vector<int> loop;
    for (int v = start; next[v] >= 0; v = std::exchange(next[v], -1)) loop.push_back(v);
    if (!loop.empty()) loops.emplace_back(LoopLength(loop, uv), std::move(loop));
  }
  std::stable_sort(loops.begin(), loops.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::vector<int>> result;
  for (auto& [length, loop] : loops) result.push_back(std::move(loop));
  return result;
}

Eigen::Vector3d Barycentric(const Mesh& mesh, const Face& face, const Eigen::Vector2d& point) {
  Eigen::Vector3d coordinates;
  const Eigen::Matrix<double, 2, 3> gradients = BarycentricGradients(mesh, face);
  for (int i = 0; i < 3; ++i)
    coordinates[i] = 1 + gradients.col(i).dot(point - mesh.uv.col(face.vertex[i]));
  return coordinates;
}

// The face in which the smallest coordinate of a point is largest: that which holds it, if one
// does.
int NearestFace(const Mesh& mesh, const Eigen::Vector2d& point) {
  int nearest = 0;
  double best = -std::numeric_limits<double>::infinity();
  for (int f = 0; f < mesh.num_faces() && best < 0; ++f) {
    const double inside = Barycentric(mesh, mesh.faces[f], point).minCoeff();
    if (inside <= best) continue;
    best = inside;
    nearest = f;
  }
  return nearest;
}

}  // namespace

Mesh BuildMesh(const Eigen::VectorXd& rest_x, const Eigen::Matrix2Xd& uv,
               const std::vector<Triangle>& triangles, const std::string& where) {
  const int num_vertices = static_cast<int>(uv.cols());
  if (triangles.empty()) throw InputError(where, "the mesh has no faces");
  CheckCoordinates(rest_x, uv, where);
  CheckIndices(triangles, num_vertices, where);
  CheckEachVertexIsUsed(triangles, num_vertices, where);
  Mesh mesh{rest_x, uv, BuildFaces(uv, triangles, where), {}, {}};
  const std::vector<Edge> edges = CollectEdges(triangles, where);
  for (const Edge& edge : edges) {
    if (edge.face[1] >= 0) mesh.hinges.push_back(MakeHinge(edge, uv, mesh.faces));
  }
  mesh.boundary_loops = TraceLoops(BoundarySuccessors(edges, num_vertices, where), uv);
  return mesh;
}

std::vector<std::array<int, 3>> ListTriangles(const Mesh& mesh) {
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.faces.size());
  for (const Face& face : mesh.faces)
    triangles.push_back({face.vertex[0], face.vertex[1], face.vertex[2]});
  return triangles;
}

std::vector<RestEdge> ListEdges(const Mesh& mesh) {
  std::map<std::pair<int, int>, RestEdge> edges;
  for (const Face& face : mesh.faces) {
    const Eigen::Matrix2d inverse =
        Eigen::Map<const Eigen::Matrix<double, 2, 2, Eigen::RowMajor>>(face.inverse_rest);
    const Eigen::Matrix2d sides = inverse.inverse();  // from corner 0 to corners 1 and 2
    const double lengths[3] = {sides.col(0).norm(), (sides.col(1) - sides.col(0)).norm(),
                               sides.col(1).norm()};
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(face.vertex[k], face.vertex[(k + 1) % 3]);
      edges.try_emplace({a, b}, RestEdge{{a, b}, lengths[k], 0.0}).first->second.area +=
          face.area / 3.0;
    }
  }
  std::vector<RestEdge> list;
  for (const auto& [ends, edge] : edges) list.push_back(edge);
  return list;
}

bool IsSameCloth(const Mesh& a, const Mesh& b) {
  constexpr double kShare = 0.03;
  const auto agree = [](double x, double y) { return std::abs(x - y) <= kShare * std::max(x, y); };
  const auto area = [](const Mesh& mesh) {
    double sum = 0.0;
    for (const Face& face : mesh.faces) sum += face.area;
    return sum;
  };
  const auto reach = [](const Mesh& mesh) { return mesh.uv.colwise().norm().maxCoeff(); };
  return agree(area(a), area(b)) && agree(reach(a), reach(b));
}

Eigen::Matrix2Xd FaceCentres(const Mesh& mesh) {
  Eigen::Matrix2Xd centres(2, mesh.num_faces());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const int* v = mesh.faces[f].vertex;
    centres.col(f) = (mesh.uv.col(v[0]) + mesh.uv.col(v[1]) + mesh.uv.col(v[2])) / 3;
  }
  return centres;
}

Eigen::Matrix2Xd HingeCentres(const Mesh& mesh) {
  Eigen::Matrix2Xd centres(2, mesh.num_hinges());
  for (int e = 0; e < mesh.num_hinges(); ++e) {
    const int* v = mesh.hinges[e].vertex;
    centres.col(e) = (mesh.uv.col(v[0]) + mesh.uv.col(v[1])) / 2;
  }
  return centres;
}

Eigen::Matrix<double, 2, 3> BarycentricGradients(const Mesh& mesh, const Face& face) {
  Eigen::Matrix<double, 2, 3> gradients;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d edge =
        mesh.uv.col(face.vertex[(i + 2) % 3]) - mesh.uv.col(face.vertex[(i + 1) % 3]);
    gradients.col(i) = Eigen::Vector2d(-edge.y(), edge.x()) / (2 * face.area);
  }
  return gradients;
}

Eigen::SparseMatrix<double, Eigen::RowMajor> InterpolationWeights(const Mesh& mesh,
                                                                  const Eigen::Matrix2Xd& points,
                                                                  Extrapolation beyond) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < points.cols(); ++i) {
    const Face& face = mesh.faces[NearestFace(mesh, points.col(i))];
    Eigen::Vector3d weights = Barycentric(mesh, face, points.col(i));
    if (beyond == Extrapolation::kNearest)
      weights = weights.cwiseMax(0.0) / weights.cwiseMax(0.0).sum();
    for (int k = 0; k < 3; ++k) entries.emplace_back(i, face.vertex[k], weights[k]);
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> weights(points.cols(), mesh.num_vertices());
  weights.setFromTriplets(entries.begin(), entries.end());
  return weights;
}

Eigen::VectorXd ReadPositions(const Eigen::SparseMatrix<double, Eigen::RowMajor>& weights,
                              const Eigen::VectorXd& x) {
  using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const Points read = weights * Eigen::Map<const Points>(x.data(), x.size() / 3, 3);
  return Eigen::Map<const Eigen::VectorXd>(read.data(), read.size());
}

}  // namespace drape
