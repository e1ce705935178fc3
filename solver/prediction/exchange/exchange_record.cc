// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/exchange_record.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <variant>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/posterior/posterior_io.h"
#include "solver/prediction/exchange/fabric_sheet.h"

namespace drape {
namespace {

// D of a hinge along row `row` of the table, at zero angle.
double RigidityOfRow(const Law& law, const BendTable& table, int row) {
  const Hinge hinge{.vertex = {},
                    .face = {},
                    .rest_length = 1.0,
                    .rest_area = 1.0,
                    .direction = static_cast<double>(row)};
  const double kappa = std::visit(
      [&](const auto& bend) { return HingeStiffness(bend, hinge, table, 0.0); }, law.bend);
  return kappa / HingeFactor(hinge) / kBendPerRigidity;
}

double RigidityInDrape(const BendTable& table, const Eigen::VectorXd& weights, int row,
                       double at_rest) {
  double sum = 0.0, weight = 0.0;
  for (int c = 0; c < kBendCols; ++c) {
    const double w = weights[kStretchEntries + row * kBendCols + c];
    sum += w * table.b[row][c];
    weight += w;
  }
  return weight > 0.0 ? sum / weight / kBendPerRigidity : at_rest;
}

using Json = nlohmann::ordered_json;

// What the fit states of each of LinearNumbers, in their order, since its drapes may name the
// directions otherwise; nothing for other fabrics.
std::optional<LaboratorySheet> FindSheet(const FabricSource& source, const Law& law) {
  if (source.kind == "field" || !std::filesystem::is_directory(source.path)) return std::nullopt;
  if (auto sheet = ReadSheet(source.path, "linear")) {
    if (sheet->rows.size() == LinearNumbers().size()) return sheet;
    throw InputError(source.path + "/summary.json: /laboratory/linear/rows",
                     "has " + std::to_string(sheet->rows.size()) + " rows, expected " +
                         std::to_string(LinearNumbers().size()));
  }
  if (!source.posterior || source.posterior->kind != PosteriorKind::kHierarchy) return std::nullopt;
  return MakeLinearSheet({.tables = source.material.field,
                          .law = law,
                          .weights = EqualStiffnessWeights(),
                          .density_is_given = true},
                         JudgeByPosterior(*source.posterior));
}

// known: the row of the fit, whose interval holds as shares of its value; null for other fabrics.
LaboratoryRow MakeNumber(const std::string& key, const char* unit, double value,
                         const LaboratoryRow* known) {
  LaboratoryRow row{
      .key = key, .name = key, .value = value, .unit = unit, .source = kOriginNotKnown};
  if (known == nullptr) return row;
  row.source = known->source;
  row.interval = known->interval;
  if (known->is_bound()) row.value = known->value;
  if (!known->interval || known->is_bound()) return row;
  row.interval->low *= value / known->value;
  row.interval->high *= value / known->value;
  return row;
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

namespace fs = std::filesystem;

constexpr int kNewDraws = 1000;

void CheckSource(const FabricSource& source) {
  if (!source.posterior)
    throw InputError(source.path, "has no posterior, expected a folder of drape_fit --model=bayes");
  if (source.posterior->kind != PosteriorKind::kHierarchy)
    throw InputError(source.path,
                     "has a posterior of kind bdp, whose deviations are a scatter over the cloth, "
                     "expected one of drape_fit --model=bayes");
}

// The samples that the fit has left, unless others are asked for.
std::optional<StoredSamples> FindSamples(const FabricSource& source,
                                         const PosteriorTableOptions& options) {
  if (options.draws > 0 || !fs::exists(source.path + "/" + kSamplesFile)) return {};
  StoredSamples samples = ReadSamples(source.path, source.posterior->size());
  if (static_cast<int>(samples.samples.size()) < options.chains)
    throw InputError(source.path + "/" + kSamplesFile,
                     "has " + std::to_string(samples.samples.size()) + " samples, expected " +
                         std::to_string(options.chains) + " chains of at least one; --draws=" +
                         std::to_string(kNewDraws) + " takes new samples, without outlines");
  samples.samples.resize(samples.samples.size() - samples.samples.size() % options.chains);
  return samples;
}

Eigen::MatrixXd LogFactors(const StoredSamples& samples) {
  Eigen::MatrixXd log_factors(samples.samples[0].log_factors.size(), samples.samples.size());
  for (Eigen::Index s = 0; s < log_factors.cols(); ++s)
    log_factors.col(s) = samples.samples[s].log_factors;
  return log_factors;
}

// The summary may be of another fit than the samples.
void CheckImages(const StoredSamples& samples, const std::string& folder) {
  const std::string path = folder + "/summary.json";
  if (!fs::exists(path)) return;
  const nlohmann::json summary = ReadJsonFile(path);
  const JsonInput input(summary, path);
  if (!input.Has("images")) return;
  const JsonInput images = input.At("images").ExpectArray();
  bool same = images.Size() == static_cast<int>(samples.images.size()) || images.Size() == 0;
  for (int i = 0; i < images.Size() && same; ++i)
    same = images.At(i).At("name").String() == samples.images[i].name;
  if (!same)
    throw InputError(folder + "/" + kSamplesFile,
                     "has other images than summary.json beside it, expected files of one fit");
}

DirectionNames DirectionsFor(const FabricSource& source, const LinearFabric& fabric) {
  return NameDirections(source.material.warp_known, fabric.bend_warp, fabric.bend_weft);
}

std::string Header(const FabricSamples& samples, const std::optional<StoredSamples>& own,
                   const DirectionNames& directions) {
  std::string text = ".chain,.iteration,.draw";
  for (const std::string& name : samples.names) text += ",log_factor[" + name + "]";
  for (const LinearNumber& number : LinearNumbers()) text += "," + NumberKey(number, directions);
  if (own) {
    text += ",lp__,lp_approx__";
    const size_t radii = own->images.size() * own->angles();
    for (size_t i = 1; i <= radii; ++i) text += ",log_lik[" + std::to_string(i) + "]";
  }
  return text + "\n";
}

void AddLikelihood(const StoredSamples& samples, const StoredSamples::Sample& sample,
                   std::vector<double>* row) {
  const Eigen::MatrixXd likelihood = samples.LogLikelihood(sample);
  row->push_back((samples.images.empty() ? sample.log_likelihood : likelihood.sum()) +
                 sample.log_prior);
  row->push_back(sample.log_density);
  row->insert(row->end(), likelihood.data(), likelihood.data() + likelihood.size());
}

}  // namespace

LinearFabric LineariseAtRest(const MaterialField& tables, const Law& law) {
  CHECK_EQ(tables.stretch.size(), 1u);
  CHECK_EQ(tables.bend.size(), 1u);
  double c[kStretchCols];
  std::visit(
      [&](const auto& stretch) {
        stretch.Stiffness(GreenStrain<double>{0.0, 0.0, 0.0}, tables.stretch[0], c);
      },
      law.stretch);
  return {.c11 = c[0],
          .c22 = c[2],
          .c12 = c[1],
          .shear = c[3] / 2.0,
          .bend_weft = RigidityOfRow(law, tables.bend[0], 2),
          .bend_warp = RigidityOfRow(law, tables.bend[0], 0),
          .bend_bias = RigidityOfRow(law, tables.bend[0], 1),
          .density = tables.density};
}

LinearFabric LineariseInDrape(const MaterialField& tables, const Law& law,
                              const Eigen::VectorXd& weights) {
  CHECK_EQ(weights.size(), kMaterialEntries);
  LinearFabric material = LineariseAtRest(tables, law);
  const BendTable& bend = tables.bend[0];
  material.bend_warp = RigidityInDrape(bend, weights, 0, material.bend_warp);
  material.bend_bias = RigidityInDrape(bend, weights, 1, material.bend_bias);
  material.bend_weft = RigidityInDrape(bend, weights, 2, material.bend_weft);
  return material;
}

MaterialField TablesFrom(const LinearFabric& material) {
  MaterialField field;
  field.density = material.density;
  field.stretch.resize(1);
  field.bend.resize(1);
  const double entries[kStretchCols] = {material.c11, material.c12, material.c22,
                                        2.0 * material.shear};
  const double rigidity[kBendRows] = {material.bend_warp, material.bend_bias, material.bend_weft};
  for (auto& row : field.stretch[0].c)
    for (int m = 0; m < kStretchCols; ++m) row[m] = entries[m] / kMembranePerEntry;
  for (int r = 0; r < kBendRows; ++r)
    for (double& entry : field.bend[0].b[r]) entry = kBendPerRigidity * rigidity[r];
  return field;
}

// The rows are linear in between, each over an eighth or a quarter of all directions.
double MeanRigidity(const LinearFabric& material) {
  return (material.bend_weft + 2.0 * material.bend_bias + material.bend_warp) / 4.0;
}

IsotropicSheet MakeIsotropic(const LinearFabric& material, IsotropicChoice choice) {
  const auto& [c11, c22, c12, shear, bend_weft, bend_warp, bend_bias, density] = material;
  const double along = (c11 + c22) / 2.0;
  switch (choice) {
    case IsotropicChoice::kNearest:
      break;
    case IsotropicChoice::kShear:
      return {.mu = shear, .lambda = std::max(0.0, along - 2.0 * shear)};
    case IsotropicChoice::kStretch:
      return {.mu = (along - c12) / 2.0, .lambda = c12};
  }
  const double lambda = (c11 + c22 + 6.0 * c12 - 4.0 * shear) / 8.0;
  if (lambda < 0.0) return {.mu = (c11 + c22 + 2.0 * shear) / 6.0, .lambda = 0.0};
  return {.mu = (c11 + c22 - 2.0 * c12 + 4.0 * shear) / 8.0, .lambda = lambda};
}

LinearFabric WithIsotropicMembrane(LinearFabric material, const IsotropicSheet& sheet) {
  material.c11 = material.c22 = sheet.lambda + 2.0 * sheet.mu;
  material.c12 = sheet.lambda;
  material.shear = sheet.mu;
  return material;
}

LinearFabric WithMeanRigidity(LinearFabric material) {
  material.bend_weft = material.bend_warp = material.bend_bias = MeanRigidity(material);
  return material;
}

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

std::string NumberKey(const LinearNumber& number, const DirectionNames& directions) {
  if (number.value == &LinearFabric::bend_warp) return "bend_" + directions.warp;
  if (number.value == &LinearFabric::bend_weft) return "bend_" + directions.weft;
  return number.key;
}

ExchangeRecord MakeRecord(const FabricSource& source, const Law& law,
                          const RecordOptions& options) {
  ExchangeRecord record;
  record.source = source;
  record.point = options.point;
  record.thickness = options.thickness;
  const MaterialField& tables = source.material.field;
  record.material = options.point == LinearPoint::kRest
                        ? LineariseAtRest(tables, law)
                        : LineariseInDrape(tables, law, options.weights);
  record.directions = DirectionsFor(source, record.material);
  const std::optional<LaboratorySheet> sheet = FindSheet(source, law);
  for (std::size_t i = 0; i < LinearNumbers().size(); ++i) {
    const LinearNumber& number = LinearNumbers()[i];
    record.numbers.push_back(MakeNumber(NumberKey(number, record.directions), number.unit,
                                        record.material.*number.value,
                                        sheet ? &sheet->rows[i] : nullptr));
  }
  return record;
}

Json RecordJson(const ExchangeRecord& record) {
  Json json = {{"format", "drapefit-exchange"},       {"version", 2},
               {"name", record.source.material.name}, {"units", "SI"},
               {"source", record.source.path},        {"linearised_at", ToString(record.point)}};
  for (const LaboratoryRow& number : record.numbers) json["linear"][number.key] = RowJson(number);
  json["directions"] = {record.directions.warp, record.directions.weft};
  json["density"] = {{"value", record.material.density}, {"unit", "kg/m2"}};
  json["thickness"] =
      record.thickness ? Json{{"value", *record.thickness}, {"unit", "m"}} : Json(nullptr);
  json["tables"] = TablesJson(record.source.material.field);
  return json;
}

std::string PosteriorCsv(const FabricSource& source, const Law& law,
                         const PosteriorTableOptions& options) {
  CheckSource(source);
  CHECK_EQ(options.draws % options.chains, 0);
  CHECK_LE(options.chains, kNewDraws);
  const std::optional<StoredSamples> own = FindSamples(source, options);
  if (own) CheckImages(*own, source.path);
  const int new_draws = options.draws > 0 ? options.draws : kNewDraws - kNewDraws % options.chains;
  const FabricSamples samples = own ? SamplesAt(*source.posterior, LogFactors(*own))
                                    : SampleFabric(*source.posterior, new_draws, options.seed);
  const auto count = static_cast<int>(samples.tables.size()), draws = count / options.chains;
  const LinearFabric median = LineariseAtRest(source.material.field, law);
  std::string text = Header(samples, own, DirectionsFor(source, median));
  for (int s = 0; s < count; ++s) {
    const auto factors = samples.log_factors.col(s);
    std::vector<double> row(factors.begin(), factors.end());
    const LinearFabric fabric = LineariseAtRest(samples.tables[s], law);
    for (const LinearNumber& number : LinearNumbers()) row.push_back(fabric.*number.value);
    if (own) AddLikelihood(*own, own->samples[s], &row);
    text += std::to_string(s / draws + 1) + "," + std::to_string(s % draws + 1) + "," +
            std::to_string(s + 1);
    for (const double value : row) AppendNumber(text += ",", value);
    text += "\n";
  }
  return text;
}

}  // namespace drape
