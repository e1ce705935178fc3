// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/posterior_table.h"

#include <glog/logging.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/posterior/posterior_io.h"

namespace drape {
namespace {

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

std::string Header(const FabricSamples& samples, const std::optional<StoredSamples>& own) {
  std::string text = ".chain,.iteration,.draw";
  for (const std::string& name : samples.names) text += ",log_factor[" + name + "]";
  for (const LinearNumber& number : LinearNumbers()) text += std::string(",") + number.key;
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
  row->push_back(likelihood.sum() + sample.log_prior);
  row->push_back(sample.log_density);
  row->insert(row->end(), likelihood.data(), likelihood.data() + likelihood.size());
}

}  // namespace

std::string PosteriorCsv(const FabricSource& source, const Law& law,
                         const PosteriorTableOptions& options) {
  CheckSource(source);
  CHECK_EQ(options.draws % options.chains, 0);
  CHECK_LE(options.chains, kNewDraws);
  const std::optional<StoredSamples> own = FindSamples(source, options);
  if (own) CheckImages(*own, source.path);
  const int new_draws = options.draws > 0 ? options.draws : kNewDraws - kNewDraws % options.chains;
  const FabricSamples samples = own ? SamplesAt(*source.posterior, LogFactors(*own))
                                    : SamplePosterior(*source.posterior, new_draws, options.seed);
  const auto count = static_cast<int>(samples.tables.size()), draws = count / options.chains;
  std::string text = Header(samples, own);
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
