// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <span>
#include <string>
#include <vector>

#include "physics/cloth/assembly/dynamics.h"
#include "physics/cloth/assembly/step_solver.h"
#include "physics/material/material.h"
#include "physics/util/options/field.h"

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
  // ∂(numbers of DynamicsEntry, then StartVelocity)/∂θ at θ, shape [10, P]; empty: θ does not
  // change them.
  virtual Eigen::MatrixXd DynamicsByTheta(const Eigen::VectorXd&) const { return {}; }
  // The part of θ in the velocity of all vertices where a motion begins [m/s].
  virtual Eigen::Vector3d StartVelocity(const Eigen::VectorXd&) const {
    return Eigen::Vector3d::Zero();
  }
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
inline bool FreesStretch(ParameterTying tying) {
  return tying != ParameterTying::kBendScale && tying != ParameterTying::kBendRows;
}
// The name of a tying is its number of parameters.
constexpr auto EnumNames(ParameterTying) {
  return MakeNames<ParameterTying>({{ParameterTying::kBendScale, "1"},
                                    {ParameterTying::kScales, "2"},
                                    {ParameterTying::kBendRows, "3"},
                                    {ParameterTying::kColumns, "7"},
                                    {ParameterTying::kEntries, "39"}});
}
// The T of a tying: ones and zeros, shape [39, P].
Eigen::MatrixXd TyingMatrix(ParameterTying tying);

// The tie of intervals [METHODS, P57]: its numbers, then in units of their prior what each free
// entry is off by within its column or row; shape [39, P + 39], or T where each entry is a number.
Eigen::MatrixXd TieWithForm(const Eigen::MatrixXd& tie, double prior_sigma);

// The name of number i of a tying: "stretch", "c11", "bend[2]", "c33[5]", "bend[2][4]".
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

// Numbers that may be free beside the tables, in the order of DynamicsEntry, then the velocity of
// all vertices where motions begin.
enum class FreeNumber { kDensity, kMassDamping, kStiffnessDamping, kAirDrag, kWind, kVelocity };
constexpr auto EnumNames(FreeNumber) {
  return MakeNames<FreeNumber>({{FreeNumber::kDensity, "density"},
                                {FreeNumber::kMassDamping, "mass_damping"},
                                {FreeNumber::kStiffnessDamping, "stiffness_damping"},
                                {FreeNumber::kAirDrag, "air_drag"},
                                {FreeNumber::kWind, "wind"},
                                {FreeNumber::kVelocity, "velocity"}});
}
inline bool IsVector(FreeNumber number) { return number >= FreeNumber::kWind; }
// Counts their numbers of θ: one, three of a vector.
int CountNumbers(const std::vector<FreeNumber>& free);
// Finds it in a material, shape [1] or [3]; empty for a velocity, which no material has.
std::span<double> FindNumbers(FreeNumber number, MaterialField& material);

// A table, and after its numbers those that are free: log factors on the base's, of which it has
// more than zero, and of a vector what is added to it [m/s].
class DynamicsParametrisation final : public MaterialParametrisation {
 public:
  DynamicsParametrisation(TableParametrisation table, std::vector<FreeNumber> free);

  int size() const override { return table_.size() + CountNumbers(free_); }
  MaterialField Material(const Eigen::VectorXd& theta) const override;
  bool has_one_table() const override { return table_.has_one_table(); }
  Eigen::MatrixXd LogEntriesByTheta(const Eigen::VectorXd& theta) const override;
  Eigen::MatrixXd DynamicsByTheta(const Eigen::VectorXd& theta) const override;
  Eigen::Vector3d StartVelocity(const Eigen::VectorXd& theta) const override;
  RowMatrix Vjp(const MaterialField& material, const MaterialGradient& gradient) const override;
  MaterialField Jvp(const MaterialField& material, const Eigen::VectorXd& change) const override;

 private:
  template <class Visit>
  void ForEach(const Visit& visit) const;

  TableParametrisation table_;
  std::vector<FreeNumber> free_;
};

// Stretch tables from log factors, so that a table resists all strains whatever the factors are
// [METHODS, P2]. A row resists where c11, c22, c33 > 0 and its coupling ρ = c12/√(c11·c22) is
// between −1 and 1. With the log factors η of a row on those of the base (index 0),
//   c11 = c11₀·e^η11, c22 = c22₀·e^η22, c33 = c33₀·e^η33,
//   ρ/(ρmax − ρ) = e^u·ρ₀/(ρmax − ρ₀),  u = η12 − (η11 + η22)/2,
// a logistic map of u onto couplings from 0 to ρmax, analytic everywhere: c12 = c12₀·e^η12 as for
// the other entries while ρ is small, and c12 < ρmax·√(c11·c22) always. Equal factors on all
// entries leave ρ as it is, and steps from a table with ρ₀ ≤ 0.98 add up: a table made from another
// has the sum of both log factors on the first base.
//
// A row of the base that does not resist (a stiffness that is not positive, |ρ₀| ≥ 1) has no such
// map: c12 = c12₀·e^η12 there.

// ρmax of bases with |ρ₀| ≤ 0.98: the softest membrane strain keeps a hundredth of the geometric
// mean of c11 and c22. (1 + |ρ₀|)/2 for a base closer to 1.
inline constexpr double kLargestCoupling = 0.99;

// The largest ρ² = c12²/(c11·c22) of the rows: 1 where a strain meets no resistance.
double LargestSquaredCoupling(const StretchTable& table);

// log_factors: η of the 24 entries, row by row.
StretchTable ApplyLogFactors(const StretchTable& base, const double* log_factors);

// The inverse: η with ApplyLogFactors(base, η) = table, shape [24]. Where c12 is zero in both, its
// η is that which leaves it zero, the mean of the row's η11 and η22. Not finite where no η gives
// the table: another sign, zero in one of them alone, or a coupling of ρmax or more.
Eigen::VectorXd FindLogFactors(const StretchTable& base, const StretchTable& table);

// The inverse for one table of each kind, shape [39]: a bend entry has the logarithm of the ratio.
Eigen::VectorXd FindLogFactors(const MaterialField& base, const MaterialField& table);
// The Jacobian by the numbers of a tie and by those after the table, shape [K, P + n], from that by
// the log entries and by those, shape [K, 39 + n].
Eigen::MatrixXd JacobianByTie(const Eigen::MatrixXd& by_entries, const Eigen::MatrixXd& tie);
// The means of log factors over the entries of each number of a tying T, shape [P]; the columns of
// T, shape [39, P], are ones and zeros.
Eigen::VectorXd MeanLogFactors(const Eigen::MatrixXd& tie, const Eigen::VectorXd& log_factors);

// Turns a change of η into the change of the log entries at `table`, which is
// ApplyLogFactors(base, η), in place, shape [24].
void PushLogFactors(const StretchTable& base, const StretchTable& table, double* change);

// The transpose, in place: gradient by the log entries → gradient by η.
void PullLogFactors(const StretchTable& base, const StretchTable& table, double* gradient);

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
