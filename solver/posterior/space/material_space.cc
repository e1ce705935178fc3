// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/space/material_space.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "physics/material/material_scaling.h"

namespace drape {
namespace {

Distances Compare(const NormalDistribution& p, const NormalDistribution& q, double unit) {
  if (p.size() == 0) return {};
  const double there = KullbackLeibler(p, q), back = KullbackLeibler(q, p);
  return {
      there, back, there + back, Bhattacharyya(p, q), Hellinger(p, q), unit * Wasserstein(p, q)};
}

// The distributions of elements are no posteriors: all their directions count.
DeterminedDirections FindDirections(const SpaceFrame& frame, const Eigen::MatrixXd& covariance) {
  const int n = frame.size();
  if (frame.kind == PosteriorKind::kElements)
    return {Eigen::MatrixXd::Identity(n, n), covariance.diagonal()};
  return FindDetermined(covariance, n);
}

PairDistances ComparePair(const FabricBeliefs& beliefs, int first, int second) {
  const SpaceFrame& frame = beliefs.frame;
  const FabricBelief &a = beliefs.fabrics[first], &b = beliefs.fabrics[second];
  PairDistances pair{.first = first, .second = second};
  const BeliefLevel narrow = frame.Levels().front();
  const Eigen::MatrixXd middle =
      0.5 * (BeliefAt(frame, a, narrow).covariance + BeliefAt(frame, b, narrow).covariance);
  const DeterminedDirections directions = FindDirections(frame, middle);
  pair.directions = static_cast<int>(directions.ratios.size());
  for (const BeliefLevel level : frame.Levels()) {
    const NormalDistribution p = BeliefAt(frame, a, level), q = BeliefAt(frame, b, level);
    const Distances all = Compare(p, q, frame.LogUnit());
    const Distances inside =
        Compare(Project(p, directions.axes), Project(q, directions.axes), frame.LogUnit());
    const double share = inside.wasserstein / all.wasserstein;
    pair.all.push_back(all);
    pair.determined.push_back(inside);
    pair.share_of_prior.push_back(std::max(0.0, 1.0 - share * share));
  }
  return pair;
}

void CompareFabrics(MaterialSpace* space) {
  const FabricBeliefs& beliefs = space->beliefs;
  for (const FabricBelief& fabric : beliefs.fabrics)
    space->fabrics.push_back(Project(BeliefAt(beliefs.frame, fabric, beliefs.frame.Levels().back()),
                                     space->directions.axes));
  const auto n = static_cast<Eigen::Index>(beliefs.fabrics.size());
  space->wasserstein = space->hellinger = Eigen::MatrixXd::Zero(n, n);
  for (const PairDistances& pair : space->pairs) {
    const int i = pair.first, j = pair.second;
    space->wasserstein(i, j) = space->wasserstein(j, i) =
        beliefs.frame.LogUnit() * Wasserstein(space->fabrics[i], space->fabrics[j]);
    space->hellinger(i, j) = space->hellinger(j, i) =
        pair.directions > 0 ? pair.determined.back().hellinger
                            : std::numeric_limits<double>::quiet_NaN();
  }
}

std::vector<NormalDistribution> AllEvidence(const MaterialSpace& space) {
  std::vector<NormalDistribution> evidence;
  for (const FabricBelief& fabric : space.beliefs.fabrics)
    evidence.push_back(Evidence(space.beliefs.frame, fabric, space.leading.axes));
  return evidence;
}

// p-values are those of exchangeable scores: a material that is as the fabrics are has each rank
// with the same probability.
double PValue(const std::vector<double>& left_out, double score) {
  const auto less = std::count_if(left_out.begin(), left_out.end(),
                                  [&](double fabric) { return fabric <= score; });
  return (1.0 + double(less)) / (1.0 + double(left_out.size()));
}

// Under the fabrics but number `without`; −1: all.
void JudgeByMixture(const std::vector<NormalDistribution>& fabrics, const NormalDistribution& seen,
                    int without, JudgedMaterial* judged) {
  Eigen::ArrayXd logs(fabrics.size());
  for (int f = 0; f < int(fabrics.size()); ++f)
    logs[f] = LogDensity({fabrics[f].mean, fabrics[f].covariance + seen.covariance}, seen.mean);
  if (without >= 0) logs[without] = -std::numeric_limits<double>::infinity();
  const double largest = logs.maxCoeff();
  const Eigen::ArrayXd shares = (logs - largest).exp();
  const double count = double(fabrics.size()) - (without >= 0 ? 1 : 0);
  judged->log_mixture = largest + std::log(shares.sum() / count);
  for (const double share : shares / shares.sum()) judged->by_fabric.push_back(share);
}

// What is known of a fabric's mean is compared with the means of others; a table or the fit of one
// specimen alone, with specimens of them.
BeliefLevel ComparedLevel(const FabricBelief& material) {
  return material.specimen_sd.isZero() ? BeliefLevel::kSpecimen : BeliefLevel::kFabric;
}

// without: number of the fabric that is the material itself; −1: none.
JudgedMaterial Judge(const MaterialSpace& space, const FabricBelief& material, int without) {
  const SpaceFrame& frame = space.beliefs.frame;
  const Eigen::MatrixXd& axes = space.leading.axes;
  const NormalDistribution seen = Evidence(frame, material, axes);
  std::vector<double> scores = space.choice.left_out;
  JudgedMaterial judged{
      .name = material.name,
      .log_likelihood = without >= 0 ? scores[without] : space.population.LogLikelihood(seen),
      .place = seen.mean};
  judged.determined = space.directions.axes.transpose() * frame.ToPriorUnits(material.theta).mean;
  if (without >= 0) scores.erase(scores.begin() + without);
  judged.p_value = PValue(scores, judged.log_likelihood);
  std::vector<NormalDistribution> fabrics;
  for (const FabricBelief& fabric : space.beliefs.fabrics)
    fabrics.push_back(Project(BeliefAt(frame, fabric, ComparedLevel(material)), axes));
  JudgeByMixture(fabrics, seen, without, &judged);
  return judged;
}

// The population in its directions, the prior of the fits, which is standard normal about the
// common base, in the others.
NormalDistribution MakePrior(const MaterialSpace& space) {
  const Eigen::MatrixXd& axes = space.leading.axes;
  const NormalDistribution moments = space.population.Moments();
  const Eigen::Index n = axes.rows();
  const Eigen::MatrixXd outside = Eigen::MatrixXd::Identity(n, n) - axes * axes.transpose();
  return space.beliefs.frame.FromPriorUnits(
      {axes * moments.mean, axes * moments.covariance * axes.transpose() + outside});
}

void FindPopulation(MaterialSpace* space) {
  const int count = static_cast<int>(space->beliefs.fabrics.size());
  const int most = std::min<int>({kMostLeading, space->determined, std::max(1, (count - 1) / 2)});
  if (space->beliefs.frame.kind == PosteriorKind::kElements || most == 0) return;
  space->leading = {space->directions.axes.leftCols(most), space->directions.ratios.head(most)};
  const std::vector<NormalDistribution> evidence = AllEvidence(*space);
  space->choice = ChooseComponents(evidence, kMostComponents);
  space->population = Deconvolve(evidence, space->choice.components);
  space->prior = MakePrior(*space);
  for (int i = 0; i < count; ++i)
    space->left_out.push_back(Judge(*space, space->beliefs.fabrics[i], i));
}

FabricBelief AsPoint(const SpaceFrame& frame, const std::string& name, const MaterialField& table) {
  constexpr double kDeviation = 1e-6;
  const Eigen::Index n = frame.size();
  const Eigen::VectorXd theta = frame.LogFactors(table, name);
  return {.name = name,
          .folder = "",
          .density = table.density,
          .theta = {theta, kDeviation * kDeviation * Eigen::MatrixXd::Identity(n, n)},
          .centre = theta};
}

// The material `paper` of ARCSim: 5e5 N/m in its convention in all directions, D = 1e-4 N·m,
// 0.1 kg/m²; its c12 of zero, which has no logarithm, is replaced by a Poisson ratio of 0.3.
MaterialField PaperTable() {
  constexpr double kStiffness = 5e5, kPoisson = 0.3, kRigidity = 1e-4;
  MaterialField paper{.density = 0.1, .stretch = {{}}, .bend = {{}}};
  for (auto& row : paper.stretch[0].c) {
    row[0] = row[2] = row[3] = kStiffness;
    row[1] = kPoisson * kStiffness;
  }
  for (double& entry : std::span(paper.bend[0].entries(), kBendEntries))
    entry = kBendPerRigidity * kRigidity;
  return paper;
}

}  // namespace

NormalDistribution Evidence(const SpaceFrame& frame, const FabricBelief& fabric,
                            const Eigen::MatrixXd& axes) {
  const NormalDistribution z = frame.ToPriorUnits(fabric.theta);
  const NormalDistribution centre = frame.ToPriorUnits({fabric.centre, fabric.theta.covariance});
  return WithoutPrior(Project(z, axes), axes.transpose() * centre.mean);
}

std::vector<FabricBelief> MakeNonFabrics(const FabricBeliefs& beliefs) {
  constexpr double kStretch = 100.0, kRigidity = 1e-4, kRatio = 30.0;
  const SpaceFrame& frame = beliefs.frame;
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(frame.size());
  double log_density = 0.0;
  for (const FabricBelief& fabric : beliefs.fabrics) {
    theta += fabric.theta.mean / double(beliefs.fabrics.size());
    log_density += std::log(fabric.density) / double(beliefs.fabrics.size());
  }
  const MaterialField median = frame.Table(theta, std::exp(log_density));
  MaterialField stiff = Scaled(median, kStretch, 1.0), isotropic = median, ratio = median;
  for (double& entry : std::span(isotropic.bend[0].entries(), kBendEntries))
    entry = kBendPerRigidity * kRigidity;
  for (int k = 0; k < kBendCols; ++k) {
    ratio.bend[0].b[0][k] *= std::sqrt(kRatio);
    ratio.bend[0].b[2][k] /= std::sqrt(kRatio);
  }
  std::vector<FabricBelief> all;
  const std::pair<const char*, MaterialField> named[] = {{"paper", PaperTable()},
                                                         {"stretch x 100", stiff},
                                                         {"isotropic bend 1e-4 N m", isotropic},
                                                         {"bend ratio 30", ratio}};
  for (const auto& [name, table] : named)
    if (frame.CanRepresent(table)) all.push_back(AsPoint(frame, name, table));
  return all;
}

NormalDistribution LogBendingLengths(const SpaceFrame& frame, const FabricBelief& fabric) {
  const MaterialField table = frame.Table(fabric.theta.mean, fabric.density);
  const Eigen::MatrixXd tie = TyingMatrix(frame.tying);
  NormalDistribution lengths{Eigen::Vector2d::Zero(), {}};
  Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(2, kMaterialEntries);
  for (int direction = 0; direction < 2; ++direction) {
    const int row = direction == 0 ? 2 : 0;  // weft, warp
    const Eigen::Map<const Eigen::VectorXd> entries(table.bend[0].b[row], kBendCols);
    const double rigidity = entries.mean() / kBendPerRigidity;
    lengths.mean[direction] = std::log(BendingLength(rigidity, table.density));
    slope.row(direction).segment(kStretchEntries + row * kBendCols, kBendCols) =
        entries.transpose() / entries.sum() / 3.0;
  }
  const NormalDistribution wide =
      frame.FromPriorUnits(BeliefAt(frame, fabric, frame.Levels().back()));
  const Eigen::MatrixXd map = slope * tie;
  lengths.covariance = map * wide.covariance * map.transpose();
  return lengths;
}

MaterialSpace BuildMaterialSpace(FabricBeliefs beliefs, std::vector<FabricBelief> added) {
  MaterialSpace space{.beliefs = std::move(beliefs), .added_beliefs = std::move(added)};
  const SpaceFrame& frame = space.beliefs.frame;
  const int count = static_cast<int>(space.beliefs.fabrics.size());
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(frame.size(), frame.size());
  for (int i = 0; i < count; ++i) {
    mean += BeliefAt(frame, space.beliefs.fabrics[i], frame.Levels().front()).covariance / count;
    for (int j = i + 1; j < count; ++j) space.pairs.push_back(ComparePair(space.beliefs, i, j));
  }
  space.directions = FindDirections(frame, mean);
  space.determined = static_cast<int>(space.directions.ratios.size());
  if (space.determined == 0)
    space.directions = FindDetermined(mean, frame.size(), std::numeric_limits<double>::infinity());
  CompareFabrics(&space);
  FindPopulation(&space);
  if (!space.has_population()) return space;
  const auto judge_all = [&](const std::vector<FabricBelief>& materials,
                             std::vector<JudgedMaterial>* judged) {
    for (const FabricBelief& material : materials) judged->push_back(Judge(space, material, -1));
  };
  // Fewer numbers cannot make them from the base.
  if (frame.tying == ParameterTying::kEntries)
    judge_all(MakeNonFabrics(space.beliefs), &space.non_fabrics);
  judge_all(space.added_beliefs, &space.added);
  return space;
}

}  // namespace drape
