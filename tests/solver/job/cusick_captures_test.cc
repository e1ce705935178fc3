// SPDX-License-Identifier: Apache-2.0
// Captures of the published data set as observations of a fit.
#include <gmock/gmock.h>

#include <filesystem>

#include "losses/metrics/metrics.h"
#include "solver/job/fit_input.h"

namespace drape {
namespace {

class CusickCaptures : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(folder_)) GTEST_SKIP() << folder_ << " is not there";
  }
  FitData Select(ObservationSource source) const {
    FitData data;
    data.source = source;
    SelectCaptures({folder_, 2, "1-3", "", "both"}, &data);
    return data;
  }

  const std::string folder_ = std::string(DRAPE_SHARED_DIR) + "/cusick";
};

TEST_F(CusickCaptures, SilhouettesOfAFabric) {
  const FitData data = Select(ObservationSource::kSilhouettes);
  ASSERT_EQ(data.captures.size(), 12u);
  EXPECT_EQ(data.density, 0.192);
  EXPECT_THAT(data.specimens, testing::ElementsAre(1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3));
}

// Each mesh was computed from its silhouette: as an observation it has the same outline.
TEST_F(CusickCaptures, MeshesSayWhatTheirSilhouettesSay) {
  const FitData data = Select(ObservationSource::kMeshes);
  ASSERT_EQ(data.captures.size(), 8u);
  EXPECT_EQ(data.notes.size(), 4u);
  for (const Capture& capture : data.captures) {
    const Observation mesh = ReadCaptureObservation(capture, ObservationSource::kMeshes, {});
    const Observation image = ReadCaptureObservation(capture, ObservationSource::kSilhouettes, {});
    EXPECT_LT(ProfileRms(mesh.radius, image.radius), kMaxMeshRms) << capture.Name();
  }
}

}  // namespace
}  // namespace drape
