// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace drape {

enum class CgwStatus { kGoOn, kSolved, kGaveUp };

// The decisions of the generalised conjugate gradients for K·X = B with a factor of the symmetric
// part Ks of K [Concus 1976], [Widlund 1978], [MODEL, M44], for many columns at a time, each
// independent of the others. One round is
//   Z = Ks⁻¹·R,  ω = Weights(diag(RᵀZ)),  X ← X₋ + ω·(Z + X − X₋),  R = B − K·X,  Judge(‖R‖)
// with X₋ the X of the previous round; both are zero at first. A column leaves when it is solved:
// spans hold the numbers of the active columns only.
class CgwRecurrence {
 public:
  // Takes the norms of the columns of B. A column of zeros is solved at once.
  explicit CgwRecurrence(std::span<const double> rhs_norm);

  CgwStatus status() const { return status_; }
  // Indices of the columns that are not solved yet, ascending.
  const std::vector<int>& active() const { return active_; }
  // Their positions among the columns that were active before the last call of Judge.
  const std::vector<int>& kept() const { return kept_; }

  // Returns ω of the active columns, given diag(RᵀZ) as `square`.
  std::span<const double> Weights(std::span<const double> square);

  // A column is solved when its residual is at most 1e-9 of its right-hand side. All columns count
  // as solved when the largest relative residual is at most 1e-6 and has decreased by less than a
  // tenth in the last round: a slender strip is so much stiffer in its plane than across it that
  // products with K lose more digits.
  void Judge(std::span<const double> residual_norm);

 private:
  void Keep(const std::vector<int>& positions);

  CgwStatus status_ = CgwStatus::kGoOn;
  int round_ = 0;
  double worst_ = 1.0;  // largest ‖R‖ / ‖B‖ of an active column
  std::vector<int> active_, kept_;
  std::vector<double> rhs_norm_, square_, weight_;  // of active columns
};

}  // namespace drape
