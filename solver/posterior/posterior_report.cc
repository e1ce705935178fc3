// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/posterior_report.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/util/text_format.h"
#include "solver/fit/parameters/effective_stiffness.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

constexpr double kNarrowed = 0.7;  // posterior over prior deviation of a determined log factor
constexpr double kReliable = 0.7;  // k̂ up to which the approximation is reliable

bool IsElementwise(const PosteriorFit& fit) { return fit.kind == PosteriorKind::kElements; }

// The prior's standard deviation of the log factor of a latent number.
double PriorDeviation(const HierarchicalModel& hierarchy, int latent) {
  if (latent < hierarchy.num_fabric()) return hierarchy.fabric_sigma;
  return (latent - hierarchy.num_fabric()) % 2 == 0 ? hierarchy.specimen_stretch_sigma
                                                    : hierarchy.specimen_bend_sigma;
}

Eigen::VectorXd PriorDeviations(const HierarchicalModel& hierarchy) {
  Eigen::VectorXd deviations(hierarchy.num_latents());
  for (int i = 0; i < deviations.size(); ++i) deviations[i] = PriorDeviation(hierarchy, i);
  return deviations;
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
  const Eigen::VectorXd deviation = fit.distribution.gaussian.Deviations();
  const Eigen::VectorXd laplace = fit.mode.gaussian.Deviations();
  ordered_json numbers = ordered_json::array();
  for (int i = 0; i < hierarchy.num_latents(); ++i) {
    const double prior = PriorDeviation(hierarchy, i);
    ordered_json number = {{"name", hierarchy.NameFor(i)},
                           {"prior_sd", prior},
                           {"mode", prior * fit.mode.gaussian.mean[i]},
                           {"laplace_sd", prior * laplace[i]},
                           {"mean", prior * fit.distribution.gaussian.mean[i]}};
    if (IsElementwise(fit)) {
      number["element_sd"] = prior * deviation[i];
    } else {
      number["sd"] = prior * deviation[i];
      number["sd_over_prior_sd"] = deviation[i];
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
  const Eigen::VectorXd prior = PriorDeviations(fit.hierarchy);
  StoredPosterior stored;
  stored.kind = fit.kind;
  stored.fabric = fit.hierarchy.fabric;
  stored.specimens = fit.hierarchy.has_specimens() ? fit.hierarchy.specimens : 0;
  stored.base = fit.hierarchy.base;
  stored.prior_sd = prior;
  stored.mean = prior.cwiseProduct(fit.distribution.gaussian.mean);
  if (IsElementwise(fit)) {
    stored.element_sd = prior.cwiseProduct(fit.distribution.gaussian.Deviations());
    return stored;
  }
  stored.covariance =
      prior.asDiagonal() * fit.distribution.gaussian.Covariance() * prior.asDiagonal();
  return stored;
}

std::string PosteriorTable(const PosteriorFit& fit, const Eigen::VectorXd& weights) {
  const PosteriorStiffness stiffness = ComputePosteriorStiffness(fit, weights);
  const Eigen::VectorXd deviation = fit.distribution.gaussian.Deviations();
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
