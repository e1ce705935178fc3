// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "physics/cloth/assembly/material_sensitivity.h"
#include "physics/util/options/enum_names.h"

namespace drape {

// A map from optimisation variables θ, shape [P], to the tables of a cloth. The log factors η of
// the entries on a base are linear functions of θ. An entry is its base value times e^η, so signs
// are kept and no bound is needed; c12 is bounded by c11 and c22 (ApplyLogFactors), so that every
// table resists all strains if the base does.
class MaterialParametrisation {
 public:
  virtual ~MaterialParametrisation() = default;

  virtual int size() const = 0;
  virtual MaterialField Material(const Eigen::VectorXd& theta) const = 0;
  // Whether one table serves all elements; LogEntriesByTheta CHECKs it.
  virtual bool has_one_table() const { return false; }
  // ∂(log entries)/∂θ at θ, shape [39, P].
  virtual Eigen::MatrixXd LogEntriesByTheta(const Eigen::VectorXd& theta) const;
  // ∂L/∂θ of m scalars, shape [P, m], from their gradients by each entry of `material`, which is
  // Material(θ).
  virtual RowMatrix Vjp(const MaterialField& material, const MaterialGradient& gradient) const = 0;
  // The change of each entry of `material`, which is Material(θ), to first order in a change of θ.
  virtual MaterialField Jvp(const MaterialField& material, const Eigen::VectorXd& change) const = 0;
};

// How many numbers of a fabric are free [METHODS, P3].
enum class ParameterTying {
  kBendScale,  // 1: one factor on all bend entries; stretch stays as it is
  kBendRows,   // 3: one for each bend row; stretch stays as it is
  kScales,     // 2: one factor on all stretch entries, one on all bend entries
  kColumns,    // 7: one for each of c11 c12 c22 c33, one for each bend row
  kEntries     // 39: each entry
};
inline constexpr ParameterTying kParameterTyings[] = {
    ParameterTying::kBendScale, ParameterTying::kBendRows, ParameterTying::kScales,
    ParameterTying::kColumns, ParameterTying::kEntries};
inline bool FreesStretch(ParameterTying tying) {
  return tying != ParameterTying::kBendScale && tying != ParameterTying::kBendRows;
}
// By its number of parameters.
constexpr auto EnumNames(ParameterTying) {
  return MakeNames<ParameterTying>({{ParameterTying::kBendScale, "1"},
                                    {ParameterTying::kScales, "2"},
                                    {ParameterTying::kBendRows, "3"},
                                    {ParameterTying::kColumns, "7"},
                                    {ParameterTying::kEntries, "39"}});
}
// The T of a tying: ones and zeros, shape [39, P].
Eigen::MatrixXd TyingMatrix(ParameterTying tying);

// Of number i of a tying: "stretch", "c11", "bend[2]", "c33[5]", "bend[2][4]".
std::string NameFor(ParameterTying tying, int i);

// One table for the whole cloth, with log factors η = T·θ. A base of a table for each element keeps
// them, with the same factors on all.
class TableParametrisation final : public MaterialParametrisation {
 public:
  TableParametrisation(MaterialField base, ParameterTying tying);
  // tie: T, shape [39, P].
  TableParametrisation(MaterialField base, Eigen::MatrixXd tie);

  int size() const override { return static_cast<int>(tie_.cols()); }
  MaterialField Material(const Eigen::VectorXd& theta) const override;
  bool has_one_table() const override;
  Eigen::MatrixXd LogEntriesByTheta(const Eigen::VectorXd& theta) const override;
  RowMatrix Vjp(const MaterialField& material, const MaterialGradient& gradient) const override;
  MaterialField Jvp(const MaterialField& material, const Eigen::VectorXd& change) const override;

  const MaterialField& base() const { return base_; }
  const Eigen::MatrixXd& tie() const { return tie_; }

 private:
  MaterialField base_;
  Eigen::MatrixXd tie_;
};

}  // namespace drape
