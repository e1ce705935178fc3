// SPDX-License-Identifier: Apache-2.0
// Captures of the published data set as targets of a fit.
#include <gmock/gmock.h>

#include <filesystem>

#include "losses/metrics/metrics.h"
#include "solver/job/fit_captures.h"

namespace drape {
namespace {

class CusickCaptures : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(folder_)) GTEST_SKIP() << folder_ << " is not there";
  }
  FitJob Select(ObservationSource targets) const {
    FitJob job;
    job.targets = targets;
    SelectCaptures({folder_, 2, "1-3", "", "both"}, &job);
    return job;
  }

  const std::string folder_ = std::string(DRAPE_SHARED_DIR) + "/cusick";
};

TEST_F(CusickCaptures, SilhouettesOfAFabric) {
  const FitJob job = Select(ObservationSource::kSilhouettes);
  ASSERT_EQ(job.captures.size(), 12u);
  EXPECT_EQ(job.density, 0.192);
  EXPECT_THAT(job.posterior.specimen, testing::ElementsAre(1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3));
}

// Each mesh was computed from its silhouette: as a target it says the same.
TEST_F(CusickCaptures, MeshesSayWhatTheirSilhouettesSay) {
  const FitJob job = Select(ObservationSource::kMeshes);
  ASSERT_EQ(job.captures.size(), 8u);
  EXPECT_EQ(job.notes.size(), 4u);
  for (const Capture& capture : job.captures) {
    const Observation mesh = ReadCaptureObservation(capture, ObservationSource::kMeshes, {});
    const Observation image = ReadCaptureObservation(capture, ObservationSource::kSilhouettes, {});
    EXPECT_LT(ProfileRms(mesh.radius, image.radius), kMaxMeshRms) << capture.Name();
  }
}

}  // namespace
}  // namespace drape
