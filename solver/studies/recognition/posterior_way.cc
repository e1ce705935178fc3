// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/posterior_way.h"

#include "physics/util/errors.h"
#include "solver/posterior/space/material_space.h"
#include "solver/studies/recognition/sample_model.h"

namespace drape {
namespace {

constexpr double kScatter = 0.1;    // of samples of a fabric, in logarithms
constexpr double kWeighing = 0.03;  // standard deviation of ln density

DeterminedDirections FindLeading(const FabricBeliefs& beliefs, const std::string& folder) {
  const int size = beliefs.frame.size();
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(size, size);
  for (const FabricBelief& belief : beliefs.fabrics)
    mean += beliefs.frame.ToPriorUnits(belief.theta).covariance / double(beliefs.fabrics.size());
  DeterminedDirections leading = FindDetermined(mean, kMostLeading);
  if (leading.ratios.size() == 0)
    throw InputError(folder,
                     "the fits determine no direction, expected some with less than half of the "
                     "prior's deviation");
  return leading;
}

}  // namespace

PosteriorLogs CompareByPosterior(const SampleList& list, const std::string& folder, SpaceBy by) {
  std::vector<std::string> folders;
  for (const ListedSample& sample : list.samples) folders.push_back(folder + "/" + sample.name);
  const FabricBeliefs beliefs = ReadFabricBeliefs(folders, by);
  const DeterminedDirections leading = FindLeading(beliefs, folder);
  const Eigen::VectorXd scatter =
      Eigen::VectorXd::Constant(leading.ratios.size(), kScatter / beliefs.frame.LogUnit());
  std::vector<SeenSample> seen;
  Eigen::VectorXd density(list.num_fabrics());
  for (std::size_t i = 0; i < list.samples.size(); ++i) {
    const FabricBelief& belief = beliefs.fabrics[i];
    seen.push_back({list.samples[i].fabric, Evidence(beliefs.frame, belief, leading.axes)});
    density[list.samples[i].fabric] = belief.density;
  }
  PosteriorLogs logs{CompareWithOthers(seen, list.num_fabrics(), scatter), {}};
  for (const ListedSample& sample : list.samples) {
    const Eigen::ArrayXd off = (density.array() / density[sample.fabric]).log() / kWeighing;
    logs.by_density.push_back(-0.5 * off.square().matrix());
  }
  return logs;
}

}  // namespace drape
