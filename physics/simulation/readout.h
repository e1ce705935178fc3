// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>

namespace drape {

struct DeviceReadout;  // losses/readout/device_readout.h

// ∂r/∂x, shape [K, 3V].
using ReadoutJacobian = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// The numbers that a loss reads from the shapes of a batch: K numbers of each shape.
class Readout {
 public:
  virtual ~Readout() = default;
  // K, which is the same for all rollouts.
  virtual int size() const = 0;
  // Computes r(x) of a shape x [3V] of rollout i, shape [K], and its Jacobian unless dr_dx is null.
  // Returns false where the shape cannot be read. May be called from several threads at a time.
  [[nodiscard]] virtual bool Read(std::size_t i, const Eigen::VectorXd& x, Eigen::VectorXd* r,
                                  ReadoutJacobian* dr_dx) const = 0;
  // The data from which a device computes the readout of rollout i. All rollouts of a batch have
  // one kind; the data are null for all of them when only Read can compute the readout.
  virtual const DeviceReadout* device(std::size_t i) const {
    (void)i;
    return nullptr;
  }
};

// The rollouts from `first` on of another readout's batch.
class ReadoutFrom final : public Readout {
 public:
  // `all` outlives the object.
  ReadoutFrom(const Readout& all, std::size_t first) : all_(all), first_(first) {}
  int size() const override { return all_.size(); }
  bool Read(std::size_t i, const Eigen::VectorXd& x, Eigen::VectorXd* r,
            ReadoutJacobian* dr_dx) const override {
    return all_.Read(first_ + i, x, r, dr_dx);
  }
  const DeviceReadout* device(std::size_t i) const override { return all_.device(first_ + i); }

 private:
  const Readout& all_;
  std::size_t first_;
};

}  // namespace drape
