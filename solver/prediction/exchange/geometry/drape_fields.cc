// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/geometry/drape_fields.h"

#include <glog/logging.h>

#include <cmath>
#include <variant>

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

}  // namespace drape
