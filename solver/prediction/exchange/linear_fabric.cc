// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/linear_fabric.h"

#include <glog/logging.h>

#include <algorithm>
#include <variant>

namespace drape {
namespace {

// D of a hinge along row `row` of the table, at zero angle.
double RigidityOfRow(const Law& law, const BendTable& table, int row) {
  const Hinge hinge{.vertex = {},
                    .face = {},
                    .rest_length = 1.0,
                    .rest_area = 1.0,
                    .direction = static_cast<double>(row)};
  const double kappa = std::visit(
      [&](const auto& bend) { return HingeStiffness(bend, hinge, table, 0.0); }, law.bend);
  return kappa / HingeFactor(hinge) / kBendPerRigidity;
}

double RigidityInDrape(const BendTable& table, const Eigen::VectorXd& weights, int row,
                       double at_rest) {
  double sum = 0.0, weight = 0.0;
  for (int c = 0; c < kBendCols; ++c) {
    const double w = weights[kStretchEntries + row * kBendCols + c];
    sum += w * table.b[row][c];
    weight += w;
  }
  return weight > 0.0 ? sum / weight / kBendPerRigidity : at_rest;
}

}  // namespace

LinearFabric LineariseAtRest(const MaterialField& tables, const Law& law) {
  CHECK_EQ(tables.stretch.size(), 1u);
  CHECK_EQ(tables.bend.size(), 1u);
  double c[kStretchCols];
  std::visit(
      [&](const auto& stretch) {
        stretch.Stiffness(GreenStrain<double>{0.0, 0.0, 0.0}, tables.stretch[0], c);
      },
      law.stretch);
  return {.c11 = c[0],
          .c22 = c[2],
          .c12 = c[1],
          .shear = c[3] / 2.0,
          .bend_weft = RigidityOfRow(law, tables.bend[0], 2),
          .bend_warp = RigidityOfRow(law, tables.bend[0], 0),
          .bend_bias = RigidityOfRow(law, tables.bend[0], 1),
          .density = tables.density};
}

LinearFabric LineariseInDrape(const MaterialField& tables, const Law& law,
                              const Eigen::VectorXd& weights) {
  CHECK_EQ(weights.size(), kMaterialEntries);
  LinearFabric material = LineariseAtRest(tables, law);
  const BendTable& bend = tables.bend[0];
  material.bend_warp = RigidityInDrape(bend, weights, 0, material.bend_warp);
  material.bend_bias = RigidityInDrape(bend, weights, 1, material.bend_bias);
  material.bend_weft = RigidityInDrape(bend, weights, 2, material.bend_weft);
  return material;
}

MaterialField TablesFrom(const LinearFabric& material) {
  MaterialField field;
  field.density = material.density;
  field.stretch.resize(1);
  field.bend.resize(1);
  const double entries[kStretchCols] = {material.c11, material.c12, material.c22,
                                        2.0 * material.shear};
  const double rigidity[kBendRows] = {material.bend_warp, material.bend_bias, material.bend_weft};
  for (auto& row : field.stretch[0].c)
    for (int m = 0; m < kStretchCols; ++m) row[m] = entries[m] / kMembranePerEntry;
  for (int r = 0; r < kBendRows; ++r)
    for (double& entry : field.bend[0].b[r]) entry = kBendPerRigidity * rigidity[r];
  return field;
}

// The rows are linear in between, each over an eighth or a quarter of all directions.
double MeanRigidity(const LinearFabric& material) {
  return (material.bend_weft + 2.0 * material.bend_bias + material.bend_warp) / 4.0;
}

IsotropicSheet MakeIsotropic(const LinearFabric& material, IsotropicChoice choice) {
  const auto& [c11, c22, c12, shear, bend_weft, bend_warp, bend_bias, density] = material;
  const double along = (c11 + c22) / 2.0;
  switch (choice) {
    case IsotropicChoice::kNearest:
      break;
    case IsotropicChoice::kShear:
      return {.mu = shear, .lambda = std::max(0.0, along - 2.0 * shear)};
    case IsotropicChoice::kStretch:
      return {.mu = (along - c12) / 2.0, .lambda = c12};
  }
  const double lambda = (c11 + c22 + 6.0 * c12 - 4.0 * shear) / 8.0;
  if (lambda < 0.0) return {.mu = (c11 + c22 + 2.0 * shear) / 6.0, .lambda = 0.0};
  return {.mu = (c11 + c22 - 2.0 * c12 + 4.0 * shear) / 8.0, .lambda = lambda};
}

LinearFabric WithIsotropicMembrane(LinearFabric material, const IsotropicSheet& sheet) {
  material.c11 = material.c22 = sheet.lambda + 2.0 * sheet.mu;
  material.c12 = sheet.lambda;
  material.shear = sheet.mu;
  return material;
}

LinearFabric WithMeanRigidity(LinearFabric material) {
  material.bend_weft = material.bend_warp = material.bend_bias = MeanRigidity(material);
  return material;
}

}  // namespace drape
