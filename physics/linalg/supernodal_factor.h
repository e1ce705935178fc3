// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "physics/linalg/blocks/block_matrix.h"
#include "physics/linalg/symbolic_analysis.h"

namespace drape {

// Work on the nodes of a forest by several threads, children before parents or the reverse. Small
// subtrees are tasks of one thread; each node above them is a task of its own. The tasks do not
// depend on the number of threads.
class TreeTasks {
 public:
  struct Task {
    int first, last;  // the nodes of a subtree with the root `last`, or one node
    int parent;       // task; −1 of a root
    int num_children;
  };
  // parent: [S], greater than the node, or −1; descendants of a node directly precede it.
  // work: [S], of each node.
  TreeTasks(const std::vector<int>& parent, const std::vector<double>& work);

  const std::vector<Task>& tasks() const { return tasks_; }

  // Who visits a task.
  class Queue;
  struct Worker {
    int thread;    // 0 … threads − 1
    Queue* queue;  // null where there is one thread

    // Calls work(i) for 0 ≤ i < count, on this thread and on those that have no task just now.
    // work throws nothing.
    void ForEach(int count, const std::function<void(int)>& work) const;
  };

  // Calls visit(worker, task) for every task after its children's, or after its parent's. Ends soon
  // after a call returned false, and returns false then.
  using Visit = std::function<bool(const Worker& worker, const Task& task)>;
  bool VisitUp(int threads, const Visit& visit) const;
  bool VisitDown(int threads, const Visit& visit) const;

 private:
  bool VisitAll(int threads, bool up, const Visit& visit) const;

  std::vector<Task> tasks_;               // children before parents
  std::vector<int> first_child_, child_;  // of tasks
  std::vector<int> rank_;                 // of a task: those with more work up to the root first
};

// Numbers on the boundary of a cache line, not initialised.
class AlignedNumbers {
 public:
  void Resize(std::size_t size);  // keeps its memory when it is large enough
  double* data() const { return data_.get(); }

 private:
  struct Free {
    void operator()(double* data) const;
  };
  std::unique_ptr<double[], Free> data_;
  std::size_t size_ = 0;
};

// The memory that a factorisation or a solve of one vector needs beside its result. Copies are
// empty.
struct FactorWorkspace {
  FactorWorkspace() = default;
  FactorWorkspace(const FactorWorkspace&) {}
  FactorWorkspace& operator=(const FactorWorkspace&) { return *this; }

  AlignedNumbers shared;                // update matrices, and vectors, that pass between tasks
  std::vector<AlignedNumbers> panel;    // [threads] own columns of a front
  std::vector<AlignedNumbers> subtree;  // [threads] update matrices inside a task
};

// The factorisation A = L·Lᵀ on such a pattern, multifrontal [Duff 1983; Liu 1992]. It does
// not use the BLAS: the supernodes of a cloth are so small that a BLAS call costs as much as the
// products, and threads wait for its locks. The object is immutable and shared by threads; numbers
// and workspace belong to the caller. Each number is summed in the same order whatever the vector
// width of the machine and the number of threads.
class SupernodalFactor {
 public:
  // lower: the lower triangle of A, every number of which the pattern must contain.
  SupernodalFactor(SupernodalPattern pattern, const LowerTriangle& lower,
                   const FrontKernels& kernels = ChosenFrontKernels());

  // The size of `number` below.
  std::size_t num_numbers() const;
  double flops() const { return plan_.flops; }  // of a factorisation

  // Factors A, whose numbers are read at lower.source of `a`, into the lower triangles of `number`.
  // Returns false when A is not positive definite, and soon after *cancel turns true (cancel may be
  // null). threads ≥ 1.
  [[nodiscard]] bool Factor(const double* a, double* number, FactorWorkspace* workspace,
                            int threads = 1, const std::atomic<bool>* cancel = nullptr) const;

  // Solves in place, b ← L⁻ᵀ·L⁻¹·b, shape [n].
  void Solve(const double* number, double* b, FactorWorkspace* workspace, int threads = 1) const;
  // Solves for shape [n, m], with m a multiple of 4 (pad with zero columns). CHOLMOD's own solve
  // gathers and scatters columns that are n numbers apart. Measured with 39 right-hand sides on
  // 2,700 vertices: 15 ms by BLAS calls on rows, 9 ms by this function.
  void SolveRows(const double* number, RowMatrix& b, int threads = 1) const;

 private:
  // The memory of a thread for one task, and what the fronts of the task read.
  struct Front;

  // A tile reads up to seven numbers past the rows of a panel or an update matrix.
  static constexpr int kMargin = 8;

  void PlaceTasks();
  bool FactorFront(const Front& front, int s, const TreeTasks::Worker& worker) const;
  bool FactorPanel(const FrontPanel& panel, const TreeTasks::Worker& worker) const;
  UpdateMatrix GetUpdateMatrix(const Front& front, int s) const;

  SupernodalPattern pattern_;
  FactorPlan plan_;
  TreeTasks tasks_;
  const FrontKernels* kernels_;
  std::vector<std::ptrdiff_t> place_;         // [S] of an update matrix: in `subtree`, or
  std::vector<char> is_shared_;               // [S] … in `shared`
  std::vector<std::ptrdiff_t> vector_place_;  // [S] of a vector over the rows: in `shared`
  // One thread has few of them at a time: all are in `subtree`, and leave the numbers of L in the
  // cache for the solve.
  std::vector<std::ptrdiff_t> place_alone_, vector_place_alone_;
  std::size_t shared_size_ = 0, subtree_size_ = 0, alone_size_ = 0, panel_size_ = 0;
};

}  // namespace drape
