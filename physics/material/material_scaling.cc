// SPDX-License-Identifier: Apache-2.0
#include "physics/material/material_scaling.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <vector>

namespace drape {
namespace {

// Replaces `count` entries with a stride. The mean of equal entries is that entry bit for bit, so
// that a form taken twice is the form.
void ReplaceByMean(double* entries, int count, int stride) {
  double sum = 0.0;
  bool equal = true;
  for (int i = 0; i < count; ++i) {
    sum += entries[i * stride];
    equal &= entries[i * stride] == entries[0];
  }
  if (equal) return;
  for (int i = 0; i < count; ++i) entries[i * stride] = sum / count;
}

int RaiseToShare(double* entries, int count, int stride, double share) {
  double largest = 0.0;
  for (int i = 0; i < count; ++i) largest = std::max(largest, entries[i * stride]);
  int raised = 0;
  for (int i = 0; i < count; ++i) {
    double& entry = entries[i * stride];
    if (entry >= share * largest) continue;
    entry = share * largest;
    ++raised;
  }
  return raised;
}

void MakeLinear(StretchTable& table) {
  for (int k = 0; k < kStretchCols; ++k) ReplaceByMean(&table.c[0][k], kStretchRows, kStretchCols);
}

void MakeLinear(BendTable& table) {
  for (auto& row : table.b) ReplaceByMean(row, kBendCols, 1);
}

// Makes a linear table isotropic.
void MakeIsotropic(StretchTable& table) {
  constexpr double kMaxPoisson = 0.95;
  const double c11 = 0.5 * (table.c[0][0] + table.c[0][2]);
  const double c12 = std::min(table.c[0][1], kMaxPoisson * c11);
  for (auto& row : table.c) {
    row[0] = row[2] = c11;
    row[1] = c12;
    row[3] = c11 - c12;
  }
}

void MakeIsotropic(BendTable& table) {
  ReplaceByMean(table.entries(), kBendRows, kBendCols);
  for (auto& row : table.b) std::fill(std::begin(row), std::end(row), table.b[0][0]);
}

template <class Table>
Table MeanTable(const std::vector<Table>& tables) {
  Table mean = {};
  for (const Table& table : tables)
    for (std::size_t k = 0; k < sizeof(Table) / sizeof(double); ++k)
      mean.entries()[k] += table.entries()[k] / static_cast<double>(tables.size());
  return mean;
}

constexpr double kMicro = 1e-6, kPercent = 100.0;
constexpr double kFastShear = 123.0, kFastFormability = 14.7;
constexpr double kGramForce = 1e-3 * kStandardGravity;  // [N]
constexpr double kCentimetre = 1e-2;

}  // namespace

MaterialField Scaled(MaterialField material, double stretch, double bend) {
  for (StretchTable& table : material.stretch)
    for (auto& row : table.c)
      for (double& entry : row) entry *= stretch;
  for (BendTable& table : material.bend)
    for (auto& row : table.b)
      for (double& entry : row) entry *= bend;
  return material;
}

int RaiseSmallEntries(MaterialField& field, double share) {
  int raised = 0;
  for (StretchTable& table : field.stretch)
    for (int col = 0; col < kStretchCols; ++col)
      raised += RaiseToShare(&table.c[0][col], kStretchRows, kStretchCols, share);
  for (BendTable& table : field.bend)
    for (auto& row : table.b) raised += RaiseToShare(row, kBendCols, 1, share);
  return raised;
}

MaterialField InForm(MaterialField material, TableForm form) {
  if (form == TableForm::kGiven) return material;
  const auto shape = [form](auto& table) {
    MakeLinear(table);
    if (form == TableForm::kIsotropic) MakeIsotropic(table);
  };
  std::for_each(material.stretch.begin(), material.stretch.end(), shape);
  std::for_each(material.bend.begin(), material.bend.end(), shape);
  return material;
}

double MeanStretch(const StretchTable& table) {
  double sum = 0.0;
  for (const auto& row : table.c) sum += row[0] + row[2];
  return kMembranePerEntry * sum / (2 * kStretchRows);
}

double MeanBend(const BendTable& table) {
  double sum = 0.0;
  for (const auto& row : table.b) sum = std::accumulate(std::begin(row), std::end(row), sum);
  return sum / (kBendPerRigidity * kBendEntries);
}

double BendOverWeight(double rigidity, double density) {
  return rigidity / (density * kStandardGravity);
}
double BendingLength(double rigidity, double density) {
  return std::cbrt(BendOverWeight(rigidity, density));
}

MaterialField MeanTables(const MaterialField& field) {
  return {field.density, {MeanTable(field.stretch)}, {MeanTable(field.bend)}};
}

double OverallStiffness(double warp, double weft) { return std::sqrt(warp * weft); }

double ExtensionPercent(double force, double stiffness) { return kPercent * force / stiffness; }

double FastBiasExtensionPercent(double shear_rigidity) { return kFastShear / shear_rigidity; }

double FormabilityMm2(double rigidity, double e5_percent, double e20_percent) {
  return rigidity / kMicro * (e20_percent - e5_percent) / kFastFormability;
}

double KesBending(double rigidity) { return rigidity / (kGramForce * kCentimetre); }

double KesShear(double shear_rigidity) {
  return shear_rigidity / (kGramForce / kCentimetre) * M_PI / 180.0;
}

}  // namespace drape
