// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/camera.h"

#include <ceres/jet.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "losses/image/image.h"
#include "losses/silhouette/silhouette.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "tests/losses/disc.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

Camera Pinhole() {
  Camera camera;
  camera.kind = CameraKind::kPinhole;
  return camera;
}

Camera Oblique() {
  Camera camera = Pinhole();
  camera.eye_x = 0.2;
  camera.eye_y = -0.1;
  return camera;
}

TEST(Camera, AnEyeBesideTheAxisMovesWhatIsBelowTheSupport) {
  const Camera camera = Oblique();
  double origin[2], below[2], under_eye[2];
  const double at_origin[3] = {0, 0, 0}, at_below[3] = {0, 0, -0.1};
  const double at_eye[3] = {camera.eye_x, camera.eye_y, -0.1};
  camera.Project(at_origin, origin);
  camera.Project(at_below, below);
  camera.Project(at_eye, under_eye);
  EXPECT_DOUBLE_EQ(origin[0], camera.cx);
  EXPECT_DOUBLE_EQ(origin[1], camera.cy);
  const double f = camera.focal_length();
  EXPECT_NEAR(below[0] - camera.cx, f * 0.2 * (1 / 0.7 - 1 / 0.8), 1e-9);
  EXPECT_NEAR(camera.cy - below[1], -f * 0.1 * (1 / 0.7 - 1 / 0.8), 1e-9);
  // What is straight below the eye is seen on the optical axis, whatever its depth.
  EXPECT_NEAR(under_eye[0] - camera.cx, f * 0.2 / 0.7, 1e-9);
  const Eigen::Vector2d back = camera.WorldFromImage({below[0], below[1]}, -0.1);
  EXPECT_LT(back.norm(), 1e-12);
}

TEST(Camera, FileKeepsIt) {
  const std::string path = testing::TempDir() + "/camera.json";
  Camera camera = Oblique();
  camera.width = 700;
  camera.cx = 321.25;
  WriteFileAtomically(path, CameraJson(camera).dump());
  const Camera read = ReadCamera(path);
  EXPECT_EQ(read.kind, CameraKind::kPinhole);
  EXPECT_EQ(read.width, 700);
  EXPECT_EQ(read.cx, 321.25);
  EXPECT_EQ(read.eye_x, 0.2);
  EXPECT_EQ(read.eye_y, -0.1);
  EXPECT_EQ(read.field_of_view, camera.field_of_view);
  WriteFileAtomically(path, R"({"kind": "pinhole", "width": 700})");
  EXPECT_THROW(ReadCamera(path), InputError);
}

TEST(Camera, KnowsWhereTheWarpIs) {
  EXPECT_EQ(ParseWarp("unknown"), std::nullopt);
  EXPECT_EQ(ParseWarp("up"), 90);
  EXPECT_EQ(ParseWarp("right"), 0);
  EXPECT_EQ(ParseWarp("100"), 100);
  EXPECT_EQ(ParseWarp("-80"), 100);
  EXPECT_EQ(ParseWarp("-360"), 0);
  for (const char* text : {"9x", "", "left", "12.5", "361", "99999999999"})
    EXPECT_THROW(ParseWarp(text), InputError) << text;
  const std::string path = testing::TempDir() + "/warp_camera.json";
  nlohmann::ordered_json json = CameraJson(Camera());
  WriteFileAtomically(path, json.dump());
  EXPECT_EQ(ReadWarp(path), "unknown");
  json["warp"] = "12";
  WriteFileAtomically(path, json.dump());
  EXPECT_EQ(ReadWarp(path), "12");
  json["warp"] = "leftish";
  WriteFileAtomically(path, json.dump());
  EXPECT_THROW(ReadWarp(path), InputError);
}

TEST(Camera, FileSaysWhatThePhotographSays) {
  const std::string path = testing::TempDir() + "/photograph_camera.json";
  nlohmann::ordered_json json = CameraJson(Oblique());
  WriteFileAtomically(path, json.dump());
  EXPECT_FALSE(ReadPhotographNotes(path));
  json["photograph"] = PhotographJson({0.27, 0.003, {"the camera is tilted by 14 degrees"}});
  WriteFileAtomically(path, json.dump());
  const auto notes = ReadPhotographNotes(path);
  ASSERT_TRUE(notes);
  EXPECT_EQ(notes->coefficient, 0.27);
  EXPECT_EQ(notes->coefficient_sd, 0.003);
  EXPECT_EQ(notes->warnings, std::vector<std::string>{"the camera is tilted by 14 degrees"});
  EXPECT_EQ(ReadCamera(path).eye_x, 0.2);
  json["photograph"]["dc_sd"] = -1;
  WriteFileAtomically(path, json.dump());
  EXPECT_THROW(ReadPhotographNotes(path), InputError);
}

TEST(Camera, OrthographicPutsFifteenCentimetresAt107Point9Pixels) {
  const double x[3] = {0.15, -0.1, 0.3};
  double image[2];
  Camera().Project(x, image);
  EXPECT_DOUBLE_EQ(image[0], 127.5 + 107.925);
  EXPECT_DOUBLE_EQ(image[1], 127.5 + 71.95);
}

TEST(Camera, PinholeEdgeOfViewIsHalfAPixelOutsideTheLastRow) {
  const double x[3] = {0, 0.7 * std::tan(0.25), 0};
  double image[2];
  Pinhole().Project(x, image);
  EXPECT_NEAR(image[1], -0.5, 1e-12);
}

TEST(Camera, PinholeShowsALowerHemSmaller) {
  EXPECT_NEAR(Pinhole().PixelsPerMetre(-0.1) / Pinhole().PixelsPerMetre(0.0), 0.7 / 0.8, 1e-14);
}

TEST(Camera, JacobianAgreesWithDualNumbers) {
  using Jet = ceres::Jet<double, 3>;
  for (const Camera& camera : {Camera(), Pinhole(), Oblique()}) {
    const double x[3] = {0.08, -0.11, -0.07};
    const Jet jet_x[3] = {Jet(x[0], 0), Jet(x[1], 1), Jet(x[2], 2)};
    Jet image[2];
    camera.Project(jet_x, image);
    double jacobian[2][3];
    camera.Jacobian(x, jacobian);
    for (int row = 0; row < 2; ++row)
      EXPECT_LT((Eigen::Vector3d(jacobian[row]) - image[row].v).norm(), 1e-11);
  }
}

TEST(Camera, ProjectVerticesReportsNanAndPointsBehindTheCamera) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(6);
  Eigen::Matrix2Xd points;
  EXPECT_TRUE(ProjectVertices(x, Pinhole(), &points));
  x[5] = 0.7;
  EXPECT_FALSE(ProjectVertices(x, Pinhole(), &points));
  EXPECT_TRUE(ProjectVertices(x, Camera(), &points));
  x[5] = std::nan("");
  EXPECT_FALSE(ProjectVertices(x, Camera(), &points));
}

TEST(Camera, CheckNamesTheFieldAndTheValue) {
  Camera camera;
  EXPECT_NO_THROW(camera.Check("camera"));
  camera.scale = -2;
  EXPECT_THAT([&] { camera.Check("a.json"); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("a.json: camera_scale = -2")));
  camera = Pinhole();
  for (const double angle : {4.0, 1e-320}) {
    camera.field_of_view = angle;
    EXPECT_THROW(camera.Check("camera"), InputError) << angle;
  }
}

constexpr DrapeDiscs kSmall = {0.12, 0.09}, kLarge = {0.18, 0.09};

class FindDiscsTest : public FileFixture {
 protected:
  std::string Image(const std::string& name, const std::optional<DrapeDiscs>& discs) const {
    WritePng(GrayImage(16, 16), Path(name), discs);
    return Path(name);
  }
};

TEST_F(FindDiscsTest, AreThoseOfTheFilesAndOfTheUser) {
  const std::string none = Image("none.png", {}), small = Image("small.png", kSmall);
  EXPECT_EQ(FindDiscs({}), DrapeDiscs());
  EXPECT_EQ(FindDiscs({}, {none, Path("no file")}), DrapeDiscs());
  EXPECT_EQ(FindDiscs({}, {none, small}), kSmall);
  EXPECT_EQ(FindDiscs({.specimen = 0.24}, {small}), kSmall);
  EXPECT_EQ(FindDiscs({.specimen = 0.254, .support = 0.127}), (DrapeDiscs{0.127, 0.0635}));
  EXPECT_EQ(FindDiscs(GivenDiscs(kLarge)), kLarge);
}

TEST_F(FindDiscsTest, AFileOfJsonSaysThemToo) {
  const std::string json = Write("camera.json", DiscsJson(kLarge).dump());
  EXPECT_EQ(FindDiscs({}, {json}), kLarge);
  EXPECT_EQ(FindDiscs({}, {Write("other.json", "{\"kind\": 1}")}), DrapeDiscs());
  EXPECT_INPUT_ERROR(
      FindDiscs(
          {}, {Write("bad.json", "{\"specimen_diameter_m\": 0.1, \"support_diameter_m\": 0.18}")}),
      "bad.json: found 10 cm on 18 cm, expected a support that is smaller");
}

TEST_F(FindDiscsTest, ThoseThatDifferAreNeverCompared) {
  const std::string small = Image("small.png", kSmall), large = Image("large.png", kLarge);
  EXPECT_INPUT_ERROR(FindDiscs({}, {small, large}),
                     "large.png: is of a specimen of 36 cm on 18 cm, expected 24 cm on 18 cm as ");
  EXPECT_INPUT_ERROR(FindDiscs({.specimen = 0.3}, {small}),
                     "small.png: is of a specimen of 24 cm on 18 cm, expected 30 cm on 18 cm as "
                     "options");
  EXPECT_INPUT_ERROR(FindDiscs({.support = 0.3}),
                     "option 'support': found 30 cm on 30 cm, expected a support that is smaller");
}

// The scale of the published images is known for pictures of the size that a specimen needs.
TEST(CameraAbove, HoldsTheFlatSpecimen) {
  EXPECT_EQ(CameraAbove(kSmall).width, 256);
  EXPECT_EQ(CameraAbove({}).width, 256);
  const Camera camera = CameraAbove(kLarge);
  EXPECT_EQ(camera.width, 308);
  EXPECT_EQ(camera.cx, 153.5);
  EXPECT_EQ(camera.pixels_per_metre(), 719.5);
  EXPECT_EQ(MakeCamera(CameraInput(), kLarge).width, 308);
  EXPECT_EQ(MakeCamera({}, GrayImage(308, 308), kLarge, "a.png").cy, 153.5);
  EXPECT_INPUT_ERROR(MakeCamera({}, GrayImage(308, 308), {}, "a.png"), "its scale is not given");
}

}  // namespace
}  // namespace drape
