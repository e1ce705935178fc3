// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "physics/linalg/blocks/block_matrix.h"

namespace drape {

// Direct solver of symmetric positive definite systems on one block pattern. The symbolic analysis
// is done once; clones share its result and factor independently. Not thread-safe.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  // Returns a copy with its own factor, for another thread.
  virtual std::unique_ptr<LinearSolver> Clone() const = 0;
  // Returns a solver on another pattern of the same vertices, whose analysis starts from this one's
  // where the two differ little.
  virtual std::unique_ptr<LinearSolver> Adapt(const BlockPattern& other) const = 0;

  // Factors A = L·Lᵀ with A symmetric (one entry of each pair is read). Returns false when A is not
  // positive definite or the factorisation is cancelled; the factor is then unusable.
  [[nodiscard]] virtual bool Factor(const BlockMatrix& A) = 0;

  // Solves in place, b ← A⁻¹·b, with shapes [3V] and [3V, m].
  virtual void Solve(Eigen::VectorXd& b) = 0;
  virtual void Solve(RowMatrix& b) = 0;

  // Copies the numbers of the present factor, for later solves (adjoint of a rollout). `saved`
  // keeps its memory when it already has the right size.
  virtual void SaveFactor(std::vector<double>& saved) const = 0;
  virtual void SolveSaved(const std::vector<double>& saved, RowMatrix& b) = 0;
  virtual std::size_t factor_bytes() const = 0;
  virtual double factor_flops() const { return 0.0; }  // of one factorisation; 0 if not known

  // The threads of one factorisation and of its solves, ≥ 1 (1 at first): for where fewer systems
  // than processors are solved at a time. Small systems use fewer (1,000 vertices two, 10,000 all
  // of a large server). The results do not depend on them.
  virtual void SetThreads(int /*threads*/) {}

  // Takes from another solver by which flag an Interruptible ends its factorisations.
  void CancelLike(const LinearSolver& other) { cancel_ = other.cancel_; }
  bool cancelled() const { return cancel_ != nullptr && cancel_->load(std::memory_order_relaxed); }

 protected:
  const std::atomic<bool>* cancel_ = nullptr;  // ends Factor early when it turns true

 private:
  friend class Interruptible;
};

// While it exists, the factorisations of a solver end early when *cancel turns true. One at a time
// of a solver; cancel may be null.
class Interruptible {
 public:
  Interruptible(LinearSolver& solver, const std::atomic<bool>* cancel) : solver_(solver) {
    solver_.cancel_ = cancel;
  }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;
  ~Interruptible() { solver_.cancel_ = nullptr; }

 private:
  LinearSolver& solver_;
};

// Makes a supernodal solver: nested dissection of the vertices [George 1973], symbolic analysis by
// CHOLMOD, factorisation and solves by SupernodalFactor. threads: see SetThreads; clones have as
// many.
std::unique_ptr<LinearSolver> MakeLinearSolver(const BlockPattern& pattern, int threads = 1);

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
