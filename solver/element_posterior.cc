// SPDX-License-Identifier: Apache-2.0
// Model bdp: its bound is derived in posterior_fit.h.
#include <algorithm>

#include "physics/random.h"
#include "solver/element_draws.h"
#include "solver/posterior_mode.h"

namespace drape {
namespace {

// Of the seed: the fit's noise, then that of each batch of fresh draws.
enum Stream : uint64_t { kFitStream, kFreshStream };

class ElementFitter {
 public:
  ElementFitter(const FitProblem& problem, const PosteriorOptions& options, PosteriorMode& mode,
                PosteriorFit* fit)
      : backend_(problem.fine), options_(options), mode_(mode), fit_(*fit) {}

  bool Run() {
    if (!FindDistribution() || mode_.Cancelled()) return false;
    ScoreFreshDraws();
    if (mode_.Cancelled()) return false;
    fit_.posterior.posterior.factor *= options_.element_sigma / fit_.hierarchy.fabric_sigma;
    return true;
  }

 private:
  ElementDraws MakeDraws(int count, uint64_t stream, BeyondBranch beyond) const {
    return {backend_,
            fit_.hierarchy.base,
            {fit_.hierarchy.fabric_sigma, options_.element_sigma},
            mode_.targets(),
            mode_.BatchOptionsOf(),
            count,
            SeedOfStream(options_.seed, stream),
            beyond};
  }

  static Eigen::VectorXd PointOf(const GaussianPosterior& q) {
    Eigen::VectorXd point(2 * q.size());
    point << q.mean, q.factor.diagonal();
    return point;
  }

  // From elements that scatter less than they may, less still where their drapes do not stand.
  bool FindDistribution() {
    constexpr int n = kMaterialEntries;
    for (const double deviation : {0.3, 0.1, 0.03, 0.01}) {
      const GaussianPosterior start{fit_.mode.posterior.mean, Eigen::MatrixXd::Identity(n, n),
                                    deviation * Eigen::MatrixXd::Identity(n, n)};
      ElementDraws draws = MakeDraws(options_.draws, kFitStream, BeyondBranch::kTangent);
      if (mode_.Cancelled()) return false;
      if (!draws.StartAt(PointOf(start))) continue;
      fit_.posterior =
          FitPosterior(draws, start,
                       mode_.OptionsOf(DrawKind::kElementwise, options_.iterations,
                                       PosteriorMode::kModeShare, PosteriorMode::kFitShare));
      fit_.counts += draws.counts();
      fit_.beyond = draws.num_beyond();
      if (fit_.posterior.termination != FitTermination::kFailed) return true;
    }
    return false;
  }

  // Noise that the fit has not seen, as much at a time as the fit had, until too few can stand.
  void ScoreFreshDraws() {
    const GaussianPosterior& q = fit_.posterior.posterior;
    std::vector<Eigen::VectorXd> residuals;
    Eigen::VectorXd residual;
    uint64_t stream = kFreshStream;
    const auto enough = [&](int left) { return int(residuals.size()) + left >= kLeastFresh; };
    for (int left = options_.fresh_draws; left > 0 && enough(left) && !mode_.Cancelled();
         left -= options_.draws) {
      const int count = std::min(left, options_.draws);
      ElementDraws fresh = MakeDraws(count, stream++, BeyondBranch::kRefuse);
      fresh.Prepare(PointOf(q).replicate(1, count), false);
      fit_.counts += fresh.counts();
      for (int s = 0; s < count; ++s)
        if (fresh.Copy(s, &residual, nullptr)) residuals.push_back(residual);
    }
    const std::vector<double> log_ratios(residuals.size(), -q.DivergenceFromPrior());
    ScoreDraws(residuals, log_ratios, &fit_);
  }

  Backend* backend_;
  const PosteriorOptions& options_;
  PosteriorMode& mode_;
  PosteriorFit& fit_;
};

}  // namespace

bool FitElements(const FitProblem& problem, const PosteriorOptions& options, PosteriorMode& mode,
                 PosteriorFit* fit) {
  return ElementFitter(problem, options, mode, fit).Run();
}

}  // namespace drape
