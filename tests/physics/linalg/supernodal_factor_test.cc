// SPDX-License-Identifier: Apache-2.0
// Compares factors and solves on hand-made patterns with Eigen's dense Cholesky factor, and the
// versions of the kernels with one another.
#include "physics/linalg/supernodal_factor.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <thread>
#include <vector>

#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

// Makes supernodes of these widths. Each has the rows of the later supernodes that it sees, which
// those must see too.
SupernodalPattern MakePattern(const std::vector<int>& widths, auto sees) {
  SupernodalPattern pattern{{0}, {0}, {0}, {}};
  for (const int width : widths)
    pattern.first_column.push_back(pattern.first_column.back() + width);
  for (std::size_t s = 0; s < widths.size(); ++s) {
    const int first = pattern.first_row.back();
    for (int row = pattern.first_column[s]; row < pattern.first_column.back(); ++row)
      if (row < pattern.first_column[s + 1] || sees(static_cast<int>(s), row))
        pattern.row.push_back(row);
    pattern.first_row.push_back(static_cast<int>(pattern.row.size()));
    pattern.first_number.push_back(pattern.first_number.back() +
                                   (pattern.first_row.back() - first) * widths[s]);
  }
  return pattern;
}

// Visits each row and column of the lower triangle that the pattern contains.
void ForEachNumber(const SupernodalPattern& pattern, auto visit) {
  for (int s = 0; s < pattern.num_supernodes(); ++s)
    for (int j = pattern.first_column[s]; j < pattern.first_column[s + 1]; ++j)
      for (int r = pattern.first_row[s]; r < pattern.first_row[s + 1]; ++r)
        if (pattern.row[r] >= j) visit(pattern.row[r], j);
}

// Makes a positive definite matrix whose factor has this pattern.
Eigen::MatrixXd MakeMatrix(const SupernodalPattern& pattern, std::mt19937_64& random) {
  const int n = pattern.first_column.back();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
  ForEachNumber(pattern, [&](int i, int j) {
    lower(i, j) = i == j ? 2.0 + SampleUniform(random) : SampleNormal(random) / n;
  });
  return lower * lower.transpose();
}

// All numbers of the pattern; their sources are those of a row-major matrix of this size.
LowerTriangle MakeLower(const SupernodalPattern& pattern) {
  LowerTriangle lower;
  const int n = pattern.first_column.back();
  ForEachNumber(pattern, [&](int i, int j) {
    if (i == j) lower.column_start.push_back(static_cast<int>(lower.row.size()));
    lower.row.push_back(i);
    lower.source.push_back(i * n + j);
  });
  lower.column_start.push_back(static_cast<int>(lower.row.size()));
  return lower;
}

struct Factored {
  bool ok;
  std::vector<double> number;
  FactorWorkspace workspace;
};

Factored ComputeFactor(const SupernodalFactor& factor, const RowMatrix& a, int threads = 1) {
  Factored result{false, std::vector<double>(factor.num_numbers()), {}};
  result.ok = factor.Factor(a.data(), result.number.data(), &result.workspace, threads);
  return result;
}

// The factor and the solutions of all versions of the kernels on several threads are equal, bit for
// bit.
void ExpectAlike(const SupernodalPattern& pattern, const RowMatrix& a, std::mt19937_64& random) {
  const LowerTriangle lower = MakeLower(pattern);
  const RowMatrix b = test::RandomMatrix(static_cast<int>(a.rows()), 12, random);
  std::vector<double> number;
  RowMatrix many;
  Eigen::VectorXd one;
  for (const FrontKernels* kernels : AvailableFrontKernels())
    for (const int threads : {1, 2, 3, 7}) {
      SCOPED_TRACE(testing::Message() << kernels->name << ", " << threads << " threads");
      const SupernodalFactor factor(pattern, lower, *kernels);
      Factored found = ComputeFactor(factor, a, threads);
      ASSERT_TRUE(found.ok);
      RowMatrix x = b;
      factor.SolveRows(found.number.data(), x, threads);
      Eigen::VectorXd y = b.col(1);
      factor.Solve(found.number.data(), y.data(), &found.workspace, threads);
      if (number.empty()) {
        number = found.number;
        many = x;
        one = y;
      }
      EXPECT_TRUE(found.number == number);
      EXPECT_TRUE(x == many);
      EXPECT_TRUE(y == one);
    }
}

// The index of the number of L in a row and a column of the pattern.
int FindPlace(const SupernodalPattern& p, int row, int column) {
  int s = 0;
  while (p.first_column[s + 1] <= column) ++s;
  const auto begin = p.row.begin() + p.first_row[s], end = p.row.begin() + p.first_row[s + 1];
  return p.first_number[s] + (column - p.first_column[s]) * static_cast<int>(end - begin) +
         static_cast<int>(std::find(begin, end, row) - begin);
}

void ExpectFactorAndSolves(const SupernodalPattern& pattern, std::mt19937_64& random) {
  const RowMatrix a = MakeMatrix(pattern, random);
  const Eigen::LLT<Eigen::MatrixXd> dense(a);
  const Eigen::MatrixXd lower = dense.matrixL();
  const SupernodalFactor factor(pattern, MakeLower(pattern));
  Factored found = ComputeFactor(factor, a);
  ASSERT_TRUE(found.ok);
  ForEachNumber(pattern, [&](int i, int j) {
    EXPECT_NEAR(found.number[FindPlace(pattern, i, j)], lower(i, j), 1e-13) << i << ", " << j;
  });
  const RowMatrix b = test::RandomMatrix(static_cast<int>(a.rows()), 4, random);
  const Eigen::MatrixXd expected = dense.solve(Eigen::MatrixXd(b));
  RowMatrix many = b;
  factor.SolveRows(found.number.data(), many);
  EXPECT_LT((many - expected).norm(), 1e-13 * expected.norm());
  Eigen::VectorXd one = b.col(2);
  factor.Solve(found.number.data(), one.data(), &found.workspace);
  EXPECT_LT((one - expected.col(2)).norm(), 1e-13 * expected.norm());
  ExpectAlike(pattern, a, random);
}

class SupernodalFactorTest : public testing::Test {
 protected:
  std::mt19937_64 random_{7};
};

TEST_F(SupernodalFactorTest, FactorsOneDenseSupernodeOfEachWidth) {
  for (int n = 1; n <= 40; ++n) {
    SCOPED_TRACE(n);
    ExpectFactorAndSolves(MakePattern({n}, [](int, int) { return true; }), random_);
  }
}

// Widths and numbers of rows that are not multiples of those of a tile; the first supernode sees
// only some rows of the others.
TEST_F(SupernodalFactorTest, SupernodesReceiveFromAllEarlierOnes) {
  for (int first = 1; first <= 9; ++first)
    for (int gap = 1; gap <= 3; ++gap) {
      SCOPED_TRACE(testing::Message() << first << ", " << gap);
      ExpectFactorAndSolves(
          MakePattern({first, 3, 7, 1, 14},
                      [&](int s, int row) { return s >= 1 || row % (gap + 1) == 0 || row > 20; }),
          random_);
    }
}

// Two levels of separators over leaves: update matrices pass through several parents, in places
// that others had before.
TEST_F(SupernodalFactorTest, UpdateMatricesPassUpATree) {
  for (int width = 2; width <= 22; width += 5) {
    SCOPED_TRACE(width);
    const SupernodalPattern separators =
        MakePattern({3, 4, width, 5, 9, width + 1, 17}, [&](int s, int row) {
          const int first_right = 7 + width, root = first_right + 15 + width;
          if (row >= root) return (row + s) % 4 != 0 || s == 2 || s == 5;
          return s < 2 ? row >= 7 && row < first_right : s > 2 && s < 5 && row >= first_right + 14;
        });
    ExpectFactorAndSolves(separators, random_);
  }
}

TEST_F(SupernodalFactorTest, AWideRootIsFactoredInSeveralBlocks) {
  ExpectFactorAndSolves(MakePattern({70, 300}, [](int, int row) { return row % 3 != 0; }), random_);
}

TEST_F(SupernodalFactorTest, AnIndefiniteMatrixIsFalse) {
  const SupernodalPattern pattern = MakePattern({5, 6}, [](int, int) { return true; });
  const SupernodalFactor factor(pattern, MakeLower(pattern));
  const RowMatrix a = MakeMatrix(pattern, random_);
  EXPECT_TRUE(ComputeFactor(factor, a).ok);
  for (const int i : {0, 4, 5, 10})
    for (const double bad : {-1e-3, std::numeric_limits<double>::quiet_NaN()})
      for (const int threads : {1, 2}) {
        RowMatrix changed = a;
        changed(i, i) = bad;
        EXPECT_FALSE(ComputeFactor(factor, changed, threads).ok) << i << ", " << bad;
      }
}

// A binary tree of this depth in postorder.
int AppendTree(int depth, std::vector<int>& parent) {
  std::vector<int> children;
  if (depth > 1)
    for (int side = 0; side < 2; ++side) children.push_back(AppendTree(depth - 1, parent));
  const int root = static_cast<int>(parent.size());
  parent.push_back(-1);
  for (const int child : children) parent[child] = root;
  return root;
}

class TreeTasksTest : public testing::Test {
 protected:
  static std::vector<int> MakeForest() {
    std::vector<int> parent;
    AppendTree(8, parent);
    AppendTree(3, parent);
    parent.push_back(-1);
    return parent;
  }
  const std::vector<int> parent_ = MakeForest();
  const TreeTasks tasks_{parent_, std::vector<double>(parent_.size(), 1.0)};
};

TEST_F(TreeTasksTest, TasksAreSubtreesBelowSingleNodes) {
  std::vector<int> covered(parent_.size());
  int subtrees = 0;
  for (const TreeTasks::Task& task : tasks_.tasks()) {
    for (int s = task.first; s <= task.last; ++s) {
      ++covered[s];
      EXPECT_TRUE(s == task.last || parent_[s] <= task.last);
    }
    subtrees += task.first < task.last;
  }
  EXPECT_THAT(covered, testing::Each(1));
  EXPECT_GT(subtrees, 8);
}

TEST_F(TreeTasksTest, ChildrenComeFirstUpAndLastDown) {
  for (const int threads : {1, 2, 5})
    for (const bool up : {true, false}) {
      SCOPED_TRACE(testing::Message() << threads << (up ? ", up" : ", down"));
      std::vector<std::atomic<int>> done(parent_.size());
      std::atomic<int> wrong = 0;
      const auto visit = [&](const TreeTasks::Worker& worker, const TreeTasks::Task& task) {
        wrong += worker.thread < 0 || worker.thread >= threads;
        for (int s = 0; s < task.first; ++s)  // the nodes outside the task that it depends on
          if (up && parent_[s] >= task.first && parent_[s] <= task.last) wrong += done[s] != 1;
        if (const int p = parent_[task.last]; !up && p >= 0) wrong += done[p] != 1;
        // So that the others take tasks meanwhile.
        std::this_thread::sleep_for(std::chrono::microseconds(200));
        for (int s = task.first; s <= task.last; ++s) ++done[s];
        return true;
      };
      EXPECT_TRUE(up ? tasks_.VisitUp(threads, visit) : tasks_.VisitDown(threads, visit));
      EXPECT_EQ(wrong, 0);
      for (const auto& count : done) EXPECT_EQ(count, 1);
    }
}

TEST_F(TreeTasksTest, LoopsOfATaskAreSharedAndEndWithin) {
  for (const int threads : {1, 2, 5}) {
    std::atomic<int> wrong = 0;
    tasks_.VisitUp(threads, [&](const TreeTasks::Worker& worker, const TreeTasks::Task&) {
      std::vector<int> calls(50);
      worker.ForEach(50, [&](int i) { ++calls[i]; });
      for (const int count : calls) wrong += count != 1;
      return true;
    });
    EXPECT_EQ(wrong, 0) << threads;
  }
}

TEST_F(TreeTasksTest, EndsAfterARefusalAndPassesErrorsOn) {
  for (const int threads : {1, 3}) {
    std::atomic<int> calls = 0;
    EXPECT_FALSE(tasks_.VisitUp(threads, [&](const TreeTasks::Worker&, const TreeTasks::Task&) {
      ++calls;
      return false;
    }));
    EXPECT_LE(calls, threads);
    EXPECT_THROW(tasks_.VisitUp(threads,
                                [](const TreeTasks::Worker&, const TreeTasks::Task& task) {
                                  if (task.last > 100) throw std::runtime_error("full");
                                  return true;
                                }),
                 std::runtime_error);
  }
}

}  // namespace
}  // namespace drape
