// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/outline_readouts.h"

#include <gtest/gtest.h>

#include "tests/losses/disc.h"
#include "tests/losses/readout/differences.h"

namespace drape {
namespace {

const DrapeDiscs kDiscs;

class SpectrumReadoutTest : public testing::Test {
 protected:
  Eigen::VectorXd Read(const Readout& readout, const Eigen::VectorXd& x) const {
    Eigen::VectorXd r;
    EXPECT_TRUE(readout.Read(x, &r, nullptr));
    return r;
  }
  const Mesh mesh_ = MakeDisc(4, 720, 0.15);
};

// A hem r(θ) = 12 cm · (1 + 0.05 cos 6θ) of 720 vertices.
TEST_F(SpectrumReadoutTest, HasTheAmplitudesOfAKnownHem) {
  const Eigen::VectorXd x =
      Deform(mesh_, {.folds = 6, .amplitude = 0.04, .shrink = 0.8, .twist = 0.0});
  const SpectrumReadout readout(mesh_, kDiscs, 20);
  ASSERT_EQ(readout.size(), 20);
  const Eigen::VectorXd r = Read(readout, x);
  for (int k = 1; k <= 20; ++k) EXPECT_NEAR(r[k - 1], k == 6 ? 0.006 : 0.0, 2e-6) << k;
  EXPECT_NEAR(Read(ProjectionReadout(mesh_, kDiscs), x)[0], 0.126, 1e-9);
}

TEST_F(SpectrumReadoutTest, DoesNotChangeWithATurn) {
  const Eigen::VectorXd x = Deform(mesh_, {.folds = 5, .twist = 0.4});
  const SpectrumReadout readout(mesh_, kDiscs, 20);
  EXPECT_LT((Read(readout, TurnedAboutZ(x, M_PI / 9)) - Read(readout, x)).norm(), 1e-12);
  EXPECT_LT((Read(readout, TurnedAboutZ(x, 1.2345)) - Read(readout, x)).norm(), 3e-5);
}

TEST_F(SpectrumReadoutTest, HasTheDerivativeOfDifferences) {
  const Mesh mesh = MakeDisc(5, 50, 0.15);
  const Eigen::VectorXd x =
      Deform(mesh, {.folds = 5, .twist = 0.4}) + 1e-3 * RandomVector(3 * mesh.num_vertices(), 6);
  test::ExpectDerivative(SpectrumReadout(mesh, kDiscs, 15), x);
  test::ExpectDerivative(ProjectionReadout(mesh, kDiscs), x);
  Eigen::VectorXd r;
  EXPECT_FALSE(SpectrumReadout(mesh, kDiscs, 3).Read(x.array() + 1.0, &r, nullptr));
}

}  // namespace
}  // namespace drape
