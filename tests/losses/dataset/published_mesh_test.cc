// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "losses/dataset/dataset.h"
#include "losses/image/segmentation.h"
#include "losses/silhouette/silhouette.h"
#include "tests/losses/dataset/synthetic_dataset.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

TEST(PublishedMesh, TheFillerVtIsDropped) {
  const SyntheticDataset tree;
  const PublishedMesh mesh = ReadPublishedMesh(tree.AddMesh("a.obj", true));
  EXPECT_EQ(mesh.surface.x.size(), 3 * 121);
  EXPECT_EQ(mesh.surface.triangles.size(), 120u);
  ASSERT_TRUE(mesh.cloth.has_value());
  EXPECT_NEAR(mesh.cloth->uv(0, 1), 0.15,
              1e-6);  // with an offset of one it would be 0, as at the centre
  EXPECT_NEAR(mesh.cloth->uv.col(31).y(), 0.15, 1e-6);
}

TEST(PublishedMesh, OtherTopologiesHaveNoCloth) {
  const SyntheticDataset tree;
  const PublishedMesh mesh = ReadPublishedMesh(tree.AddMesh("a.obj", false));
  EXPECT_EQ(mesh.surface.triangles.size(), 90u);
  EXPECT_FALSE(mesh.cloth.has_value());
}

TEST(PublishedMesh, ACountOfVtThatFitsNothingIsAnError) {
  const SyntheticDataset tree;
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/2 3/3\n";
  EXPECT_INPUT_ERROR(
      ReadPublishedMesh(tree.AddFile("a.obj", triangle + "vt 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n")),
      "found 4 vt for 3 v");
  EXPECT_TRUE(
      ReadPublishedMesh(tree.AddFile("b.obj", triangle + "vt 0 0\nvt 1 0\nvt 0 1\n")).cloth);
  EXPECT_INPUT_ERROR(ReadPublishedMesh(tree.AddFile("c.obj", "v 0 0 0\n")), "no faces");
}

TEST(QuarterTurn, IsFoundAgainstTheImage) {
  const SyntheticDataset tree;
  const GrayImage image = ReadSilhouette(tree.AddImage("a.jpg", 85, 5, 0.4)).image;
  for (int quarters = 0; quarters < 4; ++quarters) {
    const auto mesh = ReadPublishedMesh(tree.AddMesh("a.obj", true, 85 / 719.5, 5, 0.4, quarters));
    const auto turn = FindQuarterTurn(mesh.surface, image, Camera());
    ASSERT_TRUE(turn.has_value());
    EXPECT_EQ(turn->quarters, (4 - quarters) % 4);
    EXPECT_LT(turn->rms, 0.5);
    ObjSurface turned = mesh.surface;
    turned.x = TurnedAboutZ(turned.x, turn->quarters * M_PI / 2);
    EXPECT_EQ(FindQuarterTurn(turned, image, Camera())->quarters, 0);
  }
}

TEST(TurnedAboutZ, MirrorsFirst) {
  const Eigen::VectorXd turned = TurnedAboutZ(Eigen::Vector3d(1, 2, 3), M_PI / 2, true);
  EXPECT_NEAR((turned - Eigen::Vector3d(2, 1, 3)).norm(), 0, 1e-15);
}

TEST(Rasterize, ASurfaceEqualsItsMesh) {
  const SyntheticDataset tree;
  const PublishedMesh mesh = ReadPublishedMesh(tree.AddMesh("a.obj", true));
  EXPECT_EQ(Rasterize(mesh.surface, Camera(), 2).coverage,
            Rasterize(*mesh.cloth, mesh.surface.x, Camera(), 2).coverage);
}

}  // namespace
}  // namespace drape
