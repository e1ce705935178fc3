// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parameters/effective_stiffness.h"

#include <glog/logging.h>

#include "physics/cloth/assembly/assembly.h"

namespace drape {
namespace {

// c11 and c22.
bool IsAlongThreads(int entry) {
  const int column = entry % kStretchCols;
  return entry < kStretchEntries && (column == 0 || column == 2);
}

// Of a cloth that is not deformed there is rounding at most.
constexpr double kNoEnergy = 1e-25;

// Weights of c11, c22 and of bend with the sums 1; equal ones where there is no energy.
Eigen::VectorXd Normalised(Eigen::VectorXd weights) {
  for (int i = 0; i < kStretchEntries; ++i)
    if (!IsAlongThreads(i)) weights[i] = 0.0;
  const auto normalise = [](auto part, const Eigen::VectorXd& equal) {
    const double sum = part.sum();
    part = sum > kNoEnergy ? Eigen::VectorXd(part / sum) : equal;
  };
  Eigen::VectorXd threads(kStretchEntries);
  for (int i = 0; i < kStretchEntries; ++i)
    threads[i] = IsAlongThreads(i) ? 1.0 / (2 * kStretchRows) : 0.0;
  normalise(weights.head(kStretchEntries), threads);
  normalise(weights.tail(kBendEntries),
            Eigen::VectorXd::Constant(kBendEntries, 1.0 / kBendEntries));
  return weights;
}

Eigen::VectorXd AllEntries(const MaterialField& table) {
  CHECK(table.stretch.size() == 1 && table.bend.size() == 1);
  Eigen::VectorXd entries(kMaterialEntries);
  entries << Eigen::Map<const Eigen::VectorXd>(table.stretch[0].entries(), kStretchEntries),
      Eigen::Map<const Eigen::VectorXd>(table.bend[0].entries(), kBendEntries);
  return entries;
}

// The part of stretch or of bend of weights × entries.
Eigen::VectorXd Part(const MaterialField& table, const Eigen::VectorXd& weights, int from,
                     int count) {
  CHECK_EQ(weights.size(), kMaterialEntries);
  Eigen::VectorXd part = Eigen::VectorXd::Zero(kMaterialEntries);
  part.segment(from, count) = weights.cwiseProduct(AllEntries(table)).segment(from, count);
  return part;
}

Eigen::VectorXd StretchPart(const MaterialField& table, const Eigen::VectorXd& weights) {
  return Part(table, weights, 0, kStretchEntries);
}

Eigen::VectorXd BendPart(const MaterialField& table, const Eigen::VectorXd& weights) {
  return Part(table, weights, kStretchEntries, kBendEntries);
}

}  // namespace

Eigen::VectorXd StiffnessWeights(const ClothModel& model,
                                 const std::vector<Eigen::VectorXd>& shapes) {
  Eigen::VectorXd energy = Eigen::VectorXd::Zero(kMaterialEntries);
  for (const Eigen::VectorXd& x : shapes) energy += EnergyByEntry(model, x);
  return Normalised(std::move(energy));
}

Eigen::VectorXd EqualStiffnessWeights() {
  return Normalised(Eigen::VectorXd::Zero(kMaterialEntries));
}

double EffectiveStretch(const MaterialField& table, const Eigen::VectorXd& weights) {
  return kMembranePerEntry * StretchPart(table, weights).sum();
}

double EffectiveBend(const MaterialField& table, const Eigen::VectorXd& weights) {
  return BendPart(table, weights).sum() / kBendPerRigidity;
}

Eigen::VectorXd SharesInStretch(const MaterialField& table, const Eigen::VectorXd& weights) {
  const Eigen::VectorXd part = StretchPart(table, weights);
  return part / part.sum();
}

Eigen::VectorXd SharesInBend(const MaterialField& table, const Eigen::VectorXd& weights) {
  const Eigen::VectorXd part = BendPart(table, weights);
  return part / part.sum();
}

}  // namespace drape
