// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/resources/device_gradient.h"

namespace drape {
namespace {

void AddRows(std::span<const double> rows, int columns, RowMatrix& sum) {
  const std::int64_t count = static_cast<std::int64_t>(rows.size()) / columns;
  for (std::int64_t r = 0; r < count; ++r)
    for (Eigen::Index j = 0; j < sum.cols(); ++j) sum(r % sum.rows(), j) += rows[r * columns + j];
}

}  // namespace

DeviceGradient::DeviceGradient(std::span<const RolloutInput> batch, int faces, int hinges,
                               int columns)
    : columns_(columns), stretch_start_{0}, bend_start_{0} {
  for (const RolloutInput& input : batch) {
    const std::int64_t stretch = GradientRows(faces, input.material->stretch.size() > 1);
    const std::int64_t bend = GradientRows(hinges, input.material->bend.size() > 1);
    stretch_start_.push_back(stretch_start_.back() + stretch * kStretchEntries * columns);
    bend_start_.push_back(bend_start_.back() + bend * kBendEntries * columns);
  }
  stretch_ = DeviceBuffer<double>(stretch_start_.back());
  bend_ = DeviceBuffer<double>(bend_start_.back());
  stretch_starts_ = DeviceBuffer<std::int64_t>(stretch_start_);
  bend_starts_ = DeviceBuffer<std::int64_t>(bend_start_);
  Clear(stretch_);
  Clear(bend_);
}

GradientView DeviceGradient::From(int first) {
  return {stretch_.data(), bend_.data(), stretch_starts_.data() + first,
          bend_starts_.data() + first};
}

MaterialGradient DeviceGradient::Collect(const RolloutInput& input, int i, int m) {
  if (host_stretch_.empty() && host_bend_.empty()) {
    host_stretch_.resize(stretch_.size());
    host_bend_.resize(bend_.size());
    CopyToHost<double>(stretch_.data(), host_stretch_);
    CopyToHost<double>(bend_.data(), host_bend_);
  }
  MaterialGradient gradient = MaterialGradient::Zero(*input.material, m);
  const auto part = [&](const std::vector<double>& all, const std::vector<std::int64_t>& start) {
    return std::span(all).subspan(start[i], start[i + 1] - start[i]);
  };
  AddRows(part(host_stretch_, stretch_start_), columns_, gradient.stretch);
  AddRows(part(host_bend_, bend_start_), columns_, gradient.bend);
  return gradient;
}

}  // namespace drape
