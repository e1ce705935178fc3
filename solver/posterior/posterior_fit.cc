// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/posterior_fit.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "losses/outline/outline.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "solver/fit/parametrisation.h"

namespace drape {
namespace {

constexpr int kModeIterations = 40;
constexpr double kUsualModeIterations = 10.0;  // of mode or distribution, for the progress line
constexpr int kSigmaRounds = 2;       // of mode and σ in alternation, from σ of the candidate
constexpr double kLeastSigma = 0.05;  // of an estimate: that of the measured outline [px]
constexpr double kMapTolerance = 1e-4;
constexpr int kSampleNewtonFactor = 2;  // a sample lies further from the mode than a trial

// The profile estimate of k for exceedances x > 0, ascending.
double ZhangStephens(const Eigen::ArrayXd& x) {
  constexpr double kPrior = 3.0;
  const auto n = static_cast<double>(x.size());
  const int points = 30 + static_cast<int>(std::sqrt(n));
  const double quartile = x[static_cast<Eigen::Index>(std::floor(n / 4 + 0.5)) - 1];
  Eigen::ArrayXd theta(points), likelihood(points);
  const auto shape = [&](double t) { return (1 - t * x).log().mean(); };
  for (int j = 0; j < points; ++j) {
    theta[j] = 1 / x[x.size() - 1] + (1 - std::sqrt(points / (j + 0.5))) / (kPrior * quartile);
    const double k = shape(theta[j]);
    likelihood[j] = n * (std::log(-theta[j] / k) - k - 1);
  }
  const Eigen::ArrayXd weight = (likelihood - likelihood.maxCoeff()).exp();
  return shape((weight * theta).sum() / weight.sum());
}

// A Pareto tail cannot be fitted to fewer samples.
constexpr int kMinElboSamples = 25;

// Model bdp: its bound is derived in posterior_fit.h.

// Random streams: the noise of the fit, then of each batch of independent samples.
enum ElementStream : uint64_t { kFitStream, kIndependentStream };

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
  std::unique_ptr<HierarchicalSamples> MakeSamples(int count, uint64_t stream,
                                                   LostBranchPolicy policy) const {
    return HierarchicalSamples::Elementwise(backend_, fit_.hierarchy.base,
                                            {fit_.hierarchy.fabric_sigma, options_.element_sigma},
                                            mode_.specimens(), mode_.MakeResidualOptions(), count,
                                            SeedOfStream(options_.seed, stream), policy);
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
    constexpr int kCount = kMaterialEntries;
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(kCount, kCount);
    const Eigen::VectorXd& mean = fit_.mode.gaussian.mean;
    CHECK_EQ(mean.size(), kCount) << "each entry has a mean of its own";
    const auto draws = MakeSamples(options_.draws, kFitStream, LostBranchPolicy::kExtrapolate);
    if (!draws->StartAt(ReadPoint({mean, unit, drapes * unit}))) return false;
    fit_.distribution =
        FitPosterior(*draws, {mean, unit, deviation * unit},
                     mode_.MakeOptions(SampleKind::kElementwise, options_.iterations,
                                       MapEstimator::kModeShare, MapEstimator::kFitShare));
    fit_.counts += draws->counts();
    fit_.num_extrapolated = draws->num_extrapolated();
    return fit_.distribution.termination != FitTermination::kFailed;
  }

  // Draws noise that the fit has not used, in batches of its size, until too few samples can be
  // valid.
  void EstimateElboOfFit() {
    const GaussianPosterior& q = fit_.distribution.gaussian;
    std::vector<Eigen::VectorXd> residuals;
    Eigen::VectorXd residual;
    uint64_t stream = kIndependentStream;
    const auto enough = [&](int left) { return int(residuals.size()) + left >= kMinElboSamples; };
    for (int left = options_.elbo_samples; left > 0 && enough(left) && !mode_.Cancelled();
         left -= options_.draws) {
      const int count = std::min(left, options_.draws);
      const auto independent = MakeSamples(count, stream++, LostBranchPolicy::kReject);
      independent->Prepare(ReadPoint(q).replicate(1, count), false);
      fit_.counts += independent->counts();
      for (int s = 0; s < count; ++s)
        if (independent->Residuals(s, &residual, nullptr)) residuals.push_back(residual);
    }
    const std::vector<double> log_ratios(residuals.size(), -q.DivergenceFromPrior());
    EstimateElbo(residuals, log_ratios, &fit_);
  }

  Backend* backend_;
  const PosteriorOptions& options_;
  MapEstimator& mode_;
  PosteriorFit& fit_;
};

// The squares of the residuals that are by PosteriorFit::sigma: all of an experiment; of images
// the outlines', which come before the strips'.
double SquaresBySigma(const PosteriorFit& fit, const Eigen::VectorXd& residual) {
  return (fit.of_experiment ? residual : residual.head(fit.independent)).squaredNorm();
}

// The posterior given the observed branches, each extrapolated linearly past its end.
bool FindDistribution(const PosteriorOptions& options, const MapEstimator& mode,
                      PosteriorFit* fit) {
  HierarchicalSamples draws = mode.MakeSamples(options.draws, LostBranchPolicy::kExtrapolate);
  if (mode.Cancelled() || !draws.StartAt(fit->mode.gaussian.mean)) return false;
  fit->distribution =
      FitPosterior(draws, fit->mode.gaussian,
                   mode.MakeOptions(SampleKind::kShared, options.iterations,
                                    MapEstimator::kModeShare, MapEstimator::kFitShare));
  fit->counts += draws.counts();
  fit->num_extrapolated = draws.num_extrapolated();
  return fit->distribution.termination != FitTermination::kFailed;
}

// For each observation, how many of its sample's outlines come before it: those of a sample go
// specimen by specimen.
std::vector<Eigen::Index> OutlinePlaces(const std::vector<int>& specimen, int specimens) {
  std::vector<Eigen::Index> places(specimen.size());
  Eigen::Index next = 0;
  for (int p = 0; p < specimens; ++p)
    for (std::size_t i = 0; i < specimen.size(); ++i)
      if (specimen[i] == p) places[i] = next++;
  return places;
}

// Collects samples of a fit with the outlines that their residuals (r − r_image)/σ stand for.
class SampleCollector {
 public:
  SampleCollector(const MapEstimator& mode, const PosteriorFit& fit, int drawn)
      : fit_(fit), places_(OutlinePlaces(fit.specimen, fit.hierarchy.specimens)) {
    std::vector<const Observation*> by_specimen;
    for (const SpecimenDrapes& specimen : mode.specimens())
      for (const Observation& each : specimen.observations) by_specimen.push_back(&each);
    stored_.drawn = drawn;
    if (fit.of_experiment) return;
    for (const Eigen::Index place : places_) {
      const Observation& image = *by_specimen[place];
      const double metre = image.outline_camera().pixels_per_metre();
      stored_.images.push_back({image.name, fit.sigma / metre, image.radius / metre});
    }
  }
  void Add(const Eigen::VectorXd& u, const Eigen::VectorXd& residual, double log_prior,
           double log_density) {
    const Eigen::Index angles = stored_.angles();
    StoredSamples::Sample sample{fit_.hierarchy.LatentRoot() * u, log_prior, log_density,
                                 Eigen::MatrixXd(angles, stored_.images.size()),
                                 -0.5 * residual.squaredNorm()};
    for (std::size_t i = 0; i < stored_.images.size(); ++i)
      sample.radius.col(i) =
          stored_.images[i].radius +
          stored_.images[i].sigma * residual.segment(angles * places_[i], angles);
    stored_.samples.push_back(std::move(sample));
  }
  StoredSamples Take() { return std::move(stored_); }

 private:
  const PosteriorFit& fit_;
  const std::vector<Eigen::Index> places_;
  StoredSamples stored_;
};

// ln p(r | u) + ln p(u) − ln q(u) of independent samples.
void EstimateElboOfFit(const PosteriorOptions& options, const MapEstimator& mode,
                       PosteriorFit* fit) {
  const GaussianPosterior& q = fit->distribution.gaussian;
  fit->samples.emplace();
  HierarchicalSamples at_mode = mode.MakeSamples(1, LostBranchPolicy::kReject);
  if (!at_mode.StartAt(fit->mode.gaussian.mean)) return EstimateElbo({}, {}, fit);
  const Eigen::MatrixXd standard =
      IndependentSamples(q.size(), options.elbo_samples, options.seed + 1);
  const Eigen::MatrixXd u = q.Draws(standard);
  const double volume = q.factor.diagonal().array().log().sum();
  const double constant = 0.5 * q.size() * std::log(2 * std::numbers::pi);
  SampleCollector collector(mode, *fit, options.elbo_samples);
  std::vector<Eigen::VectorXd> residuals;
  std::vector<double> log_ratios;
  Eigen::VectorXd residual;
  // Takes as many at a time as the fit had, since each holds a Jacobian.
  for (int first = 0; first < options.elbo_samples && !mode.Cancelled(); first += options.draws) {
    const int count = std::min(options.draws, options.elbo_samples - first);
    const auto independent = at_mode.WithSamples(count, LostBranchPolicy::kReject);
    independent->Prepare(u.middleCols(first, count), false);
    fit->counts += independent->counts();
    for (int s = first; s < first + count; ++s) {
      if (!independent->Residuals(s - first, &residual, nullptr)) continue;
      const double log_prior = -0.5 * u.col(s).squaredNorm() - constant;
      const double log_density = -0.5 * standard.col(s).squaredNorm() - volume - constant;
      residuals.push_back(residual);
      log_ratios.push_back(log_prior - log_density);
      collector.Add(u.col(s), residual, log_prior, log_density);
    }
  }
  EstimateElbo(residuals, log_ratios, fit);
  fit->samples = collector.Take();
}

bool FitHierarchy(const PosteriorOptions& options, const MapEstimator& mode, PosteriorFit* fit) {
  if (!FindDistribution(options, mode, fit)) return false;
  EstimateElboOfFit(options, mode, fit);
  return !mode.Cancelled();
}

}  // namespace

void EstimateElbo(const std::vector<Eigen::VectorXd>& residuals,
                  const std::vector<double>& log_ratios, PosteriorFit* fit) {
  fit->elbo_samples_valid = static_cast<int>(residuals.size());
  if (fit->elbo_samples_valid < kMinElboSamples) {
    fit->elbo = fit->elbo_error = fit->pareto_k = fit->sample_rms =
        std::numeric_limits<double>::quiet_NaN();
    return;
  }
  const double count = fit->independent;
  Eigen::ArrayXd weights(fit->elbo_samples_valid), squares(fit->elbo_samples_valid);
  for (int s = 0; s < fit->elbo_samples_valid; ++s) {
    squares[s] = SquaresBySigma(*fit, residuals[s]);
    weights[s] = log_ratios[s] - 0.5 * residuals[s].squaredNorm();
  }
  weights -= count * std::log(fit->sigma * std::sqrt(2 * std::numbers::pi));
  fit->elbo = weights.mean();
  fit->elbo_error = std::sqrt((weights - fit->elbo).square().mean() / fit->elbo_samples_valid);
  fit->pareto_k = ParetoShape(weights.matrix());
  fit->sample_rms = fit->sigma * std::sqrt(squares.mean() / count);
}

void PosteriorOptions::Check() const {
  CheckFields(*this);
  CHECK_EQ(draws % 2, 0) << "draws";
}

MaterialField PosteriorFit::FabricAt(const Eigen::VectorXd& u) const {
  Eigen::MatrixXd common = hierarchy.LogEntries(0);
  common.rightCols(common.cols() - hierarchy.num_fabric()).setZero();
  return TableParametrisation(hierarchy.base, common).Material(u);
}

MapEstimator::MapEstimator(const FitProblem& problem, const StagedFitOptions& staged,
                           const PosteriorOptions& options, const FitCandidate& candidate,
                           const RunControl& control, PosteriorFit* fit)
    : problem_(problem),
      staged_(staged),
      options_(options),
      control_(control),
      candidate_fitter_(problem, staged, *problem.fine, control.cancel, 0),
      fit_(*fit) {
  options.Check();
  fit_.kind = options.kind;
  fit_.of_experiment = FindExperiment(problem) != nullptr;
  SetHierarchy(candidate);
  fit_.independent = CountIndependentNumbers();
  const double given = fit_.of_experiment ? 1.0 : staged.residuals.sigma_px;
  fit_.sigma = options.estimate_sigma ? SigmaBy(candidate.profile_rms) : given;
  SetSpecimens(candidate);
  mean_ = Eigen::VectorXd::Zero(fit_.hierarchy.num_latents());
  mean_.head(fit_.hierarchy.num_fabric()) = StartNumbers(candidate);
}

bool MapEstimator::Find() {
  const int rounds = options_.estimate_sigma ? kSigmaRounds : 1;
  for (int round = 0; round < rounds && !Cancelled(); ++round)
    if (!FindOnce(round, rounds)) return false;
  return !Cancelled();
}

void MapEstimator::SetHierarchy(const FitCandidate& candidate) {
  CHECK(problem_.specimens.empty() || problem_.specimens.size() == problem_.observations.size());
  for (int i = 0; i < int(problem_.observations.size()); ++i)
    fit_.specimen.push_back(problem_.specimens.empty() ? i : problem_.specimens[i] - 1);
  const bool hierarchical = options_.kind == PosteriorKind::kHierarchy;
  fit_.hierarchy = {.base = candidate.base,
                    .fabric = staged_.parameters,
                    .fabric_sigma = staged_.prior_sigma,
                    .specimen_stretch_sigma = hierarchical ? options_.specimen_stretch_sigma : 0.0,
                    .specimen_bend_sigma = hierarchical ? options_.specimen_bend_sigma : 0.0,
                    .specimens = 1 + *std::max_element(fit_.specimen.begin(), fit_.specimen.end())};
  if (!options_.prior) return;
  fit_.hierarchy.base = options_.prior->median;
  fit_.hierarchy.fabric_root = options_.prior->root;
}

// The numbers of the candidate's tables, or of the nearest ones that the prior's numbers can make.
Eigen::VectorXd MapEstimator::StartNumbers(const FitCandidate& candidate) const {
  if (!options_.prior) return candidate.theta / staged_.prior_sigma;
  const MaterialField& median = options_.prior->median;
  Eigen::VectorXd log_factors = FindLogFactors(median, FittedMaterial(staged_, candidate));
  for (double& factor : log_factors)
    if (!std::isfinite(factor)) factor = 0.0;
  return options_.prior->root.triangularView<Eigen::Lower>().solve(
      MeanLogFactors(TyingMatrix(staged_.parameters), log_factors));
}

void MapEstimator::SetSpecimens(const FitCandidate& candidate) {
  specimens_.resize(fit_.hierarchy.specimens);
  const std::vector<State> drapes = AtRest(candidate.shapes);
  for (std::size_t i = 0; i < drapes.size(); ++i) {
    const Observation& observation = problem_.observations[i];
    SpecimenDrapes& specimen = specimens_[fit_.specimen[i]];
    specimen.observations.push_back(ForPosterior(observation));
    specimen.starts.push_back(drapes[i]);
  }
}

int MapEstimator::CountIndependentNumbers() const {
  const Experiment* experiment = FindExperiment(problem_);
  if (experiment == nullptr) return options_.angles * int(problem_.observations.size());
  int sum = 0;
  for (const Sight& sight : MakeSights(*experiment, problem_.fine->model()))
    sum += CountIndependent(sight);
  for (const RolloutBlock& block : BlocksOfFabric()) sum += block.num_independent();
  return sum;
}

// σ, or the factor on it, where the residuals are as large, root mean square.
double MapEstimator::SigmaBy(double misfit) const {
  return fit_.of_experiment ? EnlargeSigma(misfit, fit_.independent)
                            : std::max(kLeastSigma, misfit);
}

// Strips and further experiments, which elements with tables of their own do not have.
std::vector<RolloutBlock> MapEstimator::BlocksOfFabric() const {
  if (options_.kind != PosteriorKind::kHierarchy) return {};
  std::vector<RolloutBlock> blocks = FurtherBlocks(ForIntervals(problem_), control_.cancel);
  for (RolloutBlock& block : blocks)
    for (Sight& sight : block.sights)
      if (fit_.of_experiment) sight.sigma *= fit_.sigma;
  return blocks;
}

// An outline is at the posterior's angles, an experiment has σ times their factor.
Observation MapEstimator::ForPosterior(Observation observation) const {
  if (fit_.of_experiment) {
    Experiment enlarged = ForIntervals(*observation.experiment);
    for (Measurement& each : enlarged.measurements) each.sigma *= fit_.sigma;
    observation.experiment = std::make_shared<const Experiment>(std::move(enlarged));
    return observation;
  }
  std::optional<Eigen::VectorXd> radius = observation.MeasureRadius(options_.angles);
  if (!radius)
    throw InputError(observation.file, "no closed outline at " + std::to_string(options_.angles) +
                                           " angles, expected the silhouette of a drape");
  observation.radius = *std::move(radius);
  return observation;
}

ResidualOptions MapEstimator::MakeResidualOptions() const {
  ResidualOptions options = candidate_fitter_.MakeResidualOptions();
  if (!fit_.of_experiment) options.sigma_px = fit_.sigma;
  options.equilibrium.max_iterations *= kSampleNewtonFactor;
  return options;
}

HierarchicalSamples MapEstimator::MakeSamples(int count, LostBranchPolicy policy) const {
  return {problem_.fine, fit_.hierarchy, specimens_,      MakeResidualOptions(),
          count,         policy,         BlocksOfFabric()};
}

VariationalOptions MapEstimator::MakeOptions(SampleKind kind, int iterations, double from,
                                             double to) const {
  VariationalOptions options;
  options.kind = kind;
  options.draws = options_.draws;
  options.rank = options_.rank;
  options.seed = options_.seed;
  options.trust_region.max_iterations = iterations;
  options.trust_region.cost_tolerance = kMapTolerance;
  options.trust_region.cancel = control_.cancel;
  options.trust_region.progress = [this, from, to](const FitIteration& iteration) {
    const double share = IterationShare(iteration.iteration, kUsualModeIterations);
    control_.Report(from + (to - from) * share, "posterior");
  };
  return options;
}

bool MapEstimator::FindOnce(int round, int rounds) {
  HierarchicalSamples one = MakeSamples(1, LostBranchPolicy::kRejectAtOnce);
  if (!one.StartAt(mean_)) return false;
  const int n = fit_.hierarchy.num_latents();
  const GaussianPosterior start{mean_, Eigen::MatrixXd::Identity(n, n),
                                Eigen::MatrixXd::Identity(n, n)};
  fit_.mode =
      FitPosterior(one, start,
                   MakeOptions(SampleKind::kMode, kModeIterations, kModeShare * round / rounds,
                               kModeShare * (round + 1) / rounds));
  fit_.counts += one.counts();
  if (fit_.mode.termination == FitTermination::kFailed) return false;
  mean_ = fit_.mode.gaussian.mean;
  one.Prepare(mean_, false);
  Eigen::VectorXd residual;
  if (!one.Residuals(0, &residual, nullptr)) return false;
  StartFrom(one.Shapes(0));
  if (options_.estimate_sigma && round + 1 < rounds) EstimateSigma(residual);
  return true;
}

// The drapes of a point, specimen by specimen, become the starts.
void MapEstimator::StartFrom(const std::vector<Eigen::VectorXd>& shapes) {
  std::size_t next = 0;
  for (SpecimenDrapes& specimen : specimens_)
    for (State& start : specimen.starts) start.x = shapes[next++];
}

// σ² = (residual sum of squares) / (its degrees of freedom, less those of the mode: tr(1 − Σ) of
// its Laplace covariance).
void MapEstimator::EstimateSigma(const Eigen::VectorXd& residual) {
  const double determined = mean_.size() - fit_.mode.gaussian.Covariance().trace();
  const double freedom = std::max(1.0, fit_.independent - determined);
  fit_.sigma = SigmaBy(fit_.sigma * std::sqrt(SquaresBySigma(fit_, residual) / freedom));
  if (!fit_.of_experiment) return;
  for (std::size_t i = 0; i < problem_.observations.size(); ++i)
    specimens_[fit_.specimen[i]].observations = {ForPosterior(problem_.observations[i])};
}

bool MapEstimator::ReportDrapes() {
  HierarchicalSamples sample = MakeSamples(1, LostBranchPolicy::kReject);
  if (!sample.StartAt(fit_.mode.gaussian.mean)) return false;
  const auto is_found = [&](const Eigen::VectorXd& u) {
    sample.Prepare(u, false);
    return sample.num_extrapolated() == 0;
  };
  fit_.reported_at_mode = std::isnan(fit_.elbo) || !is_found(fit_.distribution.gaussian.mean);
  if (fit_.reported_at_mode && !is_found(fit_.mode.gaussian.mean)) return false;
  const std::vector<Eigen::VectorXd> by_specimen = sample.Shapes(0);
  fit_.counts += sample.counts();
  for (const Eigen::Index place : OutlinePlaces(fit_.specimen, fit_.hierarchy.specimens))
    fit_.shapes.push_back(by_specimen[place]);
  for (const int p : fit_.specimen)
    fit_.materials.push_back(TableParametrisation(fit_.hierarchy.base, fit_.hierarchy.LogEntries(p))
                                 .Material(fit_.reported_mean()));
  return true;
}

double ParetoShape(const Eigen::VectorXd& log_weights) {
  constexpr double kTowards = 0.5, kTowardsCount = 10.0;
  CHECK_GE(log_weights.size(), 25);
  CHECK(log_weights.allFinite());
  Eigen::VectorXd sorted = log_weights.array() - log_weights.maxCoeff();
  if (sorted.minCoeff() == 0.0) return 0.0;
  std::sort(sorted.begin(), sorted.end());
  const auto n = static_cast<double>(sorted.size());
  const auto tail = static_cast<Eigen::Index>(std::ceil(std::min(0.2 * n, 3 * std::sqrt(n))));
  const double cut = std::exp(sorted[sorted.size() - tail - 1]);
  const Eigen::ArrayXd above = sorted.tail(tail).array().exp() - cut;
  const Eigen::Index positive = (above > 0).count();
  if (positive < 5) return std::numeric_limits<double>::infinity();
  const double k = ZhangStephens(above.tail(positive));
  const auto count = static_cast<double>(positive);
  return (count * k + kTowardsCount * kTowards) / (count + kTowardsCount);
}

bool FitElements(const FitProblem& problem, const PosteriorOptions& options, MapEstimator& mode,
                 PosteriorFit* fit) {
  return ElementFitter(problem, options, mode, fit).Run();
}

void CountForm(StagedFitOptions& staged, FitCandidate& candidate, PosteriorOptions& options) {
  constexpr double kFixed = 1e-24;  // variance of the entries that no number varies
  const Eigen::MatrixXd tie = TyingMatrix(staged.parameters),
                        with_form = staged.prior_sigma * TieWithForm(tie, staged.prior_sigma);
  Eigen::MatrixXd covariance = with_form * with_form.transpose();
  covariance.diagonal().array() += kFixed;
  staged.parameters = ParameterTying::kEntries;
  candidate.theta = tie * candidate.theta;
  options.prior =
      std::make_shared<const FabricPrior>(FabricPrior{candidate.base, covariance.llt().matrixL()});
}

PosteriorFit FitDrapePosterior(const FitProblem& problem, const StagedFitOptions& staged,
                               const PosteriorOptions& options, const FitCandidate& candidate,
                               const RunControl& control) {
  PosteriorFit fit;
  MapEstimator mode(problem, staged, options, candidate, control, &fit);
  if (!mode.Find()) return fit;
  const bool fitted = options.kind == PosteriorKind::kElements
                          ? FitElements(problem, options, mode, &fit)
                          : FitHierarchy(options, mode, &fit);
  if (!fitted || !mode.ReportDrapes()) fit.shapes.clear();
  return fit;
}

}  // namespace drape
