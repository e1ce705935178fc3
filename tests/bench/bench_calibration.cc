// SPDX-License-Identifier: Apache-2.0
// Simulation-based calibration [Talts 2018] of the posteriors of drapes. Fabrics are sampled from
// the prior of the hierarchy, and drapes of each are observed with noise on their outlines. The
// rank of the true parameters among samples of the fitted posterior is recorded. With
// --branches=given, each drape is on the branch that continues from one of the prior median, and a
// fit starts from there. With --branches=sought, each drape relaxes from a random start of its own,
// and a fit must find its branch from the outline, as drape_fit does.
#include <gflags/gflags.h>
#include <glog/logging.h>
#include <omp.h>

#include <Eigen/LU>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <vector>

#include "physics/mesh/mesh_spec.h"
#include "physics/util/math/random.h"
#include "solver/fit/protocol/initial_guess.h"
#include "solver/forward/settle.h"
#include "solver/posterior/variational_fit.h"
#include "tests/bench/fabrics.h"
#include "tests/solver/solver_fixture.h"

DEFINE_string(mesh, "disc:300", "mesh of the drapes");
DEFINE_string(fabric, DRAPE_SOURCE_DIR "/configs/fabrics/synthetic_wool.json",
              "file of the prior median");
DEFINE_int32(fabrics, 50, "number of fabrics sampled from the prior");
DEFINE_int32(specimens, 2, "specimens of each fabric");
DEFINE_int32(drapes, 2, "drapes of each specimen");
DEFINE_double(fabric_sigma, 0.3,
              "prior standard deviation of the log factors of the table columns");
DEFINE_double(specimen_sigma, 0.1,
              "prior standard deviation of the log factors of a specimen on stretch and on bend");
DEFINE_string(branches, "given", "branches of the drapes: given or sought");
DEFINE_int32(candidates_per_round, 4,
             "sought: number of initial guesses from which a mode is fitted");
DEFINE_double(sigma, 0.5,
              "standard deviation of the noise at each of the 36 angles of an outline [px]");
DEFINE_int32(samples, 16, "samples of a fit, an even number");
DEFINE_int32(rank, 8, "number of correlated directions of a fit in addition to the Laplace axes");
DEFINE_int32(iterations, 20, "maximum iterations of a fit");
DEFINE_int32(ranks, 99, "samples among which the true parameters are ranked");
DEFINE_uint64(seed, 1, "random seed of the first fabric");
DEFINE_int32(threads, 1, "fabrics that are fitted in parallel");

namespace drape {
namespace {

constexpr int kAngles = 36, kBins = 10;
constexpr double kMaxOutlineError = 1.5;  // relative to --sigma; noise alone gives 1 ± .12

const char* const kFamilies[] = {"Laplace", "mean field", "Laplace axes"};
constexpr int kNumFamilies = 3;

struct Outcome {
  // For each family: P ranks from 0 to --ranks, and the z scores of the true parameters, shape [P].
  std::vector<int> ranks[kNumFamilies];
  Eigen::VectorXd z[kNumFamilies];
  int num_extrapolated = 0;  // samples of the last family past the end of their branch
  double mode_error = 0;     // largest rms error of the outlines of the mode, relative to --sigma
  bool is_plausible() const { return mode_error < kMaxOutlineError; }
};

// A start of a fit: parameters in units of the prior, and the drapes there, specimen by specimen.
struct BranchStart {
  Eigen::VectorXd u;
  std::vector<Eigen::VectorXd> x;
};

ResidualOptions MakeOptions(double sigma) {
  ResidualOptions options = test::CloseOutlineOptions();
  options.sigma_px = sigma;
  options.equilibrium.max_iterations *= 2;
  return options;
}

// One fabric: its backend, the hierarchy, and the drapes of the prior median.
class Trial {
 public:
  Trial(const std::shared_ptr<const ClothModel>& model, const MaterialField& base, uint64_t seed)
      : backend_(MakeCpuBackend(model, 1)), random_(SeedOfStream(seed, 0)), seed_(seed) {
    hierarchy_ = {.base = base,
                  .fabric = ParameterTying::kColumns,
                  .fabric_sigma = FLAGS_fabric_sigma,
                  .specimen_stretch_sigma = FLAGS_specimen_sigma,
                  .specimen_bend_sigma = FLAGS_specimen_sigma,
                  .specimens = FLAGS_specimens};
  }

  // Returns std::nullopt, and the reason in *why, where the true parameters have no observable
  // drapes, or no mode is found.
  std::optional<Outcome> Run(const char** why) {
    SampleTrueParameters();
    const bool sought = FLAGS_branches == "sought";
    *why = sought ? "the true parameters have no stable drape" : "the median has no stable drape";
    if (!(sought ? SettleTrueDrapes() : SettleMedianDrapes())) return std::nullopt;
    *why = "the true parameters are past the end of a branch";
    if (!sought && !FollowToTrueParameters()) return std::nullopt;
    AddNoise();
    *why = "no mode was found";
    if (!FindMode(sought ? SoughtStarts() : GivenStarts())) return std::nullopt;
    *why = "";
    Score(0, mode_.gaussian);
    Score(1, Fit(MeanFieldStart(), 0));
    Score(2, Fit(mode_.gaussian, FLAGS_rank));
    return std::move(outcome_);
  }

 private:
  int latents() const { return hierarchy_.num_latents(); }
  int num_drapes() const { return FLAGS_specimens * FLAGS_drapes; }
  Observation& observation(int drape) {
    return specimens_[drape / FLAGS_drapes].observations[drape % FLAGS_drapes];
  }
  State& start(int drape) { return specimens_[drape / FLAGS_drapes].starts[drape % FLAGS_drapes]; }

  void SampleTrueParameters() {
    true_u_.resize(latents());
    for (double& number : true_u_) number = SampleNormal(random_);
    specimens_.assign(FLAGS_specimens,
                      {std::vector<Observation>(FLAGS_drapes), std::vector<State>(FLAGS_drapes)});
  }

  // The stable equilibrium that a start relaxes to; empty where there is none.
  Eigen::VectorXd RelaxedShape(const MaterialField& material, const State& start) const {
    const SettleOptions settling{.steps = {.h = 0.1, .steps = 100}};
    const SettledDrape drape = Settle(*backend_, material, {&start, 1}, settling).front();
    return drape.IsUsable(settling.solve_mode) ? drape.rest.x : Eigen::VectorXd();
  }
  State Start(int drape) const {
    return test::RandomStart(backend_->model(), SeedOfStream(seed_, 1 + drape), 3e-3);
  }
  static State AtRest(Eigen::VectorXd x) {
    const Eigen::Index size = x.size();
    return {std::move(x), Eigen::VectorXd::Zero(size)};
  }

  bool SettleMedianDrapes() {
    for (int i = 0; i < num_drapes(); ++i) {
      const Eigen::VectorXd x = RelaxedShape(hierarchy_.base, Start(i));
      if (x.size() == 0) return false;
      start(i) = AtRest(x);
      observation(i).radius = Eigen::VectorXd::Zero(kAngles);
    }
    return true;
  }

  // Follows the drapes of the median to those of the true parameters.
  bool FollowToTrueParameters() {
    // With zero outlines and σ = 1 px, the residuals are the outlines themselves.
    HierarchicalSamples one(backend_.get(), hierarchy_, specimens_, MakeOptions(1.0), 1);
    if (!one.StartAt(Eigen::VectorXd::Zero(latents()))) return false;
    one.Prepare(true_u_, false);
    Eigen::VectorXd outlines;
    if (!one.Residuals(0, &outlines, nullptr)) return false;
    for (int i = 0; i < num_drapes(); ++i)
      observation(i).radius = outlines.segment(i * kAngles, kAngles);
    return true;
  }

  // Relaxes the drapes of the true parameters onto whichever branches they reach.
  bool SettleTrueDrapes() {
    for (int i = 0; i < num_drapes(); ++i) {
      const TableParametrisation specimen(hierarchy_.base, hierarchy_.LogEntries(i / FLAGS_drapes));
      const Eigen::VectorXd x = RelaxedShape(specimen.Material(true_u_), Start(i));
      Outline outline;
      if (x.size() == 0 || !OutlineFromMesh(backend_->model().mesh, x, Camera(), kAngles, &outline))
        return false;
      observation(i).radius = outline.radius;
    }
    return true;
  }

  void AddNoise() {
    for (int i = 0; i < num_drapes(); ++i)
      for (double& radius : observation(i).radius) radius += FLAGS_sigma * SampleNormal(random_);
  }

  std::vector<BranchStart> GivenStarts() {
    BranchStart median{Eigen::VectorXd::Zero(latents()), {}};
    for (int i = 0; i < num_drapes(); ++i) median.x.push_back(start(i).x);
    return {median};
  }

  // Drapes from flaps below the outlines, of the materials of a grid about the median.
  std::vector<BranchStart> SoughtStarts() {
    const std::vector<double> factors = {0.6, 1.0, 1.6};
    std::vector<Observation> all;
    for (int i = 0; i < num_drapes(); ++i) all.push_back(observation(i));
    TriedGuesses tried;
    TryInitialGuesses(*backend_, {hierarchy_.base}, all, {.stretch = factors, .bend = factors}, {},
                      tried, [] {});
    std::vector<BranchStart> starts;
    for (const InitialGuess& guess : RankGuesses(tried)) {
      if (static_cast<int>(starts.size()) == FLAGS_candidates_per_round) break;
      BranchStart start{Eigen::VectorXd::Zero(latents()), {}};
      for (int k = 0; k < hierarchy_.num_fabric(); ++k)
        start.u[k] = std::log(k < kStretchCols ? guess.stretch : guess.bend) / FLAGS_fabric_sigma;
      const MaterialField scaled = Scaled(hierarchy_.base, guess.stretch, guess.bend);
      for (int i = 0; i < num_drapes(); ++i)
        start.x.push_back(
            RelaxedShape(scaled, StartAt(*all[i].Measured(), backend_->model(), guess.lifts[i])));
      if (std::all_of(start.x.begin(), start.x.end(), [](const auto& x) { return x.size() > 0; }))
        starts.push_back(std::move(start));
    }
    return starts;
  }

  // Finds the best mode of all starts; its drapes become the starts. Where the
  // branch is sought, σ is estimated from the residual of the mode, as drape_fit does.
  bool FindMode(const std::vector<BranchStart>& starts) {
    constexpr int kIterations = 60, kFirstIterations = 10;
    const bool sought = FLAGS_branches == "sought";
    BranchStart best;
    for (const BranchStart& start : starts)
      TryMode(start, sought ? kFirstIterations : kIterations, &best);
    if (sought && !best.x.empty()) {
      const double determined = latents() - mode_.gaussian.Covariance().trace();
      const double freedom = std::max(1.0, double(residual_.size()) - determined);
      sigma_ = std::max(sigma_, sigma_ * residual_.norm() / std::sqrt(freedom));
      const BranchStart first = std::move(best);
      best = {};
      TryMode(first, kIterations, &best);
    }
    for (std::size_t i = 0; i < best.x.size(); ++i) {
      const double rms = residual_.segment(i * kAngles, kAngles).norm() / std::sqrt(kAngles);
      outcome_.mode_error = std::max(outcome_.mode_error, rms * sigma_ / FLAGS_sigma);
      start(static_cast<int>(i)) = AtRest(best.x[i]);
    }
    return !best.x.empty();
  }
  // Keeps the mode from this start when it is better than *best.
  void TryMode(const BranchStart& from, int iterations, BranchStart* best) {
    for (int i = 0; i < num_drapes(); ++i) start(i) = AtRest(from.x[i]);
    HierarchicalSamples one(backend_.get(), hierarchy_, specimens_, MakeOptions(sigma_), 1);
    if (!one.StartAt(from.u)) return;
    VariationalOptions options;
    options.kind = SampleKind::kMode;
    options.trust_region.max_iterations = iterations;
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(latents(), latents());
    VariationalFit mode = FitPosterior(one, {from.u, unit, unit}, options);
    if (mode.termination == FitTermination::kFailed) return;
    if (!best->x.empty() && mode.cost >= mode_.cost) return;
    one.Prepare(mode.gaussian.mean, false);
    Eigen::VectorXd residual;
    if (!one.Residuals(0, &residual, nullptr)) return;
    *best = {mode.gaussian.mean, one.Shapes(0)};
    residual_ = std::move(residual);
    mode_ = std::move(mode);
  }

  GaussianPosterior MeanFieldStart() const {
    GaussianPosterior start = mode_.gaussian;
    const Eigen::VectorXd precisions = start.Covariance().inverse().diagonal();
    start.rotation.setIdentity();
    start.factor = precisions.cwiseInverse().cwiseSqrt().asDiagonal();
    return start;
  }

  GaussianPosterior Fit(const GaussianPosterior& start, int rank) {
    HierarchicalSamples samples(backend_.get(), hierarchy_, specimens_, MakeOptions(sigma_),
                                FLAGS_samples, LostBranchPolicy::kExtrapolate);
    if (!samples.StartAt(start.mean)) return start;
    VariationalOptions options;
    options.draws = FLAGS_samples;
    options.rank = rank;
    options.seed = seed_;
    options.trust_region.max_iterations = FLAGS_iterations;
    options.trust_region.cost_tolerance = 1e-4;
    const GaussianPosterior found = FitPosterior(samples, start, options).gaussian;
    outcome_.num_extrapolated = samples.num_extrapolated();
    return found;
  }

  void Score(int family, const GaussianPosterior& q) {
    const Eigen::MatrixXd samples =
        q.Draws(IndependentSamples(latents(), FLAGS_ranks, SeedOfStream(seed_, 100)));
    for (int i = 0; i < latents(); ++i)
      outcome_.ranks[family].push_back(
          static_cast<int>((samples.row(i).array() < true_u_[i]).count()));
    outcome_.z[family] = (true_u_ - q.mean).cwiseQuotient(q.Covariance().diagonal().cwiseSqrt());
  }

  const std::unique_ptr<Backend> backend_;
  std::mt19937_64 random_;
  const uint64_t seed_;
  HierarchicalModel hierarchy_;
  std::vector<SpecimenDrapes> specimens_;  // by specimen
  Eigen::VectorXd true_u_;
  double sigma_ = FLAGS_sigma;  // of the outlines, as the fit assumes it
  VariationalFit mode_;
  Eigen::VectorXd residual_;  // of the mode
  Outcome outcome_;
};

// The probability of a larger χ² of ranks that are uniform over kBins bins.
double ComputeUniformity(const std::vector<int>& ranks) {
  std::vector<double> counts(kBins, 0.0);
  for (const int rank : ranks) counts[kBins * rank / (FLAGS_ranks + 1)] += 1.0;
  const double expected = static_cast<double>(ranks.size()) / kBins;
  double sum = 0.0;
  for (const double count : counts) sum += (count - expected) * (count - expected) / expected;
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(kBins - 1), sum));
}

void PrintFamily(int family, const std::vector<Outcome>& outcomes) {
  constexpr double k90 = 1.6448536, k50 = 0.6744898;  // quantiles of |z|
  std::vector<int> all;
  int in90 = 0, in50 = 0;
  double smallest = 1.0;
  const int numbers = static_cast<int>(outcomes.front().z[family].size());
  for (int i = 0; i < numbers; ++i) {
    std::vector<int> of_number;
    for (const Outcome& outcome : outcomes) {
      of_number.push_back(outcome.ranks[family][i]);
      const double z = std::abs(outcome.z[family][i]);
      in90 += z < k90;
      in50 += z < k50;
    }
    smallest = std::min(smallest, ComputeUniformity(of_number));
    all.insert(all.end(), of_number.begin(), of_number.end());
  }
  const double count = static_cast<double>(all.size());
  std::printf("%-14s %8.1f %8.1f %12.4f %18.4f\n", kFamilies[family], 100 * in50 / count,
              100 * in90 / count, ComputeUniformity(all), std::min(1.0, numbers * smallest));
}

void PrintFamilies(const char* which, const std::vector<Outcome>& outcomes) {
  std::printf("%s: %zu of %d fabrics\n", which, outcomes.size(), FLAGS_fabrics);
  if (outcomes.empty()) return;
  std::printf("%-14s %8s %8s %12s %18s\n", "family", "in 50 %", "in 90 %", "p, all ranks",
              "p, worst parameter");
  for (int family = 0; family < kNumFamilies; ++family) PrintFamily(family, outcomes);
}

void Run() {
  CHECK(FLAGS_branches == "given" || FLAGS_branches == "sought") << FLAGS_branches;
  const auto model =
      std::make_shared<ClothModel>(ParseMeshSpec(FLAGS_mesh), CusickScene(), MakeLaw("smooth"));
  const MaterialField base = ReadFabric(FLAGS_fabric);
  std::vector<std::optional<Outcome>> found(FLAGS_fabrics);
#pragma omp parallel for schedule(dynamic) num_threads(FLAGS_threads)
  for (int i = 0; i < FLAGS_fabrics; ++i) {
    const char* why = "";
    found[i] = Trial(model, base, FLAGS_seed + i).Run(&why);
#pragma omp critical
    if (found[i]) {
      std::printf("fabric %d: worst drape of the mode %.2f sigma, %d samples extrapolated, z",
                  i + 1, found[i]->mode_error, found[i]->num_extrapolated);
      for (const double z : found[i]->z[2]) std::printf(" %.2f", z);
      std::printf("\n");
    } else {
      std::printf("fabric %d: left out, %s\n", i + 1, why);
    }
    std::fflush(stdout);
  }
  std::vector<Outcome> outcomes;
  for (auto& outcome : found)
    if (outcome) outcomes.push_back(std::move(*outcome));
  PrintFamilies("all", outcomes);
  std::vector<Outcome> right;
  for (const Outcome& outcome : outcomes)
    if (outcome.is_plausible()) right.push_back(outcome);
  PrintFamilies("all outlines of the mode within 1.5 sigma", right);
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  google::InitGoogleLogging(argv[0]);
  drape::Run();
  return 0;
}
