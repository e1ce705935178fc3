// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/field_map.h"

#include "losses/image/image.h"
#include "physics/mesh/disc.h"
#include "solver/job/plot/gnuplot.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"

namespace drape {
namespace {

using FieldMapTest = FileFixture;

// Half of the disc is dark, half is light.
TEST_F(FieldMapTest, ColoursFollowTheField) {
  const Mesh mesh = MakeDisc({.target_vertices = 300});
  const Eigen::VectorXd of_face = FaceCentres(mesh).row(0).array().sign().matrix().transpose();
  RenderFaceMap(Path("faces.png"), mesh, of_face, {"title", "unit"});
  const GrayImage faces = ReadImage(Path("faces.png"));  // 1 is black
  EXPECT_EQ(faces.width, 900);
  EXPECT_GT(faces.at(250, 380), faces.at(500, 380) + 0.3);
  const Eigen::VectorXd of_hinge = Eigen::VectorXd::LinSpaced(mesh.num_hinges(), 1.0, 100.0);
  RenderHingeMap(Path("hinges.png"), mesh, of_hinge, {"title", "unit"});
  EXPECT_EQ(ReadImage(Path("hinges.png")).height, 760);
}

TEST_F(FieldMapTest, AFolderThatIsMissingIsNamed) {
  const Mesh mesh = MakeDisc({.target_vertices = 100});
  EXPECT_IO_ERROR(RenderFaceMap(Path("absent/faces.png"), mesh,
                                Eigen::VectorXd::LinSpaced(mesh.num_faces(), 0.0, 1.0), {}),
                  "absent");
}

TEST(RunGnuplot, SaysWhatItRefuses) {
  EXPECT_INPUT_ERROR(RunGnuplot("plott x\n"), "gnuplot: line 0: invalid command");
  EXPECT_THAT(RunGnuplot("set terminal dumb 40 10\nplot [0:1] x notitle\n"),
              testing::HasSubstr("*"));
}

}  // namespace
}  // namespace drape
