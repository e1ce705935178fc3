// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/space/fabric_belief.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "physics/material/material_scaling.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/fit/parametrisation.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// Of a log factor that the free numbers must reproduce.
constexpr double kRounding = 1e-6;
// Standard deviation of a table that is known, in log units.
constexpr double kPointDeviation = 1e-6;

// The entries as they count: by drape those of a cloth of that density.
MaterialField AtDensity(const MaterialField& table, SpaceBy by, double density) {
  if (by == SpaceBy::kWeight) return table;
  MaterialField scaled = Scaled(table, density / table.density, density / table.density);
  scaled.density = density;
  return scaled;
}

// Log factors of entries that no number is on do not count.
Eigen::VectorXd Freed(const Eigen::MatrixXd& tie, const Eigen::VectorXd& log_factors) {
  return (tie.rowwise().sum().array() > 0).select(log_factors, 0.0);
}

std::string PriorText(const StoredPosterior& posterior) {
  const Eigen::VectorXd sd = posterior.prior_sd.head(posterior.num_fabric());
  return Format("a posterior of kind %s, %d log factors of a fabric, prior_sd %.6g to %.6g",
                ToString(posterior.kind).c_str(), posterior.num_fabric(), sd.minCoeff(),
                sd.maxCoeff());
}

bool SamePrior(const StoredPosterior& a, const StoredPosterior& b) {
  if (a.kind != b.kind || a.fabric != b.fabric) return false;
  const Eigen::MatrixXd difference = a.FabricPrior() - b.FabricPrior();
  return difference.cwiseAbs().maxCoeff() < kRounding * a.FabricPrior().cwiseAbs().maxCoeff();
}

std::string PosteriorFile(const std::string& folder) { return folder + "/posterior.json"; }

StoredPosterior ReadOne(const std::string& folder) {
  if (!fs::is_directory(folder))
    throw InputError(folder, "is no folder, expected that of a fit with --model=bayes or bdp");
  StoredPosterior posterior = ReadPosterior(folder);
  const int n = posterior.num_fabric();
  const Eigen::MatrixXd spread = posterior.kind == PosteriorKind::kElements
                                     ? Eigen::MatrixXd(posterior.element_sd.asDiagonal())
                                     : Eigen::MatrixXd(posterior.covariance.topLeftCorner(n, n));
  if (Eigen::LLT<Eigen::MatrixXd>(spread).info() != Eigen::Success)
    throw InputError(PosteriorFile(folder), "a log factor has no spread, expected a distribution");
  if ((posterior.prior_sd.head(n).array() <= 0).any())
    throw InputError(PosteriorFile(folder) + ": key 'prior_sd'",
                     "found 0, expected positive deviations");
  return posterior;
}

SpaceFrame MakeFrame(const StoredPosterior& first, SpaceBy by) {
  SpaceFrame frame{
      .by = by, .kind = first.kind, .tying = first.fabric, .base = first.base, .prior_root = {}};
  frame.prior_root = first.FabricPrior().llt().matrixL();
  return frame;
}

// The geometric mean of the bases as the frame's; its coupled entries by their log factors.
void SetCommonBase(const std::vector<StoredPosterior>& posteriors,
                   const std::vector<std::string>& folders, SpaceFrame* frame) {
  const Eigen::MatrixXd tie = TyingMatrix(frame->tying);
  const double count = double(posteriors.size());
  double log_density = 0.0;
  for (const StoredPosterior& each : posteriors) log_density += std::log(each.base.density) / count;
  const double density = std::exp(log_density);
  frame->base = AtDensity(frame->base, frame->by, density);
  frame->base.density = density;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(kMaterialEntries);
  for (std::size_t i = 0; i < posteriors.size(); ++i) {
    frame->LogFactors(posteriors[i].base, folders[i] + "/base.json");
    const MaterialField base = AtDensity(posteriors[i].base, frame->by, density);
    mean += Freed(tie, FindLogFactors(frame->base, base)) / count;
  }
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(kMaterialEntries, kMaterialEntries);
  frame->base = TableParametrisation(frame->base, identity).Material(mean);
}

std::string LastName(const std::string& folder) {
  const fs::path path = fs::path(folder).lexically_normal();
  return (path.has_filename() ? path.filename() : path.parent_path().filename()).string();
}

FabricBelief MakeBelief(const SpaceFrame& frame, const StoredPosterior& posterior,
                        const std::string& folder) {
  const int n = posterior.num_fabric();
  FabricBelief belief{.name = LastName(folder),
                      .folder = folder,
                      .density = posterior.base.density,
                      .theta = {},
                      .centre = frame.LogFactors(posterior.base, folder + "/base.json")};
  belief.theta.mean = belief.centre + posterior.mean.head(n);
  if (posterior.kind == PosteriorKind::kElements) {
    belief.theta.covariance = posterior.element_sd.cwiseAbs2().asDiagonal();
    return belief;
  }
  belief.theta.covariance = posterior.covariance.topLeftCorner(n, n);
  if (posterior.specimens > 0) belief.specimen_sd = posterior.prior_sd.segment<2>(n);
  return belief;
}

}  // namespace

std::vector<std::string> ShortNames(const std::vector<std::string>& folders) {
  std::vector<std::vector<std::string>> paths;
  std::vector<std::string> names;
  for (const std::string& folder : folders) {
    names.push_back(LastName(folder));
    std::vector<std::string> parts;
    for (const fs::path& part : fs::path(folder).lexically_normal())
      if (!part.empty()) parts.push_back(part.string());
    paths.push_back(std::move(parts));
  }
  if (std::set<std::string>(names.begin(), names.end()).size() == names.size()) return names;
  const auto share = [&](const auto& part_of) {
    return std::all_of(paths.begin(), paths.end(), [&](const auto& path) {
      return path.size() > 1 && part_of(path) == part_of(paths.front());
    });
  };
  while (share([](const auto& path) { return path.front(); }))
    for (auto& path : paths) path.erase(path.begin());
  while (share([](const auto& path) { return path.back(); }))
    for (auto& path : paths) path.pop_back();
  for (std::size_t i = 0; i < paths.size(); ++i) {
    fs::path name;
    for (const std::string& part : paths[i]) name /= part;
    names[i] = name.string();
  }
  return names;
}

std::vector<BeliefLevel> SpaceFrame::Levels() const {
  if (kind == PosteriorKind::kElements) return {BeliefLevel::kElement};
  return {BeliefLevel::kFabric, BeliefLevel::kSpecimen};
}

double SpaceFrame::LogUnit() const { return std::exp(prior_root.diagonal().array().log().mean()); }

Eigen::VectorXd SpaceFrame::LogFactors(const MaterialField& table, const std::string& where) const {
  const Eigen::MatrixXd tie = TyingMatrix(tying);
  const Eigen::VectorXd all = Freed(tie, FindLogFactors(base, AtDensity(table, by, base.density)));
  if (!all.allFinite())
    throw InputError(where,
                     "an entry has another sign than in the other tables, or is zero in one "
                     "of them, expected tables with finite log factors");
  Eigen::VectorXd theta = MeanLogFactors(tie, all);
  const double error = (tie * theta - all).cwiseAbs().maxCoeff();
  if (error > kRounding)
    throw InputError(where,
                     Format("the table differs from those of the other fabrics by more than "
                            "its %d numbers can change (a log factor by %.3g), expected fits "
                            "of one start table, or num_parameters 39",
                            static_cast<int>(tie.cols()), error));
  return theta;
}

bool SpaceFrame::CanRepresent(const MaterialField& table) const {
  try {
    LogFactors(table, "");
  } catch (const InputError&) {
    return false;
  }
  return true;
}

MaterialField SpaceFrame::Table(const Eigen::VectorXd& theta, double density) const {
  const MaterialField table = TableParametrisation(base, tying).Material(theta);
  if (by == SpaceBy::kDrape) return AtDensity(table, by, density);
  MaterialField with_density = table;
  with_density.density = density;
  return with_density;
}

NormalDistribution SpaceFrame::ToPriorUnits(const NormalDistribution& theta) const {
  const auto root = prior_root.triangularView<Eigen::Lower>();
  const Eigen::MatrixXd half = root.solve(theta.covariance);
  return {root.solve(theta.mean), root.solve(half.transpose())};
}

NormalDistribution SpaceFrame::FromPriorUnits(const NormalDistribution& z) const {
  return {prior_root * z.mean, prior_root * z.covariance * prior_root.transpose()};
}

NormalDistribution BeliefAt(const SpaceFrame& frame, const FabricBelief& fabric,
                            BeliefLevel level) {
  NormalDistribution theta = fabric.theta;
  if (level == BeliefLevel::kSpecimen) {
    Eigen::MatrixXd both = Eigen::MatrixXd::Zero(kMaterialEntries, 2);
    both.col(0).head(kStretchEntries).setOnes();
    both.col(1).tail(kBendEntries).setOnes();
    const Eigen::MatrixXd tie = TyingMatrix(frame.tying);
    for (int part = 0; part < 2; ++part) {
      const Eigen::VectorXd axis = MeanLogFactors(tie, both.col(part)) * fabric.specimen_sd[part];
      theta.covariance += axis * axis.transpose();
    }
  }
  return frame.ToPriorUnits(theta);
}

FabricBeliefs ReadFabricBeliefs(const std::vector<std::string>& folders, SpaceBy by) {
  if (folders.size() < 2)
    throw InputError("option 'posteriors'", Format("found %d folder(s), expected those of at least "
                                                   "two fabrics",
                                                   int(folders.size())));
  std::vector<StoredPosterior> posteriors;
  std::set<std::string> seen;
  for (const std::string& folder : folders) {
    posteriors.push_back(ReadOne(folder));
    if (!seen.insert(fs::weakly_canonical(folder).string()).second)
      throw InputError("option 'posteriors'", "found " + folder + " twice, expected each once");
    if (!SamePrior(posteriors[0], posteriors.back()))
      throw InputError(PosteriorFile(folder), "found " + PriorText(posteriors.back()) +
                                                  ", expected " + PriorText(posteriors[0]) +
                                                  ", as in " + folders[0]);
  }
  FabricBeliefs beliefs{MakeFrame(posteriors[0], by), {}};
  SetCommonBase(posteriors, folders, &beliefs.frame);
  for (std::size_t i = 0; i < folders.size(); ++i)
    beliefs.fabrics.push_back(MakeBelief(beliefs.frame, posteriors[i], folders[i]));
  const std::vector<std::string> names = ShortNames(folders);
  for (std::size_t i = 0; i < folders.size(); ++i) beliefs.fabrics[i].name = names[i];
  return beliefs;
}

FabricBelief ReadFabricBelief(const SpaceFrame& frame, const std::string& path) {
  if (!fs::is_directory(path)) {
    const MaterialField table = ReadMaterial(path).field;
    const int n = frame.size();
    FabricBelief belief{.name = LastName(path),
                        .folder = path,
                        .density = table.density,
                        .theta = {},
                        .centre = Eigen::VectorXd::Zero(n)};
    belief.theta = {frame.LogFactors(table, path),
                    kPointDeviation * kPointDeviation * Eigen::MatrixXd::Identity(n, n)};
    return belief;
  }
  const StoredPosterior posterior = ReadOne(path);
  if (posterior.kind != frame.kind || posterior.fabric != frame.tying)
    throw InputError(PosteriorFile(path),
                     "found " + PriorText(posterior) +
                         Format(", expected the kind %s and %d log factors of the "
                                "other fabrics",
                                ToString(frame.kind).c_str(), frame.size()));
  return MakeBelief(frame, posterior, path);
}

}  // namespace drape
