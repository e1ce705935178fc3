// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/posterior_data.h"

#include <glog/logging.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/build.h"
#include "solver/prediction/exchange/statistics/fabric_samples.h"
#include "solver/prediction/exchange/statistics/outline_data.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

NetcdfDimension Chains(int chains) { return {.name = "chain", .size = chains}; }
NetcdfDimension Draws(int draws) { return {.name = "draw", .size = draws}; }
NetcdfDimension Parameters(const std::string& name, const std::vector<std::string>& names) {
  return {.name = name, .size = static_cast<int>(names.size()), .labels = names};
}

std::vector<NetcdfDimension> SampleDimensions(const FabricSamples& samples, int chains) {
  const int draws = static_cast<int>(samples.tables.size()) / chains;
  return {Chains(chains),
          Draws(draws),
          Parameters("parameter", samples.names),
          {"strain", kStretchRows, {"zero", "0 deg", "22.5 deg", "45 deg", "67.5 deg", "90 deg"}},
          {"stiffness", kStretchCols, {"c11", "c12", "c22", "c33"}},
          {"edge", kBendRows, {"along weft", "45 deg", "along warp"}},
          {.name = "curvature", .size = kBendCols}};
}

// Chain after chain, as the samples come.
NetcdfGroup SampleGroup(const std::string& name, const FabricSamples& samples, int chains,
                        const Law& law) {
  NetcdfGroup group;
  group.name = name;
  group.dimensions = SampleDimensions(samples, chains);
  NetcdfVariable factor = {
      "log_factor", {"chain", "draw", "parameter"}, {}, "1", "log factor on the start tables"};
  NetcdfVariable stretch = {
      "stretch", {"chain", "draw", "strain", "stiffness"}, {}, "N/m", "membrane stiffness"};
  NetcdfVariable bend = {"bend",
                         {"chain", "draw", "edge", "curvature"},
                         {},
                         "N m",
                         "rigidity of hinges by the direction of their edges"};
  std::vector<NetcdfVariable> linear;
  for (const LinearNumber& number : LinearNumbers())
    linear.push_back({number.key, {"chain", "draw"}, {}, number.unit, "at zero strain"});
  for (size_t s = 0; s < samples.tables.size(); ++s) {
    const MaterialField& tables = samples.tables[s];
    for (const double value : samples.log_factors.col(static_cast<Eigen::Index>(s)))
      factor.values.push_back(value);
    for (int i = 0; i < kStretchEntries; ++i)
      stretch.values.push_back(kMembranePerEntry * tables.stretch[0].entries()[i]);
    for (int i = 0; i < kBendEntries; ++i)
      bend.values.push_back(tables.bend[0].entries()[i] / kBendPerRigidity);
    const LinearFabric fabric = LineariseAtRest(tables, law);
    for (size_t i = 0; i < linear.size(); ++i)
      linear[i].values.push_back(fabric.*LinearNumbers()[i].value);
  }
  group.variables = {std::move(factor), std::move(stretch), std::move(bend)};
  for (NetcdfVariable& variable : linear) group.variables.push_back(std::move(variable));
  group.attributes = {{"sampling",
                       "independent samples of a normal distribution of log factors; "
                       "R-hat and effective sample sizes say nothing about it"}};
  return group;
}

NetcdfGroup ConstantData(const StoredPosterior& posterior) {
  std::vector<std::string> names;
  for (int i = 0; i < posterior.size(); ++i) names.push_back(posterior.NameFor(i));
  const auto list = [](const auto& values) {
    return std::vector<double>(values.reshaped().begin(), values.reshaped().end());
  };
  return {.name = "constant_data",
          .dimensions = {Parameters("parameter", names), Parameters("parameter_bis", names)},
          .variables =
              {{"prior_sd",
                {"parameter"},
                list(posterior.prior_sd),
                "1",
                "standard deviation of a log factor in the prior"},
               {"posterior_mean", {"parameter"}, list(posterior.mean), "1", "mean of a log factor"},
               {"posterior_covariance",
                {"parameter", "parameter_bis"},
                list(posterior.covariance),
                "1",
                "covariance of the log factors"}},
          .attributes = {}};
}

// One number of each drape, along `dimensions`.
void AddDrapes(const std::vector<std::string>& dimensions, std::vector<double> coefficients,
               std::vector<double> nodes, NetcdfGroup* group) {
  group->variables.push_back(
      {"drape_coefficient", dimensions, std::move(coefficients), "1", "drape coefficient, 0 to 1"});
  group->variables.push_back({"nodes", dimensions, std::move(nodes), "1", "number of folds"});
}

// Empty where the summary of the fit has no images.
NetcdfGroup ObservedData(const std::string& folder) {
  NetcdfGroup group{.name = "observed_data", .dimensions = {}, .variables = {}, .attributes = {}};
  const std::string path = folder + "/summary.json";
  if (!fs::exists(path)) return group;
  const nlohmann::json summary = ReadJsonFile(path);
  const JsonInput input(summary, path);
  if (!input.Has("images")) return group;
  const JsonInput images = input.At("images").ExpectArray();
  std::vector<std::string> names;
  std::vector<double> coefficients, nodes;
  for (int i = 0; i < images.Size(); ++i) {
    const JsonInput image = images.At(i), metrics = image.At("metrics");
    names.push_back(image.At("name").String());
    coefficients.push_back(metrics.At("dc_image").Number());
    nodes.push_back(metrics.At("folds_image").Number());
  }
  if (names.empty()) return group;
  group.dimensions = {Parameters("image", names)};
  AddDrapes({"image"}, std::move(coefficients), std::move(nodes), &group);
  return group;
}

// The drapes at rest of a folder of drape_predict, in one chain.
NetcdfGroup PredictedDrapes(const std::string& folder) {
  const std::string path = folder + "/summary.json";
  const nlohmann::json summary = ReadJsonFile(path);
  const JsonInput input(summary, path);
  const JsonInput drapes = input.At("drapes").ExpectArray();
  std::vector<double> coefficients, nodes;
  for (int i = 0; i < drapes.Size(); ++i) {
    const JsonInput drape = drapes.At(i);
    if (!drape.Has("dc")) continue;
    coefficients.push_back(drape.At("dc").Number());
    nodes.push_back(drape.At("folds").Number());
  }
  if (coefficients.empty()) drapes.Fail("a drape that came to rest");
  NetcdfGroup group{.name = "predictions",
                    .dimensions = {Chains(1), Draws(static_cast<int>(coefficients.size()))},
                    .variables = {},
                    .attributes = {{"source", folder}}};
  AddDrapes({"chain", "draw"}, std::move(coefficients), std::move(nodes), &group);
  return group;
}

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
                                         const PosteriorDataOptions& options) {
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

NetcdfAttributes FileAttributes(const std::optional<StoredSamples>& samples) {
  NetcdfAttributes attributes = {{"inference_library", "drapefit"},
                                 {"inference_library_version", BuildVersion()},
                                 {"creation_library", "drapefit"},
                                 {"creation_library_version", BuildVersion()},
                                 {"creation_library_language", "C++"}};
  if (samples)
    attributes.emplace_back("samples", "those of the fit's " + std::to_string(samples->drawn) +
                                           " whose drapes are stable, without those that do not "
                                           "fill the chains");
  else
    attributes.emplace_back("log_likelihood", "none: these samples have no drapes");
  return attributes;
}

// The summary may be of another fit than the samples.
void CheckImages(const NetcdfGroup& observed, const StoredSamples& samples,
                 const std::string& folder) {
  if (observed.dimensions.empty()) return;
  std::vector<std::string> names;
  for (const StoredSamples::Image& image : samples.images) names.push_back(image.name);
  if (observed.dimensions[0].labels != names)
    throw InputError(folder + "/" + kSamplesFile,
                     "has other images than summary.json beside it, expected files of one fit");
}

// What only the fit's own samples have.
void AddOutlines(const StoredSamples& samples, const PosteriorDataOptions& options,
                 std::vector<NetcdfGroup>* groups) {
  for (NetcdfGroup& group : *groups) {
    if (group.name == "posterior") AddSampleOutlines(samples, &group);
    if (group.name == "constant_data") AddSigma(samples, &group);
    if (group.name == "observed_data") AddObservedOutlines(samples, &group);
  }
  for (NetcdfGroup& group : OutlineGroups(samples, options.chains, options.seed))
    groups->push_back(std::move(group));
}

const NetcdfGroup* FindGroup(const PosteriorData& data, const char* name) {
  for (const NetcdfGroup& group : data.groups)
    if (group.name == name) return &group;
  return nullptr;
}

// A column of the table: a number of each sample, every `stride`-th of `values` from `first` on.
struct Column {
  std::string name;
  const std::vector<double>* values;
  size_t first, stride;
};

// log_lik[i] of all radii, and the log densities.
void AddLikelihoodColumns(const PosteriorData& data, size_t samples, std::vector<Column>* columns) {
  const NetcdfGroup* stats = FindGroup(data, kSampleStatsGroup);
  const NetcdfGroup* likelihood = FindGroup(data, kLogLikelihoodGroup);
  if (stats == nullptr || likelihood == nullptr) return;
  for (const NetcdfVariable& variable : stats->variables)
    columns->push_back({variable.name + "__", &variable.values, 0, 1});
  const std::vector<double>& values = likelihood->variables.front().values;
  const size_t points = values.size() / samples;
  for (size_t i = 0; i < points; ++i)
    columns->push_back({"log_lik[" + std::to_string(i + 1) + "]", &values, i, points});
}

}  // namespace

PosteriorData CollectPosterior(const FabricSource& source, const Law& law,
                               const PosteriorDataOptions& options) {
  CheckSource(source);
  CHECK_EQ(options.draws % options.chains, 0);
  CHECK_LE(options.chains, kNewDraws);
  const StoredPosterior& posterior = *source.posterior;
  const std::optional<StoredSamples> own = FindSamples(source, options);
  const int draws = options.draws > 0 ? options.draws : kNewDraws - kNewDraws % options.chains;
  PosteriorData data;
  data.attributes = FileAttributes(own);
  data.groups = {
      SampleGroup("posterior",
                  own ? SamplesAt(posterior, LogFactors(*own))
                      : SamplePosterior(posterior, draws, options.seed),
                  options.chains, law),
      SampleGroup("prior", SamplePrior(posterior, draws, options.seed), options.chains, law),
      ConstantData(posterior)};
  NetcdfGroup observed = ObservedData(source.path);
  if (own) CheckImages(observed, *own, source.path);
  if (own || !observed.variables.empty()) data.groups.push_back(std::move(observed));
  if (own) AddOutlines(*own, options, &data.groups);
  if (!options.prediction.empty()) data.groups.push_back(PredictedDrapes(options.prediction));
  for (NetcdfGroup& group : data.groups)
    group.attributes.insert(group.attributes.end(), data.attributes.begin(), data.attributes.end());
  return data;
}

std::string DrawsCsv(const PosteriorData& data) {
  const NetcdfGroup& group = data.groups.front();
  const int chains = group.dimensions[0].size, draws = group.dimensions[1].size;
  const std::vector<std::string>& names = group.dimensions[2].labels;
  std::vector<Column> columns;
  for (size_t i = 0; i < names.size(); ++i)
    columns.push_back(
        {"log_factor[" + names[i] + "]", &group.variables.front().values, i, names.size()});
  for (const NetcdfVariable& variable : group.variables)
    if (variable.dimensions.size() == 2) columns.push_back({variable.name, &variable.values, 0, 1});
  AddLikelihoodColumns(data, static_cast<size_t>(chains) * draws, &columns);
  std::string text = ".chain,.iteration,.draw";
  for (const Column& column : columns) text += "," + column.name;
  text += "\n";
  for (int s = 0; s < chains * draws; ++s) {
    text += std::to_string(s / draws + 1) + "," + std::to_string(s % draws + 1) + "," +
            std::to_string(s + 1);
    for (const Column& column : columns) {
      text += ",";
      AppendNumber(text, (*column.values)[column.first + column.stride * s]);
    }
    text += "\n";
  }
  return text;
}

}  // namespace drape
