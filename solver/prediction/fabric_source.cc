// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/fabric_source.h"

#include <glog/logging.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/field_fit.h"
#include "solver/posterior/variational_fit.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// Separate the samples from one another, and from the start shapes, which follow from the same
// seed.
constexpr uint64_t kMaterialStream = 0x6d6174, kPosteriorStream = 0x706f7374,
                   kPriorStream = 0x7072696f;

uint64_t SeedOfSpecimen(uint64_t seed, int specimen) {
  return SeedOfStream(SeedOfStream(seed, kMaterialStream), static_cast<uint64_t>(specimen));
}

MaterialSource HierarchySamples(const StoredPosterior& posterior, uint64_t seed) {
  const int n = posterior.num_fabric();
  const TableParametrisation table(posterior.base, posterior.fabric);
  const Eigen::VectorXd mean = posterior.mean.head(n);
  const Eigen::MatrixXd root = CovarianceRoot(posterior.covariance.topLeftCorner(n, n));
  Eigen::Vector2d sd = Eigen::Vector2d::Zero();  // of a specimen's stretch and bend
  if (posterior.specimens > 0) sd = posterior.prior_sd.segment<2>(n);
  return [=](int specimen) {
    std::mt19937_64 random(SeedOfSpecimen(seed, specimen));
    Eigen::VectorXd noise(n);
    for (double& value : noise) value = SampleNormal(random);
    const double stretch = sd[0] * SampleNormal(random), bend = sd[1] * SampleNormal(random);
    return Scaled(table.Material(mean + root * noise), std::exp(stretch), std::exp(bend));
  };
}

MaterialSource ElementwiseSamples(const StoredPosterior& posterior, const Mesh& mesh,
                                  uint64_t seed) {
  const auto shared = std::make_shared<const Mesh>(mesh);
  Eigen::VectorXd theta(2 * kMaterialEntries);
  theta << posterior.mean, posterior.element_sd;
  return [=, base = posterior.base](int specimen) {
    std::vector<FieldTerm> terms = CommonTerms(*shared, 1.0);
    for (FieldTerm& term : NoiseTerms(*shared, 1.0, SeedOfSpecimen(seed, specimen)))
      terms.push_back(std::move(term));
    const FieldParametrisation field(base, shared->num_faces(), shared->num_hinges(),
                                     std::move(terms));
    return field.Material(theta);
  };
}

// Returns whether the last fit of a folder has a posterior: files of an earlier fit may lie beside
// those of the last, which the summary is of.
bool HasPosterior(const std::string& folder) {
  if (!fs::is_directory(folder)) return false;
  const std::string summary = folder + "/summary.json";
  if (fs::exists(summary)) return ReadJsonFile(summary).contains("posterior");
  return fs::exists(folder + "/posterior.json");
}

FabricSamples SampleLogFactors(const StoredPosterior& posterior, const Eigen::VectorXd& mean,
                               const Eigen::MatrixXd& covariance, int count, uint64_t seed) {
  CHECK_GE(count, 1);
  return SamplesAt(
      posterior,
      (CovarianceRoot(covariance) * IndependentSamples(posterior.size(), count, seed)).colwise() +
          mean);
}

}  // namespace

FabricSource ReadFabric(const std::string& path, const MaterialPolicy& policy, const Mesh* mesh) {
  FabricSource fabric;
  fabric.path = path;
  if (!HasPosterior(path)) {
    fabric.material =
        mesh == nullptr ? ReadMaterial(path, policy) : ReadMaterialFor(*mesh, path, policy);
    fabric.kind = fabric.material.field.stretch.size() == 1 ? "table" : "field";
    return fabric;
  }
  fabric.posterior = ReadPosterior(path, policy);
  fabric.kind = ToString(fabric.posterior->kind);
  fabric.material.field = MedianTables(*fabric.posterior);
  const fs::path folder = fs::weakly_canonical(path);
  fabric.material.name =
      (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  return fabric;
}

MaterialSource MakeSpecimens(const FabricSource& fabric, const Mesh& mesh, uint64_t seed) {
  if (!fabric.posterior) return [field = fabric.material.field](int) { return field; };
  return fabric.posterior->kind == PosteriorKind::kHierarchy
             ? HierarchySamples(*fabric.posterior, seed)
             : ElementwiseSamples(*fabric.posterior, mesh, seed);
}

FabricSamples SamplesAt(const StoredPosterior& posterior, Eigen::MatrixXd log_factors) {
  CHECK(posterior.kind == PosteriorKind::kHierarchy);
  CHECK_EQ(log_factors.rows(), posterior.size());
  FabricSamples samples;
  for (int i = 0; i < posterior.size(); ++i) samples.names.push_back(posterior.NameFor(i));
  samples.log_factors = std::move(log_factors);
  const TableParametrisation table(posterior.base, posterior.fabric);
  samples.tables.reserve(samples.log_factors.cols());
  for (const auto& sample : samples.log_factors.colwise())
    samples.tables.push_back(table.Material(sample.head(posterior.num_fabric())));
  return samples;
}

FabricSamples SamplePosterior(const StoredPosterior& posterior, int count, uint64_t seed) {
  return SampleLogFactors(posterior, posterior.mean, posterior.covariance, count,
                          SeedOfStream(seed, kPosteriorStream));
}

FabricSamples SamplePrior(const StoredPosterior& posterior, int count, uint64_t seed) {
  const int n = posterior.num_fabric();
  Eigen::MatrixXd covariance = posterior.prior_sd.cwiseAbs2().asDiagonal();
  covariance.topLeftCorner(n, n) = posterior.FabricPrior();
  return SampleLogFactors(posterior, Eigen::VectorXd::Zero(posterior.size()), covariance, count,
                          SeedOfStream(seed, kPriorStream));
}

MaterialField MedianTables(const StoredPosterior& posterior) {
  return TableParametrisation(posterior.base, posterior.fabric)
      .Material(posterior.mean.head(posterior.num_fabric()));
}

}  // namespace drape
