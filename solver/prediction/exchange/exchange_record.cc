// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/exchange_record.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

struct Spread {
  double mean = 0.0, variance = 0.0;
};
Spread MeasureSpread(const std::vector<double>& values) {
  Spread spread;
  for (const double value : values) spread.mean += value / static_cast<double>(values.size());
  for (const double value : values)
    spread.variance += (value - spread.mean) * (value - spread.mean) /
                       static_cast<double>(std::max<size_t>(1, values.size() - 1));
  return spread;
}

using Linearise = std::function<LinearFabric(const MaterialField&)>;

std::vector<LinearFabric> LineariseAll(const FabricSamples& samples, const Linearise& linearise) {
  std::vector<LinearFabric> materials;
  materials.reserve(samples.tables.size());
  for (const MaterialField& tables : samples.tables) materials.push_back(linearise(tables));
  return materials;
}

std::vector<double> Values(const std::vector<LinearFabric>& materials, double LinearFabric::*value,
                           bool logarithm) {
  std::vector<double> values;
  values.reserve(materials.size());
  for (const LinearFabric& material : materials)
    values.push_back(logarithm ? std::log(material.*value) : material.*value);
  return values;
}

void AddUncertainty(const StoredPosterior& posterior, const RecordOptions& options,
                    const Linearise& linearise, std::vector<RecordedNumber>* numbers) {
  const auto after =
      LineariseAll(SamplePosterior(posterior, options.samples, options.seed), linearise);
  const auto before =
      LineariseAll(SamplePrior(posterior, options.samples, options.seed), linearise);
  for (size_t i = 0; i < numbers->size(); ++i) {
    const auto value = LinearNumbers()[i].value;
    RecordedNumber& number = (*numbers)[i];
    number.sd = std::sqrt(MeasureSpread(Values(after, value, false)).variance);
    if (!(number.value > 0.0)) continue;  // a zero stays zero: no logarithm
    const double prior = MeasureSpread(Values(before, value, true)).variance,
                 left = MeasureSpread(Values(after, value, true)).variance;
    number.share_removed = prior > 0.0 ? std::max(0.0, 1.0 - left / prior) : 0.0;
  }
}

Json NumberJson(const RecordedNumber& number, bool has_posterior) {
  Json json = {{"value", number.value}, {"unit", number.unit}};
  json["sd"] = number.sd ? Json(*number.sd) : Json(nullptr);
  json["origin"] = !has_posterior ? "not known" : number.measured() ? "measured" : "prior";
  json["share_of_variance_removed"] =
      number.share_removed ? Json(*number.share_removed) : Json(nullptr);
  return json;
}

Json TablesJson(const MaterialField& tables) {
  Json stretch = Json::array(), bend = Json::array();
  for (int r = 0; r < kStretchRows; ++r)
    for (int c = 0; c < kStretchCols; ++c)
      stretch[r][c] = kMembranePerEntry * tables.stretch[0].c[r][c];
  for (int r = 0; r < kBendRows; ++r)
    for (int c = 0; c < kBendCols; ++c) bend[r][c] = tables.bend[0].b[r][c] / kBendPerRigidity;
  return {{"convention", "mechanical"}, {"stretch", stretch}, {"bend", bend}};
}

}  // namespace

const std::vector<LinearNumber>& LinearNumbers() {
  static const std::vector<LinearNumber> numbers = {{"c11", "N/m", &LinearFabric::c11},
                                                    {"c22", "N/m", &LinearFabric::c22},
                                                    {"c12", "N/m", &LinearFabric::c12},
                                                    {"shear", "N/m", &LinearFabric::shear},
                                                    {"bend_weft", "N m", &LinearFabric::bend_weft},
                                                    {"bend_warp", "N m", &LinearFabric::bend_warp},
                                                    {"bend_bias", "N m", &LinearFabric::bend_bias}};
  return numbers;
}

ExchangeRecord MakeRecord(const FabricSource& source, const Law& law,
                          const RecordOptions& options) {
  const Linearise linearise = [&](const MaterialField& tables) {
    return options.point == LinearPoint::kRest ? LineariseAtRest(tables, law)
                                               : LineariseInDrape(tables, law, options.weights);
  };
  ExchangeRecord record;
  record.source = source;
  record.point = options.point;
  record.thickness = options.thickness;
  record.material = linearise(source.material.field);
  for (const LinearNumber& number : LinearNumbers())
    record.numbers.push_back({.key = number.key,
                              .unit = number.unit,
                              .value = record.material.*number.value,
                              .sd = {},
                              .share_removed = {}});
  if (source.posterior && source.posterior->kind == PosteriorKind::kHierarchy)
    AddUncertainty(*source.posterior, options, linearise, &record.numbers);
  return record;
}

Json RecordJson(const ExchangeRecord& record) {
  const bool has_posterior =
      record.source.posterior && record.source.posterior->kind == PosteriorKind::kHierarchy;
  Json json = {{"format", "drapefit-exchange"},       {"version", 1},
               {"name", record.source.material.name}, {"units", "SI"},
               {"source", record.source.path},        {"linearised_at", ToString(record.point)}};
  for (const RecordedNumber& number : record.numbers)
    json["linear"][number.key] = NumberJson(number, has_posterior);
  json["density"] = {{"value", record.material.density}, {"unit", "kg/m2"}};
  json["thickness"] =
      record.thickness ? Json{{"value", *record.thickness}, {"unit", "m"}} : Json(nullptr);
  json["tables"] = TablesJson(record.source.material.field);
  return json;
}

}  // namespace drape
