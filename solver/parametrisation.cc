// SPDX-License-Identifier: Apache-2.0
#include "solver/parametrisation.h"

#include <glog/logging.h>

#include <cmath>
#include <utility>

#include "physics/errors.h"

namespace drape {
namespace {

// Which θ drives table entry `entry` (0..38).
int GroupOf(int entry, Tying tying) {
  const bool stretch = entry < kStretchEntries;
  switch (tying) {
    case Tying::kScales: return stretch ? 0 : 1;
    case Tying::kColumns:
      return stretch ? entry % kStretchCols : kStretchCols + (entry - kStretchEntries) / kBendCols;
    case Tying::kEntries: return entry;
  }
  LOG(FATAL) << "unknown tying";
}

const char* const kColumnNames[kStretchCols] = {"c11", "c12", "c22", "c33"};

std::string EntryName(int entry) {
  if (entry < kStretchEntries)
    return std::string(kColumnNames[entry % kStretchCols]) + "[" +
           std::to_string(entry / kStretchCols) + "]";
  const int k = entry - kStretchEntries;
  return "bend[" + std::to_string(k / kBendCols) + "][" + std::to_string(k % kBendCols) + "]";
}

}  // namespace

Tying ParseTying(const std::string& text) {
  if (text == "2") return Tying::kScales;
  if (text == "7") return Tying::kColumns;
  if (text == "39") return Tying::kEntries;
  throw InputError("parameters", "'" + text + "', expected 2, 7 or 39");
}

MaterialParametrisation::MaterialParametrisation(MaterialField base, Tying tying)
    : base_(std::move(base)),
      tie_(Eigen::MatrixXd::Zero(kMaterialEntries, GroupOf(kMaterialEntries - 1, tying) + 1)) {
  for (int entry = 0; entry < kMaterialEntries; ++entry) tie_(entry, GroupOf(entry, tying)) = 1.0;
}

MaterialField MaterialParametrisation::Material(const Eigen::VectorXd& theta) const {
  CHECK_EQ(theta.size(), size());
  const Eigen::VectorXd factor = (tie_ * theta).array().exp();
  MaterialField field = base_;
  for (StretchTable& table : field.stretch)
    for (int k = 0; k < kStretchEntries; ++k) (&table.c[0][0])[k] *= factor[k];
  for (BendTable& table : field.bend)
    for (int k = 0; k < kBendEntries; ++k) (&table.b[0][0])[k] *= factor[kStretchEntries + k];
  return field;
}

std::string MaterialParametrisation::name(int i) const {
  if (size() == kMaterialEntries) return EntryName(i);
  if (size() == 2) return i == 0 ? "stretch" : "bend";
  return i < kStretchCols ? kColumnNames[i] : "bend[" + std::to_string(i - kStretchCols) + "]";
}

}  // namespace drape
