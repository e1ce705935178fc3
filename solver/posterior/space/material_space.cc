// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/space/material_space.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "physics/material/material_scaling.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/fit/parametrisation.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// The error of a log factor that the free numbers must reproduce.
constexpr double kLogRounding = 1e-6;
// Standard deviation of a table that is known, in log units.
constexpr double kPointDeviation = 1e-6;
constexpr int kMostComponents = 4;  // of a population

// The entries as they count: by drape those of a cloth of that density.
MaterialField AtDensity(const MaterialField& table, SpaceBy by, double density) {
  if (by == SpaceBy::kWeight) return table;
  MaterialField scaled = Scaled(table, density / table.density, density / table.density);
  scaled.density = density;
  return scaled;
}

// Log factors of entries that no number is on do not count.
Eigen::VectorXd Freed(const Eigen::MatrixXd& tie, const Eigen::VectorXd& log_factors) {
  return (tie.rowwise().sum().array() > 0).select(log_factors, 0.0);
}

std::string PriorText(const StoredPosterior& posterior) {
  const Eigen::VectorXd sd = posterior.prior_sd.head(posterior.num_fabric());
  return Format("a posterior of kind %s, %d log factors of a fabric, prior_sd %.6g to %.6g",
                ToString(posterior.kind), posterior.num_fabric(), sd.minCoeff(), sd.maxCoeff());
}

bool SamePrior(const StoredPosterior& a, const StoredPosterior& b) {
  if (a.kind != b.kind || a.fabric != b.fabric) return false;
  const Eigen::MatrixXd difference = a.FabricPrior() - b.FabricPrior();
  return difference.cwiseAbs().maxCoeff() < kLogRounding * a.FabricPrior().cwiseAbs().maxCoeff();
}

std::string PosteriorFile(const std::string& folder) { return folder + "/posterior.json"; }

StoredPosterior ReadOne(const std::string& folder) {
  if (!fs::is_directory(folder))
    throw InputError(folder, "is no folder, expected that of a fit with --model=bayes or bdp");
  StoredPosterior posterior = ReadPosterior(folder);
  const int n = posterior.num_fabric();
  const Eigen::MatrixXd spread = posterior.kind == PosteriorKind::kElements
                                     ? Eigen::MatrixXd(posterior.element_sd.asDiagonal())
                                     : Eigen::MatrixXd(posterior.covariance.topLeftCorner(n, n));
  if (Eigen::LLT<Eigen::MatrixXd>(spread).info() != Eigen::Success)
    throw InputError(PosteriorFile(folder), "a log factor has no spread, expected a distribution");
  if ((posterior.prior_sd.head(n).array() <= 0).any())
    throw InputError(PosteriorFile(folder) + ": key 'prior_sd'",
                     "found 0, expected positive deviations");
  return posterior;
}

SpaceFrame MakeFrame(const StoredPosterior& first, SpaceBy by) {
  SpaceFrame frame{
      .by = by, .kind = first.kind, .tying = first.fabric, .base = first.base, .prior_root = {}};
  frame.prior_root = first.FabricPrior().llt().matrixL();
  return frame;
}

// The geometric mean of the bases as the frame's; its coupled entries by their log factors.
void SetCommonBase(const std::vector<StoredPosterior>& posteriors,
                   const std::vector<std::string>& folders, SpaceFrame* frame) {
  const Eigen::MatrixXd tie = TyingMatrix(frame->tying);
  const double count = double(posteriors.size());
  double log_density = 0.0;
  for (const StoredPosterior& each : posteriors) log_density += std::log(each.base.density) / count;
  const double density = std::exp(log_density);
  frame->base = AtDensity(frame->base, frame->by, density);
  frame->base.density = density;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(kMaterialEntries);
  for (std::size_t i = 0; i < posteriors.size(); ++i) {
    frame->LogFactors(posteriors[i].base, folders[i] + "/base.json");
    const MaterialField base = AtDensity(posteriors[i].base, frame->by, density);
    mean += Freed(tie, FindLogFactors(frame->base, base)) / count;
  }
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(kMaterialEntries, kMaterialEntries);
  frame->base = TableParametrisation(frame->base, identity).Material(mean);
}

std::string LastName(const std::string& folder) {
  const fs::path path = fs::path(folder).lexically_normal();
  return (path.has_filename() ? path.filename() : path.parent_path().filename()).string();
}

FabricBelief MakeBelief(const SpaceFrame& frame, const StoredPosterior& posterior,
                        const std::string& folder) {
  const int n = posterior.num_fabric();
  FabricBelief belief{.name = LastName(folder),
                      .folder = folder,
                      .density = posterior.base.density,
                      .theta = {},
                      .centre = frame.LogFactors(posterior.base, folder + "/base.json"),
                      .sheet = ReadSheet(folder, "material")};
  belief.theta.mean = belief.centre + posterior.mean.head(n);
  if (posterior.kind == PosteriorKind::kElements) {
    belief.theta.covariance = posterior.element_sd.cwiseAbs2().asDiagonal();
    return belief;
  }
  belief.theta.covariance = posterior.covariance.topLeftCorner(n, n);
  if (posterior.specimens > 0) belief.specimen_sd = posterior.prior_sd.segment<2>(n);
  return belief;
}

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

// The belief in the coordinates z.
NormalDistribution BeliefAt(const SpaceFrame& frame, const FabricBelief& fabric,
                            BeliefLevel level) {
  NormalDistribution theta = fabric.theta;
  if (level == BeliefLevel::kSpecimen) {
    Eigen::MatrixXd both = Eigen::MatrixXd::Zero(kMaterialEntries, 2);
    both.col(0).head(kStretchEntries).setOnes();
    both.col(1).tail(kBendEntries).setOnes();
    const Eigen::MatrixXd tie = TyingMatrix(frame.tying);
    for (int part = 0; part < 2; ++part) {
      const Eigen::VectorXd axis = MeanLogFactors(tie, both.col(part)) * fabric.specimen_sd[part];
      theta.covariance += axis * axis.transpose();
    }
  }
  return frame.ToPriorUnits(theta);
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
  std::vector<NormalDistribution> evidence;
  for (const FabricBelief& fabric : space->beliefs.fabrics)
    evidence.push_back(Evidence(space->beliefs.frame, fabric, space->leading.axes));
  space->choice = ChooseComponents(evidence, kMostComponents);
  space->population = Deconvolve(evidence, space->choice.components);
  space->prior = MakePrior(*space);
  for (int i = 0; i < count; ++i)
    space->left_out.push_back(Judge(*space, space->beliefs.fabrics[i], i));
}

FabricBelief AsPoint(const SpaceFrame& frame, const std::string& name, const MaterialField& table) {
  const Eigen::Index n = frame.size();
  const Eigen::VectorXd theta = frame.LogFactors(table, name);
  return {.name = name,
          .folder = "",
          .density = table.density,
          .theta = {theta, kPointDeviation * kPointDeviation * Eigen::MatrixXd::Identity(n, n)},
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

// Whether the numbers of the frame can make a table from its base.
bool CanRepresent(const SpaceFrame& frame, const MaterialField& table) {
  try {
    frame.LogFactors(table, "");
  } catch (const InputError&) {
    return false;
  }
  return true;
}

// Materials that are no fabrics, as points: paper, and the median table of the fabrics with its
// stretch × 100, with one isotropic rigidity of 1e-4 N·m, and with a ratio of 30 between warp and
// weft; but those that have no log factors on the base.
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
    if (CanRepresent(frame, table)) all.push_back(AsPoint(frame, name, table));
  return all;
}

}  // namespace

std::vector<std::string> ShortNames(const std::vector<std::string>& folders) {
  std::vector<std::vector<std::string>> paths;
  std::vector<std::string> names;
  for (const std::string& folder : folders) {
    names.push_back(LastName(folder));
    std::vector<std::string> parts;
    for (const fs::path& part : fs::path(folder).lexically_normal())
      if (!part.empty()) parts.push_back(part.string());
    paths.push_back(std::move(parts));
  }
  if (std::set<std::string>(names.begin(), names.end()).size() == names.size()) return names;
  const auto share = [&](const auto& part_of) {
    return std::all_of(paths.begin(), paths.end(), [&](const auto& path) {
      return path.size() > 1 && part_of(path) == part_of(paths.front());
    });
  };
  while (share([](const auto& path) { return path.front(); }))
    for (auto& path : paths) path.erase(path.begin());
  while (share([](const auto& path) { return path.back(); }))
    for (auto& path : paths) path.pop_back();
  for (std::size_t i = 0; i < paths.size(); ++i) {
    fs::path name;
    for (const std::string& part : paths[i]) name /= part;
    names[i] = name.string();
  }
  return names;
}

std::vector<BeliefLevel> SpaceFrame::Levels() const {
  if (kind == PosteriorKind::kElements) return {BeliefLevel::kElement};
  return {BeliefLevel::kFabric, BeliefLevel::kSpecimen};
}

double SpaceFrame::LogUnit() const { return std::exp(prior_root.diagonal().array().log().mean()); }

Eigen::VectorXd SpaceFrame::LogFactors(const MaterialField& table, const std::string& where) const {
  const Eigen::MatrixXd tie = TyingMatrix(tying);
  const Eigen::VectorXd all = Freed(tie, FindLogFactors(base, AtDensity(table, by, base.density)));
  if (!all.allFinite())
    throw InputError(where,
                     "an entry has another sign than in the other tables, or is zero in one "
                     "of them, expected tables with finite log factors");
  Eigen::VectorXd theta = MeanLogFactors(tie, all);
  const double error = (tie * theta - all).cwiseAbs().maxCoeff();
  if (error > kLogRounding)
    throw InputError(where,
                     Format("the table differs from those of the other fabrics by more than "
                            "its %d numbers can change (a log factor by %.3g), expected fits "
                            "of one start table, or num_parameters 39",
                            static_cast<int>(tie.cols()), error));
  return theta;
}

MaterialField SpaceFrame::Table(const Eigen::VectorXd& theta, double density) const {
  const MaterialField table = TableParametrisation(base, tying).Material(theta);
  if (by == SpaceBy::kDrape) return AtDensity(table, by, density);
  MaterialField with_density = table;
  with_density.density = density;
  return with_density;
}

NormalDistribution SpaceFrame::ToPriorUnits(const NormalDistribution& theta) const {
  const auto root = prior_root.triangularView<Eigen::Lower>();
  const Eigen::MatrixXd half = root.solve(theta.covariance);
  return {root.solve(theta.mean), root.solve(half.transpose())};
}

NormalDistribution SpaceFrame::FromPriorUnits(const NormalDistribution& z) const {
  return {prior_root * z.mean, prior_root * z.covariance * prior_root.transpose()};
}

FabricBeliefs ReadFabricBeliefs(const std::vector<std::string>& folders, SpaceBy by) {
  if (folders.size() < 2)
    throw InputError("option 'posteriors'", Format("found %d folder(s), expected those of at least "
                                                   "two fabrics",
                                                   int(folders.size())));
  std::vector<StoredPosterior> posteriors;
  std::set<std::string> seen;
  for (const std::string& folder : folders) {
    posteriors.push_back(ReadOne(folder));
    if (!seen.insert(fs::weakly_canonical(folder).string()).second)
      throw InputError("option 'posteriors'", "found " + folder + " twice, expected each once");
    if (!SamePrior(posteriors[0], posteriors.back()))
      throw InputError(PosteriorFile(folder), "found " + PriorText(posteriors.back()) +
                                                  ", expected " + PriorText(posteriors[0]) +
                                                  ", as in " + folders[0]);
  }
  FabricBeliefs beliefs{MakeFrame(posteriors[0], by), {}};
  SetCommonBase(posteriors, folders, &beliefs.frame);
  for (std::size_t i = 0; i < folders.size(); ++i)
    beliefs.fabrics.push_back(MakeBelief(beliefs.frame, posteriors[i], folders[i]));
  const std::vector<std::string> names = ShortNames(folders);
  for (std::size_t i = 0; i < folders.size(); ++i) beliefs.fabrics[i].name = names[i];
  return beliefs;
}

FabricBelief ReadFabricBelief(const SpaceFrame& frame, const std::string& path) {
  if (!fs::is_directory(path)) {
    FabricBelief belief = AsPoint(frame, path, ReadMaterial(path).field);
    belief.name = LastName(path);
    belief.folder = path;
    belief.centre.setZero();
    return belief;
  }
  const StoredPosterior posterior = ReadOne(path);
  if (posterior.kind != frame.kind || posterior.fabric != frame.tying)
    throw InputError(PosteriorFile(path),
                     "found " + PriorText(posterior) +
                         Format(", expected the kind %s and %d log factors of the "
                                "other fabrics",
                                ToString(frame.kind), frame.size()));
  return MakeBelief(frame, posterior, path);
}

NormalDistribution Evidence(const SpaceFrame& frame, const FabricBelief& fabric,
                            const Eigen::MatrixXd& axes) {
  const NormalDistribution z = frame.ToPriorUnits(fabric.theta);
  const NormalDistribution centre = frame.ToPriorUnits({fabric.centre, fabric.theta.covariance});
  return WithoutPrior(Project(z, axes), axes.transpose() * centre.mean);
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
