// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parameters/stiffness_list.h"

#include <iterator>

#include "physics/material/material_scaling.h"
#include "solver/fit/parameters/effective_stiffness.h"

namespace drape {
namespace {

struct Name {
  const char *key, *text;
};
constexpr Name kStretchNames[] = {
    {"c11_n_per_m", "c11"}, {"c12_n_per_m", "c12"}, {"c22_n_per_m", "c22"}, {"c33_n_per_m", "c33"}};
constexpr Name kBendNames[] = {{"bend_along_weft_n_m", "bend, edges along weft"},
                               {"bend_at_45_deg_n_m", "bend, edges at 45 deg"},
                               {"bend_along_warp_n_m", "bend, edges along warp"}};
static_assert(std::size(kStretchNames) == kStretchCols && std::size(kBendNames) == kBendRows);

double MeanOfEntries(const double* entries, int rows, int cols) {
  double sum = 0.0;
  for (int r = 0; r < rows; ++r) sum += entries[r * cols];
  return sum / rows;
}

}  // namespace

std::vector<StiffnessQuantity> ListStiffness(const MaterialField& table,
                                             const Eigen::VectorXd& weights) {
  std::vector<StiffnessQuantity> list;
  for (int c = 0; c < kStretchCols; ++c)
    list.push_back(
        {kStretchNames[c].key, kStretchNames[c].text, "N/m", 1.0,
         kMembranePerEntry * MeanOfEntries(&table.stretch[0].c[0][c], kStretchRows, kStretchCols)});
  for (int r = 0; r < kBendRows; ++r)
    list.push_back({kBendNames[r].key, kBendNames[r].text, "N m", 1.0,
                    MeanOfEntries(table.bend[0].b[r], kBendCols, 1) / kBendPerRigidity});
  const double rigidity = EffectiveBend(table, weights);
  list.push_back({"bend_n_m", "bend, as it drapes", "N m", 1.0, rigidity});
  list.push_back({"bend_over_weight_m3", "  over the weight", "cm3", 1e6,
                  BendOverWeight(rigidity, table.density)});
  list.push_back(
      {"bending_length_m", "  bending length", "mm", 1e3, BendingLength(rigidity, table.density)});
  return list;
}

}  // namespace drape
