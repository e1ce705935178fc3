// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "physics/mesh/disc.h"
#include "physics/mesh/mesh.h"
#include "solver/fit/protocol/field_fit.h"

namespace drape {
namespace {

constexpr double kRadius = 0.15;

const Mesh& Disc() {
  static const Mesh disc = MakeDisc({.radius = kRadius, .target_vertices = 1200});
  return disc;
}

Eigen::VectorXd ComputeAreas(const Mesh& mesh) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.num_vertices());
  for (const Face& face : mesh.faces)
    for (const int v : face.vertex) areas[v] += face.area / 3;
  return areas;
}

// ∫|∇(2u + 3v)|² = 13 · area.
TEST(LaplaceStiffness, IsExactForLinearFields) {
  const Eigen::VectorXd field = (Eigen::RowVector2d(2, 3) * Disc().uv).transpose();
  const double energy = field.dot(LaplaceStiffness(Disc()) * field);
  EXPECT_NEAR(energy, 13 * ComputeAreas(Disc()).sum(), 1e-12);
}

// A free disc: zeros of J'_m [Abramowitz 1964, table 9.5], m = 0; 1 1; 2 2; 0; 3 3; 4 4; 1 1.
TEST(LaplaceModes, HaveTheEigenvaluesOfADisc) {
  const double zeros[] = {0,      1.8412, 1.8412, 3.0542, 3.0542, 3.8317,
                          4.2012, 4.2012, 5.3176, 5.3176, 5.3314, 5.3314};
  const LaplaceModes modes = FindLaplaceModes(Disc(), std::size(zeros));
  EXPECT_NEAR(modes.eigenvalues[0], 0.0, 1e-6);
  for (std::size_t i = 1; i < std::size(zeros); ++i)
    EXPECT_NEAR(std::sqrt(modes.eigenvalues[i]) * kRadius, zeros[i], 5e-3 * zeros[i]) << i;
}

TEST(LaplaceModes, AreOrthogonalByAreaAndOfMeanSquareOne) {
  const LaplaceModes modes = FindLaplaceModes(Disc(), 30);
  const Eigen::VectorXd areas = ComputeAreas(Disc());
  const Eigen::MatrixXd products =
      modes.vectors.transpose() * areas.asDiagonal() * modes.vectors / areas.sum();
  EXPECT_LT((products - Eigen::MatrixXd::Identity(30, 30)).cwiseAbs().maxCoeff(), 1e-8);
}

// With enough modes: σ²·κr·K₁(κr), κ² = 2/ℓ², away from the hem.
TEST(MaternDeviations, GiveTheCorrelationOfTheMaternField) {
  const MaternOptions options{.length = 0.03, .sigma = 0.5};
  const LaplaceModes modes = FindLaplaceModes(Disc(), 400);
  const Eigen::VectorXd deviations = MaternDeviations(modes.eigenvalues, options);
  EXPECT_NEAR(deviations.squaredNorm(), 0.25, 1e-12);
  Eigen::Matrix2Xd points(2, 4);
  points << 0, 0.015, 0.03, 0.06, 0, 0, 0, 0;
  const Eigen::MatrixXd at =
      InterpolationWeights(Disc(), points) * modes.vectors * deviations.asDiagonal();
  const Eigen::VectorXd covariance = at * at.row(0).transpose();
  for (int i = 1; i < 4; ++i) {
    const double r = std::sqrt(2.0) * points(0, i) / options.length;
    EXPECT_NEAR(covariance[i] / covariance[0], r * std::cyl_bessel_k(1.0, r), 0.04) << i;
  }
}

}  // namespace
}  // namespace drape
