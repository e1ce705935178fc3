// SPDX-License-Identifier: Apache-2.0
// How often the intervals of FitDistribution hold the numbers of fabrics that are known. Fabrics
// are drawn at random; their drapes are taken from one half of a pool, in proportion to the
// fabric's density, and the fabric is inferred from the other half. Of one sample, the numbers to
// be held are those of the specimen itself.
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <array>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include "losses/metrics/metrics.h"
#include "physics/util/math/random.h"
#include "solver/prediction/generative/generative_prediction.h"

DEFINE_string(pool, "", "file of a pool of simulated drapes (drape_predict --learn)");
DEFINE_int32(fabrics, 60, "number of fabrics");
DEFINE_int32(samples, 12, "drapes of each, of one face and of as many samples; 1: of a specimen");
DEFINE_int32(
    resamples, 32,
    "inferences with random weights of the samples, or samples of the posterior of a specimen");
DEFINE_double(deviation, 0.7, "deviation of each number, in units of the largest of its range");
DEFINE_uint64(seed, 1, "random seed of the first fabric");
DEFINE_int32(threads, 1, "threads of an inference");

namespace drape {
namespace {

// The drapes of a pool with an even or odd index.
DrapePool TakeHalf(const DrapePool& pool, int odd) {
  DrapePool half = pool;
  half.drapes.clear();
  for (std::size_t i = odd; i < pool.drapes.size(); i += 2) half.drapes.push_back(pool.drapes[i]);
  half.simulated = pool.simulated / 2;
  half.rounds = {{.drapes = half.simulated}};
  return half;
}

SpecimenDistribution RandomFabric(const DrapePool& pool, std::mt19937_64& random) {
  SpecimenDistribution fabric;
  const auto any = static_cast<std::size_t>(SampleUniform(random) * double(pool.drapes.size()));
  fabric.mean[0] = fabric.mean[1] = pool.drapes[any].numbers;
  for (int k = 0; k < kSpecimenNumbers; ++k)
    fabric.deviation[k] = FLAGS_deviation * NumberRanges()[k].most_deviation;
  return fabric;
}

// A drape of the pool with the probability that its weight for the fabric has.
const PooledDrape& DrawDrape(const DrapePool& pool, const std::vector<double>& weights,
                             std::mt19937_64& random) {
  double left = SampleUniform(random);
  for (std::size_t i = 0; i < weights.size(); ++i)
    if ((left -= weights[i]) < 0) return pool.drapes[i];
  return pool.drapes.back();
}

std::vector<PooledDrape> DrapeFabric(const DrapePool& pool, const SpecimenDistribution& fabric,
                                     std::mt19937_64& random) {
  const Eigen::VectorXd log_proposal = pool.LogProposal();
  std::vector<double> weights;
  double sum = 0.0;
  for (std::size_t i = 0; i < pool.drapes.size(); ++i) {
    weights.push_back(std::exp(LogDensity(fabric, ClothFace::kUp, pool.drapes[i].numbers) -
                               log_proposal[static_cast<Eigen::Index>(i)]));
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  std::vector<PooledDrape> drapes;
  for (int i = 0; i < FLAGS_samples; ++i) drapes.push_back(DrawDrape(pool, weights, random));
  return drapes;
}

std::vector<TrainingDrape> ListAsSamples(const std::vector<PooledDrape>& drapes) {
  std::vector<TrainingDrape> training;
  for (const PooledDrape& drape : drapes)
    training.push_back({static_cast<int>(training.size()), ClothFace::kUp, drape.shape});
  return training;
}

// The means of a fabric and what they can be, or the numbers of a specimen.
void Infer(const DrapePool& pool, const std::vector<TrainingDrape>& training, SpecimenNumbers* best,
           std::vector<SpecimenNumbers>* possible) {
  const DistributionFitOptions options{.resamples = FLAGS_resamples,
                                       .cross_validate = false,
                                       .seed = FLAGS_seed,
                                       .threads = FLAGS_threads};
  if (training.size() == 1) {
    SpecimenPosterior posterior =
        InferSpecimen(pool, training, options.outline_weight, options.resamples, options.seed);
    *best = posterior.mean;
    *possible = std::move(posterior.samples);
    return;
  }
  const DistributionFit fit = FitDistribution(pool, training, options, {});
  *best = fit.best.mean[0];
  for (const SpecimenDistribution& each : fit.resampled) possible->push_back(each.mean[0]);
}

void Run() {
  const DrapePool pool = ReadPool(FLAGS_pool);
  const DrapePool seen_half = TakeHalf(pool, 0), known_half = TakeHalf(pool, 1);
  std::array<int, kSpecimenNumbers> held = {};
  std::array<double, kSpecimenNumbers> width = {}, error = {};
  double nominal = 0.0;
  for (int f = 0; f < FLAGS_fabrics; ++f) {
    std::mt19937_64 random(SeedOfStream(FLAGS_seed, static_cast<uint64_t>(f)));
    const SpecimenDistribution fabric = RandomFabric(seen_half, random);
    const std::vector<PooledDrape> drapes = DrapeFabric(seen_half, fabric, random);
    const SpecimenNumbers& known = FLAGS_samples == 1 ? drapes[0].numbers : fabric.mean[0];
    SpecimenNumbers best;
    std::vector<SpecimenNumbers> possible;
    Infer(known_half, ListAsSamples(drapes), &best, &possible);
    for (int k = 0; k < kSpecimenNumbers; ++k) {
      std::vector<double> values;
      for (const SpecimenNumbers& each : possible) values.push_back(each[k]);
      const CentralInterval ninety = ComputeInterval(values, 0.9);
      nominal = ninety.nominal;
      held[k] += ninety.Contains(known[k]);
      width[k] += (ninety.high - ninety.low) / FLAGS_fabrics;
      error[k] += std::abs(best[k] - known[k]) / FLAGS_fabrics;
    }
    std::fprintf(stderr, "\r%d of %d", f + 1, FLAGS_fabrics);
  }
  std::printf("\nintervals of %.0f %%, %d fabrics, %d samples\n", 100 * nominal, FLAGS_fabrics,
              FLAGS_samples);
  for (int k = 0; k < kSpecimenNumbers; ++k)
    std::printf("%s%-32s held %.2f  width %.3f  mean error %.3f\n",
                NumberRanges()[k].is_log ? "ln " : "   ", NumberRanges()[k].label,
                double(held[k]) / FLAGS_fabrics, width[k], error[k]);
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  google::InitGoogleLogging(argv[0]);
  drape::Run();
}
