// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/material_source.h"

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "physics/material/material_field_io.h"
#include "physics/material/material_scaling.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "solver/fit/protocol/field_fit.h"
#include "solver/posterior/variational_fit.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// Separates the samples from the start shapes, which follow from the same seed.
constexpr uint64_t kMaterialStream = 0x6d6174;

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

}  // namespace

// Files of an earlier fit may lie beside those of the last, which the summary is of.
bool HasPosterior(const std::string& folder) {
  const std::string summary = folder + "/summary.json";
  if (fs::exists(summary)) return ReadJsonFile(summary).contains("posterior");
  return fs::exists(folder + "/posterior.json");
}

MaterialSource MakePosteriorSource(const StoredPosterior& posterior, const Mesh& mesh,
                                   uint64_t seed) {
  return posterior.kind == PosteriorKind::kHierarchy ? HierarchySamples(posterior, seed)
                                                     : ElementwiseSamples(posterior, mesh, seed);
}

MaterialSource ReadMaterialSource(const std::string& folder_or_file, const ClothModel& model,
                                  uint64_t seed, std::string* kind) {
  const MaterialPolicy policy = {model.law.rejects_negative_entries() ? NegativeEntries::kReject
                                                                      : NegativeEntries::kWarn};
  std::string file = folder_or_file;
  if (fs::is_directory(file)) {
    if (HasPosterior(file)) {
      const StoredPosterior posterior = ReadPosterior(file, policy);
      if (kind != nullptr) *kind = ToString(posterior.kind);
      return MakePosteriorSource(posterior, model.mesh, seed);
    }
    file += "/material.json";
    if (!fs::exists(file))
      throw InputError(folder_or_file,
                       "found neither posterior.json nor material.json, expected the results of "
                       "drape_fit");
  }
  MaterialField field = ReadMaterialFor(model.mesh, file, policy).field;
  if (kind != nullptr) *kind = field.stretch.size() == 1 ? "table" : "field";
  return [field](int) { return field; };
}

}  // namespace drape
