// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>
#include <metis.h>

#include <mutex>
#include <utility>

#include "cuda/factor/plan/nested_dissection.h"
#include "physics/linalg/analysis/metis_lock.h"

namespace drape {
namespace {

constexpr int kRuns = 6;
constexpr idx_t kImbalance[] = {30, 150};  // allowed of the sides, in turns [1/1000]

std::vector<char> Separate(std::vector<idx_t>& start, std::vector<idx_t>& neighbour, int run) {
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = run + 1;
  options[METIS_OPTION_UFACTOR] = kImbalance[run % 2];
  idx_t n = static_cast<idx_t>(start.size()) - 1, separator_size;
  std::vector<idx_t> part(n);
  const std::lock_guard guard(MetisLock());
  CHECK_EQ(METIS_ComputeVertexSeparator(&n, start.data(), neighbour.data(), nullptr, options,
                                        &separator_size, part.data()),
           METIS_OK);
  return {part.begin(), part.end()};
}

}  // namespace

Cut MetisCut(const VertexGraph& graph) {
  std::vector<idx_t> start(graph.start.begin(), graph.start.end());
  std::vector<idx_t> neighbour(graph.neighbour.begin(), graph.neighbour.end());
  Cut best;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<char> side = Separate(start, neighbour, run);
    if (const double score = CutScore(side); score < best.score) best = {std::move(side), score};
  }
  return best;
}

}  // namespace drape
