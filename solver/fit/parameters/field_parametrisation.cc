// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parameters/field_parametrisation.h"

#include <glog/logging.h>

#include <utility>

#include "solver/fit/parameters/coupled_table.h"

namespace drape {
namespace {

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
