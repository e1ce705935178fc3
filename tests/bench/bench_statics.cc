// SPDX-License-Identifier: Apache-2.0
// Cost of equilibria and of their derivatives as ratios to the dynamic step, and how many of 60
// drapes converge. usage: bench_statics [--benchmark_filter=Ratios|EquilibriumJvp|Settle]
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>

#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/rollout.h"
#include "physics/simulation/statics/statics.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/fabrics.h"
#include "tests/physics/summed_tangents.h"

namespace drape {
namespace {

const char* const kFabrics[] = {"cotton_white", "cotton_blue", "viscose_white", "cotton_pink",
                                "wool_red"};
constexpr int kCottonBlue = 1, kWoolRed = 4;
constexpr int kSeeds = 4;
constexpr double kSupport = 0.09;  // [m]

MaterialField PublishedFabric(const std::string& name) {
  return ReadFabric(DRAPE_SOURCE_DIR "/configs/fabrics/" + name + ".json");
}

std::shared_ptr<const ClothModel> MakeModel(int vertices) {
  return std::make_shared<const ClothModel>(MakeDisc({.target_vertices = vertices}), CusickScene(),
                                            MakeLaw("smooth"));
}
State Start(const ClothModel& model, int seed) {
  State start = model.RestState();
  start.x = ApplyStartShape(model.mesh, kSupport, RandomStartShape(seed, 3e-3));
  return start;
}

// Steps that bring a cloth near its drape before Newton's method starts.
const RolloutOptions kRelaxation{.h = 0.1, .steps = 60};

// 100 steps, with and without their 39 tangents, compared with Newton's method from the relaxed
// cloth (with and without the relaxation) and the 39 implicit tangents there. Bound:
// 100_tangents/implicit ≥ 15.
void BM_Ratios(benchmark::State& bench) {
  StepSolver solver(MakeModel(static_cast<int>(bench.range(0))));
  const MaterialField material = PublishedFabric(kFabrics[bench.range(1)]);
  const State start = Start(solver.model(), 1);
  const RolloutOptions hundred{.h = 0.05, .steps = 100};
  EquilibriumResult rest;
  RowMatrix dx;
  bool derived = false;
  for (auto _ : bench) {
    const double steps =
        Seconds([&] { benchmark::DoNotOptimize(Rollout(solver, material, start, hundred)); });
    const double tangents = Seconds([&] {
      benchmark::DoNotOptimize(RolloutTangent(solver, material, material, start, hundred));
    });
    State relaxed;
    const double relaxation =
        Seconds([&] { relaxed = Rollout(solver, material, start, kRelaxation).end; });
    const double newton =
        Seconds([&] { rest = SolveEquilibrium(solver, material, relaxed.x, {}); });
    double implicit = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i)  // the first touches fresh memory
      implicit = std::min(implicit, Seconds([&] {
                            derived = EquilibriumTangent(solver, material, material, rest.x, &dx);
                          }));
    bench.counters["100_steps_s"] = steps;
    bench.counters["newton/100_steps"] = newton / steps;
    bench.counters["relaxation_and_newton/100_steps"] = (relaxation + newton) / steps;
    bench.counters["100_tangents/implicit"] = (tangents - steps) / implicit;
    bench.counters["100_with_tangents/implicit"] = tangents / implicit;
  }
  bench.counters["newton"] = rest.iterations;
  bench.SetLabel(std::string(ToString(rest.status)) + (derived ? "" : ", no derivatives"));
}
BENCHMARK(BM_Ratios)
    ->ArgNames({"vertices", "fabric"})
    ->ArgsProduct({{300, 1200, 2700}, {kCottonBlue, kWoolRed}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

// How drapes move in one direction of the tables, a solve each (EquilibriumJvp), against the sum of
// their 39 weighted tangents (SumEquilibriumTangents).
void BM_EquilibriumJvp(benchmark::State& bench) {
  constexpr int kBatch = 4;
  const auto model = MakeModel(static_cast<int>(bench.range(0)));
  const auto backend = MakeCpuBackend(model, 1);
  const MaterialField material = PublishedFabric(kFabrics[kWoolRed]);
  std::vector<State> states;
  for (int seed = 1; seed <= kBatch; ++seed) states.push_back(Start(*model, seed));
  std::vector<RolloutInput> inputs;
  for (const State& state : states) inputs.push_back({&material, &state});
  const auto relaxed = backend->Rollouts(inputs, kRelaxation, nullptr);
  for (int i = 0; i < kBatch; ++i) states[i] = relaxed[i].end;
  const auto rest = backend->Equilibria(inputs, {});
  for (int i = 0; i < kBatch; ++i) states[i].x = rest[i].x;
  const std::vector<const MaterialField*> changes(kBatch, &material);
  std::vector<Eigen::VectorXd> one, summed;
  double one_s = std::numeric_limits<double>::infinity(), summed_s = one_s;
  for (auto _ : bench) {
    one_s = std::min(one_s, Seconds([&] { one = backend->EquilibriumJvp(inputs, changes); }));
    summed_s = std::min(summed_s, Seconds([&] {
                          summed = test::SumEquilibriumTangents(*backend, inputs, changes);
                        }));
  }
  double difference = 0.0;
  int solved = 0;
  for (int i = 0; i < kBatch; ++i) {
    if (one[i].size() == 0 || summed[i].size() == 0) continue;
    ++solved;
    difference = std::max(difference, (one[i] - summed[i]).norm() / summed[i].norm());
  }
  bench.counters["jvp_ms"] = 1e3 * one_s / kBatch;
  bench.counters["39_columns_ms"] = 1e3 * summed_s / kBatch;
  bench.counters["speedup"] = summed_s / one_s;
  bench.counters["difference"] = difference;
  bench.counters["solved"] = solved;
}
BENCHMARK(BM_EquilibriumJvp)
    ->ArgNames({"vertices"})
    ->Arg(300)
    ->Arg(600)
    ->Arg(1200)
    ->Iterations(5)
    ->Unit(benchmark::kMillisecond);

// Five fabrics × four seeds for each mesh: does the drape converge to 1e-8 × weight within 60
// Newton steps?
void BM_Settle(benchmark::State& bench) {
  StepSolver solver(MakeModel(static_cast<int>(bench.range(0))));
  int settled = 0, stable = 0, newton = 0;
  for (auto _ : bench)
    for (const char* fabric : kFabrics)
      for (int seed = 1; seed <= kSeeds; ++seed) {
        const MaterialField material = PublishedFabric(fabric);
        const State relaxed =
            Rollout(solver, material, Start(solver.model(), seed), kRelaxation).end;
        const EquilibriumResult rest = SolveEquilibrium(solver, material, relaxed.x,
                                                        {.tolerance = 1e-8, .max_iterations = 60});
        const bool converged = rest.residual <= 1e-8;
        settled += converged;
        stable += rest.status == EquilibriumStatus::kStable;
        newton += converged ? rest.iterations : 0;
        if (converged) continue;
        std::printf("%d %s seed %d: %s, residual %.1e after %d, last shift %g\n",
                    static_cast<int>(bench.range(0)), fabric, seed, ToString(rest.status),
                    rest.residual, rest.iterations,
                    rest.steps.empty() ? 0.0 : rest.steps.back().shift);
      }
  bench.counters["settled"] = settled;
  bench.counters["stable"] = stable;
  bench.counters["newton_mean"] = static_cast<double>(newton) / std::max(settled, 1);
}
BENCHMARK(BM_Settle)->Arg(300)->Arg(1200)->Arg(2700)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace drape
