// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/prediction_way.h"

#include <glog/logging.h>

#include <mutex>

#include "physics/util/text_format.h"

namespace drape {
namespace {

// A distribution to be learned: of a fabric, or of it without one of its samples.
struct Learning {
  int fabric = 0;
  int without = -1;  // of the samples; −1: all count

  bool LearnsFrom(const std::vector<DrapesOfSample>& samples, int i) const {
    return samples[i].fabric == fabric && i != without;
  }
  // The samples that are compared with it.
  bool Predicts(const std::vector<DrapesOfSample>& samples, int i) const {
    return without >= 0 ? i == without : samples[i].fabric != fabric;
  }
};

std::vector<Learning> ListLearning(const std::vector<DrapesOfSample>& samples, int fabrics) {
  std::vector<Learning> list;
  for (int f = 0; f < fabrics; ++f) list.push_back({f});
  for (int i = 0; i < int(samples.size()); ++i) list.push_back({samples[i].fabric, i});
  return list;
}

// Mean over the captures of each face, summed over the faces. scores: of each drape.
double SumOverFaces(const std::vector<TrainingDrape>& drapes, const Eigen::VectorXd& scores) {
  Eigen::Array2d sum = Eigen::Array2d::Zero(), count = Eigen::Array2d::Zero();
  for (std::size_t j = 0; j < drapes.size(); ++j) {
    const int face = SpecimenDistribution::FaceIndex(drapes[j].face);
    sum[face] += scores[Eigen::Index(j)];
    ++count[face];
  }
  return (sum / count.max(1.0)).sum();
}

}  // namespace

std::vector<Eigen::VectorXd> CompareByPredictions(const DrapePool& pool,
                                                  const std::vector<DrapesOfSample>& samples,
                                                  int fabrics,
                                                  const DistributionFitOptions& options,
                                                  const RunControl& control) {
  const std::vector<Learning> todo = ListLearning(samples, fabrics);
  const int count = static_cast<int>(samples.size());
  std::vector<Eigen::VectorXd> logs(count, Eigen::VectorXd(fabrics));
  DistributionFitOptions alone = options;
  alone.resamples = 0;
  alone.cross_validate = false;
  alone.threads = 1;
  std::mutex mutex;
  int done = 0;
  RunInThreads(static_cast<int>(todo.size()), options.threads, control.cancel, [&](int task) {
    const Learning& learning = todo[task];
    std::vector<TrainingDrape> training, held_out;
    for (int i = 0; i < count; ++i) {
      const std::vector<TrainingDrape>& drapes = samples[i].drapes;
      if (learning.LearnsFrom(samples, i))
        training.insert(training.end(), drapes.begin(), drapes.end());
      if (learning.Predicts(samples, i))
        held_out.insert(held_out.end(), drapes.begin(), drapes.end());
    }
    CHECK(!training.empty() && !held_out.empty());
    const SpecimenDistribution learned = FitDistribution(pool, training, alone, {}).best;
    const Eigen::VectorXd scores = ScoreDrapes(pool, learned, held_out, alone);
    Eigen::Index next = 0;
    for (int i = 0; i < count; ++i) {
      if (!learning.Predicts(samples, i)) continue;
      const auto size = static_cast<Eigen::Index>(samples[i].drapes.size());
      logs[i][learning.fabric] = -SumOverFaces(samples[i].drapes, scores.segment(next, size));
      next += size;
    }
    const std::scoped_lock lock(mutex);
    ++done;
    control.Report(double(done) / double(todo.size()),
                   Format("distribution %d of %d", done, static_cast<int>(todo.size())));
  });
  if (control.cancelled()) logs.clear();
  return logs;
}

}  // namespace drape
