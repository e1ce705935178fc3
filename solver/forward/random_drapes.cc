// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/random_drapes.h"

#include <algorithm>
#include <cmath>

#include "losses/metrics/metrics.h"
#include "losses/outline/shape_features.h"
#include "losses/silhouette/raster.h"
#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/start_shape.h"
#include "physics/util/errors.h"
#include "solver/forward/settle.h"

namespace drape {
namespace {

constexpr int kSupersample = 4;

State RandomStart(const ClothModel& model, int seed, double hem_rms, const DrapeDiscs& discs) {
  const StartShape shape = RandomStartShape(static_cast<uint64_t>(seed), hem_rms);
  return {ApplyStartShape(model.mesh, discs.support, shape),
          Eigen::VectorXd::Zero(model.num_dofs())};
}

void Measure(const ClothModel& model, const MaterialField& material, const DrapeDiscs& discs,
             DrapeSample* sample) {
  sample->energy = Energy(model, material, sample->x);
  sample->at_rest = DrapeOutline(model.mesh, sample->x, &sample->outline);
  if (!sample->at_rest) {
    sample->status = "no outline";
    return;
  }
  sample->signature = ComputeSignature(sample->outline, discs);
  sample->silhouette = Rasterize(model.mesh, sample->x, CameraAbove(discs), kSupersample);
}

DrapeSample FromEquilibrium(const ClothModel& model, const MaterialField& material,
                            const DrapeDiscs& discs, EquilibriumResult rest) {
  DrapeSample sample;
  sample.status = ToString(rest.status);
  sample.stable = rest.status == EquilibriumStatus::kStable;
  sample.residual = rest.residual;
  sample.newton_iterations = rest.iterations;
  sample.x = std::move(rest.x);
  if (sample.stable || rest.status == EquilibriumStatus::kUnstable) {
    Measure(model, material, discs, &sample);
  }
  return sample;
}

DrapeSample FromSettled(const ClothModel& model, const MaterialField& material,
                        const DrapeDiscs& discs, SettledDrape drape) {
  if (drape.steps == RolloutStatus::kOk)
    return FromEquilibrium(model, material, discs, std::move(drape.rest));
  DrapeSample failed;
  failed.status = ToString(drape.steps);
  return failed;
}

SettleOptions MakeSettleOptions(const SamplingOptions& sampling, const std::atomic<bool>* cancel) {
  SettleOptions options;
  options.steps.h = sampling.h;
  options.steps.steps = sampling.steps;
  options.steps.cancel = options.equilibrium.cancel = cancel;
  return options;
}

std::vector<int> AtRest(const std::vector<DrapeSample>& samples) {
  std::vector<int> indices;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].at_rest) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

BranchCluster MakeCluster(const std::vector<DrapeSample>& samples, std::vector<int> members,
                          size_t at_rest) {
  BranchCluster cluster;
  std::stable_sort(members.begin(), members.end(),
                   [&](int a, int b) { return samples[a].energy < samples[b].energy; });
  cluster.frequency = static_cast<double>(members.size()) / static_cast<double>(at_rest);
  for (const int member : members) {
    cluster.stable = cluster.stable && samples[member].stable;
    cluster.residual = std::max(cluster.residual, samples[member].residual);
  }
  cluster.members = std::move(members);
  return cluster;
}

}  // namespace

std::vector<DrapeSample> SampleEquilibria(Backend& backend, const MaterialField& material,
                                          const SamplingOptions& options,
                                          const RunControl& control) {
  const ClothModel& model = backend.model();
  std::vector<DrapeSample> samples;
  const auto task = [&](int i) {
    return DrapeTask{material,
                     RandomStart(model, options.first_seed + i, options.hem_rms, options.discs)};
  };
  const auto done = [&](int i, SettledDrape drape) {
    samples.push_back(FromSettled(model, material, options.discs, std::move(drape)));
    samples.back().seed = options.first_seed + i;
    control.Report((i + 1.0) / options.samples,
                   "start " + std::to_string(i + 1) + " of " + std::to_string(options.samples));
  };
  SettleInBatches(backend, options.samples, SettleBatchSize(backend, options.threads), task,
                  MakeSettleOptions(options, control.cancel), done);
  return samples;
}

BranchMetric ParseBranchMetric(const std::string& text) {
  if (text == "vertices") return BranchMetric::kVertices;
  if (text == "outline") return BranchMetric::kOutline;
  if (text == "rotated") return BranchMetric::kRotated;
  if (text == "mirrored") return BranchMetric::kMirrored;
  throw InputError("distance",
                   "found '" + text + "', expected one of vertices, outline, rotated, mirrored");
}

double BranchDistance(const DrapeSample& a, const DrapeSample& b, BranchMetric metric) {
  switch (metric) {
    case BranchMetric::kVertices:
      return VertexDistance(a.x, b.x);
    case BranchMetric::kOutline:
      return MatchOutlines(a.outline, b.outline).rms;
    case BranchMetric::kRotated:
      return MatchOutlines(a.outline, b.outline, OutlineFreedom::kRotation).rms;
    case BranchMetric::kMirrored:
      break;
  }
  return MatchOutlines(a.outline, b.outline, OutlineFreedom::kRotationAndMirror).rms;
}

std::vector<BranchCluster> ClusterSamples(const std::vector<DrapeSample>& samples,
                                          BranchMetric metric, double tolerance) {
  const std::vector<int> at_rest = AtRest(samples);
  const auto n = static_cast<Eigen::Index>(at_rest.size());
  Eigen::MatrixXd distance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      distance(i, j) = BranchDistance(samples[at_rest[i]], samples[at_rest[j]], metric);
      distance(j, i) = distance(i, j);
    }
  }
  std::vector<BranchCluster> clusters;
  for (std::vector<int>& members : ClusterByDistance(distance, tolerance)) {
    for (int& member : members) member = at_rest[member];
    clusters.push_back(MakeCluster(samples, std::move(members), at_rest.size()));
  }
  std::stable_sort(clusters.begin(), clusters.end(), [&](const auto& a, const auto& b) {
    if (a.members.size() != b.members.size()) return a.members.size() > b.members.size();
    return samples[a.members[0]].energy < samples[b.members[0]].energy;
  });
  return clusters;
}

BranchSpread ComputeSpread(const std::vector<DrapeSample>& samples) {
  const std::vector<int> at_rest = AtRest(samples);
  std::vector<double> dc, folds, rms, mse;
  for (size_t i = 0; i < at_rest.size(); ++i) {
    const DrapeSample& a = samples[at_rest[i]];
    dc.push_back(a.signature.drape_coefficient);
    folds.push_back(a.signature.folds);
    for (size_t j = 0; j < i; ++j) {
      const DrapeSample& b = samples[at_rest[j]];
      rms.push_back(MatchOutlines(a.outline, b.outline).rms);
      mse.push_back(MeanSquaredError(a.silhouette, b.silhouette));
    }
  }
  return {static_cast<int>(at_rest.size()), SpreadOfValues(dc), SpreadOfValues(folds),
          SpreadOfValues(rms), SpreadOfValues(mse)};
}

}  // namespace drape
