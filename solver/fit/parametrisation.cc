// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parametrisation.h"

#include <glog/logging.h>

#include <algorithm>
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

// Multiplies entry k of a table by factor[k].
void ScaleEntries(const double* factor, int count, double* entries) {
  for (int k = 0; k < count; ++k) entries[k] *= factor[k];
}

enum Column { kC11, kC12, kC22, kC33 };

// |ρ|/ρmax of a row, ρmax by that of the base; 0 where the base does not resist.
double CouplingShare(const double* base, const double* row) {
  if (!(base[kC11] > 0.0 && base[kC22] > 0.0)) return 0.0;
  const double start = std::abs(base[kC12]) / std::sqrt(base[kC11] * base[kC22]);
  if (start >= 1.0) return 0.0;
  const double largest = std::max(kLargestCoupling, 0.5 * (1.0 + start));
  return std::abs(row[kC12]) / (largest * std::sqrt(row[kC11] * row[kC22]));
}

using Entries = Eigen::Map<RowMatrix>;

int CountEntries(ElementKind kind) {
  return kind == ElementKind::kFaces ? kStretchEntries : kBendEntries;
}
double* ElementTables(ElementKind kind, MaterialField& field) {
  return kind == ElementKind::kFaces ? &field.stretch[0].c[0][0] : &field.bend[0].b[0][0];
}
const double* ElementTables(ElementKind kind, const MaterialField& field) {
  return ElementTables(kind, const_cast<MaterialField&>(field));
}
int CountElements(ElementKind kind, const MaterialField& field) {
  return static_cast<int>(kind == ElementKind::kFaces ? field.stretch.size() : field.bend.size());
}
// Entries of all elements, shape [F, 24] or [E, 15].
Entries TableEntries(ElementKind kind, MaterialField& field) {
  return {ElementTables(kind, field), CountElements(kind, field), CountEntries(kind)};
}

// Σ over the entries of a group of the gradients by log factors, shape [elements, m].
RowMatrix GroupGradient(const FieldTerm& term, int group, const RowMatrix& by_factors) {
  const auto entries = static_cast<int>(term.tie.rows());
  const auto elements = static_cast<int>(by_factors.rows() / entries);
  RowMatrix sum = RowMatrix::Zero(elements, by_factors.cols());
  for (int e = 0; e < elements; ++e)
    for (int k = 0; k < entries; ++k)
      if (term.tie(k, group) != 0.0)
        sum.row(e) += term.tie(k, group) * by_factors.row(e * entries + k);
  return sum;
}

// Gradients by the entries of `material` become those by the log factors on `base`, shape
// [elements · entries, m].
RowMatrix ByLogFactors(ElementKind kind, const MaterialField& base, const MaterialField& material,
                       const RowMatrix& gradient) {
  const Eigen::Map<const Eigen::VectorXd> entries(ElementTables(kind, material), gradient.rows());
  RowMatrix by_factors = entries.asDiagonal() * gradient;
  if (kind == ElementKind::kHinges) return by_factors;
  Eigen::MatrixXd block(kStretchEntries, gradient.cols());
  for (std::size_t f = 0; f < base.stretch.size(); ++f) {
    auto rows =
        by_factors.middleRows(static_cast<Eigen::Index>(f) * kStretchEntries, kStretchEntries);
    block = rows;
    for (auto column : block.colwise())
      PullLogFactors(base.stretch[f], material.stretch[f], column.data());
    rows = block;
  }
  return by_factors;
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

Eigen::MatrixXd TieWithForm(const Eigen::MatrixXd& tie, double prior_sigma) {
  constexpr double kFormDeviation = 0.5;  // of the logarithm
  if (tie.cols() == kMaterialEntries) return tie;
  const Eigen::VectorXd is_free = tie.rowwise().sum();
  Eigen::MatrixXd with_form(kMaterialEntries, tie.cols() + kMaterialEntries);
  with_form << tie, Eigen::MatrixXd((kFormDeviation / prior_sigma * is_free).asDiagonal());
  return with_form;
}

Eigen::MatrixXd JacobianByTie(const Eigen::MatrixXd& by_entries, const Eigen::MatrixXd& tie) {
  const Eigen::Index others = by_entries.cols() - kMaterialEntries;
  Eigen::MatrixXd by_tie(by_entries.rows(), tie.cols() + others);
  by_tie << by_entries.leftCols(kMaterialEntries) * tie, by_entries.rightCols(others);
  return by_tie;
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

int CountNumbers(const std::vector<FreeNumber>& free) {
  int count = 0;
  for (const FreeNumber number : free) count += IsVector(number) ? 3 : 1;
  return count;
}

std::span<double> FindNumbers(FreeNumber number, MaterialField& material) {
  Dynamics& moving = material.dynamics;
  switch (number) {
    case FreeNumber::kDensity:
      return {&material.density, 1};
    case FreeNumber::kMassDamping:
      return {&moving.mass_damping, 1};
    case FreeNumber::kStiffnessDamping:
      return {&moving.stiffness_damping, 1};
    case FreeNumber::kAirDrag:
      return {&moving.air_drag, 1};
    case FreeNumber::kWind:
      return {&moving.wind.x, 3};
    case FreeNumber::kVelocity:
      return {};
  }
  LOG(FATAL) << "unknown number";
}

DynamicsParametrisation::DynamicsParametrisation(TableParametrisation table,
                                                 std::vector<FreeNumber> free)
    : table_(std::move(table)), free_(std::move(free)) {}

// Calls visit(number, where it begins in θ).
template <class Visit>
void DynamicsParametrisation::ForEach(const Visit& visit) const {
  Eigen::Index first = table_.size();
  for (const FreeNumber number : free_) {
    visit(number, first);
    first += IsVector(number) ? 3 : 1;
  }
}

MaterialField DynamicsParametrisation::Material(const Eigen::VectorXd& theta) const {
  MaterialField material = table_.Material(theta.head(table_.size()));
  ForEach([&](FreeNumber number, Eigen::Index next) {
    for (double& value : FindNumbers(number, material)) {
      value = IsVector(number) ? value + theta[next] : value * std::exp(theta[next]);
      ++next;
    }
  });
  return material;
}

Eigen::MatrixXd DynamicsParametrisation::LogEntriesByTheta(const Eigen::VectorXd& theta) const {
  Eigen::MatrixXd by_theta = Eigen::MatrixXd::Zero(kMaterialEntries, size());
  by_theta.leftCols(table_.size()) = table_.LogEntriesByTheta(theta.head(table_.size()));
  return by_theta;
}

Eigen::MatrixXd DynamicsParametrisation::DynamicsByTheta(const Eigen::VectorXd& theta) const {
  if (free_.empty()) return {};
  Eigen::MatrixXd by_theta = Eigen::MatrixXd::Zero(kDynamicsEntries + 3, size());
  MaterialField here = Material(theta);
  ForEach([&](FreeNumber number, Eigen::Index first) {
    static_assert(int(FreeNumber::kWind) == kByWind);
    const int row = number == FreeNumber::kVelocity ? kDynamicsEntries : static_cast<int>(number);
    if (IsVector(number))
      by_theta.block<3, 3>(row, first).setIdentity();
    else
      by_theta(row, first) = FindNumbers(number, here).front();
  });
  return by_theta;
}

Eigen::Vector3d DynamicsParametrisation::StartVelocity(const Eigen::VectorXd& theta) const {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  ForEach([&](FreeNumber number, Eigen::Index first) {
    if (number == FreeNumber::kVelocity) velocity = theta.segment<3>(first);
  });
  return velocity;
}

RowMatrix DynamicsParametrisation::Vjp(const MaterialField& material,
                                       const MaterialGradient& gradient) const {
  const RowMatrix of_table = table_.Vjp(material, gradient);
  RowMatrix all = RowMatrix::Zero(size(), of_table.cols());
  all.topRows(table_.size()) = of_table;
  return all;
}

MaterialField DynamicsParametrisation::Jvp(const MaterialField& material,
                                           const Eigen::VectorXd& change) const {
  return table_.Jvp(material, change.head(table_.size()));
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

double LargestSquaredCoupling(const StretchTable& table) {
  double largest = 0.0;
  for (const auto& row : table.c)
    largest = std::max(largest, row[kC12] * row[kC12] / (row[kC11] * row[kC22]));
  return largest;
}

StretchTable ApplyLogFactors(const StretchTable& base, const double* log_factors) {
  StretchTable table;
  for (int r = 0; r < kStretchRows; ++r) {
    const double *from = base.c[r], *eta = log_factors + r * kStretchCols;
    double* row = table.c[r];
    for (const Column c : {kC11, kC22, kC33}) row[c] = from[c] * std::exp(eta[c]);
    const double mean = 0.5 * (eta[kC11] + eta[kC22]), u = eta[kC12] - mean;
    // e^u/(1 + q·(e^u − 1)) without overflow.
    const double slack = 1.0 - CouplingShare(from, from);
    row[kC12] = from[kC12] * std::exp(mean) / (1.0 + slack * std::expm1(-u));
  }
  return table;
}

Eigen::VectorXd FindLogFactors(const StretchTable& base, const StretchTable& table) {
  Eigen::VectorXd log_factors(kStretchEntries);
  for (int r = 0; r < kStretchRows; ++r) {
    const double *from = base.c[r], *to = table.c[r];
    double* eta = log_factors.data() + r * kStretchCols;
    for (const Column c : {kC11, kC22, kC33}) eta[c] = std::log(to[c] / from[c]);
    eta[kC12] = 0.5 * (eta[kC11] + eta[kC22]);
    if (from[kC12] == 0.0 && to[kC12] == 0.0) continue;
    // The two shares are on the scale of the base's ρmax: u = logit(share) − logit(base's share).
    const double slack = 1.0 - CouplingShare(from, from), left = 1.0 - CouplingShare(from, to);
    eta[kC12] = std::log(to[kC12] / from[kC12] * slack / left);
  }
  return log_factors;
}

Eigen::VectorXd FindLogFactors(const MaterialField& base, const MaterialField& table) {
  Eigen::VectorXd factors(kMaterialEntries);
  factors.head(kStretchEntries) = FindLogFactors(base.stretch[0], table.stretch[0]);
  for (int i = 0; i < kBendEntries; ++i)
    factors[kStretchEntries + i] = std::log(table.bend[0].entries()[i] / base.bend[0].entries()[i]);
  return factors;
}

Eigen::VectorXd MeanLogFactors(const Eigen::MatrixXd& tie, const Eigen::VectorXd& log_factors) {
  return (tie.transpose() * log_factors).cwiseQuotient(tie.colwise().sum().transpose());
}

void PushLogFactors(const StretchTable& base, const StretchTable& table, double* change) {
  for (int r = 0; r < kStretchRows; ++r) {
    double* d = change + r * kStretchCols;
    const double share = CouplingShare(base.c[r], table.c[r]);
    d[kC12] = (1.0 - share) * d[kC12] + 0.5 * share * (d[kC11] + d[kC22]);
  }
}

void PullLogFactors(const StretchTable& base, const StretchTable& table, double* gradient) {
  for (int r = 0; r < kStretchRows; ++r) {
    double* g = gradient + r * kStretchCols;
    const double share = CouplingShare(base.c[r], table.c[r]);
    g[kC11] += 0.5 * share * g[kC12];
    g[kC22] += 0.5 * share * g[kC12];
    g[kC12] *= 1.0 - share;
  }
}

FieldParametrisation::FieldParametrisation(const MaterialField& base, int faces, int hinges,
                                           std::vector<FieldTerm> terms)
    : base_(base), terms_(std::move(terms)) {
  if (base.stretch.size() == 1) base_.stretch.assign(faces, base.stretch[0]);
  if (base.bend.size() == 1) base_.bend.assign(hinges, base.bend[0]);
  CHECK_EQ(base_.stretch.size(), faces);
  CHECK_EQ(base_.bend.size(), hinges);
  for (const FieldTerm& term : terms_) {
    CHECK_EQ(term.basis.rows(), CountElements(term.kind, base_));
    CHECK_EQ(term.tie.rows(), CountEntries(term.kind));
    size_ += term.size();
  }
}

RowMatrix FieldParametrisation::LogFactors(ElementKind kind, const Eigen::VectorXd& theta) const {
  CHECK_EQ(theta.size(), size());
  RowMatrix logs = RowMatrix::Zero(CountElements(kind, base_), CountEntries(kind));
  int first = 0;
  for (const FieldTerm& term : terms_) {
    if (term.kind == kind) {
      const Eigen::Map<const Eigen::MatrixXd> coefficients(theta.data() + first, term.basis.cols(),
                                                           term.tie.cols());
      logs += (term.basis * coefficients) * term.tie.transpose();
    }
    first += term.size();
  }
  return logs;
}

FieldTerm::Basis FieldParametrisation::MeanLogFactor(ElementKind kind) const {
  std::vector<Eigen::Triplet<double>> weights;
  int first = 0;
  for (const FieldTerm& term : terms_) {
    const auto modes = static_cast<int>(term.basis.cols());
    if (term.kind == kind)
      for (int g = 0; g < term.tie.cols(); ++g)
        for (int e = 0; e < term.basis.rows(); ++e)
          for (FieldTerm::Basis::InnerIterator at(term.basis, e); at; ++at)
            weights.emplace_back(e, first + g * modes + static_cast<int>(at.col()),
                                 term.tie.col(g).mean() * at.value());
    first += term.size();
  }
  FieldTerm::Basis mean(CountElements(kind, base_), size());
  mean.setFromTriplets(weights.begin(), weights.end());
  return mean;
}

MaterialField FieldParametrisation::Material(const Eigen::VectorXd& theta) const {
  MaterialField field = base_;
  const RowMatrix eta = LogFactors(ElementKind::kFaces, theta);
  for (std::size_t f = 0; f < field.stretch.size(); ++f)
    field.stretch[f] =
        ApplyLogFactors(base_.stretch[f], eta.row(static_cast<Eigen::Index>(f)).data());
  // Into aligned memory: which entries Eigen takes by the scalar exp, whose last bit differs,
  // depends on the address of the tables.
  const RowMatrix factors = LogFactors(ElementKind::kHinges, theta).array().exp();
  TableEntries(ElementKind::kHinges, field).array() *= factors.array();
  return field;
}

MaterialField FieldParametrisation::Jvp(const MaterialField& material,
                                        const Eigen::VectorXd& change) const {
  MaterialField direction = material;
  RowMatrix logs = LogFactors(ElementKind::kFaces, change);
  for (std::size_t f = 0; f < material.stretch.size(); ++f)
    PushLogFactors(base_.stretch[f], material.stretch[f],
                   logs.row(static_cast<Eigen::Index>(f)).data());
  TableEntries(ElementKind::kFaces, direction).array() *= logs.array();
  TableEntries(ElementKind::kHinges, direction).array() *=
      LogFactors(ElementKind::kHinges, change).array();
  return direction;
}

RowMatrix FieldParametrisation::Vjp(const MaterialField& material,
                                    const MaterialGradient& gradient) const {
  RowMatrix by_theta(size(), gradient.stretch.cols());
  const RowMatrix stretch = ByLogFactors(ElementKind::kFaces, base_, material, gradient.stretch);
  const RowMatrix bend = ByLogFactors(ElementKind::kHinges, base_, material, gradient.bend);
  int first = 0;
  for (const FieldTerm& term : terms_) {
    const RowMatrix& factors = term.kind == ElementKind::kFaces ? stretch : bend;
    const auto modes = term.basis.cols();
    for (int g = 0; g < term.tie.cols(); ++g, first += static_cast<int>(modes))
      by_theta.middleRows(first, modes) = term.basis.transpose() * GroupGradient(term, g, factors);
  }
  return by_theta;
}

}  // namespace drape
