// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "losses/silhouette/silhouette.h"

namespace drape::test {

// gradient += (∂coverage/∂x)ᵀ pixel_adjoint: shapes [height · width] → [3V]. `silhouette` is the
// result of RenderSoft at the same x and camera.
inline void AdjRenderSoft(const SoftSilhouette& silhouette, const Eigen::VectorXd& x,
                          const Camera& camera, const Eigen::VectorXd& pixel_adjoint,
                          Eigen::VectorXd* gradient) {
  ASSERT_EQ(pixel_adjoint.size(), silhouette.coverage.size());
  ASSERT_EQ(gradient->size(), x.size());
  Eigen::Matrix2Xd d_image = Eigen::Matrix2Xd::Zero(2, x.size() / 3);
  for (const RampPixel& ramp : silhouette.ramp) {
    for (int k = 0; k < ramp.num_vertices; ++k) {
      d_image.col(ramp.vertex[k]) += pixel_adjoint[ramp.pixel] * ramp.d_image[k];
    }
  }
  for (int i = 0; i < d_image.cols(); ++i) {
    if (d_image.col(i).isZero(0)) continue;
    double by_x[3];
    camera.AdjProject(&x[3 * i], {d_image(0, i), d_image(1, i)}, by_x);
    for (int d = 0; d < 3; ++d) (*gradient)[3 * i + d] += by_x[d];
  }
}

}  // namespace drape::test
