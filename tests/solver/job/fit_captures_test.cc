// SPDX-License-Identifier: Apache-2.0
// Drapes of the public data set as what a fit learns from.
#include "solver/job/fit_captures.h"

#include <gmock/gmock.h>

#include "physics/util/errors.h"
#include "solver/job/fit_input.h"
#include "tests/losses/dataset/synthetic_dataset.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class FitCapturesTest : public testing::Test {
 protected:
  FitCapturesTest() {
    for (int sample = 2; sample <= 4; ++sample)
      for (int capture = 1; capture <= 4; ++capture)
        data_.AddImage(Name("silhouettes", sample, capture) + ".jpg", 80 + 2 * sample, 5,
                       0.4 * capture);
    data_.AddMesh(Name("meshes", 2, 1) + ".obj", true, 84 / 719.5, 5, 0.4, 3);
    data_.AddMesh(Name("meshes", 3, 1) + ".obj", false, 86 / 719.5, 3);  // of another drape
    data_.AddFile("data/Fabric 7/notes.txt", "");
    selection_ = {data_.path(), 7, "2-4", "1,3", "both"};
  }
  static std::string Name(const std::string& kind, int sample, int capture) {
    return "data/Fabric 7/" + kind + "/Sample " + std::to_string(sample) + " Capture " +
           std::to_string(capture);
  }
  FitJob Selected() const {
    FitJob job;
    job.targets = targets_;
    SelectCaptures(selection_, &job);
    return job;
  }

  const SyntheticDataset data_;
  FitSelection selection_;
  ObservationSource targets_ = ObservationSource::kSilhouettes;
};

TEST_F(FitCapturesTest, TakesTheSelectionWithItsSpecimensAndDensity) {
  const FitJob job = Selected();
  ASSERT_EQ(job.captures.size(), 6u);
  EXPECT_THAT(job.posterior.specimen, ElementsAre(1, 1, 2, 2, 3, 3));
  EXPECT_EQ(job.density, 0.100);
  EXPECT_THAT(job.log_lines, testing::Contains(HasSubstr("notes.txt")));
  EXPECT_THAT(job.notes, ElementsAre(HasSubstr("misses its image")));
}

TEST_F(FitCapturesTest, WhatTheUserSaysStands) {
  FitJob job;
  job.density = 0.3;
  job.posterior.specimen = {1, 1, 1, 1, 1, 1};
  SelectCaptures(selection_, &job);
  EXPECT_EQ(job.density, 0.3);
  EXPECT_EQ(job.posterior.specimen[5], 1);
}

TEST_F(FitCapturesTest, ATargetIsNamedByItsCapture) {
  const Observation target =
      ReadCaptureObservation(Selected().captures[1], targets_, {.angles = 72});
  EXPECT_EQ(target.name, "sample_2_capture_3_down");
  EXPECT_THAT(target.file, HasSubstr("Sample 2 Capture 3.jpg"));
  EXPECT_NEAR(target.radius.mean(), 84, 0.5);
}

// The mesh is that of the image, turned by 270° in its file.
TEST_F(FitCapturesTest, AMeshGivesTheOutlineOfItsImage) {
  targets_ = ObservationSource::kMeshes;
  const FitJob job = Selected();
  ASSERT_EQ(job.captures.size(), 1u);
  const ObservationOptions options{.angles = 72};
  const Observation mesh = ReadCaptureObservation(job.captures[0], targets_, options);
  const Observation image =
      ReadCaptureObservation(job.captures[0], ObservationSource::kSilhouettes, options);
  EXPECT_THAT(mesh.file, HasSubstr("Sample 2 Capture 1.obj"));
  EXPECT_EQ(mesh.name, image.name);
  EXPECT_LT((mesh.radius - image.radius).cwiseAbs().maxCoeff(), 1.0);
  EXPECT_LT((mesh.radius - image.radius).norm() / std::sqrt(72.0), 0.4);
  EXPECT_GT((mesh.radius - image.radius).norm(), 0.0);
}

TEST_F(FitCapturesTest, CapturesWithoutAMeshOfTheirOwnAreSkippedWithTheReason) {
  targets_ = ObservationSource::kMeshes;
  const FitJob job = Selected();
  EXPECT_THAT(job.notes,
              testing::AllOf(testing::Contains(HasSubstr("misses its image")),
                             testing::Contains(HasSubstr("sample 3, capture 1 has no mesh")),
                             testing::Contains(HasSubstr("sample 4, capture 3 has no mesh"))));
  selection_.samples = "4";
  EXPECT_INPUT_ERROR(Selected(), "no usable capture to fit, expected some with meshes");
}

TEST_F(FitCapturesTest, MistakesAreNamed) {
  const FitSelection good = selection_;
  selection_.fabric = 0;
  EXPECT_INPUT_ERROR(Selected(), "option 'fabric': none");
  selection_.fabric = 3;
  EXPECT_INPUT_ERROR(Selected(), "fabric: found 3, expected some of 7");
  selection_ = good;
  selection_.samples = "2,9";
  EXPECT_INPUT_ERROR(Selected(), "samples: found 9");
  selection_ = good;
  selection_.captures = "one";
  EXPECT_INPUT_ERROR(Selected(), "option 'captures'");
  selection_ = good;
  selection_.folder += "/none";
  EXPECT_INPUT_ERROR(Selected(), "is not a folder");
  EXPECT_INPUT_ERROR(ParseObservationSource("mesh"), "expected silhouettes or meshes");
}

TEST_F(FitCapturesTest, AFabricWithoutAPublishedDensityNeedsOne) {
  FitJob job;
  EXPECT_INPUT_ERROR(UseCaptures({{.fabric = 26, .sample = 1, .capture = 1}}, &job),
                     "none is published for fabric 26");
  job.density = 0.2;
  UseCaptures({{.fabric = 26, .sample = 1, .capture = 1}}, &job);
  EXPECT_EQ(job.density, 0.2);
}

TEST_F(FitCapturesTest, AnotherCaptureOrSourceIsAnotherJob) {
  FitJob job = Selected();
  LoadedJob loaded;
  loaded.problem.material = {0.1, {StretchTable{}}, {BendTable{}}};
  const std::string identity = CheckpointKey(job, loaded);
  job.captures[0].capture = 2;
  EXPECT_NE(CheckpointKey(job, loaded), identity);
  job.captures[0].capture = 1;
  EXPECT_EQ(CheckpointKey(job, loaded), identity);
  job.targets = ObservationSource::kMeshes;
  EXPECT_NE(CheckpointKey(job, loaded), identity);
}

}  // namespace
}  // namespace drape
