// SPDX-License-Identifier: Apache-2.0
// How often the intervals of FitDistribution hold the numbers of fabrics that are known. Fabrics
// are drawn at random; their drapes are taken from one half of a pool, in proportion to the
// fabric's density, and the fabric is inferred from the other half.
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <array>
#include <cstdio>
#include <random>
#include <vector>

#include "losses/metrics/ensemble_scores.h"
#include "physics/util/math/random.h"
#include "solver/prediction/generative/distribution_fit.h"

DEFINE_string(pool, "", "file of a pool of simulated drapes (drape_predict --learn)");
DEFINE_int32(fabrics, 60, "number of fabrics");
DEFINE_int32(samples, 12, "drapes of each, of one face and of as many samples");
DEFINE_int32(resamples, 32, "inferences with random weights of the samples");
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

std::vector<TrainingDrape> DrapeFabric(const DrapePool& pool, const SpecimenDistribution& fabric,
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
  std::vector<TrainingDrape> drapes;
  for (int i = 0; i < FLAGS_samples; ++i)
    drapes.push_back({i, ClothFace::kUp, DrawDrape(pool, weights, random).shape});
  return drapes;
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
    const std::vector<TrainingDrape> training = DrapeFabric(seen_half, fabric, random);
    const DistributionFit fit = FitDistribution(known_half, training,
                                                {.resamples = FLAGS_resamples,
                                                 .cross_validate = false,
                                                 .seed = FLAGS_seed,
                                                 .threads = FLAGS_threads},
                                                {});
    for (int k = 0; k < kSpecimenNumbers; ++k) {
      std::vector<double> means;
      for (const SpecimenDistribution& each : fit.resampled) means.push_back(each.mean[0][k]);
      const CentralInterval ninety = ComputeInterval(means, 0.9);
      nominal = ninety.nominal;
      held[k] += ninety.Contains(fabric.mean[0][k]);
      width[k] += (ninety.high - ninety.low) / FLAGS_fabrics;
      error[k] += std::abs(fit.best.mean[0][k] - fabric.mean[0][k]) / FLAGS_fabrics;
    }
    std::fprintf(stderr, "\r%d of %d", f + 1, FLAGS_fabrics);
  }
  std::printf("\nintervals of %.0f %%, %d fabrics, %d samples\n", 100 * nominal, FLAGS_fabrics,
              FLAGS_samples);
  for (int k = 0; k < kSpecimenNumbers; ++k)
    std::printf("%-32s held %.2f  width %.3f  mean error %.3f\n", NumberRanges()[k].label,
                double(held[k]) / FLAGS_fabrics, width[k], error[k]);
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  google::InitGoogleLogging(argv[0]);
  drape::Run();
}
