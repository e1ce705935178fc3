// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "solver/prediction/exchange/linear_fabric.h"
#include "solver/prediction/fabric_source.h"

namespace drape {

// A fabric on its way to another program: the one record that every target is written from.

// The strains and curvatures at which the linear numbers hold.
enum class LinearPoint {
  kRest,  // LineariseAtRest
  kDrape  // LineariseInDrape
};
constexpr auto EnumNames(LinearPoint) {
  return MakeNames<LinearPoint>({{LinearPoint::kRest, "rest"}, {LinearPoint::kDrape, "drape"}});
}

// A number of the record. sd and share are of fits with a posterior alone.
struct RecordedNumber {
  std::string key;           // "c11", "bend_weft"
  std::string unit;          // "N/m", "N m"
  double value = 0.0;        // of the exported tables: with a posterior its median
  std::optional<double> sd;  // standard deviation under the posterior
  // The share of the logarithm's prior variance that the fit has removed: at least
  // one half is called measured, less is from the prior.
  std::optional<double> share_removed;

  bool measured() const { return share_removed && *share_removed >= 0.5; }
};

struct ExchangeRecord {
  FabricSource source;
  LinearPoint point = LinearPoint::kRest;
  LinearFabric material;
  std::vector<RecordedNumber> numbers;
  std::optional<double> thickness;  // [m]
};

struct RecordOptions {
  LinearPoint point = LinearPoint::kRest;
  Eigen::VectorXd weights;  // kDrape: StiffnessWeights of its drapes, shape [39]
  std::optional<double> thickness;
  int samples = 2000;  // of posterior and prior, for sd and share
  uint64_t seed = 1;
};
ExchangeRecord MakeRecord(const FabricSource& source, const Law& law, const RecordOptions& options);

// {"format": "drapefit-exchange", "version": 1, "name", "units", "source", "linearised_at",
//  "linear": {"c11": {"value", "unit", "sd", "origin", "share_of_variance_removed"}, …},
//  "density", "thickness", "tables": {"convention": "mechanical", "stretch", "bend"}}.
nlohmann::ordered_json RecordJson(const ExchangeRecord& record);

// The numbers of a linear material by their keys, in the order of a record.
struct LinearNumber {
  const char* key;
  const char* unit;
  double LinearFabric::*value;
};
const std::vector<LinearNumber>& LinearNumbers();

}  // namespace drape
