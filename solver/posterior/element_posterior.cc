// SPDX-License-Identifier: Apache-2.0
// Model bdp: its bound is derived in posterior_fit.h.
#include <glog/logging.h>

#include <algorithm>

#include "physics/util/random.h"
#include "solver/posterior/map_estimator.h"
#include "solver/posterior/samples/elementwise_samples.h"

namespace drape {
namespace {

// Of the seed: the fit's noise, then that of each batch of fresh draws.
enum Stream : uint64_t { kFitStream, kFreshStream };

class ElementFitter {
 public:
  ElementFitter(const FitProblem& problem, const PosteriorOptions& options, MapEstimator& mode,
                PosteriorFit* fit)
      : backend_(problem.fine), options_(options), mode_(mode), fit_(*fit) {}

  bool Run() {
    if (!FindDistribution() || mode_.Cancelled()) return false;
    EstimateFreshElbo();
    if (mode_.Cancelled()) return false;
    fit_.posterior.gaussian.factor *= options_.element_sigma / fit_.hierarchy.fabric_sigma;
    return true;
  }

 private:
  ElementwiseSamples MakeSamples(int count, uint64_t stream, LostBranchPolicy beyond) const {
    return {backend_,
            fit_.hierarchy.base,
            {fit_.hierarchy.fabric_sigma, options_.element_sigma},
            mode_.targets(),
            mode_.MakeResidualOptions(),
            count,
            SeedOfStream(options_.seed, stream),
            beyond};
  }

  static Eigen::VectorXd ReadPoint(const GaussianPosterior& q) {
    Eigen::VectorXd point(2 * q.size());
    point << q.mean, q.factor.diagonal();
    return point;
  }

  // From elements that scatter less than they may, less still where their drapes do not stand;
  // where none do, from those of the mode and on by their tangents.
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
    ElementwiseSamples draws = MakeSamples(options_.draws, kFitStream, LostBranchPolicy::kTangent);
    if (!draws.StartAt(ReadPoint({mean, unit, drapes * unit}))) return false;
    fit_.posterior =
        FitPosterior(draws, {mean, unit, deviation * unit},
                     mode_.MakeOptions(SampleKind::kElementwise, options_.iterations,
                                       MapEstimator::kModeShare, MapEstimator::kFitShare));
    fit_.counts += draws.counts();
    fit_.beyond = draws.num_extrapolated();
    return fit_.posterior.termination != FitTermination::kFailed;
  }

  // Noise that the fit has not seen, as much at a time as the fit had, until too few can stand.
  void EstimateFreshElbo() {
    const GaussianPosterior& q = fit_.posterior.gaussian;
    std::vector<Eigen::VectorXd> residuals;
    Eigen::VectorXd residual;
    uint64_t stream = kFreshStream;
    const auto enough = [&](int left) { return int(residuals.size()) + left >= kLeastFresh; };
    for (int left = options_.elbo_samples; left > 0 && enough(left) && !mode_.Cancelled();
         left -= options_.draws) {
      const int count = std::min(left, options_.draws);
      ElementwiseSamples fresh = MakeSamples(count, stream++, LostBranchPolicy::kRefuse);
      fresh.Prepare(ReadPoint(q).replicate(1, count), false);
      fit_.counts += fresh.counts();
      for (int s = 0; s < count; ++s)
        if (fresh.Copy(s, &residual, nullptr)) residuals.push_back(residual);
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
