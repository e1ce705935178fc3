// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/posterior_report.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/util/text_format.h"
#include "solver/fit/effective_stiffness.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

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
          {"sigma_px", fit.sigma_px},
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
          {"sample_rms_px", fit.sample_rms_px},
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

std::string PosteriorTable(const PosteriorFit& fit, const Eigen::VectorXd& weights) {
  const PosteriorStiffness stiffness = ComputePosteriorStiffness(fit, weights);
  const Eigen::MatrixXd root = fit.hierarchy.LatentRoot();
  const Eigen::VectorXd deviation =
      LogDeviations(root, fit.distribution.gaussian).cwiseQuotient(root.rowwise().norm());
  std::string text = IsElementwise(fit)
                         ? "  faces and hinges, mean and standard deviation: stretch "
                         : "  posterior of the fabric: stretch ";
  text += StiffnessText(stiffness.stretch, stiffness.stretch_deviation, "N/m") + ", bend " +
          StiffnessText(stiffness.bend, stiffness.bend_deviation, "N m") + "\n";
  if (!IsElementwise(fit))
    text += Format("  %d of %d log factors have less than %.1f of their prior deviation\n",
                   static_cast<int>((deviation.array() < kNarrowed).count()),
                   static_cast<int>(deviation.size()), kNarrowed);
  if (std::isnan(fit.elbo))
    return text + Format(
                      "  sigma of the outline %.2f px; too few independent samples are valid "
                      "(%d) to judge the fit\n",
                      fit.sigma_px, fit.elbo_samples_valid);
  return text + Format(
                    "  sigma of the outline %.2f px; root mean square error of samples %.2f px\n"
                    "  evidence lower bound %.1f +- %.1f by %d independent samples, Pareto k %.2f: "
                    "%s\n",
                    fit.sigma_px, fit.sample_rms_px, fit.elbo, fit.elbo_error,
                    fit.elbo_samples_valid, fit.pareto_k,
                    fit.pareto_k < kReliable ? "reliable" : "not reliable");
}

}  // namespace drape
