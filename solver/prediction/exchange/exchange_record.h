// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/metrics/laboratory_drape.h"
#include "physics/material/laws/law.h"
#include "physics/material/material.h"
#include "physics/util/options/field.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/prediction/prediction.h"

namespace drape {

// A fabric as other simulators take it: one stiffness for all strains and curvatures
// [METHODS, P70]. Directions are those of a laboratory: bending along the weft is that of hinges
// whose edges lie along the warp, row 2 of a bend table; bending along the warp is row 0.
struct LinearFabric {
  double c11 = 0.0, c22 = 0.0, c12 = 0.0;  // membrane stiffness: weft, warp, coupling [N/m]
  double shear = 0.0;                      // G = c33/2, by the angle of shear [N/m]
  double bend_weft = 0.0, bend_warp = 0.0, bend_bias = 0.0;  // rigidity D of the hinges [N·m]
  double density = 0.0;                                      // [kg/m²]
};

// The tangent of the tables at zero strain and the rigidity at zero curvature, as the law sees
// them. `tables` has one table of each kind.
LinearFabric LineariseAtRest(const MaterialField& tables, const Law& law);

// The same membrane, and for each direction the rigidity that has the same bending energy in the
// drapes of `weights` (StiffnessWeights, shape [39]); a direction in which they do not bend keeps
// its rigidity at zero curvature.
LinearFabric LineariseInDrape(const MaterialField& tables, const Law& law,
                              const Eigen::VectorXd& weights);

// The tables that mean the same here: constant over strain and curvature.
MaterialField TablesFrom(const LinearFabric& material);

// The mean rigidity over all directions of the hinges, which is that of an isotropic sheet [N·m].
double MeanRigidity(const LinearFabric& material);

// What an isotropic sheet keeps of a fabric that is not: of its two numbers, or the least
// difference of both.
enum class IsotropicChoice { kNearest, kShear, kStretch };
constexpr auto EnumNames(IsotropicChoice) {
  return MakeNames<IsotropicChoice>({{IsotropicChoice::kNearest, "nearest"},
                                     {IsotropicChoice::kShear, "shear"},
                                     {IsotropicChoice::kStretch, "stretch"}});
}

// The Lamé numbers of a sheet by length of section [N/m]: c11 = c22 = λ + 2μ, c12 = λ, G = μ.
struct IsotropicSheet {
  double mu = 0.0, lambda = 0.0;
};
// kNearest: the least squares over the entries of the stiffness tensor, with c12 and G counted
// twice and four times. kShear: mean of c11 and c22, and G. kStretch: that mean, and c12. λ is at
// least 0, as the programs that take it expect.
IsotropicSheet MakeIsotropic(const LinearFabric& material, IsotropicChoice choice);
// `material` with the membrane of that sheet, and with its mean rigidity in all directions.
LinearFabric WithIsotropicMembrane(LinearFabric material, const IsotropicSheet& sheet);
LinearFabric WithMeanRigidity(LinearFabric material);

// A fabric on its way to another program: the one record that every target is written from.

// The strains and curvatures at which the linear numbers hold.
enum class LinearPoint {
  kRest,  // LineariseAtRest
  kDrape  // LineariseInDrape
};
constexpr auto EnumNames(LinearPoint) {
  return MakeNames<LinearPoint>({{LinearPoint::kRest, "rest"}, {LinearPoint::kDrape, "drape"}});
}

struct ExchangeRecord {
  FabricSource source;
  LinearPoint point = LinearPoint::kRest;
  LinearFabric material;
  DirectionNames directions;
  // Rows of LinearNumbers with their NumberKey: the exported value, and the interval and origin
  // that the fit states (MakeLinearSheet), or JudgeByPosterior where a posterior has no fit.
  std::vector<LaboratoryRow> numbers;
  std::optional<double> thickness;  // [m]
};

struct RecordOptions {
  LinearPoint point = LinearPoint::kRest;
  Eigen::VectorXd weights;  // kDrape: StiffnessWeights of its drapes, shape [39]
  std::optional<double> thickness;
};
// Throws InputError for a summary of the fit that cannot be read.
ExchangeRecord MakeRecord(const FabricSource& source, const Law& law, const RecordOptions& options);

// {"format": "drapefit-exchange", "version": 2, "name", "units", "source", "linearised_at",
//  "linear": {"c11": RowJson, …}, "directions": ["warp", "weft"] or their names, "density",
//  "thickness", "tables": {"convention": "mechanical", "stretch", "bend"}}.
nlohmann::ordered_json RecordJson(const ExchangeRecord& record);

// The numbers of a linear material by their keys, in the order of a record.
struct LinearNumber {
  const char* key;
  const char* unit;
  double LinearFabric::*value;
};
const std::vector<LinearNumber>& LinearNumbers();
// Its key where the directions have these names: "bend_warp", "bend_softer".
std::string NumberKey(const LinearNumber& number, const DirectionNames& directions);

struct PosteriorTableOptions {
  // Samples in all, a multiple of chains; 0: the samples of the fit with their outlines
  // (samples.json), as many as fill the chains, or 1000 where the fit has none.
  int draws = 0;
  int chains = 1;  // the samples are independent: chains divide them for readers that want some
  uint64_t seed = 1;
};

// Samples of the posterior of a fit as a table in CSV: .chain, .iteration and .draw, from 1, as R's
// posterior has them, then the log factors and the linear numbers at rest. The fit's own samples
// also have lp__ = ln p(r | u) + ln p(u) and lp_approx__ = ln q(u) of the latent numbers u, whose
// difference is the log weight of a sample, and log_lik[i], the ln of the density of each observed
// radius, image after image, as R's loo takes them. Throws InputError where the source has no
// posterior of kind hierarchy, for samples that cannot be read, that do not fill the chains, or
// that have other images than the summary of the fit.
std::string PosteriorCsv(const FabricSource& source, const Law& law,
                         const PosteriorTableOptions& options);

}  // namespace drape
