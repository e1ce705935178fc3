// SPDX-License-Identifier: Apache-2.0
// Batches on the CUDA device beside the CPU path of the same machine: seconds of whole calls of the
// backend, transfers included, and how far the answers differ.
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "cuda/engine/cuda_backend.h"
#include "physics/cloth/state.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/backend.h"
#include "tests/bench/fabrics.h"
#include "tests/cuda/data_folders.h"
#include "tests/physics/summed_tangents.h"

DEFINE_string(meshes, "disc:297,disc:1205,disc:2699,disc:7496", "mesh specs, by comma");
DEFINE_string(batches, "1,16,64,256,1024", "numbers of rollouts in a batch");
DEFINE_string(
    works, "forward,gradient,jacobian,settle,jvp",
    "what to time; jacobian: of the shapes by the 39 table entries; settle: 60 steps of "
    "0.1 s, then Newton to rest and 39 derivatives; jvp: how drapes at rest move with one "
    "change of their tables, by one right-hand side each, and by the sum of 39 columns");
DEFINE_string(law, "smooth", "smooth or reference");
DEFINE_bool(contact, false, "keeps the hanging cloth out of the support");
DEFINE_double(bend, 1.0, "factor on the fabrics' bend tables: soft ones touch the support");
DEFINE_bool(
    air, false,
    "wind, and derivatives by all numbers of the motion and by its velocity at the start too");
DEFINE_int32(steps, 100, "of a rollout");
DEFINE_double(h, 0.05, "time step [s]");
DEFINE_int32(frames, 0,
             "states that are seen, evenly over the steps: with seeds at each in a gradient, 75 "
             "numbers read from each in a jacobian; compare with 1");
DEFINE_int32(repeats, 3, "the fastest counts");
DEFINE_bool(host, true, "times the CPU path too");
DEFINE_int32(most, 400000, "skips batches of more vertices");
DEFINE_string(
    fabrics, "",
    "folder of the fabrics; by default that of $DRAPE_CONFIGS, of the bundle or of the build");

namespace drape {
namespace {

const char* const kFabrics[] = {"cotton_white", "cotton_pink", "viscose_white", "cotton_blue",
                                "wool_red"};

std::string FabricsFolder() {
  return FLAGS_fabrics.empty() ? test::ConfigsFolder() + "/fabrics" : FLAGS_fabrics;
}

Scene BenchScene() {
  return CusickScene({FLAGS_contact ? ContactModel::kSupport : ContactModel::kNone});
}

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

double Fastest(const std::function<void()>& work, int repeats) {
  double best = 1e300;
  for (int i = 0; i < repeats; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return best;
}

// A batch over the five published fabrics, each rollout with a start of its own.
struct Batch {
  std::vector<MaterialField> fields;
  std::vector<State> starts;
  std::vector<RolloutInput> inputs;
  std::vector<const MaterialField*> weights;
  std::vector<RowMatrix> dL_dx;
  AdjointOptions seeds;
  TangentOptions reader = {
      .on_frame = [](int, const State&, const TangentView& dx, const TangentView&) {
        const RowMatrix read = dx.topRows(75);
        (void)read;
      }};
  Batch(const ClothModel& model, int count) {
    const RowMatrix ones = RowMatrix::Ones(model.num_dofs(), 1);
    seeds.frames.assign(FLAGS_frames, {ones, {}});
    for (const char* name : kFabrics)
      fields.push_back(Scaled(ReadFabric(FabricsFolder() + "/" + name + ".json"), 1.0, FLAGS_bend));
    if (FLAGS_air) {
      for (MaterialField& field : fields) field.dynamics = {.air_drag = 0.6, .wind = {1, 0, 0.5}};
      reader.dynamics = seeds.dynamics = true;
      reader.start_dv = Eigen::Matrix3d::Identity().replicate(model.mesh.num_vertices(), 1);
    }
    for (int i = 0; i < count; ++i) {
      State start = model.RestState();
      start.x = ApplyStartShape(model.mesh, 0.09, RandomStartShape(i, 3e-3));
      starts.push_back(std::move(start));
    }
    for (int i = 0; i < count; ++i) {
      inputs.push_back({&fields[i % std::size(kFabrics)], &starts[i], &reader, &seeds});
      weights.push_back(inputs.back().material);
      dL_dx.push_back(ones);
    }
  }
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;
};

// Where a batch comes to rest: 60 steps of 0.1 s, then Newton.
struct Drapes {
  std::vector<State> states;
  std::vector<RolloutInput> inputs;

  Drapes(Backend& backend, std::span<const RolloutInput> starts) {
    for (const RolloutResult& r : backend.Rollouts(starts, {.h = 0.1, .steps = 60}, nullptr))
      states.push_back(r.end);
    for (std::size_t i = 0; i < starts.size(); ++i)
      inputs.push_back({starts[i].material, &states[i]});
    const auto rests = backend.Equilibria(inputs, {});
    for (std::size_t i = 0; i < starts.size(); ++i) states[i].x = rests[i].x;
  }
  Drapes(const Drapes&) = delete;
  Drapes& operator=(const Drapes&) = delete;
};

void Run(Backend& backend, const std::string& work, const Batch& batch, int count,
         const RolloutOptions& options) {
  const std::span inputs(batch.inputs.data(), count);
  if (work == "forward") {
    (void)backend.Rollouts(inputs, options, nullptr);
  } else if (work == "gradient") {
    std::vector<Recording> recordings;
    (void)backend.Rollouts(inputs, options, &recordings);
    (void)backend.Adjoints(inputs, recordings, std::span(batch.dL_dx.data(), count), options);
  } else if (work == "settle") {
    const Drapes drapes(backend, inputs);
    (void)backend.EquilibriumTangents(drapes.inputs, std::span(batch.weights.data(), count));
  } else {
    (void)backend.Tangents(inputs, std::span(batch.weights.data(), count), options);
  }
}

void CompareEnds(Backend& device, Backend& host, const Batch& batch, int count,
                 const RolloutOptions& options) {
  const std::span inputs(batch.inputs.data(), count);
  const auto a = device.Rollouts(inputs, options, nullptr);
  const auto b = host.Rollouts(inputs, options, nullptr);
  std::printf("  largest difference of positions after %d steps [m], by fabric:", options.steps);
  for (int i = 0; i < count; ++i)
    std::printf(" %.1e", (a[i].end.x - b[i].end.x).cwiseAbs().maxCoeff());
  std::printf("\n");
}

double LargestDifference(const std::vector<Eigen::VectorXd>& a,
                         const std::vector<Eigen::VectorXd>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].size() != b[i].size()) return INFINITY;
    if (b[i].size() > 0) largest = std::max(largest, (a[i] - b[i]).norm() / b[i].norm());
  }
  return largest;
}

// EquilibriumJvp beside the sum of the 39 columns of EquilibriumTangents, at the drapes of the
// device.
void BenchJvp(Backend& device, Backend& host, const Batch& batch, int count, int host_count) {
  const Drapes drapes(device, std::span(batch.inputs.data(), count));
  const std::span changes(batch.weights.data(), count);
  const std::span<const RolloutInput> inputs = drapes.inputs;
  std::vector<Eigen::VectorXd> one, summed, of_host;
  const auto time = [&](const char* name, int rollouts, const std::function<void()>& work) {
    work();
    const double seconds = Fastest(work, FLAGS_repeats);
    std::printf("  %-20s B %4d: %9.1f a second, %9.3f ms a batch\n", name, rollouts,
                rollouts / seconds, 1e3 * seconds);
    std::fflush(stdout);
    return seconds / rollouts;
  };
  const double native = time("jvp", count, [&] { one = device.EquilibriumJvp(inputs, changes); });
  const double columns = time("jvp-columns", count, [&] {
    summed = test::SumEquilibriumTangents(device, inputs, changes);
  });
  const auto solved = std::ranges::count_if(one, [](const auto& dx) { return dx.size() > 0; });
  std::printf("  jvp is %.1f x as fast as its 39 columns, difference %.1e, %d of %d solved\n",
              columns / native, LargestDifference(one, summed), static_cast<int>(solved), count);
  if (!FLAGS_host) return;
  const double on_host = time("jvp on the host", host_count, [&] {
    of_host = host.EquilibriumJvp(inputs.first(host_count), changes.first(host_count));
  });
  one.resize(host_count);
  std::printf("  jvp is %.1f x as fast as on the host, difference %.1e\n", on_host / native,
              LargestDifference(one, of_host));
}

void BenchMesh(const std::string& spec) {
  const auto model =
      std::make_shared<const ClothModel>(ParseMeshSpec(spec), BenchScene(), MakeLaw(FLAGS_law));
  const int threads = static_cast<int>(std::thread::hardware_concurrency());
  const auto device = MakeCudaBackend(model, threads);
  const auto host = MakeCpuBackend(model, threads);
  RolloutOptions options{.h = FLAGS_h, .steps = FLAGS_steps};
  for (int k = 1; k <= FLAGS_frames; ++k) options.frames.push_back(FLAGS_steps * k / FLAGS_frames);
  const std::vector<std::string> counts = Split(FLAGS_batches);
  int most = 1;
  for (const std::string& count : counts) most = std::max(most, std::stoi(count));
  const Batch batch(*model, most);
  std::printf("%s: %d vertices\n", spec.c_str(), model->mesh.num_vertices());
  CompareEnds(*device, *host, batch, std::min<int>(most, std::size(kFabrics)), options);
  const int on_host = std::min(most, threads);
  for (const std::string& work : Split(FLAGS_works)) {
    if (work == "jvp") {
      for (const std::string& text : counts)
        if (const int count = std::stoi(text); count * model->mesh.num_vertices() <= FLAGS_most)
          BenchJvp(*device, *host, batch, count, std::min(on_host, count));
      continue;
    }
    const double host_rate =
        FLAGS_host ? on_host / Fastest([&] { Run(*host, work, batch, on_host, options); }, 1) : NAN;
    for (const std::string& text : counts) {
      const int count = std::stoi(text);
      if (count * model->mesh.num_vertices() > FLAGS_most) continue;
      Run(*device, work, batch, count, options);
      const double seconds =
          Fastest([&] { Run(*device, work, batch, count, options); }, FLAGS_repeats);
      std::printf(
          "  %-20s B %4d: %9.1f a second, %8.2f us a step and rollout, %6.3f ms a step, "
          "%6.1f x the %d host threads\n",
          work.c_str(), count, count / seconds, 1e6 * seconds / count / FLAGS_steps,
          1e3 * seconds / FLAGS_steps, count / seconds / host_rate, threads);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) try {
  google::InitGoogleLogging(argv[0]);
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  std::printf("fabrics: %s\n", drape::FabricsFolder().c_str());
  std::printf("devices: %s; law %s, %d steps of %g s\n", drape::SurveyCuda().text.c_str(),
              FLAGS_law.c_str(), FLAGS_steps, FLAGS_h);
  for (const std::string& spec : drape::Split(FLAGS_meshes)) drape::BenchMesh(spec);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_cuda: %s\n", error.what());
  return 2;
}
