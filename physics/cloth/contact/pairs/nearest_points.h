// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace drape {

// The weights of the corners a, b, c at the point of their triangle that is nearest to p
// [Ericson 2005, 5.1.5]. Exactly 0 for corners that an edge or a corner leaves out.
Eigen::Vector3d NearestWeights(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b, const Eigen::Vector3d& c);

// The positions s, t in [0, 1] along the segments a–b and c–d of their points nearest to one
// another [Ericson 2005, 5.1.9]; of parallel ones, some such pair.
Eigen::Vector2d NearestPositions(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& c, const Eigen::Vector3d& d);

}  // namespace drape
