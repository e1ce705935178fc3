// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace drape {

enum class CgwStatus { kGoOn, kSolved, kGaveUp };

// The decisions of conjugate gradients for K·X = B with a factor of K's symmetric part Ks
// [Concus 1976], [Widlund 1978], many columns at a time, each on its own. A round is
//   Z = Ks⁻¹·R,  ω = Weights(diag(RᵀZ)),  X ← X₋ + ω·(Z + X − X₋),  R = B − K·X,  Judge(‖R‖)
// with the X of the round before in X₋ and zeros at first. Columns leave when they are solved:
// spans hold numbers of the active ones only.
class CgwRecurrence {
 public:
  // Norms of the columns of B; those of zeros are solved.
  explicit CgwRecurrence(std::span<const double> rhs_norm);

  CgwStatus status() const { return status_; }
  // Indices of the columns that are not solved, ascending.
  const std::vector<int>& active() const { return active_; }
  // Where they stood among those that were active before the last Judge.
  const std::vector<int>& kept() const { return kept_; }

  // ω of the active columns.
  std::span<const double> Weights(std::span<const double> square);

  // A column is solved at 1e-9 of its rhs. All are where the worst stands still below 1e-6: a
  // slender strip is so much stiffer in its plane than across it that products with K lose more.
  void Judge(std::span<const double> residual_norm);

 private:
  void Keep(const std::vector<int>& positions);

  CgwStatus status_ = CgwStatus::kGoOn;
  int round_ = 0;
  double worst_ = 1.0;  // ‖R‖ / ‖B‖ of any active column
  std::vector<int> active_, kept_;
  std::vector<double> rhs_norm_, square_, weight_;  // of active columns
};

}  // namespace drape
