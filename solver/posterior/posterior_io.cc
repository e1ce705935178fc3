// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/posterior_io.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/posterior/posterior_fit.h"

namespace drape {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr char kPosteriorFormat[] = "drapefit-posterior";
constexpr int kPosteriorVersion = 2;  // 1: c12 on a log scale of its own
constexpr char kFile[] = "/posterior.json", kBase[] = "base.json";
// What rounding may leave of asymmetry or of a negative variance, as a share of the largest entry.
constexpr double kRounding = 1e-9;
constexpr double kMostPosteriorDeviation = 1e4;  // of a log factor

Eigen::VectorXd ReadDeviations(const JsonInput& input, int count) {
  Eigen::VectorXd deviations = input.Vector(count);
  for (int i = 0; i < count; ++i) input.At(i).NumberWithin(0, kMostPosteriorDeviation);
  return deviations;
}

Eigen::MatrixXd ReadCovariance(const JsonInput& input, int count) {
  Eigen::MatrixXd covariance(count, count);
  input.ExpectArray(count);
  for (int i = 0; i < count; ++i) covariance.row(i) = input.At(i).Vector(count);
  const double rounding = kRounding * covariance.cwiseAbs().maxCoeff();
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < i; ++j)
      if (std::abs(covariance(i, j) - covariance(j, i)) > rounding)
        input.At(i).At(j).Fail("a symmetric matrix");
  for (int i = 0; i < count; ++i)
    input.At(i).At(i).NumberWithin(-rounding, kMostPosteriorDeviation * kMostPosteriorDeviation);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance, Eigen::EigenvaluesOnly);
  if (axes.eigenvalues()[0] < -rounding) input.Fail("a covariance without negative variances");
  return covariance;
}

// The tying whose names come first, and how many specimens follow.
void ReadNames(const JsonInput& names, StoredPosterior* posterior) {
  const int count = names.ExpectArray().Size();
  for (const auto& [tying, unused] : EnumNames(ParameterTying{})) {
    posterior->fabric = tying;
    posterior->specimens = (count - posterior->num_fabric()) / 2;
    if (posterior->specimens < 0 || posterior->size() != count) continue;
    bool same = true;
    for (int i = 0; i < count && same; ++i) same = names.At(i).String() == posterior->NameFor(i);
    if (same) return;
  }
  names.Fail("names of 1, 2, 3, 7 or 39 log factors of a fabric, then two of each specimen");
}

void ExpectHeader(const JsonInput& input) {
  if (!input.Has("format") || input.At("format").value() != kPosteriorFormat)
    input.Fail(std::string("a posterior, with \"format\": \"") + kPosteriorFormat + '"');
  if (input.At("version").Integer() != kPosteriorVersion)
    input.At("version").Fail(std::to_string(kPosteriorVersion));
  if (input.At("log_factors_on").String() != kBase)
    input.At("log_factors_on").Fail(std::string("\"") + kBase + '"');
}

constexpr char kSamplesFormat[] = "drapefit-samples";
constexpr int kSamplesVersion = 1;
constexpr int kMostDrawn = 1'000'000;

Eigen::VectorXd ReadRadii(const JsonInput& input) {
  constexpr double kMostRadius = 10.0;  // [m]
  Eigen::VectorXd radii = input.Vector();
  if (radii.size() > 0 && (radii.minCoeff() <= 0.0 || radii.maxCoeff() > kMostRadius))
    input.Fail(Format("radii above 0 and at most %g m", kMostRadius));
  return radii;
}

StoredSamples::Image ReadImage(const JsonInput& input) {
  input.ExpectKeys({"name", "sigma_m", "radius_m"});
  const double sigma = input.At("sigma_m").Number();
  if (!(sigma > 0.0)) input.At("sigma_m").Fail("a positive standard deviation");
  return {input.At("name").String(), sigma, ReadRadii(input.At("radius_m"))};
}

StoredSamples::Sample ReadSample(const JsonInput& input, int parameters, int angles, int images) {
  input.ExpectKeys({"log_factors", "log_prior", "log_density", "radius_m", "log_likelihood"});
  const JsonInput outlines = input.At("radius_m");
  outlines.ExpectArray(images);
  StoredSamples::Sample sample{ReadLogFactors(input.At("log_factors"), parameters),
                               input.At("log_prior").Number(), input.At("log_density").Number(),
                               Eigen::MatrixXd(angles, images)};
  for (int i = 0; i < images; ++i)
    sample.radius.col(i) = ReadRadii(outlines.At(i).ExpectArray(angles));
  if (images == 0) sample.log_likelihood = input.At("log_likelihood").Number();
  return sample;
}

constexpr double kNarrowed = 0.7;  // posterior over prior deviation of a determined log factor
constexpr double kReliable = 0.7;  // k̂ up to which the approximation is reliable

bool IsElementwise(const PosteriorFit& fit) { return fit.kind == PosteriorKind::kElements; }

// Standard deviations of the log factors root·u.
Eigen::VectorXd LogDeviations(const Eigen::MatrixXd& root, const GaussianPosterior& u) {
  return (root * u.rotation * u.factor).rowwise().norm();
}

// The rounding of the mean must not make a spread of numbers that are all equal.
std::pair<double, double> MeanAndDeviation(const Eigen::ArrayXd& numbers) {
  if ((numbers == numbers[0]).all()) return {numbers[0], 0.0};
  return {numbers.mean(), std::sqrt((numbers - numbers.mean()).square().mean())};
}

// "151.7 +- 12 N/m", or "151.7 N/m (not varied)" where the model holds it.
std::string StiffnessText(double mean, double deviation, const char* unit) {
  if (deviation == 0.0) return Format("%.4g %s (not varied)", mean, unit);
  return Format("%.4g +- %.3g %s", mean, deviation, unit);
}

}  // namespace

Eigen::VectorXd ReadLogFactors(const JsonInput& input, int count) {
  Eigen::VectorXd factors = input.Vector(count);
  for (int i = 0; i < count; ++i)
    if (std::abs(factors[i]) > kMostLogFactor)
      input.At(i).Fail(Format("a log factor of at most %g", kMostLogFactor));
  return factors;
}

std::string StoredPosterior::NameFor(int i) const {
  HierarchicalModel hierarchy;
  hierarchy.fabric = fabric;
  return hierarchy.NameFor(i);
}

Eigen::MatrixXd StoredPosterior::FabricPrior() const {
  if (fabric_prior.size() > 0) return fabric_prior;
  return prior_sd.head(num_fabric()).cwiseAbs2().asDiagonal();
}

void WritePosterior(const std::string& folder, const StoredPosterior& posterior,
                    const std::string& source) {
  CHECK_EQ(posterior.mean.size(), posterior.size());
  CHECK_EQ(posterior.prior_sd.size(), posterior.size());
  ordered_json names = ordered_json::array();
  for (int i = 0; i < posterior.size(); ++i) names.push_back(posterior.NameFor(i));
  ordered_json file = {{"format", kPosteriorFormat},
                       {"version", kPosteriorVersion},
                       {"kind", ToString(posterior.kind)},
                       {"log_factors_on", kBase},
                       {"names", names},
                       {"prior_sd", posterior.prior_sd},
                       {"mean", posterior.mean}};
  if (posterior.kind == PosteriorKind::kElements) {
    CHECK_EQ(posterior.element_sd.size(), kMaterialEntries);
    file["element_sd"] = posterior.element_sd;
  } else {
    CHECK_EQ(posterior.covariance.rows(), posterior.size());
    for (int i = 0; i < posterior.size(); ++i)
      file["covariance"].push_back(posterior.covariance.col(i));
    for (const auto& column : posterior.fabric_prior.colwise())
      file["fabric_prior"].push_back(column);
    if (posterior.branch_deviation > 0.0) file["branch_deviation"] = posterior.branch_deviation;
  }
  WriteMaterial(folder + "/" + kBase, {.name = "base",
                                       .field = posterior.base,
                                       .source_convention = "mechanical",
                                       .source = source,
                                       .warnings = {},
                                       .warp_known = posterior.warp_known});
  WriteFileAtomically(folder + kFile, file.dump(1) + "\n");
}

StoredPosterior ReadPosterior(const std::string& folder, const MaterialPolicy& policy) {
  const std::string path = folder + kFile;
  const json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  ExpectHeader(input);
  StoredPosterior posterior;
  posterior.kind = ParseName<PosteriorKind>(input.At("kind").String(), input.At("kind").Name());
  const bool elements = posterior.kind == PosteriorKind::kElements;
  std::vector<std::string> keys = {
      "format", "version",  "kind", "log_factors_on",
      "names",  "prior_sd", "mean", elements ? "element_sd" : "covariance"};
  if (!elements) keys.insert(keys.end(), {"fabric_prior", "branch_deviation"});
  input.ExpectKeys(keys);
  ReadNames(input.At("names"), &posterior);
  const int count = posterior.size();
  if (elements && count != kMaterialEntries)
    input.At("names").Fail("the 39 entries of a table, of kind bdp");
  posterior.prior_sd = ReadDeviations(input.At("prior_sd"), count);
  posterior.mean = ReadLogFactors(input.At("mean"), count);
  if (elements) {
    posterior.element_sd = ReadDeviations(input.At("element_sd"), count);
  } else {
    posterior.covariance = ReadCovariance(input.At("covariance"), count);
    if (input.Has("fabric_prior"))
      posterior.fabric_prior = ReadCovariance(input.At("fabric_prior"), posterior.num_fabric());
    if (input.Has("branch_deviation"))
      posterior.branch_deviation = input.At("branch_deviation").NumberWithin(0.0, kMostLogFactor);
  }
  Material base = ReadMaterial(folder + "/" + kBase, policy);
  posterior.base = std::move(base.field);
  posterior.warp_known = base.warp_known;
  return posterior;
}

Eigen::MatrixXd StoredSamples::LogLikelihood(const Sample& sample) const {
  Eigen::MatrixXd log_likelihood(angles(), images.size());
  for (Eigen::Index i = 0; i < log_likelihood.cols(); ++i) {
    const Image& image = images[i];
    const Eigen::ArrayXd z = (sample.radius.col(i) - image.radius) / image.sigma;
    log_likelihood.col(i) =
        -0.5 * z.square() - std::log(image.sigma * std::sqrt(2 * std::numbers::pi));
  }
  return log_likelihood;
}

// A line for each image and each sample.
void WriteSamples(const std::string& folder, const StoredSamples& samples) {
  const auto lines = [](std::string* text, const auto& items, const auto& make) {
    for (std::size_t i = 0; i < items.size(); ++i)
      *text += (i == 0 ? "\n  " : ",\n  ") + make(items[i]).dump();
  };
  std::string text = "{\"format\": \"" + std::string(kSamplesFormat) +
                     "\", \"version\": " + std::to_string(kSamplesVersion) +
                     ", \"drawn\": " + std::to_string(samples.drawn) + ",\n \"images\": [";
  lines(&text, samples.images, [](const StoredSamples::Image& image) {
    return ordered_json{{"name", image.name}, {"sigma_m", image.sigma}, {"radius_m", image.radius}};
  });
  text += "],\n \"samples\": [";
  lines(&text, samples.samples, [](const StoredSamples::Sample& sample) {
    ordered_json outlines = ordered_json::array();
    for (const auto& outline : sample.radius.colwise()) outlines.push_back(outline);
    ordered_json line = {{"log_factors", sample.log_factors},
                         {"log_prior", sample.log_prior},
                         {"log_density", sample.log_density},
                         {"radius_m", outlines}};
    if (outlines.empty()) line["log_likelihood"] = sample.log_likelihood;
    return line;
  });
  WriteFileAtomically(folder + "/" + kSamplesFile, text + "]}\n");
}

StoredSamples ReadSamples(const std::string& folder, int parameters) {
  const std::string path = folder + "/" + kSamplesFile;
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  if (!input.Has("format") || input.At("format").value() != kSamplesFormat)
    input.Fail(std::string("samples of a posterior, with \"format\": \"") + kSamplesFormat + '"');
  if (input.At("version").Integer() != kSamplesVersion)
    input.At("version").Fail(std::to_string(kSamplesVersion));
  input.ExpectKeys({"format", "version", "drawn", "images", "samples"});
  StoredSamples stored;
  stored.drawn = input.At("drawn").IntegerWithin(0, kMostDrawn);
  const JsonInput images = input.At("images"), samples = input.At("samples");
  images.ExpectArray();
  samples.ExpectArray();
  for (int i = 0; i < images.Size(); ++i) {
    stored.images.push_back(ReadImage(images.At(i)));
    if (stored.images[i].radius.size() != stored.angles())
      images.At(i).At("radius_m").Fail("as many radii as of the first image");
  }
  for (int s = 0; s < samples.Size(); ++s)
    stored.samples.push_back(ReadSample(samples.At(s), parameters, stored.angles(), images.Size()));
  return stored;
}

PosteriorStiffness ComputePosteriorStiffness(const PosteriorFit& fit,
                                             const Eigen::VectorXd& weights) {
  constexpr int kSamples = 400;
  const GaussianPosterior& q = fit.distribution.gaussian;
  const Eigen::MatrixXd draws = q.Draws(IndependentSamples(q.size(), kSamples, 1));
  Eigen::ArrayXd stretch(kSamples), bend(kSamples);
  for (int s = 0; s < kSamples; ++s) {
    const MaterialField fabric = fit.FabricAt(draws.col(s));
    stretch[s] = EffectiveStretch(fabric, weights);
    bend[s] = EffectiveBend(fabric, weights);
  }
  const auto [mean_stretch, stretch_deviation] = MeanAndDeviation(stretch);
  const auto [mean_bend, bend_deviation] = MeanAndDeviation(bend);
  return {mean_stretch, stretch_deviation, mean_bend, bend_deviation};
}

ordered_json PosteriorJson(const PosteriorFit& fit, const Eigen::VectorXd& weights) {
  const HierarchicalModel& hierarchy = fit.hierarchy;
  const Eigen::MatrixXd root = hierarchy.LatentRoot();
  const Eigen::VectorXd prior = root.rowwise().norm();
  const Eigen::VectorXd mode = root * fit.mode.gaussian.mean;
  const Eigen::VectorXd mean = root * fit.distribution.gaussian.mean;
  const Eigen::VectorXd laplace = LogDeviations(root, fit.mode.gaussian);
  const Eigen::VectorXd deviation = LogDeviations(root, fit.distribution.gaussian);
  ordered_json numbers = ordered_json::array();
  for (int i = 0; i < hierarchy.num_latents(); ++i) {
    ordered_json number = {{"name", hierarchy.NameFor(i)},
                           {"prior_sd", prior[i]},
                           {"mode", mode[i]},
                           {"laplace_sd", laplace[i]},
                           {"mean", mean[i]}};
    if (IsElementwise(fit)) {
      number["element_sd"] = deviation[i];
    } else {
      number["sd"] = deviation[i];
      number["sd_over_prior_sd"] = deviation[i] / prior[i];
    }
    numbers.push_back(number);
  }
  const PosteriorStiffness stiffness = ComputePosteriorStiffness(fit, weights);
  return {{"kind", ToString(fit.kind)},
          {"specimens", hierarchy.specimens},
          {fit.of_experiment ? "sigma_factor" : "sigma_px", fit.sigma},
          {"termination", ToString(fit.distribution.termination)},
          {"mode_termination", ToString(fit.mode.termination)},
          {"iterations", {fit.mode.iterations, fit.distribution.iterations}},
          {"rollouts", fit.counts.rollouts},
          {"jacobians", fit.counts.tangents},
          {"failed_rollouts", fit.counts.failed},
          {"seconds", {fit.mode.seconds, fit.distribution.seconds}},
          {"elbo", fit.elbo},
          {"elbo_error", fit.elbo_error},
          {"divergence_from_prior", fit.distribution.divergence},
          {"pareto_k", fit.pareto_k},
          {fit.of_experiment ? "sample_rms_sigma" : "sample_rms_px", fit.sample_rms},
          {"elbo_samples_valid", fit.elbo_samples_valid},
          {"extrapolated_samples", fit.num_extrapolated},
          {"reported_at", fit.reported_at_mode ? "mode" : "mean"},
          {"stretch_n_per_m", {stiffness.stretch, stiffness.stretch_deviation}},
          {"bend_n_m", {stiffness.bend, stiffness.bend_deviation}},
          {"log_factors", numbers}};
}

StoredPosterior MakeStoredPosterior(const PosteriorFit& fit) {
  const Eigen::MatrixXd root = fit.hierarchy.LatentRoot();
  StoredPosterior stored;
  stored.kind = fit.kind;
  stored.fabric = fit.hierarchy.fabric;
  stored.specimens = fit.hierarchy.has_specimens() ? fit.hierarchy.specimens : 0;
  stored.base = fit.hierarchy.base;
  stored.prior_sd = root.rowwise().norm();
  stored.mean = root * fit.distribution.gaussian.mean;
  if (IsElementwise(fit)) {
    stored.element_sd = LogDeviations(root, fit.distribution.gaussian);
    return stored;
  }
  stored.covariance = root * fit.distribution.gaussian.Covariance() * root.transpose();
  if (fit.hierarchy.fabric_root.size() > 0)
    stored.fabric_prior = fit.hierarchy.fabric_root * fit.hierarchy.fabric_root.transpose();
  return stored;
}

// Data of information C⁻¹ − P⁻¹ that have errors B·e, e ~ N(0, 1), leave C + G·(1 + S)⁻¹·Gᵀ with
// the prior P, G = B − C·P⁻¹·B, S = Gᵀ·P⁻¹·B. A number is off by the mean of its entries.
void CountBranches(double deviation, StoredPosterior& posterior) {
  constexpr double kFixed = 1e-6;  // deviation in the prior of an entry that does not vary
  const int count = posterior.num_fabric();
  const Eigen::MatrixXd tie = TyingMatrix(posterior.fabric);
  const Eigen::ArrayXd varies = (posterior.prior_sd.head(count).array() > kFixed).cast<double>();
  const Eigen::ArrayXd share = deviation * varies / tie.colwise().sum().transpose().array();
  const Eigen::MatrixXd off =
      share.matrix().asDiagonal() * tie.transpose() * TyingMatrix(ParameterTying::kColumns);
  const Eigen::MatrixXd weighted = posterior.FabricPrior().llt().solve(off);
  Eigen::MatrixXd seen = -posterior.covariance.leftCols(count) * weighted;
  seen.topRows(count) += off;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> known(seen.topRows(count).transpose() *
                                                             weighted);
  const Eigen::MatrixXd turned = seen * known.eigenvectors();
  const Eigen::ArrayXd s = known.eigenvalues();  // below 0: known less than in the prior
  const Eigen::ArrayXd kept = (s > 0.0).select(1.0 / (1.0 + s), 0.0);
  posterior.covariance += turned * kept.matrix().asDiagonal() * turned.transpose();
  posterior.branch_deviation = deviation;
}

std::string PosteriorTable(const PosteriorFit& fit, const Eigen::VectorXd& weights) {
  const Eigen::MatrixXd root = fit.hierarchy.LatentRoot();
  const Eigen::VectorXd deviation =
      LogDeviations(root, fit.distribution.gaussian).cwiseQuotient(root.rowwise().norm());
  std::string text;
  if (IsElementwise(fit)) {
    const PosteriorStiffness stiffness = ComputePosteriorStiffness(fit, weights);
    text = "  faces and hinges, mean and standard deviation: stretch " +
           StiffnessText(stiffness.stretch, stiffness.stretch_deviation, "N/m") + ", bend " +
           StiffnessText(stiffness.bend, stiffness.bend_deviation, "N m") + "\n";
  } else {
    text = Format("  %d of %d log factors have less than %.1f of their prior deviation\n",
                  static_cast<int>((deviation.array() < kNarrowed).count()),
                  static_cast<int>(deviation.size()), kNarrowed);
  }
  text += fit.of_experiment ? Format("  sigma of all measurements times %.2f", fit.sigma)
                            : Format("  sigma of the outline %.2f px", fit.sigma);
  if (std::isnan(fit.elbo))
    return text + Format("; too few independent samples are valid (%d) to judge the fit\n",
                         fit.elbo_samples_valid);
  return text + Format(
                    "; root mean square error of samples %.2f %s\n"
                    "  evidence lower bound %.1f +- %.1f by %d independent samples, Pareto k %.2f: "
                    "%s\n",
                    fit.sample_rms, fit.of_experiment ? "sigma" : "px", fit.elbo, fit.elbo_error,
                    fit.elbo_samples_valid, fit.pareto_k,
                    fit.pareto_k < kReliable ? "reliable" : "not reliable");
}

}  // namespace drape
