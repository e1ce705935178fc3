// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parameters/field_parametrisation.h"

#include <glog/logging.h>

#include <utility>

namespace drape {
namespace {

using Entries = Eigen::Map<RowMatrix>;
using ConstEntries = Eigen::Map<const RowMatrix>;

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

// Σ over the entries of a group of entry · gradient, shape [elements, m].
RowMatrix GroupGradient(const FieldTerm& term, int group, const MaterialField& material,
                        const RowMatrix& gradient) {
  const int entries = CountEntries(term.kind), elements = CountElements(term.kind, material);
  const ConstEntries entry(ElementTables(term.kind, material), elements, entries);
  RowMatrix sum = RowMatrix::Zero(elements, gradient.cols());
  for (int e = 0; e < elements; ++e)
    for (int k = 0; k < entries; ++k)
      if (term.tie(k, group) != 0.0)
        sum.row(e) += term.tie(k, group) * entry(e, k) * gradient.row(e * entries + k);
  return sum;
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
  for (const ElementKind kind : {ElementKind::kFaces, ElementKind::kHinges}) {
    // Into aligned memory: which entries Eigen takes by the scalar exp, whose last bit differs,
    // depends on the address of the tables.
    const RowMatrix factors = LogFactors(kind, theta).array().exp();
    TableEntries(kind, field).array() *= factors.array();
  }
  return field;
}

MaterialField FieldParametrisation::Jvp(const MaterialField& material,
                                        const Eigen::VectorXd& change) const {
  MaterialField direction = material;
  for (const ElementKind kind : {ElementKind::kFaces, ElementKind::kHinges})
    TableEntries(kind, direction).array() *= LogFactors(kind, change).array();
  return direction;
}

RowMatrix FieldParametrisation::Vjp(const MaterialField& material,
                                    const MaterialGradient& gradient) const {
  RowMatrix by_theta(size(), gradient.stretch.cols());
  int first = 0;
  for (const FieldTerm& term : terms_) {
    const RowMatrix& entries = term.kind == ElementKind::kFaces ? gradient.stretch : gradient.bend;
    const auto modes = term.basis.cols();
    for (int g = 0; g < term.tie.cols(); ++g, first += static_cast<int>(modes))
      by_theta.middleRows(first, modes) =
          term.basis.transpose() * GroupGradient(term, g, material, entries);
  }
  return by_theta;
}

}  // namespace drape
