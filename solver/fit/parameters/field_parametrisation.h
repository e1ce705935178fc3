// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "solver/fit/parameters/parametrisation.h"

namespace drape {

enum class ElementKind { kFaces, kHinges };  // with stretch tables; with bend tables

// A part of the log factors that varies over the elements of a kind:
//   log factor(e, k) += Σ_g tie(k, g) Σ_j basis(e, j) · θ_(g·J + j).
// The basis holds the prior standard deviations, so that θ has a unit prior.
struct FieldTerm {
  using Basis = Eigen::SparseMatrix<double, Eigen::RowMajor>;

  ElementKind kind = ElementKind::kFaces;
  Basis basis;          // shape [elements, J]
  Eigen::MatrixXd tie;  // which entries vary together, shape [24 or 15, G]

  int size() const { return static_cast<int>(basis.cols() * tie.cols()); }
};

// A table for each face and each hinge [METHODS, P4]: that of the base with log factors that are a
// sum of terms.
class FieldParametrisation final : public MaterialParametrisation {
 public:
  // base: one table or one each element. CHECKs that bases have a row for each of the elements.
  FieldParametrisation(const MaterialField& base, int faces, int hinges,
                       std::vector<FieldTerm> terms);

  int size() const override { return size_; }
  MaterialField Material(const Eigen::VectorXd& theta) const override;
  RowMatrix Vjp(const MaterialField& material, const MaterialGradient& gradient) const override;
  MaterialField Jvp(const MaterialField& material, const Eigen::VectorXd& change) const override;

  const std::vector<FieldTerm>& terms() const { return terms_; }
  // Log factors on the base's entries: shape [F, 24] and [E, 15].
  RowMatrix LogFactors(ElementKind kind, const Eigen::VectorXd& theta) const;
  // A with A·θ the mean of each element's log factors over its entries, shape [F or E, P].
  FieldTerm::Basis MeanLogFactor(ElementKind kind) const;

 private:
  MaterialField base_;  // a table for each element
  std::vector<FieldTerm> terms_;
  int size_ = 0;
};

}  // namespace drape
