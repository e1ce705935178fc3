// SPDX-License-Identifier: Apache-2.0
// Model bdp: its bound is derived in posterior_fit.h.
#include "solver/posterior/element_posterior.h"

#include <glog/logging.h>

#include <algorithm>

#include "physics/util/math/random.h"
#include "solver/posterior/samples/elementwise_samples.h"

namespace drape {
namespace {

// Random streams: the noise of the fit, then of each batch of independent samples.
enum Stream : uint64_t { kFitStream, kIndependentStream };

class ElementFitter {
 public:
  ElementFitter(const FitProblem& problem, const PosteriorOptions& options, MapEstimator& mode,
                PosteriorFit* fit)
      : backend_(problem.fine), options_(options), mode_(mode), fit_(*fit) {}

  bool Run() {
    if (!FindDistribution() || mode_.Cancelled()) return false;
    EstimateElboOfFit();
    if (mode_.Cancelled()) return false;
    fit_.distribution.gaussian.factor *= options_.element_sigma / fit_.hierarchy.fabric_sigma;
    return true;
  }

 private:
  ElementwiseSamples MakeSamples(int count, uint64_t stream, LostBranchPolicy policy) const {
    return {backend_,
            fit_.hierarchy.base,
            {fit_.hierarchy.fabric_sigma, options_.element_sigma},
            mode_.specimens(),
            mode_.MakeResidualOptions(),
            count,
            SeedOfStream(options_.seed, stream),
            policy};
  }

  static Eigen::VectorXd ReadPoint(const GaussianPosterior& q) {
    Eigen::VectorXd point(2 * q.size());
    point << q.mean, q.factor.diagonal();
    return point;
  }

  // Starts with elements that scatter less than the prior allows, and less again while their drapes
  // are not stable; if none are, extrapolates from those of the mode.
  bool FindDistribution() {
    for (const double deviation : {0.3, 0.1, 0.03, 0.01})
      if (FitFrom(deviation, deviation)) return true;
    return FitFrom(0.0, 0.1);
  }

  // A fit from one deviation of all entries, its drapes followed from those of another.
  bool FitFrom(double drapes, double deviation) {
    if (mode_.Cancelled()) return false;
    constexpr int n = kMaterialEntries;
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(n, n);
    const Eigen::VectorXd& mean = fit_.mode.gaussian.mean;
    CHECK_EQ(mean.size(), n) << "each entry has a mean of its own";
    ElementwiseSamples draws =
        MakeSamples(options_.draws, kFitStream, LostBranchPolicy::kExtrapolate);
    if (!draws.StartAt(ReadPoint({mean, unit, drapes * unit}))) return false;
    fit_.distribution =
        FitPosterior(draws, {mean, unit, deviation * unit},
                     mode_.MakeOptions(SampleKind::kElementwise, options_.iterations,
                                       MapEstimator::kModeShare, MapEstimator::kFitShare));
    fit_.counts += draws.counts();
    fit_.num_extrapolated = draws.num_extrapolated();
    return fit_.distribution.termination != FitTermination::kFailed;
  }

  // By noise that the fit has not used, in batches of its size, until too few samples can be valid.
  void EstimateElboOfFit() {
    const GaussianPosterior& q = fit_.distribution.gaussian;
    std::vector<Eigen::VectorXd> residuals;
    Eigen::VectorXd residual;
    uint64_t stream = kIndependentStream;
    const auto enough = [&](int left) { return int(residuals.size()) + left >= kMinElboSamples; };
    for (int left = options_.elbo_samples; left > 0 && enough(left) && !mode_.Cancelled();
         left -= options_.draws) {
      const int count = std::min(left, options_.draws);
      ElementwiseSamples independent = MakeSamples(count, stream++, LostBranchPolicy::kReject);
      independent.Prepare(ReadPoint(q).replicate(1, count), false);
      fit_.counts += independent.counts();
      for (int s = 0; s < count; ++s)
        if (independent.Residuals(s, &residual, nullptr)) residuals.push_back(residual);
    }
    const std::vector<double> log_ratios(residuals.size(), -q.DivergenceFromPrior());
    EstimateElbo(residuals, log_ratios, &fit_);
  }

  Backend* backend_;
  const PosteriorOptions& options_;
  MapEstimator& mode_;
  PosteriorFit& fit_;
};

}  // namespace

bool FitElements(const FitProblem& problem, const PosteriorOptions& options, MapEstimator& mode,
                 PosteriorFit* fit) {
  return ElementFitter(problem, options, mode, fit).Run();
}

}  // namespace drape
