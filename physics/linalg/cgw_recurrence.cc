// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/cgw_recurrence.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

namespace drape {
namespace {

constexpr int kMaxRounds = 40;
constexpr double kTolerance = 1e-9, kRoundingAtMost = 1e-6, kStagnation = 0.9;

template <class T>
void Compact(const std::vector<int>& positions, std::vector<T>& values) {
  for (std::size_t i = 0; i < positions.size(); ++i) values[i] = values[positions[i]];
  values.resize(positions.size());
}

}  // namespace

CgwRecurrence::CgwRecurrence(std::span<const double> rhs_norm)
    : rhs_norm_(rhs_norm.begin(), rhs_norm.end()),
      square_(rhs_norm.size()),
      weight_(rhs_norm.size()) {
  std::vector<int> nonzero;
  for (int c = 0; c < static_cast<int>(rhs_norm.size()); ++c) {
    active_.push_back(c);
    if (rhs_norm[c] != 0.0) nonzero.push_back(c);
  }
  Keep(nonzero);
}

std::span<const double> CgwRecurrence::Weights(std::span<const double> square) {
  CHECK_EQ(square.size(), active_.size());
  for (std::size_t i = 0; i < square.size(); ++i) {
    const double before = std::exchange(square_[i], square[i]);
    const bool underflow = !(square[i] > 0.0);
    weight_[i] = round_ == 0 || underflow ? 1.0 : 1.0 / (1.0 + square[i] / before / weight_[i]);
  }
  return weight_;
}

void CgwRecurrence::Judge(std::span<const double> residual_norm) {
  CHECK_EQ(residual_norm.size(), active_.size());
  const double worst_before = std::exchange(worst_, 0.0);
  std::vector<int> unsolved;
  for (std::size_t i = 0; i < residual_norm.size(); ++i) {
    const double relative = residual_norm[i] / rhs_norm_[i];
    if (!(relative <= kTolerance)) unsolved.push_back(static_cast<int>(i));
    if (!(relative <= worst_)) worst_ = relative;  // also when `relative` is NaN
  }
  if (worst_ <= kRoundingAtMost && worst_ > kStagnation * worst_before) unsolved.clear();
  Keep(unsolved);
  if (++round_ == kMaxRounds && status_ == CgwStatus::kGoOn) status_ = CgwStatus::kGaveUp;
}

void CgwRecurrence::Keep(const std::vector<int>& positions) {
  kept_ = positions;
  Compact(positions, active_);
  Compact(positions, rhs_norm_);
  Compact(positions, square_);
  Compact(positions, weight_);
  if (active_.empty()) status_ = CgwStatus::kSolved;
}

}  // namespace drape
