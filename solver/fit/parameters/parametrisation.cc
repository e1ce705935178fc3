// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parameters/parametrisation.h"

#include <glog/logging.h>

#include <cmath>
#include <utility>

#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr int kNone = -1;

// Which θ drives table entry `entry` (0..38), or kNone.
int GroupIndex(int entry, ParameterTying tying) {
  const bool stretch = entry < kStretchEntries;
  if (stretch && !FreesStretch(tying)) return kNone;
  const int row = (entry - kStretchEntries) / kBendCols;  // of bend
  switch (tying) {
    case ParameterTying::kBendScale:
      return 0;
    case ParameterTying::kBendRows:
      return row;
    case ParameterTying::kScales:
      return stretch ? 0 : 1;
    case ParameterTying::kColumns:
      return stretch ? entry % kStretchCols : kStretchCols + row;
    case ParameterTying::kEntries:
      return entry;
  }
  LOG(FATAL) << "unknown tying";
}

int CountGroups(ParameterTying tying) { return GroupIndex(kMaterialEntries - 1, tying) + 1; }

const char* const kColumnNames[kStretchCols] = {"c11", "c12", "c22", "c33"};

std::string BendRowName(int row) { return "bend[" + std::to_string(row) + "]"; }

std::string EntryName(int entry) {
  if (entry < kStretchEntries)
    return std::string(kColumnNames[entry % kStretchCols]) + "[" +
           std::to_string(entry / kStretchCols) + "]";
  const int k = entry - kStretchEntries;
  return BendRowName(k / kBendCols) + "[" + std::to_string(k % kBendCols) + "]";
}

// Multiplies entry k of all tables by factor[k], shape [39].
void ScaleEntries(const Eigen::VectorXd& factor, MaterialField* field) {
  for (StretchTable& table : field->stretch)
    for (int k = 0; k < kStretchEntries; ++k) table.entries()[k] *= factor[k];
  for (BendTable& table : field->bend)
    for (int k = 0; k < kBendEntries; ++k) table.entries()[k] *= factor[kStretchEntries + k];
}

}  // namespace

Eigen::MatrixXd TyingMatrix(ParameterTying tying) {
  Eigen::MatrixXd tie = Eigen::MatrixXd::Zero(kMaterialEntries, CountGroups(tying));
  for (int entry = 0; entry < kMaterialEntries; ++entry)
    if (const int group = GroupIndex(entry, tying); group != kNone) tie(entry, group) = 1.0;
  return tie;
}

TableParametrisation::TableParametrisation(MaterialField base, ParameterTying tying)
    : TableParametrisation(std::move(base), TyingMatrix(tying)) {}

TableParametrisation::TableParametrisation(MaterialField base, Eigen::MatrixXd tie)
    : base_(std::move(base)), tie_(std::move(tie)) {
  CHECK_EQ(tie_.rows(), kMaterialEntries);
}

MaterialField TableParametrisation::Material(const Eigen::VectorXd& theta) const {
  CHECK_EQ(theta.size(), size());
  MaterialField field = base_;
  ScaleEntries((tie_ * theta).array().exp(), &field);
  return field;
}

RowMatrix TableParametrisation::Vjp(const MaterialField& material,
                                    const MaterialGradient& gradient) const {
  return tie_.transpose() * gradient.Contract(material);
}

MaterialField TableParametrisation::Jvp(const MaterialField& material,
                                        const Eigen::VectorXd& change) const {
  MaterialField direction = material;
  ScaleEntries(tie_ * change, &direction);
  return direction;
}

std::string NameFor(ParameterTying tying, int i) {
  switch (tying) {
    case ParameterTying::kBendScale:
      return "bend";
    case ParameterTying::kBendRows:
      return BendRowName(i);
    case ParameterTying::kScales:
      return i == 0 ? "stretch" : "bend";
    case ParameterTying::kColumns:
      return i < kStretchCols ? kColumnNames[i] : BendRowName(i - kStretchCols);
    case ParameterTying::kEntries:
      return EntryName(i);
  }
  LOG(FATAL) << "unknown tying";
}

}  // namespace drape
