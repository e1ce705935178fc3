// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>

#include "physics/simulation/readout.h"

namespace drape::test {

// r = J·x with given rows J(i, x) and the derivative J. No device knows this readout.
class RowReadout final : public Readout {
 public:
  using Rows = std::function<ReadoutJacobian(std::size_t i, const Eigen::VectorXd& x)>;
  RowReadout(int size, Rows rows) : size_(size), rows_(std::move(rows)) {}
  int size() const override { return size_; }
  bool Read(std::size_t i, const Eigen::VectorXd& x, Eigen::VectorXd* r,
            ReadoutJacobian* dr_dx) const override {
    const ReadoutJacobian rows = rows_(i, x);
    *r = rows * x;
    if (dr_dx != nullptr) *dr_dx = rows;
    return r->allFinite();
  }

 private:
  int size_;
  Rows rows_;
};

// Wraps another readout and always reads on the host.
class HostReadout final : public Readout {
 public:
  // `readout` must outlive the object.
  explicit HostReadout(const Readout& readout) : readout_(readout) {}
  int size() const override { return readout_.size(); }
  bool Read(std::size_t i, const Eigen::VectorXd& x, Eigen::VectorXd* r,
            ReadoutJacobian* dr_dx) const override {
    return readout_.Read(i, x, r, dr_dx);
  }

 private:
  const Readout& readout_;
};

}  // namespace drape::test
