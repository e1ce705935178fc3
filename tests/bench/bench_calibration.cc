// SPDX-License-Identifier: Apache-2.0
// Simulation-based calibration (Talts et al. 2018) of the posteriors of drapes: fabrics drawn from
// the prior of the hierarchy, drapes of each with noise on their outlines, and where the truth
// ranks among draws of the posterior that is fitted to them. Each drape is on the branch that goes
// on from one of the prior's median, and a fit starts from there: that a fit finds the branch is
// not what this tests.
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

#include "physics/blas.h"
#include "physics/mesh_spec.h"
#include "physics/random.h"
#include "solver/drape_draws.h"
#include "tests/bench/fabrics.h"
#include "tests/solver/solver_fixture.h"

DEFINE_string(mesh, "disc:300", "mesh spec");
DEFINE_string(fabric, DRAPE_SOURCE_DIR "/configs/fabrics/synthetic_wool.json", "prior's median");
DEFINE_int32(fabrics, 50, "drawn from the prior");
DEFINE_int32(specimens, 2, "of a fabric");
DEFINE_int32(drapes, 2, "of a specimen");
DEFINE_double(fabric_sigma, 0.3, "prior standard deviation of the log factors of table columns");
DEFINE_double(specimen_sigma, 0.1, "of a specimen's log factors on stretch and on bend");
DEFINE_double(sigma, 0.5, "noise of an outline at each of 36 angles [px]");
DEFINE_int32(draws, 16, "of a fit, even");
DEFINE_int32(rank, 8, "correlated directions of a fit beyond the Laplace axes");
DEFINE_int32(iterations, 20, "of a fit");
DEFINE_int32(ranks, 99, "draws that the truth is ranked among");
DEFINE_uint64(seed, 1, "of the first fabric");
DEFINE_int32(threads, 1, "fabrics side by side");

namespace drape {
namespace {

constexpr int kAngles = 36, kBins = 10;

const char* const kFamilies[] = {"Laplace", "mean field", "Laplace axes"};
constexpr int kNumFamilies = 3;

struct Outcome {
  // Of each family: P ranks from 0 to --ranks, z scores of the truth, shape [P].
  std::vector<int> ranks[kNumFamilies];
  Eigen::VectorXd z[kNumFamilies];
  int beyond = 0;         // draws of the last family beyond their branch
  double mode_error = 0;  // greatest difference of the mode's residuals from noise, rms over angles
};

BatchOptions OptionsOf(double sigma) {
  BatchOptions options;
  options.sigma_px = sigma;
  options.equilibrium.max_iterations *= 2;
  return options;
}

// One fabric: its backend, the hierarchy, and the drapes of the prior's median.
class Trial {
 public:
  Trial(const std::shared_ptr<const ClothModel>& model, const MaterialField& base, uint64_t seed)
      : backend_(MakeCpuBackend(model, 1)), random_(SeedOfStream(seed, 0)), seed_(seed) {
    hierarchy_ = {.base = base,
                  .fabric = Tying::kColumns,
                  .fabric_sigma = FLAGS_fabric_sigma,
                  .specimen_stretch_sigma = FLAGS_specimen_sigma,
                  .specimen_bend_sigma = FLAGS_specimen_sigma,
                  .specimens = FLAGS_specimens};
  }

  // None where the drapes of the median do not stand, the truth's branches end on the way to it, or
  // the mode is not found.
  std::optional<Outcome> Run(const char** why) {
    *why = "the median has no stable drape";
    if (!HangMedian()) return std::nullopt;
    *why = "the truth is beyond a branch";
    if (!DrawTruth()) return std::nullopt;
    *why = "no mode";
    if (!FindMode()) return std::nullopt;
    *why = "";
    Score(0, mode_.posterior);
    Score(1, Fit(MeanFieldStart(), 0));
    Score(2, Fit(mode_.posterior, FLAGS_rank));
    return std::move(outcome_);
  }

 private:
  int latents() const { return hierarchy_.num_latents(); }

  bool HangMedian() {
    const ClothModel& model = backend_->model();
    targets_.resize(FLAGS_specimens);
    for (int i = 0; i < FLAGS_specimens * FLAGS_drapes; ++i) {
      State start = test::RandomStart(model, SeedOfStream(seed_, 1 + i), 3e-3);
      RolloutInput input{&hierarchy_.base, &start};
      start.x = backend_->Rollouts({&input, 1}, {.h = 0.1, .steps = 100}, nullptr)[0].end.x;
      const EquilibriumResult rest = backend_->Equilibria({&input, 1}, {})[0];
      if (rest.status != EquilibriumStatus::kStable) return false;
      Target target;
      target.start = {rest.x, Eigen::VectorXd::Zero(rest.x.size())};
      target.radius = Eigen::VectorXd::Zero(kAngles);
      targets_[i / FLAGS_drapes].push_back(std::move(target));
    }
    return true;
  }

  bool DrawTruth() {
    truth_.resize(latents());
    for (double& number : truth_) number = DrawNormal(random_);
    // Against outlines of nothing and σ = 1 px, residuals are the outlines themselves.
    DrapeDraws one(backend_.get(), hierarchy_, targets_, OptionsOf(1.0), 1);
    if (!one.StartAt(Eigen::VectorXd::Zero(latents()))) return false;
    one.Prepare(truth_, false);
    Eigen::VectorXd outlines;
    if (!one.Copy(0, &outlines, nullptr)) return false;
    int next = 0;
    for (auto& of_specimen : targets_)
      for (Target& target : of_specimen)
        for (double& radius : target.radius)
          radius = outlines[next++] + FLAGS_sigma * DrawNormal(random_);
    return true;
  }

  bool FindMode() {
    DrapeDraws one(backend_.get(), hierarchy_, targets_, OptionsOf(FLAGS_sigma), 1);
    const GaussianPosterior prior{Eigen::VectorXd::Zero(latents()),
                                  Eigen::MatrixXd::Identity(latents(), latents()),
                                  Eigen::MatrixXd::Identity(latents(), latents())};
    if (!one.StartAt(prior.mean)) return false;
    VariationalOptions options;
    options.kind = DrawKind::kMode;
    options.max_iterations = 60;
    mode_ = FitPosterior(one, prior, options);
    if (mode_.termination == FitTermination::kFailed) return false;
    one.Prepare(mode_.posterior.mean, false);
    Eigen::VectorXd residual;
    if (!one.Copy(0, &residual, nullptr)) return false;
    for (int i = 0; i < FLAGS_specimens * FLAGS_drapes; ++i) {
      const double rms = residual.segment(i * kAngles, kAngles).norm() / std::sqrt(kAngles);
      outcome_.mode_error = std::max(outcome_.mode_error, rms);
    }
    std::size_t next = 0;
    for (auto& of_specimen : targets_)
      for (Target& target : of_specimen) target.start.x = one.Shapes(0)[next++];
    return true;
  }

  GaussianPosterior MeanFieldStart() const {
    GaussianPosterior start = mode_.posterior;
    const Eigen::VectorXd precisions = start.Covariance().inverse().diagonal();
    start.rotation.setIdentity();
    start.factor = precisions.cwiseInverse().cwiseSqrt().asDiagonal();
    return start;
  }

  GaussianPosterior Fit(const GaussianPosterior& start, int rank) {
    DrapeDraws draws(backend_.get(), hierarchy_, targets_, OptionsOf(FLAGS_sigma), FLAGS_draws,
                     BeyondBranch::kTangent);
    if (!draws.StartAt(start.mean)) return start;
    VariationalOptions options;
    options.draws = FLAGS_draws;
    options.rank = rank;
    options.seed = seed_;
    options.max_iterations = FLAGS_iterations;
    options.cost_tolerance = 1e-4;
    const GaussianPosterior found = FitPosterior(draws, start, options).posterior;
    outcome_.beyond = draws.num_beyond();
    return found;
  }

  void Score(int family, const GaussianPosterior& q) {
    const Eigen::MatrixXd draws =
        q.Draws(IndependentDraws(latents(), FLAGS_ranks, SeedOfStream(seed_, 100)));
    for (int i = 0; i < latents(); ++i)
      outcome_.ranks[family].push_back(
          static_cast<int>((draws.row(i).array() < truth_[i]).count()));
    outcome_.z[family] = (truth_ - q.mean).cwiseQuotient(q.Deviations());
  }

  const std::unique_ptr<Backend> backend_;
  std::mt19937_64 random_;
  const uint64_t seed_;
  DrapeHierarchy hierarchy_;
  std::vector<std::vector<Target>> targets_;
  Eigen::VectorXd truth_;
  VariationalFit mode_;
  Outcome outcome_;
};

// χ² of equal shares in kBins bins: the probability of so much or more.
double UniformityOf(const std::vector<int>& ranks) {
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
  double least = 1.0;
  const int numbers = static_cast<int>(outcomes.front().z[family].size());
  for (int i = 0; i < numbers; ++i) {
    std::vector<int> of_number;
    for (const Outcome& outcome : outcomes) {
      of_number.push_back(outcome.ranks[family][i]);
      const double z = std::abs(outcome.z[family][i]);
      in90 += z < k90;
      in50 += z < k50;
    }
    least = std::min(least, UniformityOf(of_number));
    all.insert(all.end(), of_number.begin(), of_number.end());
  }
  const double count = static_cast<double>(all.size());
  std::printf("%-14s %8.1f %8.1f %12.4f %16.4f\n", kFamilies[family], 100 * in50 / count,
              100 * in90 / count, UniformityOf(all), std::min(1.0, numbers * least));
}

void Run() {
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
      std::printf("fabric %d: worst drape of the mode %.2f sigma, %d draws beyond, z", i + 1,
                  found[i]->mode_error, found[i]->beyond);
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
  std::printf("%zu of %d fabrics\n", outcomes.size(), FLAGS_fabrics);
  if (outcomes.empty()) return;
  std::printf("%-14s %8s %8s %12s %16s\n", "family", "in 50 %", "in 90 %", "p, all ranks",
              "p, worst number");
  for (int family = 0; family < kNumFamilies; ++family) PrintFamily(family, outcomes);
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  drape::EnsureFastBlas(argv);
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  google::InitGoogleLogging(argv[0]);
  drape::Run();
  return 0;
}
