// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <span>
#include <string>

#include "physics/cloth/cloth_model.h"
#include "physics/material/material.h"
#include "physics/mesh/disc.h"
#include "physics/util/math/random.h"

// Small cloths and fabrics of the physics tests.
namespace drape::test {

// A table with the features of measured ones: stretch softer on the bias, and bending that rises
// with curvature. Every entry differs. `level` multiplies stretch.
inline MaterialField TestMaterial(double level = 1.0) {
  MaterialField material;
  material.density = 0.2;
  StretchTable stretch;
  for (int r = 0; r < kStretchRows; ++r) {
    const double bias = r == 0 ? 1.0 : 0.6 + 0.4 * std::cos((r - 1) * M_PI / 2);
    const double row[] = {60.0 * bias + 3 * r, 4.0 + r, 55.0 * bias + 4 * r, 12.0 + 2 * r};
    for (int m = 0; m < kStretchCols; ++m) stretch.c[r][m] = level * row[m];
  }
  BendTable bend;
  for (int r = 0; r < kBendRows; ++r)
    for (int c = 0; c < kBendCols; ++c) bend.b[r][c] = 4e-5 * (1.0 + 0.2 * r) * (1.0 + 0.3 * c);
  material.stretch = {stretch};
  material.bend = {bend};
  return material;
}

// Gives every face and hinge its own table: each entry of `base` times exp(sigma·normal).
inline MaterialField Scatter(const MaterialField& base, const Mesh& mesh, double sigma,
                             std::mt19937_64& random) {
  MaterialField field = base;
  field.stretch.assign(mesh.num_faces(), base.stretch[0]);
  field.bend.assign(mesh.num_hinges(), base.bend[0]);
  for (StretchTable& table : field.stretch)
    for (double& entry : std::span(&table.c[0][0], kStretchEntries))
      entry *= std::exp(sigma * SampleNormal(random));
  for (BendTable& table : field.bend)
    for (double& entry : std::span(&table.b[0][0], kBendEntries))
      entry *= std::exp(sigma * SampleNormal(random));
  return field;
}

// Whether c11, c22, c33 > 0 and c12² < c11·c22 in all rows, and therefore between them too. Without
// that, a cloth has no energy minimum under compression and the matrix of its time step is not
// positive definite.
inline bool ResistsAllStrains(const MaterialField& material) {
  bool resists = true;
  for (const StretchTable& table : material.stretch)
    for (const auto& [c11, c12, c22, c33] : table.c)
      resists = resists && c11 > 0 && c22 > 0 && c33 > 0 && c12 * c12 < c11 * c22;
  return resists;
}

inline RowMatrix RandomMatrix(int rows, int columns, std::mt19937_64& random) {
  RowMatrix matrix(rows, columns);
  for (double& value : std::span(matrix.data(), matrix.size())) value = SampleNormal(random);
  return matrix;
}

inline std::shared_ptr<const ClothModel> SmallDisc(const std::string& law, int vertices = 100) {
  DiscOptions options;
  options.target_vertices = vertices;
  return std::make_shared<ClothModel>(MakeDisc(options), CusickScene(), MakeLaw(law));
}

// The flat rest shape with noise of `amplitude` [m], so that no derivative is zero by symmetry.
inline State NoisyStart(const ClothModel& model, double amplitude, std::mt19937_64& random) {
  State state = model.RestState();
  state.x += amplitude * RandomMatrix(model.num_dofs(), 1, random);
  return state;
}

}  // namespace drape::test
