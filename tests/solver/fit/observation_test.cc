// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observation.h"

#include <gtest/gtest.h>

#include "solver/fit/outline_residuals.h"
#include "tests/losses/image/photograph.h"
#include "tests/solver/fake_backend.h"

namespace drape {
namespace {

Observation ObserveStar(const Camera& camera) {
  Observation observation;
  observation.image = StarSilhouette(camera);
  observation.camera = camera;
  observation.radius = *observation.MeasureRadius(45);
  return observation;
}

// A photograph of any resolution gives the outline and the error of the published scale.
TEST(Observation, ComparesOutlinesAtThePublishedScale) {
  const test::FakeBackend backend;
  const Eigen::VectorXd drape = backend.Shape(test::TestMaterial());
  const Observation published = ObserveStar(Camera());
  const Observation photograph = ObserveStar(PhotographCamera());
  ASSERT_GT(photograph.camera.scale, 2 * published.camera.scale);
  EXPECT_LT((photograph.radius - published.radius).cwiseAbs().maxCoeff(), 0.25);
  const Mesh& mesh = backend.model().mesh;
  const double error = *OutlineRms(mesh, drape, published);
  EXPECT_GT(error, 1);
  EXPECT_NEAR(*OutlineRms(mesh, drape, photograph), error, 0.05);
}

}  // namespace
}  // namespace drape
