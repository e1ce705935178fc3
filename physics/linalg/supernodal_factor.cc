// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/supernodal_factor.h"

#include <glog/logging.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

namespace drape {
namespace {

constexpr std::align_val_t kCacheLine{64};
constexpr int kAhead = 128;                   // numbers of A
constexpr std::ptrdiff_t kPrefetched = 8192;  // numbers of L
constexpr int kPanelColumns = 64;
constexpr int kPartColumns = 24;      // of a part of a product that another thread may take
constexpr double kSharedFlops = 2e6;  // handing out a smaller product takes longer than it gains

// Calls part(first, last) for the columns begin … end, in parts for other threads where that pays.
void ForEachPart(const TreeTasks::Worker& worker, int begin, int end, double flops,
                 const auto& part) {
  if (begin >= end) return;
  if (worker.queue == nullptr || flops < kSharedFlops) return part(begin, end);
  worker.ForEach((end - begin + kPartColumns - 1) / kPartColumns, [&](int i) {
    const int first = begin + i * kPartColumns;
    part(first, std::min(first + kPartColumns, end));
  });
}

}  // namespace

void AlignedNumbers::Free::operator()(double* data) const { ::operator delete[](data, kCacheLine); }

void AlignedNumbers::Resize(std::size_t size) {
  if (size <= size_) return;
  data_.reset();
  size_ = 0;
  data_.reset(static_cast<double*>(::operator new[](size * sizeof(double), kCacheLine)));
  size_ = size;
}

struct SupernodalFactor::Front {
  const double* a;
  double* number;
  double *panel, *subtree, *shared;  // shared: null where there is one thread
};

SupernodalFactor::SupernodalFactor(SupernodalPattern pattern, const LowerTriangle& lower,
                                   const FrontKernels& kernels)
    : pattern_(std::move(pattern)),
      plan_(MakeFactorPlan(pattern_, lower)),
      tasks_(plan_.parent, plan_.work),
      kernels_(&kernels) {
  PlaceTasks();
}

void SupernodalFactor::PlaceTasks() {
  const int supernodes = pattern_.num_supernodes();
  std::vector<std::ptrdiff_t> matrices, vectors;
  for (int s = 0; s < supernodes; ++s) {
    const std::ptrdiff_t rows = UpdateMatrix::Padded(pattern_.num_rows(s));
    matrices.push_back(UpdateMatrix::NumNumbers(pattern_.num_below(s)));
    vectors.push_back(rows);
    vector_place_.push_back(static_cast<std::ptrdiff_t>(shared_size_));
    shared_size_ += rows;
    panel_size_ =
        std::max(panel_size_, static_cast<std::size_t>(rows) * pattern_.width(s) + kMargin);
  }
  place_.resize(supernodes);
  is_shared_.assign(supernodes, 0);
  std::size_t shared_matrices = 0, size = 0;
  for (const TreeTasks::Task& task : tasks_.tasks()) {
    const std::vector<std::ptrdiff_t> place =
        PlacePassed(plan_, matrices, task.first, task.last - 1, &size);
    std::copy(place.begin(), place.end(), place_.begin() + task.first);
    subtree_size_ = std::max(subtree_size_, size);
    place_[task.last] = static_cast<std::ptrdiff_t>(shared_matrices);
    is_shared_[task.last] = 1;
    shared_matrices += matrices[task.last];
  }
  shared_size_ = std::max(shared_size_, shared_matrices);
  place_alone_ = PlacePassed(plan_, matrices, 0, supernodes - 1, &alone_size_);
  vector_place_alone_ = PlacePassed(plan_, vectors, 0, supernodes - 1, &size);
  alone_size_ = std::max(alone_size_, size);
}

std::size_t SupernodalFactor::num_numbers() const {
  return static_cast<std::size_t>(pattern_.first_number.back());
}

int SupernodalFactor::FindPlace(int row, int column) const {
  const SupernodalPattern& p = pattern_;
  const int s =
      static_cast<int>(std::upper_bound(p.first_column.begin(), p.first_column.end(), column) -
                       p.first_column.begin()) -
      1;
  const auto begin = p.row.begin() + p.first_row[s], end = p.row.begin() + p.first_row[s + 1];
  const auto found = std::lower_bound(begin, end, row);
  CHECK(found != end && *found == row);
  return p.first_number[s] + (column - p.first_column[s]) * static_cast<int>(end - begin) +
         static_cast<int>(found - begin);
}

UpdateMatrix SupernodalFactor::GetUpdateMatrix(const Front& front, int s) const {
  const int below = pattern_.num_below(s);
  if (front.shared == nullptr) return {front.subtree + place_alone_[s], below};
  return {(is_shared_[s] ? front.shared : front.subtree) + place_[s], below};
}

bool SupernodalFactor::FactorPanel(const FrontPanel& panel, const TreeTasks::Worker& worker) const {
  for (int begin = 0; begin < panel.width; begin += kPanelColumns) {
    const int end = std::min(begin + kPanelColumns, panel.width);
    if (!kernels_->factor_columns(panel, begin, end)) return false;
    const double flops = 2.0 * kPanelColumns * (panel.width - end) * (panel.rows - end);
    ForEachPart(worker, end, panel.width, flops, [&](int first, int last) {
      kernels_->subtract_columns(panel, begin, end, first, last);
    });
  }
  return true;
}

bool SupernodalFactor::FactorFront(const Front& front, int s,
                                   const TreeTasks::Worker& worker) const {
  const int rows = pattern_.num_rows(s), width = pattern_.width(s);
  const FrontPanel panel{front.panel, UpdateMatrix::Padded(rows), rows, width};
  std::memset(panel.number, 0,
              (static_cast<std::size_t>(panel.stride) * width + kMargin) * sizeof(double));
  const FactorPlan::Entry* const entry = plan_.entry.data();
  const int last_entry = plan_.first_entry[s + 1], all_entries = plan_.first_entry.back();
  for (int e = plan_.first_entry[s]; e < last_entry; ++e) {
    __builtin_prefetch(front.a + entry[std::min(e + kAhead, all_entries - 1)].source);
    panel.number[entry[e].place] = front.a[entry[e].source];
  }
  constexpr int kColumns = 8;

  // Adds, some at a time, the columns of the children's matrices that are own columns here, or the
  // other ones.
  const auto add_children = [&](bool own, const auto& column_at) {
    for (int k = plan_.first_child[s]; k < plan_.first_child[s + 1]; ++k) {
      const int c = plan_.child[k];
      const UpdateMatrix update = GetUpdateMatrix(front, c);
      const RowRun* end = plan_.run.data() + plan_.first_run[c + 1];
      for (const RowRun* run = plan_.run.data() + plan_.first_run[c]; run != end; ++run) {
        const int first = own ? 0 : std::max(0, width - run->to);
        const int last = own ? std::min(run->length, width - run->to) : run->length;
        for (int n = first; n < last; n += kColumns) {
          const int count = std::min(last - n, kColumns);
          const double* from[kColumns];
          double* to[kColumns];
          for (int i = 0; i < count; ++i) {
            from[i] = update.column(run->from + n + i);
            to[i] = column_at(run->to + n + i);
          }
          kernels_->add_columns(from, to, run->from + n, count, run, end);
        }
      }
    }
  };
  add_children(true, [&](int j) { return panel.column(j); });
  if (!FactorPanel(panel, worker)) return false;
  // The numbers of L are written after the products, which hide that they come from memory.
  double* to = front.number + pattern_.first_number[s];
  const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(rows) * width;
  for (std::ptrdiff_t i = 0; i < std::min(size, kPrefetched); i += 8) __builtin_prefetch(to + i, 1);
  const UpdateMatrix update = GetUpdateMatrix(front, s);
  ForEachPart(worker, 0, update.size, static_cast<double>(update.size) * update.size * width,
              [&](int first, int last) { kernels_->multiply_below(panel, update, first, last); });
  for (int j = 0; j < width; ++j, to += rows)
    std::copy(panel.column(j) + j, panel.column(j) + rows, to + j);
  add_children(false, [&](int j) { return update.column(j - width) - width; });
  return true;
}

bool SupernodalFactor::Factor(const double* a, double* number, FactorWorkspace* workspace,
                              int threads, const std::atomic<bool>* cancel) const {
  const bool alone = threads <= 1;
  if (!alone) workspace->shared.Resize(shared_size_ + kMargin);
  workspace->panel.resize(threads);
  workspace->subtree.resize(threads);
  return tasks_.VisitUp(threads, [&](const TreeTasks::Worker& worker, const TreeTasks::Task& task) {
    const int thread = worker.thread;
    workspace->panel[thread].Resize(panel_size_);
    workspace->subtree[thread].Resize((alone ? alone_size_ : subtree_size_) + kMargin);
    const Front front{a, number, workspace->panel[thread].data(), workspace->subtree[thread].data(),
                      alone ? nullptr : workspace->shared.data()};
    for (int s = task.first; s <= task.last; ++s) {
      if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return false;
      if (!FactorFront(front, s, worker)) return false;
    }
    return true;
  });
}

}  // namespace drape
