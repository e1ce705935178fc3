// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/fitted_samples.h"

#include <algorithm>
#include <map>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {

FittedSamples CollectSamples(const RecognitionJob& job, const std::vector<std::string>& done) {
  std::map<int, std::vector<const FitCell*>> by_fabric;
  for (const FitCell& cell : job.cells)
    if (std::find(done.begin(), done.end(), cell.name) != done.end())
      by_fabric[cell.captures[0].fabric].push_back(&cell);
  std::erase_if(by_fabric, [](const auto& each) { return each.second.size() < 2; });
  if (by_fabric.size() < 2)
    throw InputError("option 'data'", Format("found %d fabric(s) with two fitted samples or more, "
                                             "expected at least two",
                                             static_cast<int>(by_fabric.size())));
  FittedSamples samples;
  std::vector<std::string> folders;
  for (const auto& [fabric, cells] : by_fabric) {
    for (const FitCell* cell : cells) {
      samples.fitted.push_back(
          {cell, static_cast<int>(samples.fabrics.size()), cell->captures[0].sample, {}});
      folders.push_back(job.fits.out + "/" + cell->name);
    }
    samples.fabrics.push_back(fabric);
  }
  FabricBeliefs beliefs = ReadFabricBeliefs(folders, job.by);
  samples.frame = beliefs.frame;
  const int size = samples.frame.size();
  samples.centre = Eigen::VectorXd::Zero(size);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < folders.size(); ++i) {
    samples.fitted[i].belief = std::move(beliefs.fabrics[i]);
    const NormalDistribution z = samples.frame.ToPriorUnits(samples.fitted[i].belief.theta);
    mean += z.covariance / double(folders.size());
    samples.centre += z.mean / double(folders.size());
  }
  samples.leading = FindDetermined(mean, kMostLeading);
  if (samples.leading.ratios.size() == 0)
    throw InputError(job.fits.out,
                     "the fits determine no direction, expected some with less than "
                     "half of the prior's deviation");
  return samples;
}

SampleModel ModelOfPosteriors(const FittedSamples& samples, int without) {
  std::vector<SeenSample> seen;
  for (int i = 0; i < int(samples.fitted.size()); ++i)
    if (i != without)
      seen.push_back({samples.fitted[i].fabric,
                      Evidence(samples.frame, samples.fitted[i].belief, samples.leading.axes)});
  constexpr double kScatter = 0.1;  // log units, of samples of a fabric
  const auto d = samples.leading.ratios.size();
  return {seen, static_cast<int>(samples.fabrics.size()),
          Eigen::VectorXd::Constant(d, kScatter / samples.frame.LogUnit())};
}

Eigen::VectorXd ScaledFeatures(const ObservedDrape& drape) {
  return ComputeFeatures(drape.shape).cwiseQuotient(kFeatureScales);
}

}  // namespace drape
