// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/sewing.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace drape {
namespace {

// The first vertex of each group of stitched ones, for all vertices.
std::vector<int> FirstOfGroups(const GarmentMesh& garment) {
  std::vector<int> first(garment.mesh.num_vertices());
  std::iota(first.begin(), first.end(), 0);
  const auto find = [&](int i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  for (const auto& [a, b] : garment.stitches) {
    const int one = find(a), other = find(b);
    first[std::max(one, other)] = std::min(one, other);
  }
  for (int i = 0; i < static_cast<int>(first.size()); ++i) first[i] = find(i);
  return first;
}

// Numbers without gaps in the order of the groups' first vertices.
std::vector<int> Number(const std::vector<int>& first) {
  std::vector<int> number(first.size());
  int count = 0;
  for (int i = 0; i < static_cast<int>(first.size()); ++i)
    number[i] = first[i] == i ? count++ : number[first[i]];
  return number;
}

Scene Falling() {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  return scene;
}

}  // namespace

SewnGarment Sew(const GarmentMesh& garment, const Law& law) {
  SewnGarment sewn{.vertex_of = Number(FirstOfGroups(garment))};
  const int count = 1 + *std::max_element(sewn.vertex_of.begin(), sewn.vertex_of.end());
  Mesh mesh = garment.mesh;
  mesh.boundary_loops.clear();
  mesh.uv.resize(2, count);
  sewn.start_x = Eigen::VectorXd::Zero(3 * count);
  Eigen::VectorXd joined = Eigen::VectorXd::Zero(count);
  for (int i = 0; i < garment.mesh.num_vertices(); ++i) {
    const int k = sewn.vertex_of[i];
    mesh.uv.col(k) = garment.mesh.uv.col(i);
    sewn.start_x.segment<3>(3 * k) += garment.start_x.segment<3>(3 * i);
    joined[k] += 1.0;
  }
  for (int k = 0; k < count; ++k) sewn.start_x.segment<3>(3 * k) /= joined[k];
  mesh.rest_x = sewn.start_x;
  for (Face& face : mesh.faces)
    for (int& i : face.vertex) i = sewn.vertex_of[i];
  for (Hinge& hinge : mesh.hinges)
    for (int& i : hinge.vertex) i = sewn.vertex_of[i];
  for (const GarmentMesh::HeldRing& ring : garment.rings)
    if (ring.held_by_pelvis)
      for (const int i : ring.vertices) sewn.held_by_pelvis.push_back(sewn.vertex_of[i]);
  std::sort(sewn.held_by_pelvis.begin(), sewn.held_by_pelvis.end());
  sewn.held_by_pelvis.erase(std::unique(sewn.held_by_pelvis.begin(), sewn.held_by_pelvis.end()),
                            sewn.held_by_pelvis.end());
  sewn.model = std::make_shared<const ClothModel>(std::move(mesh), Falling(), law);
  return sewn;
}

}  // namespace drape
