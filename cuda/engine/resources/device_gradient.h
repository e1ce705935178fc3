// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cuda/device/device_buffer.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "physics/simulation/backend.h"

namespace drape {

// Columns that the kernels work on: pairs, but for a single one.
inline int PaddedColumns(int m) { return m == 1 ? 1 : (m + 1) / 2 * 2; }

// What a gradient needs at most for m columns [bytes of a slot].
inline std::size_t GradientBytes(const ClothView& cloth, int columns) {
  return sizeof(double) * columns *
         (kStretchEntries * std::size_t{1} * cloth.num_faces + kBendEntries * cloth.num_hinges);
}

// Gradients by the tables of a batch's materials, sums over elements in rows as GradientRows says;
// zero at first.
class DeviceGradient {
 public:
  DeviceGradient(std::span<const RolloutInput> batch, int faces, int hinges, int columns);

  // Of the slots from `first` on.
  GradientView From(int first);
  // That of slot i, its chunks added up in order; the first m columns. Waits for no stream.
  MaterialGradient Collect(const RolloutInput& input, int i, int m);

 private:
  int columns_;
  std::vector<std::int64_t> stretch_start_, bend_start_;
  DeviceBuffer<double> stretch_, bend_;
  DeviceBuffer<std::int64_t> stretch_starts_, bend_starts_;
  std::vector<double> host_stretch_, host_bend_;  // after the first Collect
};

}  // namespace drape
