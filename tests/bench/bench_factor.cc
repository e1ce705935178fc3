// SPDX-License-Identifier: Apache-2.0
// Cost of a factorisation beside the peak of the processor, which is measured in between by
// multiply-adds of the same vector width. Machines are shared: the peak is not the one of a data
// sheet, and the best of many rounds is nearest to an idle machine.
//   bench_factor [<vertices>[,<vertices>...] [<threads>]]
// DRAPE_VECTORS=baseline measures the narrow kernels.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/cloth_model.h"
#include "physics/linalg/kernels/front_kernels.h"
#include "physics/linalg/linear_solver.h"
#include "physics/mesh/disc.h"
#include "physics/util/math/random.h"
#include "tests/bench/cpu_time.h"

namespace drape {
namespace {

constexpr double kRoundSeconds = 3.0;  // for each mesh

double WallSeconds(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

MaterialField Cotton() {
  MaterialField material;
  material.density = 0.19;
  material.stretch.resize(1);
  material.bend.resize(1);
  for (auto& row : material.stretch[0].c) {
    const double entries[] = {180.0, 4.0, 180.0, 25.0};
    std::copy(entries, entries + kStretchCols, row);
  }
  for (auto& row : material.bend[0].b)
    for (int c = 0; c < kBendCols; ++c) row[c] = 3e-5 * (1 + c);
  return material;
}

// Peak of `threads` threads [flop/s].
double Peak(int threads) {
  const FrontKernels& kernels = ChosenFrontKernels();
  constexpr long kRounds = 200000;
  double sum = 0.0;
  const auto work = [&] {
#pragma omp parallel for num_threads(threads) reduction(+ : sum) schedule(static, 1)
    for (int t = 0; t < threads; ++t) sum += kernels.multiply_add(kRounds, 0.5);
  };
  const double seconds = threads == 1 ? Seconds(work) : WallSeconds(work);
  if (!(sum > 0.0)) std::abort();
  return threads * static_cast<double>(kRounds) * kernels.flops_per_round / seconds;
}

struct Times {
  std::vector<double> values;

  double best() const { return *std::min_element(values.begin(), values.end()); }
  double median() {
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
  }
};

// Prints a line; returns the time of a step, which is an assembly, a factorisation and a solve [s].
double Measure(int vertices, int threads) {
  DiscOptions options;
  options.target_vertices = vertices;
  const ClothModel model(MakeDisc(options), CusickScene(), MakeLaw("smooth"));
  std::mt19937_64 random(1);
  Eigen::VectorXd x = model.RestState().x, force;
  for (double& coordinate : x) coordinate += 1e-4 * SampleNormal(random);
  BlockMatrix A(model.pattern);
  AssembleStep(model, Cotton(), x, 0.05, force, A);
  const std::unique_ptr<LinearSolver> solver = MakeLinearSolver(model.pattern);
  RowMatrix columns = RowMatrix::Ones(model.num_dofs(), 39);
  Times assemble, one, many, solve, solve39, peak, share, gain;
  const auto factor = [&] {
    if (!solver->Factor(A)) std::abort();
  };
  double spent = 0.0;
  for (int round = 0; round < 7 || spent < kRoundSeconds; ++round) {
    const double peak_now = Peak(1);
    assemble.values.push_back(Seconds([&] { AssembleStep(model, Cotton(), x, 0.05, force, A); }));
    solver->SetThreads(1);
    one.values.push_back(Seconds(factor));
    if (threads > 1) {
      solver->SetThreads(threads);
      many.values.push_back(WallSeconds(factor));
      solver->SetThreads(1);
      gain.values.push_back(WallSeconds(factor) / many.values.back());
    }
    solve.values.push_back(Seconds([&] { solver->Solve(force); }));
    solve39.values.push_back(Seconds([&] { solver->Solve(columns); }));
    peak.values.push_back(1.0 / peak_now);
    share.values.push_back(one.values.back() * peak_now);
    spent += one.values.back() + solve.values.back() + solve39.values.back();
  }
  const double flops = solver->factor_flops();
  std::printf("%8d %10.1f %9.1f %9.3f %9.3f %8.1f %8.1f %7.0f %7.0f", model.mesh.num_vertices(),
              1e-6 * flops, 1e-6 * static_cast<double>(solver->factor_bytes()), 1e3 * one.best(),
              1e3 * one.median(), 1e-9 * flops / one.best(), 1e-9 / peak.best(),
              100.0 * flops / one.best() * peak.best(), 100.0 * flops / share.median());
  if (threads > 1)
    std::printf(" %9.3f %6.2f %6.2f", 1e3 * many.best(), one.best() / many.best(), gain.median());
  const double step = assemble.best() + one.best() + solve.best();
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  std::printf(" %9.3f %9.3f %9.3f %9.3f %8.0f\n", 1e3 * solve.best(), 1e3 * solve39.best(),
              1e3 * assemble.best(), 1e3 * step, usage.ru_maxrss * 1024e-6);
  return step;
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  std::stringstream list(argc > 1 ? argv[1] : "600,2400,4800,10000,30000");
  const int threads = argc > 2 ? std::max(1, std::atoi(argv[2])) : 1;
  double peak_of_one = 0.0, peak_of_all = 0.0;
  for (int round = 0; round < 20; ++round) {
    peak_of_one = std::max(peak_of_one, drape::Peak(1));
    peak_of_all = std::max(peak_of_all, drape::Peak(threads));
  }
  std::printf("kernels: %s; peak of 1 and %d threads: %.1f, %.1f Gflop/s\n",
              drape::ChosenFrontKernels().name, threads, 1e-9 * peak_of_one, 1e-9 * peak_of_all);
  std::printf("%8s %10s %9s %9s %9s %8s %8s %7s %7s", "vertices", "Mflop", "MB", "best ms",
              "median", "Gflop/s", "peak", "best %", "med. %");
  if (threads > 1) std::printf(" %6d ms %6s %6s", threads, "best x", "med. x");
  std::printf(" %9s %9s %9s %9s %8s\n", "solve ms", "solve39", "assemble", "step ms", "peak MB");
  double last_step = 0.0;
  int last = 0;
  for (std::string item; std::getline(list, item, ',');) {
    const int vertices = std::atoi(item.c_str());
    const double step = drape::Measure(vertices, threads);
    if (last > 0)
      std::printf("%8s step ~ vertices^%.2f\n", "",
                  std::log(step / last_step) / std::log(static_cast<double>(vertices) / last));
    last = vertices;
    last_step = step;
  }
}
