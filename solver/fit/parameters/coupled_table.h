// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/material/material.h"

namespace drape {

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

// The same of one table of each kind, shape [39]; of bend the logarithm of the ratio.
Eigen::VectorXd FindLogFactors(const MaterialField& base, const MaterialField& table);
// Their means over the entries that each number of a tying T is on, shape [P]; the columns of T,
// shape [39, P], are ones and zeros.
Eigen::VectorXd MeanLogFactors(const Eigen::MatrixXd& tie, const Eigen::VectorXd& log_factors);

// In place, shape [24]: a change of η becomes the change of the log entries at `table`, which is
// ApplyLogFactors(base, η).
void PushLogFactors(const StretchTable& base, const StretchTable& table, double* change);

// The transpose, in place: gradient by the log entries → gradient by η.
void PullLogFactors(const StretchTable& base, const StretchTable& table, double* gradient);

}  // namespace drape
