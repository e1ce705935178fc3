// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "losses/readout/readout.h"
#include "tests/losses/disc.h"

namespace drape::test {

// Expects the Jacobian at x to agree with central differences of width 2h along a random direction,
// row by row, to `tolerance` · (1 + the length of the row).
inline void ExpectDerivative(const Readout& readout, const Eigen::VectorXd& x,
                             double tolerance = 1e-6, double h = 1e-7) {
  Eigen::VectorXd r, plus, minus;
  ReadoutJacobian jacobian;
  ASSERT_TRUE(readout.Read(x, &r, &jacobian));
  ASSERT_EQ(r.size(), readout.size());
  ASSERT_EQ(readout.size() % readout.group(), 0);
  ASSERT_EQ(jacobian.rows(), readout.size());
  ASSERT_EQ(jacobian.cols(), x.size());
  const Eigen::VectorXd direction = RandomVector(static_cast<int>(x.size()), 9);
  ASSERT_TRUE(readout.Read(x + h * direction, &plus, nullptr));
  ASSERT_TRUE(readout.Read(x - h * direction, &minus, nullptr));
  const Eigen::VectorXd found = jacobian * direction, differences = (plus - minus) / (2 * h);
  for (int k = 0; k < readout.size(); ++k)
    EXPECT_NEAR(found[k], differences[k], tolerance * (1.0 + jacobian.row(k).norm()))
        << "row " << k << ", value " << r[k];
}

}  // namespace drape::test
