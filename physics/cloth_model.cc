// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth_model.h"

#include <utility>

namespace drape {
namespace {

std::vector<int> HeldVertices(const Mesh& mesh, const Scene& scene) {
  std::vector<int> held;
  if (!scene.handles) return held;
  // A ring of vertices exactly on the support's radius is held whichever way it rounds.
  const double radius = scene.handles->radius * (1.0 + 1e-12);
  for (int i = 0; i < mesh.num_vertices(); ++i)
    if (mesh.rest_x.segment<3>(3 * i).norm() < radius) held.push_back(i);
  return held;
}

}  // namespace

ClothModel::ClothModel(Mesh mesh_in, Scene scene_in, Law law_in)
    : mesh(std::move(mesh_in)),
      scene(std::move(scene_in)),
      law(std::move(law_in)),
      pattern(MakeBlockPattern(mesh, scene.stretch, scene.bend)),
      vertex_area(Eigen::VectorXd::Zero(mesh.num_vertices())),
      held(HeldVertices(mesh, scene)) {
  for (const Face& f : mesh.faces)
    for (int i : f.vertex) vertex_area[i] += f.area / 3.0;
}

State ClothModel::RestState() const { return {mesh.rest_x, Eigen::VectorXd::Zero(num_dofs())}; }

Eigen::VectorXd ClothModel::LumpedMass(double density) const {
  Eigen::VectorXd mass(num_dofs());
  for (int i = 0; i < mesh.num_vertices(); ++i)
    mass.segment<3>(3 * i).setConstant(density * vertex_area[i]);
  return mass;
}

}  // namespace drape
