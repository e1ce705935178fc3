// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/random_drapes.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/state.h"
#include "physics/util/errors.h"
#include "solver/forward/settle.h"

namespace drape {
namespace {

using std::numbers::pi;

StartShape::Mode ModeOfOutline(const Eigen::VectorXd& outline, int k) {
  const double n = static_cast<double>(outline.size());
  double a = 0.0, b = 0.0;
  for (Eigen::Index i = 0; i < outline.size(); ++i) {
    const double angle = 2 * pi * k * static_cast<double>(i) / n;
    a += 2 * outline[i] * std::cos(angle) / n;
    b += 2 * outline[i] * std::sin(angle) / n;
  }
  return {k, std::hypot(a, b), std::atan2(b, a)};
}

constexpr int kSupersample = 4;

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

DrapeSample FromSettled(const ClothModel& model, const MaterialField& material,
                        const DrapeDiscs& discs, SettledDrape drape) {
  if (drape.steps != RolloutStatus::kOk) return {.status = ToString(drape.steps)};
  EquilibriumResult& rest = drape.rest;
  DrapeSample sample{.status = ToString(rest.status),
                     .stable = rest.status == EquilibriumStatus::kStable,
                     .residual = rest.residual,
                     .newton_iterations = rest.iterations,
                     .x = std::move(rest.x)};
  if (sample.stable || rest.status == EquilibriumStatus::kUnstable)
    Measure(model, material, discs, &sample);
  return sample;
}

SettleOptions MakeSettleOptions(const SamplingOptions& sampling, const std::atomic<bool>* cancel) {
  return {.steps = {.h = sampling.h, .steps = sampling.steps, .cancel = cancel},
          .equilibrium = {.cancel = cancel}};
}

std::vector<int> RestingSamples(const std::vector<DrapeSample>& samples) {
  std::vector<int> indices;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].at_rest) indices.push_back(static_cast<int>(i));
  }
  return indices;
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

bool DrapeOutline(const Mesh& mesh, const Eigen::VectorXd& x, Eigen::VectorXd* outline) {
  const Camera camera;
  Outline seen;
  if (!OutlineFromMesh(mesh, x, camera, kBranchAngles, &seen)) return false;
  *outline = MetresFromPixels(seen.radius, camera);
  return true;
}

BranchSignature ComputeSignature(const Eigen::VectorXd& outline, const DrapeDiscs& discs) {
  constexpr int kFirstWave = 2, kLastWave = 15;
  constexpr std::size_t kKeptWaves = 3;
  CHECK_GE(outline.size(), 180);
  BranchSignature signature;
  signature.folds = CountFolds(outline);
  signature.drape_coefficient = DrapeCoefficient(ProfileArea(outline), discs);
  for (int k = kFirstWave; k <= kLastWave; ++k)
    signature.modes.push_back(ModeOfOutline(outline, k));
  std::sort(signature.modes.begin(), signature.modes.end(),
            [](const auto& a, const auto& b) { return a.amplitude_m > b.amplitude_m; });
  signature.modes.resize(kKeptWaves);
  return signature;
}

double VertexRms(const Eigen::VectorXd& v) {
  return v.norm() / std::sqrt(static_cast<double>(v.size()) / 3.0);
}

double VertexDistance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  CHECK_EQ(a.size(), b.size());
  CHECK_GT(a.size(), 0);
  return VertexRms(a - b);
}

std::vector<std::vector<int>> ClusterByDistance(const Eigen::MatrixXd& distance, double tolerance) {
  CHECK_EQ(distance.rows(), distance.cols());
  const int n = static_cast<int>(distance.rows());
  std::vector<bool> taken(n, false);
  std::vector<std::vector<int>> clusters;
  for (int first = 0; first < n; ++first) {
    if (taken[first]) continue;
    std::vector<int> members = {first};
    taken[first] = true;
    for (size_t next = 0; next < members.size(); ++next) {
      for (int other = 0; other < n; ++other) {
        if (taken[other] || distance(members[next], other) > tolerance) continue;
        taken[other] = true;
        members.push_back(other);
      }
    }
    std::sort(members.begin(), members.end());
    clusters.push_back(std::move(members));
  }
  return clusters;
}

State RandomStart(const ClothModel& model, int seed, double hem_rms, const DrapeDiscs& discs) {
  const StartShape shape = RandomStartShape(static_cast<uint64_t>(seed), hem_rms);
  return {ApplyStartShape(model.mesh, discs.support, shape),
          Eigen::VectorXd::Zero(model.num_dofs())};
}

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

std::vector<BranchCluster> ClusterSamples(const std::vector<DrapeSample>& samples,
                                          BranchMetric metric, double tolerance) {
  const std::vector<int> at_rest = RestingSamples(samples);
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
  const std::vector<int> at_rest = RestingSamples(samples);
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
