// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/posterior_types.h"

#include <glog/logging.h>

namespace drape {

void PosteriorOptions::Check() const {
  CheckFields(*this);
  CHECK_EQ(draws % 2, 0) << "draws";
}

MaterialField PosteriorFit::FabricAt(const Eigen::VectorXd& u) const {
  Eigen::MatrixXd common = hierarchy.LogEntries(0);
  common.rightCols(common.cols() - hierarchy.num_fabric()).setZero();
  return TableParametrisation(hierarchy.base, common).Material(u);
}

}  // namespace drape
