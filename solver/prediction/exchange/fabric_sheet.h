// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "losses/metrics/laboratory_drape.h"
#include "physics/material/laws/law.h"
#include "physics/material/material.h"
#include "solver/posterior/posterior_io.h"

namespace drape {

// A fabric as textile laboratories report it [METHODS, P71]: bending rigidity and bending length by
// direction, shear rigidity, and what FAST and KES-FB would read.

// The logarithm of a quantity of tables of one entry for the whole cloth.
using LogQuantity = std::function<double(const MaterialField& tables)>;

// The deformation that a quantity resists. It decides which tests can have measured the quantity.
enum class Resistance { kBending, kStretching };

// How well a quantity is known: its 90 % interval, as shares of its value, and whether the data
// have narrowed that of the prior. None where the model does not vary the quantity.
struct KnownTo {
  double low = 1.0, high = 1.0;
  bool determined = false;
};
using Judgement = std::function<std::optional<KnownTo>(const LogQuantity&, Resistance)>;

// Judges by samples of a posterior of kind hierarchy. A quantity is determined where the fit has
// removed at least half of the variance of its logarithm in the prior, as in an ExchangeRecord;
// stretching only where strips have measured it, since no silhouette does (P57). bend_deviation:
// standard deviation of the logarithm of a rigidity, the model's error beside the posterior's.
Judgement JudgeByPosterior(const StoredPosterior& posterior, bool stretch_measured,
                           double bend_deviation = 0.0);

struct FabricSheetInput {
  MaterialField tables;  // one of each kind
  Law law;
  Eigen::VectorXd weights;  // StiffnessWeights of the fitted drapes, shape [39]
  bool density_is_given = false;
};
// Rigidities are those in the drapes (LineariseInDrape); stretching and shear are those at zero
// strain, of a strip that is free to contract, and extensions are taken as linear, up to the
// largest that the instrument reads. "measured" is a bending rigidity or length of one direction
// only if the data also determine the ratio of the two. Of a fabric whose weight is not known the
// bending lengths are measured, and the rigidities as far as the assumed weight is right.
LaboratorySheet MakeFabricSheet(const FabricSheetInput& input, const Judgement& judge);

}  // namespace drape
