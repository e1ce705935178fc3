// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parameters/parametrisation.h"

#include <glog/logging.h>

#include <cmath>
#include <utility>

#include "physics/util/errors.h"
#include "solver/fit/parameters/coupled_table.h"

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

// Multiplies entry k of a table by factor[k].
void ScaleEntries(const double* factor, int count, double* entries) {
  for (int k = 0; k < count; ++k) entries[k] *= factor[k];
}

}  // namespace

Eigen::MatrixXd MaterialParametrisation::LogEntriesByTheta(const Eigen::VectorXd&) const {
  LOG(FATAL) << "tables of their own for the elements";
}

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
  const Eigen::VectorXd eta = tie_ * theta;
  const Eigen::VectorXd bend = eta.tail(kBendEntries).array().exp();
  MaterialField field = base_;
  for (StretchTable& table : field.stretch) table = ApplyLogFactors(table, eta.data());
  for (BendTable& table : field.bend) ScaleEntries(bend.data(), kBendEntries, table.entries());
  return field;
}

bool TableParametrisation::has_one_table() const {
  return base_.stretch.size() == 1 && base_.bend.size() == 1;
}

Eigen::MatrixXd TableParametrisation::LogEntriesByTheta(const Eigen::VectorXd& theta) const {
  CHECK(has_one_table());
  const StretchTable table = ApplyLogFactors(base_.stretch[0], (tie_ * theta).eval().data());
  Eigen::MatrixXd by_theta = tie_;
  for (auto column : by_theta.colwise()) PushLogFactors(base_.stretch[0], table, column.data());
  return by_theta;
}

RowMatrix TableParametrisation::Vjp(const MaterialField& material,
                                    const MaterialGradient& gradient) const {
  RowMatrix by_factors = RowMatrix::Zero(kMaterialEntries, gradient.stretch.cols());
  Eigen::MatrixXd by_logs(kStretchEntries, gradient.stretch.cols());
  for (std::size_t f = 0; f < base_.stretch.size(); ++f) {
    const StretchTable& table = material.stretch[f];
    const Eigen::Map<const Eigen::VectorXd> entries(table.entries(), kStretchEntries);
    by_logs =
        entries.asDiagonal() * gradient.stretch.middleRows(
                                   static_cast<Eigen::Index>(f) * kStretchEntries, kStretchEntries);
    for (auto column : by_logs.colwise()) PullLogFactors(base_.stretch[f], table, column.data());
    by_factors.topRows(kStretchEntries) += by_logs;
  }
  by_factors.bottomRows(kBendEntries) = gradient.Contract(material).bottomRows(kBendEntries);
  return tie_.transpose() * by_factors;
}

MaterialField TableParametrisation::Jvp(const MaterialField& material,
                                        const Eigen::VectorXd& change) const {
  const Eigen::VectorXd eta = tie_ * change;
  MaterialField direction = material;
  for (std::size_t f = 0; f < direction.stretch.size(); ++f) {
    Eigen::VectorXd logs = eta.head(kStretchEntries);
    PushLogFactors(base_.stretch[f], material.stretch[f], logs.data());
    ScaleEntries(logs.data(), kStretchEntries, direction.stretch[f].entries());
  }
  for (BendTable& table : direction.bend)
    ScaleEntries(eta.data() + kStretchEntries, kBendEntries, table.entries());
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
