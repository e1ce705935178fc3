// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "physics/cloth/scene.h"
#include "physics/cloth/state.h"
#include "physics/linalg/blocks/block_matrix.h"
#include "physics/material/laws/law.h"
#include "physics/material/material.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh.h"

namespace drape {

struct VertexLoad {
  int vertex;
  Eigen::Vector3d force;  // [N]
};

// Everything that the rollouts of one mesh, scene and law share. It is immutable and safe to read
// from all threads.
struct ClothModel {
  Mesh mesh;  // the rest areas of its hinges are those of the scene and the law [MODEL, M26]
  Scene scene;
  Law law;
  BlockPattern pattern;
  Eigen::VectorXd vertex_area;  // a third of the adjacent face areas [m²], shape [V]
  std::vector<int> held;        // vertices with a handle [MODEL, M28]
  std::vector<VertexLoad> loads;

  // Throws InputError where the region of a load contains no edge of the hem, and where the mesh
  // has not the vertices that are held by their number.
  ClothModel(Mesh mesh, Scene scene, Law law);

  int num_dofs() const { return static_cast<int>(mesh.rest_x.size()); }
  State RestState() const;
  // The lumped mass of each degree of freedom [kg], shape [3V] [MODEL, M27].
  Eigen::VectorXd LumpedMass(double density) const;
};

// Calls stretch(law) and bend(law) for the laws of the elements that the scene has.
template <class Stretch, class Bend>
void VisitLaws(const ClothModel& model, const Stretch& stretch, const Bend& bend) {
  if (model.scene.stretch) std::visit(stretch, model.law.stretch);
  if (model.scene.bend) std::visit(bend, model.law.bend);
}

// Whether the hem and the support have those radii, to 2 %: a mesh may have a coarse hem.
bool HasDiscs(const ClothModel& model, const DrapeDiscs& discs);
// Throws InputError that names `mesh` where it has not.
void RequireDiscs(const ClothModel& model, const DrapeDiscs& discs, const std::string& mesh);

}  // namespace drape
