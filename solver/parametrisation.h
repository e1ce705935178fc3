// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "physics/material.h"

namespace drape {

// How many numbers of a fabric are free (SPEC section 1: HOMO).
enum class Tying {
  kScales,   // 2: one factor on all stretch entries, one on all bend entries
  kColumns,  // 7: one for each of c11 c12 c22 c33, one for each bend row
  kEntries   // 39: each entry
};
// "2", "7" or "39". Throws InputError for any other.
Tying ParseTying(const std::string& text);

// The map from optimisation variables θ to material tables, on a log scale: an entry is its base
// value times exp((T·θ)_entry), so signs are kept and no bound is needed.
class MaterialParametrisation {
 public:
  MaterialParametrisation(MaterialField base, Tying tying);

  int size() const { return static_cast<int>(tie_.cols()); }
  const MaterialField& base() const { return base_; }
  MaterialField Material(const Eigen::VectorXd& theta) const;
  // T = ∂(log entries)/∂θ, shape [39, size()].
  const Eigen::MatrixXd& log_entries_by_theta() const { return tie_; }
  std::string name(int i) const;

 private:
  MaterialField base_;
  Eigen::MatrixXd tie_;
};

}  // namespace drape
