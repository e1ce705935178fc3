// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/tubes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace drape {
namespace {

constexpr double kRing = .04;  // [m]

// The cuffs of each vertex: the first vertex of its boundary, and −1 inside.
std::vector<int> FindCuffs(const Mesh& mesh) {
  std::map<std::pair<int, int>, int> faces;  // of each edge
  for (const Face& face : mesh.faces)
    for (int k = 0; k < 3; ++k) ++faces[std::minmax(face.vertex[k], face.vertex[(k + 1) % 3])];
  std::erase_if(faces, [](const auto& edge) { return edge.second > 1; });
  std::vector<int> cuff(mesh.num_vertices(), -1);
  for (const auto& [edge, count] : faces)
    for (const int i : {edge.first, edge.second}) cuff[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [edge, count] : faces) {
      int &a = cuff[edge.first], &b = cuff[edge.second];
      changed = changed || a != b;
      a = b = std::min(a, b);
    }
  }
  return cuff;
}

// The distance of each vertex from a cuff, along edges [m].
std::vector<double> FindDistances(const std::vector<RestEdge>& edges, const std::vector<int>& cuffs,
                                  int cuff) {
  std::vector<double> distance(cuffs.size(), HUGE_VAL);
  for (size_t i = 0; i < cuffs.size(); ++i)
    if (cuffs[i] == cuff) distance[i] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (const RestEdge& edge : edges) {
      double &a = distance[edge.vertex[0]], &b = distance[edge.vertex[1]];
      changed = changed || a > b + edge.rest_length || b > a + edge.rest_length;
      a = std::min(a, b + edge.rest_length);
      b = std::min(b, a + edge.rest_length);
    }
  }
  return distance;
}

}  // namespace

std::vector<ClothTube> FindTubes(const SewnGarment& garment, const Eigen::VectorXd& x) {
  const Mesh& mesh = garment.model->mesh;
  const std::vector<RestEdge> edges = ListEdges(mesh);
  const std::vector<int> cuffs = FindCuffs(mesh);
  std::vector<ClothTube> tubes;
  for (int cuff = 0; cuff < mesh.num_vertices(); ++cuff) {
    if (cuffs[cuff] != cuff) continue;
    const double side = x[3 * cuff] < 0 ? -1 : 1;
    std::map<int, std::vector<int>> rings;
    const std::vector<double> distance = FindDistances(edges, cuffs, cuff);
    for (int i = 0; i < mesh.num_vertices(); ++i)
      if (distance[i] < HUGE_VAL) rings[static_cast<int>(distance[i] / kRing)].push_back(i);
    ClothTube tube;
    for (const auto& [number, ring] : rings) {
      ClothRing& found = tube.emplace_back();
      double area = 0;
      for (const int i : ring) {
        found.inner = std::min(found.inner, side * x[3 * i]);
        found.middle += garment.model->vertex_area[i] * x.segment<3>(3 * i);
        area += garment.model->vertex_area[i];
      }
      found.middle /= area;
      if (found.inner <= 0) break;
    }
    tube.pop_back();
    if (!tube.empty()) tubes.push_back(std::move(tube));
  }
  return tubes;
}

}  // namespace drape
