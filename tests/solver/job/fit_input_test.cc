// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_input.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "physics/util/errors.h"
#include "solver/job/fit_checkpoint.h"
#include "solver/job/fit_cloths.h"
#include "tests/losses/dataset/synthetic_dataset.h"
#include "tests/losses/temp_folder.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class ExpandImagesTest : public testing::Test {
 protected:
  ExpandImagesTest() {
    for (const std::string name : {"b.jpg", "a.png", "c.JPEG", "notes.txt"})
      WriteAll(folder_ / name, {1});
  }
  std::vector<std::string> Paths(const std::vector<std::string>& names) const {
    std::vector<std::string> paths;
    for (const std::string& name : names) paths.push_back(folder_ / name);
    return paths;
  }
  const TempFolder folder_;
};

TEST_F(ExpandImagesTest, Lists) {
  EXPECT_EQ(ExpandImages((folder_ / "b.jpg") + "," + (folder_ / "a.png")),
            Paths({"b.jpg", "a.png"}));
}
TEST_F(ExpandImagesTest, Folders) {
  EXPECT_EQ(ExpandImages(folder_.path()), Paths({"a.png", "b.jpg", "c.JPEG"}));
}
TEST_F(ExpandImagesTest, Patterns) {
  EXPECT_EQ(ExpandImages(folder_ / "*.[jp]*g"), Paths({"a.png", "b.jpg"}));
}
TEST_F(ExpandImagesTest, NothingIsAnError) {
  std::filesystem::create_directory(folder_ / "none");
  for (const std::string& text : {folder_ / "absent.png", folder_ / "*.gif", folder_ / "none",
                                  (folder_ / "a.png") + "," + (folder_ / "absent.png")}) {
    EXPECT_THROW(ExpandImages(text), InputError) << text;
  }
}

TEST(SearchMeshes, AtMostDoubleUpToTheMesh) {
  FitSpec spec;
  std::vector<std::string> notes;
  EXPECT_EQ(SearchMeshes(spec, {}, &notes), std::vector<std::string>{"disc:600"});
  spec.mesh = "disc:2400";
  EXPECT_EQ(SearchMeshes(spec, {}, &notes).size(), 2u);
  spec.mesh = "disc:4800";
  const std::vector<std::string> meshes = SearchMeshes(spec, {}, &notes);
  ASSERT_EQ(meshes.size(), 3u);
  EXPECT_THAT(meshes[1], testing::StartsWith("disc:1"));
  EXPECT_THAT(meshes[2], testing::StartsWith("disc:2"));
  for (const char* mesh : {"disc:600", "disc:800", "disc:300"}) {
    spec.mesh = mesh;
    EXPECT_TRUE(SearchMeshes(spec, {}, &notes).empty()) << mesh;
  }
  EXPECT_TRUE(notes.empty());
  spec.mesh = "disc:2400,radius=0.2";
  EXPECT_TRUE(SearchMeshes(spec, {}, &notes).empty());
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0], testing::HasSubstr("another cloth"));
}

// Drapes of the public data set as what a fit learns from.

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
  FitData Selected() const {
    FitData data;
    data.source = observations_;
    SelectCaptures(selection_, &data);
    return data;
  }

  const SyntheticDataset data_;
  FitSelection selection_;
  ObservationSource observations_ = ObservationSource::kSilhouettes;
};

TEST_F(FitCapturesTest, TakesTheSelectionWithItsSpecimensAndDensity) {
  const FitData data = Selected();
  ASSERT_EQ(data.captures.size(), 6u);
  EXPECT_THAT(data.specimens, ElementsAre(1, 1, 2, 2, 3, 3));
  EXPECT_EQ(data.density, 0.100);
  EXPECT_THAT(data.log_lines, testing::Contains(HasSubstr("notes.txt")));
  EXPECT_THAT(data.notes, ElementsAre(HasSubstr("misses its image")));
}

TEST_F(FitCapturesTest, WhatTheUserGivesIsKept) {
  FitData data;
  data.density = 0.3;
  data.specimens = {1, 1, 1, 1, 1, 1};
  SelectCaptures(selection_, &data);
  EXPECT_EQ(data.density, 0.3);
  EXPECT_EQ(data.specimens[5], 1);
}

TEST_F(FitCapturesTest, AnObservationIsNamedByItsCapture) {
  const Observation observation =
      ReadCaptureObservation(Selected().captures[1], observations_, {.angles = 72});
  EXPECT_EQ(observation.name, "sample_2_capture_3_down");
  EXPECT_THAT(observation.file, HasSubstr("Sample 2 Capture 3.jpg"));
  EXPECT_NEAR(observation.radius.mean(), 84, 0.5);
}

// The mesh is that of the image, turned by 270° in its file.
TEST_F(FitCapturesTest, AMeshGivesTheOutlineOfItsImage) {
  observations_ = ObservationSource::kMeshes;
  const FitData data = Selected();
  ASSERT_EQ(data.captures.size(), 1u);
  const ObservationOptions options{.angles = 72};
  const Observation mesh = ReadCaptureObservation(data.captures[0], observations_, options);
  const Observation image =
      ReadCaptureObservation(data.captures[0], ObservationSource::kSilhouettes, options);
  EXPECT_THAT(mesh.file, HasSubstr("Sample 2 Capture 1.obj"));
  EXPECT_EQ(mesh.name, image.name);
  EXPECT_LT((mesh.radius - image.radius).cwiseAbs().maxCoeff(), 1.0);
  EXPECT_LT((mesh.radius - image.radius).norm() / std::sqrt(72.0), 0.4);
  EXPECT_GT((mesh.radius - image.radius).norm(), 0.0);
}

TEST_F(FitCapturesTest, CapturesWithoutAMeshOfTheirOwnAreSkippedWithTheReason) {
  observations_ = ObservationSource::kMeshes;
  const FitData data = Selected();
  EXPECT_THAT(data.notes,
              testing::AllOf(testing::Contains(HasSubstr("misses its image")),
                             testing::Contains(HasSubstr("sample 3, capture 1 has no mesh")),
                             testing::Contains(HasSubstr("sample 4, capture 3 has no mesh"))));
  selection_.samples = "4";
  EXPECT_INPUT_ERROR(Selected(), "no usable capture to fit, expected some with meshes");
}

TEST_F(FitCapturesTest, MistakesAreNamed) {
  const FitSelection good = selection_;
  selection_.fabric = 0;
  EXPECT_INPUT_ERROR(Selected(), "option 'data_fabric': not given");
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
  EXPECT_INPUT_ERROR(ParseName<ObservationSource>("mesh", ""),
                     "expected one of silhouettes, meshes");
}

TEST_F(FitCapturesTest, AFabricWithoutAPublishedDensityNeedsOne) {
  FitData data;
  EXPECT_INPUT_ERROR(UseCaptures({{.fabric = 26, .sample = 1, .capture = 1}}, &data),
                     "none is published for fabric 26");
  data.density = 0.2;
  UseCaptures({{.fabric = 26, .sample = 1, .capture = 1}}, &data);
  EXPECT_EQ(data.density, 0.2);
}

TEST_F(FitCapturesTest, AnotherCaptureOrSourceIsAnotherJob) {
  FitData data = Selected();
  const FitSpec spec;
  FitInput input;
  input.problem.material = {0.1, {StretchTable{}}, {BendTable{}}};
  const std::string key = CheckpointKey(spec, data, input);
  data.captures[0].capture = 2;
  EXPECT_NE(CheckpointKey(spec, data, input), key);
  data.captures[0].capture = 1;
  EXPECT_EQ(CheckpointKey(spec, data, input), key);
  data.source = ObservationSource::kMeshes;
  EXPECT_NE(CheckpointKey(spec, data, input), key);
}

// A path is no part of the job, but what was read from it is.
TEST(CheckpointKeyTest, ContentsStandForAFile) {
  FitSpec spec;
  FitData data;
  FitInput input;
  input.problem.material = {0.1, {StretchTable{}}, {BendTable{}}};
  spec.mesh = "a/cloth.obj";
  data.material = "a/wool.json";
  input.files = {{"a/cloth.obj", "1"}, {"a/wool.json", "2"}};
  const std::string key = CheckpointKey(spec, data, input);
  spec.mesh = "b/other.obj";
  data.material = "b/other.json";
  input.files = {{"b/other.obj", "1"}, {"b/other.json", "2"}};
  EXPECT_EQ(CheckpointKey(spec, data, input), key);
  input.files[0].sha256 = "3";
  EXPECT_NE(CheckpointKey(spec, data, input), key);
  spec.mesh = "disc:300";
  input.files.clear();
  const std::string disc = CheckpointKey(spec, data, input);
  spec.mesh = "disc:400";
  EXPECT_NE(CheckpointKey(spec, data, input), disc);
}

}  // namespace
}  // namespace drape
