// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cuda/device/device_buffer.h"
#include "cuda/kernels/cloth/device_cloth.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/readout/read_kernels.h"

namespace drape {

// Shapes on the present device and what is to be read of each.
struct ShapesToRead {
  const DeviceCloth* cloth;
  const double* x;                             // [3V] a slot
  std::vector<const DeviceReadout*> readouts;  // of each slot; of one kind and size

  int slots() const { return static_cast<int>(readouts.size()); }
};

// Losses ½ Σ ((r − target)/sigma)² of these shapes.
class DeviceLosses {
 public:
  // targets: of each slot, [K] on the host. Loss and dL_dx of a slot that cannot be read stay zero.
  DeviceLosses(const ShapesToRead& shapes, std::span<const Eigen::VectorXd* const> targets,
               double sigma);

  const double* target(int slot) const { return targets_.data() + target_start_[slot]; }
  double sigma() const { return sigma_; }
  double* loss(int slot) { return loss_.data() + slot; }                             // [1]
  double* dL_dx(int slot) { return dL_dx_.data() + std::size_t{1} * slot * dofs_; }  // [3V]
  std::vector<double> Download() const;

 private:
  int dofs_;
  double sigma_;
  std::vector<std::size_t> target_start_;
  DeviceBuffer<double> targets_, loss_, dL_dx_;  // a target that slots share is there once
};

// Outlines of all slots.
class DeviceOutlines {
 public:
  // losses: null, or where loss and dL_dx go.
  DeviceOutlines(const ShapesToRead& shapes, DeviceLosses* losses, cudaStream_t stream);

  std::vector<double> Radius() const;  // [slots, K]
  std::vector<int> Status() const;     // ReadStatus of each slot
  SparseRows Jacobian() const;         // ∂r/∂x of all slots, zero where a slot cannot be read

 private:
  DeviceBuffer<Vec2> points_;
  DeviceBuffer<double> radius_, value_;
  DeviceBuffer<int> start_, dof_, status_;
  DeviceBuffer<OutlineSlot> slots_;
};

// Soft silhouettes of all slots.
class DeviceSilhouettes {
 public:
  DeviceSilhouettes(const ShapesToRead& shapes, DeviceLosses* losses, cudaStream_t stream);
  static std::size_t BytesOfSlot(const DeviceCloth& cloth, const DeviceReadout& readout);

  std::vector<double> Coverage(int slot) const;  // [pixels]
  std::vector<int> Status() const;
  int Cuts(int slot) const;  // ends of edges at crossings

 private:
  SilhouettePlan plan_;
  DeviceBuffer<char> memory_;
  DeviceBuffer<int> status_;
  std::vector<SilhouetteSlot> host_slots_;
  DeviceBuffer<SilhouetteSlot> slots_;
};

// Losses and dL_dx of the kind of readout that the shapes have; ReadStatus of each slot.
std::vector<int> MeasureLosses(const ShapesToRead& shapes, DeviceLosses* losses,
                               cudaStream_t stream);

}  // namespace drape
