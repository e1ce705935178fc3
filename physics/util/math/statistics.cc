// SPDX-License-Identifier: Apache-2.0
#include "physics/util/math/statistics.h"

#include <glog/logging.h>

#include <Eigen/Core>
#include <cmath>

namespace drape {

std::optional<PowerLaw> FitPowerLaw(std::span<const double> x, std::span<const double> y) {
  CHECK_EQ(x.size(), y.size());
  const Eigen::Index count = static_cast<Eigen::Index>(x.size());
  const Eigen::ArrayXd xs = Eigen::Map<const Eigen::ArrayXd>(x.data(), count);
  const Eigen::ArrayXd ys = Eigen::Map<const Eigen::ArrayXd>(y.data(), count);
  CHECK((xs > 0.0).all() && (ys > 0.0).all());
  if (count < 2 || xs.minCoeff() == xs.maxCoeff()) return {};
  const Eigen::ArrayXd u = xs.log() - xs.log().mean(), v = ys.log();
  const double exponent = (u * v).sum() / u.square().sum();
  return PowerLaw{exponent, std::exp(v.mean() - exponent * xs.log().mean())};
}

}  // namespace drape
