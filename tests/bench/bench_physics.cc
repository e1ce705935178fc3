// SPDX-License-Identifier: Apache-2.0
// Cost of a step and of its derivatives on one core. Machines and their load differ, so the bounds
// of the project are ratios: each is measured within one benchmark, alternating between its parts.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/step_solver.h"
#include "physics/mesh/disc.h"
#include "physics/simulation/rollout.h"
#include "tests/bench/cpu_time.h"

namespace drape {
namespace {

constexpr int kSteps = 10;
const char* const kLaws[] = {"reference", "smooth"};

MaterialField Cotton() {
  MaterialField material;
  material.density = 0.19;
  material.stretch.resize(1);
  material.bend.resize(1);
  for (int r = 0; r < kStretchRows; ++r) {
    const double bias = r == 0 ? 1.0 : 0.6 + 0.4 * std::cos((r - 1) * M_PI / 2);
    const double row[] = {180.0 * bias, 4.0, 180.0 * bias, 25.0};
    std::copy(row, row + kStretchCols, material.stretch[0].c[r]);
  }
  for (auto& row : material.bend[0].b)
    for (int c = 0; c < kBendCols; ++c) row[c] = 3e-5 * (1 + c);
  return material;
}

// A disc that has relaxed for two seconds, with the folds and strains of a drape.
struct Drape {
  Drape(int vertices, const std::string& law)
      : solver(MakeModel(vertices, law)), material(Cotton()) {
    RolloutOptions options;
    options.h = 0.1;
    options.steps = 20;
    state = Rollout(solver, material, model().RestState(), options).end;
  }
  static std::shared_ptr<const ClothModel> MakeModel(int vertices, const std::string& law) {
    DiscOptions options;
    options.target_vertices = vertices;
    return std::make_shared<const ClothModel>(MakeDisc(options), CusickScene(), MakeLaw(law));
  }
  const ClothModel& model() const { return solver.model(); }

  StepSolver solver;
  MaterialField material;
  State state;
};

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void BM_Parts(benchmark::State& bench) {
  Drape drape(static_cast<int>(bench.range(0)), kLaws[bench.range(1)]);
  const ClothModel& model = drape.model();
  const Eigen::VectorXd &x = drape.state.x, &w = drape.state.v;
  Eigen::VectorXd force;
  BlockMatrix A(model.pattern), derivative(model.pattern);
  RowMatrix columns = RowMatrix::Zero(model.num_dofs(), kPaddedEntries), image = columns;
  MaterialGradient gradient = MaterialGradient::Zero(drape.material, 1);
  const RowMatrix lambda = w;
  RowMatrix adj_x = lambda;
  struct Part {
    const char* name;
    std::function<void()> work;
    std::vector<double> seconds;
  };
  std::vector<Part> parts = {
      {"assemble", [&] { AssembleStep(model, drape.material, x, 0.05, force, A); }, {}},
      {"factor", [&] { benchmark::DoNotOptimize(drape.solver.linear().Factor(A)); }, {}},
      {"solve", [&] { drape.solver.linear().Solve(force); }, {}},
      {"solve39", [&] { drape.solver.linear().Solve(columns); }, {}},
      {"derivative",
       [&] { AssembleStepDerivative(model, drape.material, x, w, 0.05, derivative); },
       {}},
      {"multiply39", [&] { AddMultiply(model.pattern, derivative, columns, image); }, {}},
      {"columns39",
       [&] { AddMaterialColumns(model, drape.material, drape.material, x, w, 0.05, columns); },
       {}},
      {"adjoint1",
       [&] { AdjStep(model, drape.material, x, w, 0.05, lambda, adj_x, gradient); },
       {}}};
  for (auto _ : bench)
    for (Part& part : parts) part.seconds.push_back(Seconds(part.work));
  for (Part& part : parts) bench.counters[part.name] = 1e3 * Median(part.seconds);
}

// The ratios of the bounds, which were set for steps by CHOLMOD: step ≤ 1.25 × its factor + solve;
// the 39 tangents add ≤ 1 × the forward time; one gradient adds ≤ .5 × with all factors kept, ≤ 1.3
// × with none.
void BM_Ratios(benchmark::State& bench) {
  Drape drape(static_cast<int>(bench.range(0)), kLaws[bench.range(1)]);
  StepSolver& solver = drape.solver;
  const ClothModel& model = drape.model();
  RolloutOptions options;
  options.steps = kSteps;
  const auto record = [&](std::size_t factor_memory, Recording* recording) {
    options.factor_memory = factor_memory;
    benchmark::DoNotOptimize(Rollout(solver, drape.material, drape.state, options, recording));
  };
  BlockMatrix A(model.pattern);
  Eigen::VectorXd force;
  AssembleStep(model, drape.material, drape.state.x, options.h, force, A);
  const RowMatrix seed = RowMatrix::Ones(model.num_dofs(), 1);
  Recording kept, states;
  std::vector<double> linear, forward, tangent, recorded, back_kept, back_recomputed;
  for (auto _ : bench) {
    linear.push_back(kSteps * Seconds([&] {
                       benchmark::DoNotOptimize(solver.linear().Factor(A));
                       solver.linear().Solve(force);
                     }));
    forward.push_back(Seconds([&] { record(0, nullptr); }));
    tangent.push_back(Seconds([&] {
      benchmark::DoNotOptimize(
          RolloutTangent(solver, drape.material, drape.material, drape.state, options));
    }));
    recorded.push_back(Seconds([&] { record(std::size_t{1} << 40, &kept); }));
    const auto back = [&](const Recording& recording) {
      return Seconds([&] {
        benchmark::DoNotOptimize(RolloutAdjoint(solver, drape.material, options, recording, seed));
      });
    };
    back_kept.push_back(back(kept));
    record(0, &states);
    back_recomputed.push_back(back(states));
  }
  const double one = Median(forward);
  bench.counters["step_ms"] = 1e3 * one / kSteps;
  bench.counters["step/linear"] = one / Median(linear);
  bench.counters["tangents_add"] = Median(tangent) / one - 1.0;
  bench.counters["adjoint_kept_adds"] = (Median(recorded) + Median(back_kept)) / one - 1.0;
  bench.counters["adjoint_recomputed_adds"] = Median(back_recomputed) / one;
}

// Thirty frames of sixty steps beside the last one alone, at most 1.2 times as long: the states,
// the tangents by which 75 numbers are read from each frame, and the adjoint with seeds at each.
void BM_Frames(benchmark::State& bench) {
  constexpr int kFrames = 30, kNumbers = 75;
  Drape drape(static_cast<int>(bench.range(0)), kLaws[bench.range(1)]);
  StepSolver& solver = drape.solver;
  const int dofs = drape.model().num_dofs();
  RolloutOptions last{.steps = 2 * kFrames}, all = last;
  for (int k = 1; k <= kFrames; ++k) all.frames.push_back(2 * k);
  last.frames = {last.steps};
  RowMatrix jacobian(kFrames * kNumbers, kMaterialEntries);
  const TangentOptions read = {
      .on_frame = [&](int k, const State&, const TangentView& dx, const TangentView&) {
        jacobian.middleRows<kNumbers>(kNumbers * k) = dx.middleRows<kNumbers>(0);
      }};
  const RowMatrix seed = RowMatrix::Ones(dofs, 1);
  Recording recording;
  struct Seconds3 {
    std::vector<double> states, tangents, adjoint;
  } of_last, of_all;
  const auto measure = [&](const RolloutOptions& options, Seconds3& to) {
    to.states.push_back(Seconds([&] {
      benchmark::DoNotOptimize(Rollout(solver, drape.material, drape.state, options, &recording));
    }));
    to.tangents.push_back(Seconds([&] {
      benchmark::DoNotOptimize(
          RolloutTangent(solver, drape.material, drape.material, drape.state, options, read));
    }));
    const AdjointOptions seeds{.frames = {options.frames.size(), FrameSeeds{seed, seed}}};
    to.adjoint.push_back(Seconds([&] {
      benchmark::DoNotOptimize(
          RolloutAdjoint(solver, drape.material, options, recording, seed, seeds));
    }));
  };
  for (auto _ : bench) {
    measure(last, of_last);
    measure(all, of_all);
  }
  bench.counters["states"] = Median(of_all.states) / Median(of_last.states);
  bench.counters["tangents"] = Median(of_all.tangents) / Median(of_last.tangents);
  bench.counters["adjoint"] = Median(of_all.adjoint) / Median(of_last.adjoint);
}

// The largest memory of the process so far [MB]; run it alone
// (--benchmark_filter=BM_GradientMemory).
void BM_GradientMemory(benchmark::State& bench) {
  StepSolver solver(Drape::MakeModel(2700, "smooth"));
  const MaterialField material = Cotton();
  const RolloutOptions options;
  const RowMatrix seed = RowMatrix::Ones(solver.model().num_dofs(), 1);
  for (auto _ : bench) {
    Recording recording;
    benchmark::DoNotOptimize(
        Rollout(solver, material, solver.model().RestState(), options, &recording));
    benchmark::DoNotOptimize(RolloutAdjoint(solver, material, options, recording, seed));
  }
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  bench.counters["peak_MB"] = usage.ru_maxrss * 1024e-6;
}

void Sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"vertices", "law"})->Unit(benchmark::kMillisecond);
  for (const int vertices : {300, 1200, 2700})
    for (const int law : {0, 1}) bench->Args({vertices, law});
}
BENCHMARK(BM_Parts)->Apply(Sizes);
BENCHMARK(BM_GradientMemory)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Ratios)->Apply(Sizes)->Iterations(7);
BENCHMARK(BM_Frames)->Apply(Sizes)->Iterations(5);

}  // namespace
}  // namespace drape
