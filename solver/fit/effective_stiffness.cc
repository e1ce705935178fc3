// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/effective_stiffness.h"

#include <glog/logging.h>

#include <algorithm>
#include <iterator>

#include "physics/cloth/assembly/assembly.h"
#include "physics/material/material_scaling.h"

namespace drape {
namespace {

// c11 and c22.
bool IsAlongThreads(int entry) {
  const int column = entry % kStretchCols;
  return entry < kStretchEntries && (column == 0 || column == 2);
}

// A cloth that is not deformed has at most the energy of rounding.
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

// The sum of weights × entries over stretch or bend.
double WeightedSum(const MaterialField& table, const Eigen::VectorXd& weights, int from,
                   int count) {
  CHECK_EQ(weights.size(), kMaterialEntries);
  return weights.segment(from, count).dot(AllEntries(table).segment(from, count));
}

struct Name {
  const char *key, *text;
};
constexpr Name kStretchNames[] = {
    {"c11_n_per_m", "c11"}, {"c12_n_per_m", "c12"}, {"c22_n_per_m", "c22"}, {"c33_n_per_m", "c33"}};
static_assert(std::size(kStretchNames) == kStretchCols);

double MeanOfEntries(const double* entries, int rows, int cols) {
  double sum = 0.0;
  for (int r = 0; r < rows; ++r) sum += entries[r * cols];
  return sum / rows;
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
  return kMembranePerEntry * WeightedSum(table, weights, 0, kStretchEntries);
}

double EffectiveBend(const MaterialField& table, const Eigen::VectorXd& weights) {
  return WeightedSum(table, weights, kStretchEntries, kBendEntries) / kBendPerRigidity;
}

DirectionNames NameDirections(bool warp_known, double bend_warp, double bend_weft) {
  if (warp_known) return {};
  if (bend_warp < bend_weft) return {.warp = "softer", .weft = "stiffer"};
  return {.warp = "stiffer", .weft = "softer"};
}

std::vector<StiffnessQuantity> ListStiffness(const MaterialField& table,
                                             const Eigen::VectorXd& weights,
                                             const DirectionNames& directions) {
  std::vector<StiffnessQuantity> list;
  for (int c = 0; c < kStretchCols; ++c)
    list.push_back(
        {kStretchNames[c].key, kStretchNames[c].text, "N/m", 1.0,
         kMembranePerEntry * MeanOfEntries(&table.stretch[0].c[0][c], kStretchRows, kStretchCols)});
  const std::string edges[kBendRows] = {"along " + directions.weft, "at 45 deg",
                                        "along " + directions.warp};
  for (int r = 0; r < kBendRows; ++r) {
    std::string key = "bend_" + edges[r] + "_n_m";
    std::replace(key.begin(), key.end(), ' ', '_');
    list.push_back({key, "bend, edges " + edges[r], "N m", 1.0,
                    MeanOfEntries(table.bend[0].b[r], kBendCols, 1) / kBendPerRigidity});
  }
  const double rigidity = EffectiveBend(table, weights);
  list.push_back({"bend_n_m", "bend, as it drapes", "N m", 1.0, rigidity});
  list.push_back({"bend_over_weight_m3", "  over the weight", "cm3", 1e6,
                  BendOverWeight(rigidity, table.density)});
  list.push_back(
      {"bending_length_m", "  bending length", "mm", 1e3, BendingLength(rigidity, table.density)});
  return list;
}

}  // namespace drape
