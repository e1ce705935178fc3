// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/clearance.h"

namespace drape {

Clearance::Clearance(const Contact& contact, const Eigen::VectorXd& x, int threads)
    : contact_(&contact), threads_(threads), x_(x), gap_(x.size() / 3) {
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads_) if (threads_ > 1)
  for (Eigen::Index i = 0; i < gap_.size(); ++i)
    gap_[i] = SmallestGap(contact, x.segment<3>(3 * i));
}

bool Clearance::MayTouch(int i, const Eigen::Vector3d& place) const {
  return gap_[i] - (place - x_.segment<3>(3 * i)).norm() < contact_->range;
}

bool Clearance::ShortenMoves(const Eigen::VectorXd& x, Eigen::VectorXd& dx) const {
  bool shortened = false;
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads_) if (threads_ > 1) \
    reduction(||                                                                       \
              : shortened)
  for (int i = 0; i < static_cast<int>(gap_.size()); ++i) {
    const double way = (x.segment<3>(3 * i) - x_.segment<3>(3 * i)).norm();
    // More is left of the gap after the move than where a move is shortened.
    if (gap_[i] - way - dx.segment<3>(3 * i).norm() > 0.15 * (gap_[i] + way)) continue;
    Eigen::VectorXd move = dx.segment<3>(3 * i);
    if (!drape::ShortenMoves(*contact_, x.segment<3>(3 * i), move)) continue;
    dx.segment<3>(3 * i) = move;
    shortened = true;
  }
  return shortened;
}

}  // namespace drape
