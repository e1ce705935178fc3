// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_verdict.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "losses/outline/outline.h"
#include "physics/material/material_scaling.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/text_format.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/lab_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/forward/drape_pool.h"
#include "solver/forward/settle.h"
#include "solver/job/first_answer.h"
#include "solver/job/fit_report.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

// A log factor counts as determined when the data leave less than this share of its prior
// deviation.
constexpr double kDetermined = 0.7;
// A quantity that is good up to one limit and usable up to another [METHODS, P57].
struct Limits {
  double good, usable;
};
constexpr Limits kCoefficientError = {0.02, 0.05};  // of the drape coefficient
constexpr Limits kFoldError = {0, 1};
constexpr Limits kForceResidual = {kAtRestResidual, 1e-3};    // by the weight
constexpr Limits kDrift = {1e3 * kAtRestDrift, 5.0};          // of a vertex of a nudged drape [mm]
constexpr Limits kMisfit = {2.0, 3.0};                        // of a laboratory reading [sigma]
constexpr Limits kMeasurementMisfit = {kTrustedMisfit, 3.0};  // of an experiment [sigma]
constexpr Limits kBendFactor = {2.0, 4.0};  // half the 90 % interval of a rigidity, as a factor
constexpr double kNearSingular = 0.95;      // c12²/(c11·c22); kLargestCoupling² is 0.98
constexpr double kReach = 100.0;            // of a fit from its start tables, as a factor

// The root mean square outline error [mm] that models of so many numbers reach on known fabrics
// with an overhang of 60 mm (tests/bench/FITS.md), and the limit of what is usable.
Limits OutlineError(const DrapeDiscs& discs, Eigen::Index numbers) {
  constexpr double kOverhang = 0.06;
  const double scale = (discs.specimen - discs.support) / kOverhang;
  const Limits limits = numbers == 0 || numbers > 7 ? Limits{3.0, 5.0} : Limits{4.0, 6.5};
  return {scale * limits.good, scale * limits.usable};
}

Limits Widen(const Limits& limits, double by) {
  return {std::hypot(limits.good, by), std::hypot(limits.usable, by)};
}

FitGrade ChooseGrade(double value, const Limits& limits) {
  if (value <= limits.good) return FitGrade::kGood;
  return value <= limits.usable ? FitGrade::kUsable : FitGrade::kDoNotUse;  // NaN too
}

// Collects the reasons of a lamp.
class Judge {
 public:
  void Add(FitGrade grade, const std::string& reason) {
    if (grade != FitGrade::kGood) found_.push_back({grade, reason});
  }
  void Add(const Judge& other) {
    found_.insert(found_.end(), other.found_.begin(), other.found_.end());
  }
  Lamp MakeLamp() {
    std::stable_sort(found_.begin(), found_.end(),
                     [](const Found& a, const Found& b) { return a.grade > b.grade; });
    Lamp lamp;
    if (!found_.empty()) lamp.grade = found_.front().grade;
    for (const Found& found : found_) lamp.reasons.push_back(found.reason);
    return lamp;
  }

 private:
  struct Found {
    FitGrade grade;
    std::string reason;
  };
  std::vector<Found> found_;
};

struct Judges {
  Judge measurement, shape, bending;

  // A fault of the drape itself says nothing of the cloth either.
  void Condemn(const std::string& reason) {
    shape.Add(FitGrade::kDoNotUse, reason);
    bending.Add(FitGrade::kDoNotUse, reason);
  }
  FitVerdict Verdict() {
    FitVerdict verdict{measurement.MakeLamp(), shape.MakeLamp(), bending.MakeLamp()};
    Judge all = shape;
    all.Add(measurement);
    all.Add(bending);
    const Lamp worst = all.MakeLamp();
    verdict.grade = worst.grade;
    for (const std::string& reason : worst.reasons)
      if (std::find(verdict.reasons.begin(), verdict.reasons.end(), reason) ==
          verdict.reasons.end())
        verdict.reasons.push_back(reason);
    return verdict;
  }
};

double Millimetres(double pixels, const Observation& observation) {
  return 1e3 * pixels / observation.camera.pixels_per_metre();
}

// The root mean square over the images of the outline's error [mm].
double MeanOutlineError(const FitProblem& problem, const FitReport& report) {
  double sum = 0.0;
  for (std::size_t i = 0; i < report.drapes.size(); ++i)
    sum += std::pow(
        Millimetres(report.drapes[i].fitted.metrics.profile_rms, problem.observations[i]), 2);
  return std::sqrt(sum / static_cast<double>(report.drapes.size()));
}

// The drape coefficients of each image and of its fitted drape.
Eigen::ArrayX2d ListCoefficients(const FitReport& report) {
  Eigen::ArrayX2d list(report.drapes.size(), 2);
  for (std::size_t i = 0; i < report.drapes.size(); ++i) {
    const SilhouetteMetrics& m = report.drapes[i].fitted.metrics;
    list.row(Eigen::Index(i)) << m.image.drape_coefficient, m.fitted.drape_coefficient;
  }
  return list;
}

// What one table leaves of the differences of several specimens, faces and starts: two standard
// deviations of their drape coefficients, and of the radius that goes with these [mm].
struct Scatter {
  double coefficient = 0.0, radius = 0.0;
};
Scatter FindScatter(const FitProblem& problem, const FitReport& report) {
  if (report.drapes.size() < 2 ||
      std::ranges::count(problem.specimens, 1) == std::ssize(problem.specimens))
    return {};
  constexpr double kMost = 0.04;  // of specimens of one fabric
  const Eigen::ArrayXd image = ListCoefficients(report).col(0);
  const DrapeDiscs& discs = problem.observations.front().discs;
  const double inner = discs.support * discs.support,
               ring = discs.specimen * discs.specimen - inner,
               variance = (image - image.mean()).square().sum() / double(image.size() - 1),
               sd = std::min(std::sqrt(variance), kMost);
  return {2 * sd, 1e3 * sd * ring / std::sqrt(inner + image.mean() * ring)};
}

// By how many the folds of two profiles [m] differ. A fold counts from a prominence on; the count
// of each profile may be any that the outline's error [m] allows.
int FoldDifference(const Eigen::VectorXd& image, const Eigen::VectorXd& fitted, double error) {
  if (image.size() == 0 || fitted.size() == 0) return 0;
  const double least = std::max(0.4 * kFoldProminence, kFoldProminence - 2 * error),
               most = kFoldProminence + 2 * error;
  const int more = CountFolds(image, most) - CountFolds(fitted, least),
            fewer = CountFolds(fitted, most) - CountFolds(image, least);
  return std::max({0, more, fewer});
}

// Whether a fitted drape is at rest, stable, and does not pass through itself.
void JudgeRest(const DrapeReport& drape, const std::string& which, Judges& judges) {
  const FitGrade rest = ChooseGrade(drape.force_residual, kForceResidual);
  const std::string forces =
      Format("not at rest: forces of %.1g of the weight remain", drape.force_residual) + which;
  if (rest == FitGrade::kDoNotUse) judges.Condemn(forces);
  if (rest == FitGrade::kUsable) judges.shape.Add(rest, forces);
  if (!IsStable(drape.lowest_eigenvalues)) judges.Condemn("the fitted drape is not stable" + which);
  if (drape.self_intersections > 0)
    judges.shape.Add(FitGrade::kDoNotUse,
                     Format("the fitted drape passes through itself, in %d pairs of "
                            "faces, which --contact=self prevents",
                            drape.self_intersections) +
                         which);
}

// A fit far from its start tables may have left the minimum that the data mean: a cloth that hardly
// stretches is as like its measurements with any stretching stiffness.
void JudgeReach(const FitReport& report, Judge& judge) {
  if (!report.start) return;
  const MaterialField fitted = MeanTables(report.material), &start = *report.start;
  const auto judge_ratio = [&](const char* name, double ratio) {
    if (std::abs(std::log(ratio)) > std::log(kReach))
      judge.Add(FitGrade::kUsable,
                Format("the %s stiffness ends at %.3g times the start tables' and may be another "
                       "cloth's: start nearer to it",
                       name, ratio));
  };
  judge_ratio("stretching", MeanStretch(fitted.stretch[0]) / MeanStretch(start.stretch[0]));
  judge_ratio("bending", MeanBend(fitted.bend[0]) / MeanBend(start.bend[0]));
}

void JudgeMeasurements(const FitReport& report, Judges& judges) {
  constexpr double kMuch = 2.0;  // a factor on sigma
  for (const MeasurementReport& each : report.measurements) {
    const std::string off = each.experiment + ": " + each.name +
                            Format(" are off by %.1f sigma, root mean square", each.misfit);
    const FitGrade grade = ChooseGrade(each.misfit, kMeasurementMisfit);
    const double enlarged = EnlargeSigma(each.misfit, each.count);
    if (grade == FitGrade::kGood && enlarged > kMuch)
      judges.shape.Add(FitGrade::kUsable,
                       off + Format(", more than %d numbers are by chance: the model or the branch "
                                    "is off, and intervals count %.1f times the sigma",
                                    each.count, enlarged));
    else
      judges.shape.Add(grade, off);
  }
  std::map<std::string, const MeasurementReport*> by_experiment;
  for (const MeasurementReport& each : report.measurements) by_experiment[each.experiment] = &each;
  const auto judge_grid = [&](const std::string& experiment, const char* fault, double factor) {
    const std::string reason =
        experiment + Format(": %s for what was measured, and intervals count %.2g times the sigma",
                            fault, factor);
    if (factor > kMostGridFactor)
      judges.Condemn(reason);
    else if (factor > kMuch)
      judges.shape.Add(FitGrade::kUsable, reason);
  };
  for (const auto& [experiment, measurement] : by_experiment) {
    judge_grid(experiment, "the mesh is too coarse", measurement->mesh_factor);
    judge_grid(experiment, "the time step is too long", measurement->step_factor);
  }
  for (const DrapeReport& drape : report.drapes) JudgeRest(drape, "", judges);
  JudgeReach(report, judges.bending);
}

void JudgeDrape(const Observation& observation, const DrapeReport& drape, Eigen::Index numbers,
                const Scatter& scatter, const std::string& which, Judges& judges) {
  if (drape.fitted.x.size() == 0) return judges.Condemn("the fitted drape has no outline" + which);
  Judge& judge = judges.shape;
  const SilhouetteMetrics& m = drape.fitted.metrics;
  const double error = Millimetres(m.profile_rms, observation);
  const Limits limits = Widen(OutlineError(observation.discs, numbers), scatter.radius);
  judge.Add(ChooseGrade(error, limits),
            Format("an outline error of %s mm (%.1f px), expected at most %.3g mm",
                   FormatBeyond(error, limits.good, 1).c_str(), m.profile_rms, limits.good) +
                which);
  const FitGrade folds = ChooseGrade(
      FoldDifference(drape.image_radius, drape.fitted.radius, 1e-3 * error), kFoldError);
  const std::string counts =
      Format("%d folds, the image has %d", m.fitted.folds, m.image.folds) + which;
  judge.Add(folds, counts);
  if (folds != FitGrade::kGood)
    judges.bending.Add(FitGrade::kUsable, counts + ": another branch than the cloth's");
  judge.Add(ChooseGrade(std::abs(m.image.drape_coefficient - m.fitted.drape_coefficient),
                        Widen(kCoefficientError, scatter.coefficient)),
            Format("drape coefficient %.1f %%, the image has %.1f %%",
                   100 * m.fitted.drape_coefficient, 100 * m.image.drape_coefficient) +
                which);
  JudgeRest(drape, which, judges);
  if (drape.status == EquilibriumStatus::kStable) {
    judge.Add(ChooseGrade(1e3 * drape.drift, kDrift),
              Format("nudged, it comes to rest %.1f mm away", 1e3 * drape.drift) + which);
  } else {
    judge.Add(FitGrade::kDoNotUse, "nudged, it does not come to rest" + which);
  }
}

void JudgeImage(const ImageQuality& quality, const std::string& which, Judge& judge) {
  if (!quality.doubtful) return;
  if (quality.notes.empty())
    judge.Add(FitGrade::kUsable, "scale, centre or outline of the image may be off" + which);
  for (const std::string& note : quality.notes) judge.Add(FitGrade::kUsable, note + which);
}

void JudgeStrips(const std::vector<StripReport>& strips, Judge& judge) {
  for (const StripReport& strip : strips) {
    const LabMeasurement& measurement = strip.measurement;
    if (strip.computed.empty())
      judge.Add(FitGrade::kDoNotUse,
                "laboratory measurement " + measurement.name + " cannot be computed");
    double worst = 0.0;
    for (std::size_t i = 0; i < strip.computed.size(); ++i)
      worst = std::max(
          worst, std::abs(strip.computed[i] - measurement.points[i].reading) / measurement.sigma);
    judge.Add(ChooseGrade(worst, kMisfit), "laboratory measurement " + measurement.name +
                                               Format(" is off by up to %.1f sigma", worst));
  }
}

bool IsNearlySingular(const MaterialField& material) {
  return std::any_of(
      material.stretch.begin(), material.stretch.end(),
      [](const StretchTable& table) { return LargestSquaredCoupling(table) > kNearSingular; });
}

// What a person reads first of the bending stiffness: the rigidity, or without a weight of the
// cloth the bending length, the first that has been measured.
const LaboratoryRow* FindBendingRow(const FitReport& report) {
  if (!report.fabric_sheet) return nullptr;
  const char* first =
      report.density_is_given ? "bending_in_drape_un_m" : "bending_length_overall_cm";
  const LaboratoryRow* found = nullptr;
  for (const LaboratoryRow& row : report.fabric_sheet->rows) {
    if (!row.measured() || !(report.density_is_given ? row.key.ends_with("_un_m")
                                                     : row.key.starts_with("bending_length_")))
      continue;
    if (row.key == first) return &row;
    if (found == nullptr) found = &row;
  }
  return found;
}

void JudgeBending(const FitReport& report, Judge& judge) {
  if (report.posterior && !(report.posterior->pareto_k < kReliableK))
    judge.Add(FitGrade::kUsable,
              std::isnan(report.posterior->pareto_k)
                  ? std::string("nothing confirms the posterior: do not use its samples")
                  : Format("Pareto k %.2f: do not use the posterior's samples",
                           report.posterior->pareto_k));
  if (IsNearlySingular(report.material))
    judge.Add(FitGrade::kUsable, "the stretch table is at the limit of what resists all strains");
  if (report.spectrum.determined == 0) judge.Add(FitGrade::kDoNotUse, "the data determine nothing");
  const LaboratoryRow* row = FindBendingRow(report);
  if (row == nullptr)
    return judge.Add(FitGrade::kDoNotUse, "the data do not determine the bending stiffness");
  if (row->is_bound())
    return judge.Add(FitGrade::kUsable, "the data bound the bending stiffness from one side only");
  for (const LaboratorySheet& each : report.at_once)
    if (const auto reason = FindDisagreement(each, *report.fabric_sheet))
      judge.Add(FitGrade::kUsable, *reason);
  const double power = row->key.starts_with("bending_length_") ? 3.0 : 1.0;  // of a length
  const double factor = std::pow(row->interval->high / row->interval->low, power / 2);
  judge.Add(ChooseGrade(factor, kBendFactor),
            Format("the bending rigidity is known to a factor of %.2g only", factor));
}

// The standard deviation of gradientᵀ·θ under the prior and rows of weight w, shape [K, P].
double LaplaceDeviation(const Eigen::VectorXd& gradient, const Eigen::MatrixXd& weighted_rows,
                        double prior_sigma) {
  Eigen::MatrixXd precision = weighted_rows.transpose() * weighted_rows;
  precision.diagonal().array() += 1 / (prior_sigma * prior_sigma);
  return std::sqrt(gradient.dot(precision.llt().solve(gradient)));
}

// The distance of the stiff end of an interval in the logarithm of a stiffness to the power of
// `degree`, whose deviation is known. What is read follows the compliance: where cloth hardly moves
// any more, ever stiffer cloth is excluded by the prior alone.
double FindStiffEnd(double deviation, double prior, double degree) {
  const double information = 1 / (deviation * deviation) - 1 / (prior * prior);
  double low = kQuantile90 * deviation, high = std::max(low, kQuantile90 * prior);
  while (high - low > 1e-6) {
    const double middle = 0.5 * (low + high), moved = -degree * std::expm1(-middle / degree);
    const bool is_inside =
        information * moved * moved + std::pow(middle / prior, 2) < kQuantile90 * kQuantile90;
    (is_inside ? low : high) = middle;
  }
  return high;
}

// How well the logarithm of a quantity is known at a fitted table, of which `shares` is its
// gradient by the log entries, shape [39].
class LaplaceApproximation {
 public:
  LaplaceApproximation(const Eigen::MatrixXd& tie, const WeightedRows& rows, double prior_sigma,
                       double model_deviation)
      : tie_(tie),
        has_outlines_(rows.outline_rows > 0),
        tell_stretching_(rows.tell_stretching),
        all_(rows.jacobian.size() > 0 ? rows.jacobian : Eigen::MatrixXd(0, tie.cols())),
        prior_sigma_(prior_sigma),
        model_deviation_(model_deviation) {
    all_.topRows(rows.outline_rows) *= std::sqrt(rows.outline_weight);
    strips_ = all_.bottomRows(all_.rows() - rows.outline_rows);
  }

  // Whether a free number changes it at all.
  bool Varies(const Eigen::VectorXd& shares) const {
    return (tie_.transpose() * shares).norm() > kRounding;
  }

  // degree: of the quantity in a stiffness, whose logarithm has the model's error.
  KnownTo Judge(const Eigen::VectorXd& shares, bool is_bending, double degree) const {
    const Eigen::VectorXd gradient = tie_.transpose() * shares;
    const double prior = prior_sigma_ * gradient.norm(), limit = kDetermined * prior;
    const bool by_strips = LaplaceDeviation(gradient, strips_, prior_sigma_) < limit;
    const double deviation = LaplaceDeviation(gradient, all_, prior_sigma_);
    const bool by_outlines = !by_strips && has_outlines_;
    const double model = by_outlines ? kQuantile90 * degree * model_deviation_ : 0.0;
    const double near = kQuantile90 * deviation;
    const bool by_experiment = by_outlines && tell_stretching_ && degree > kRounding;
    const double far = by_experiment ? FindStiffEnd(deviation, prior, degree) : near;
    const bool is_compliance = shares.sum() < 0.0;
    return {.low = std::exp(-std::hypot(is_compliance ? far : near, model)),
            .high = std::exp(std::hypot(is_compliance ? near : far, model)),
            .determined = by_strips || ((is_bending || tell_stretching_) && deviation < limit),
            .by_outlines = by_outlines,
            .left = std::pow(deviation / prior, 2)};
  }

 private:
  static constexpr double kRounding = 1e-6;

  Eigen::MatrixXd tie_;
  bool has_outlines_, tell_stretching_;
  Eigen::MatrixXd all_, strips_;
  double prior_sigma_, model_deviation_;
};

// Takes central differences, which have an error of 1e-8 of the gradient.
Eigen::VectorXd GradientByLogEntries(const LogQuantity& quantity, const MaterialField& table) {
  constexpr double kStep = 1e-4;
  const auto at = [&](int entry, double step) {
    MaterialField moved = table;
    (entry < kStretchEntries ? moved.stretch[0].entries()[entry]
                             : moved.bend[0].entries()[entry - kStretchEntries]) *= std::exp(step);
    return quantity(moved);
  };
  Eigen::VectorXd gradient(kMaterialEntries);
  for (int entry = 0; entry < kMaterialEntries; ++entry)
    gradient[entry] = (at(entry, kStep) - at(entry, -kStep)) / (2 * kStep);
  return gradient;
}

// The radii by which the images of a cloth are smaller than the flat cloth, the mean over the
// angles, and what of it may be due to the outline's error and to a doubt of half a percent about
// the scale [m].
struct Sag {
  double mean = 0.0, error = 0.0;
};
Sag FindSag(const Observation& observation, const DrapeReport& drape) {
  constexpr double kScale = 0.005;
  return {std::max(0.0, observation.discs.specimen - drape.image_radius.mean()),
          std::max(kScale * observation.discs.specimen,
                   1e-3 * Millimetres(drape.fitted.metrics.profile_rms, observation))};
}

std::string LampText(const char* name, const Lamp& lamp, const std::string& tells) {
  constexpr std::size_t kMostReasons = 3;
  std::string line = std::string("  ") + name + ": " + ToString(lamp.grade);
  for (std::size_t i = 0; i < std::min(kMostReasons, lamp.reasons.size()); ++i)
    line += (i == 0 ? ": " : "; ") + lamp.reasons[i];
  if (lamp.reasons.size() > kMostReasons)
    line += Format("; and %zu more", lamp.reasons.size() - kMostReasons);
  return line + (tells.empty() ? "" : ". " + tells) + "\n";
}

// "bending rigidity B, as it drapes 10 µN·m (6.1 … 16.4), measured, mesh 3 %".
std::string BendingText(const FitReport& report) {
  const LaboratoryRow* row = FindBendingRow(report);
  std::string text = row == nullptr ? "Bending is from the prior" : "Trust " + row->Text();
  if (row != nullptr && report.mesh_error)
    text += Format(", mesh %.2g %%", 100.0 * std::expm1(std::abs(report.mesh_error->log_bend)));
  const LaboratoryRow& stretch = report.fabric_sheet->of("stretch_in_drape_n_per_m");
  text += stretch.measured() ? "; " + stretch.Text() : "; stretching is from the prior";
  return text + "; no single entry of the tables can be trusted";
}

}  // namespace

Judgement JudgeByLaplace(const MaterialField& table, const Eigen::MatrixXd& tie,
                         const WeightedRows& rows, double prior_sigma, double model_deviation) {
  const LaplaceApproximation laplace(tie, rows, prior_sigma, model_deviation);
  return [=](const LogQuantity& quantity, Resistance resistance) -> std::optional<KnownTo> {
    const Eigen::VectorXd shares = GradientByLogEntries(quantity, table);
    if (!laplace.Varies(shares)) return std::nullopt;
    const double degree = std::max(std::abs(shares.head(kStretchEntries).sum()),
                                   std::abs(shares.tail(kBendEntries).sum()));
    return laplace.Judge(shares, resistance == Resistance::kBending, degree);
  };
}

FitVerdict JudgeFit(const FitProblem& problem, const FitReport& report) {
  Judges judges;
  const bool by_experiment = FindExperiment(problem) != nullptr;
  const Scatter scatter = FindScatter(problem, report);
  for (std::size_t i = 0; !by_experiment && i < problem.observations.size(); ++i) {
    const Observation& observation = problem.observations[i];
    const std::string which = problem.observations.size() > 1 ? " (" + observation.name + ")" : "";
    JudgeImage(observation.quality, which, judges.measurement);
    if (!report.cancelled && i < report.drapes.size())
      JudgeDrape(observation, report.drapes[i], report.spectrum.values.size(), scatter, which,
                 judges);
  }
  if (scatter.coefficient > 0) {
    const Eigen::Array2d mean = ListCoefficients(report).colwise().mean();
    judges.shape.Add(ChooseGrade(std::abs(mean[0] - mean[1]), kCoefficientError),
                     Format("a mean drape coefficient of %.1f %%, the images have %.1f %%",
                            100 * mean[1], 100 * mean[0]));
  }
  if (const Experiment* experiment = FindExperiment(problem))
    for (const Measurement& each : experiment->measurements)
      JudgeImage(each.quality, " (" + each.name + ")", judges.measurement);
  if (!report.fitted()) {
    judges.Condemn("nothing could be fitted");
  } else if (report.cancelled) {  // its drapes have not been examined
    judges.Condemn("the fit was cancelled");
  } else {
    JudgeStrips(report.strips, judges.shape);
    if (!report.measurements.empty()) JudgeMeasurements(report, judges);
    JudgeBending(report, judges.bending);
  }
  return judges.Verdict();
}

Bound FindBendBound(const FitProblem& problem, const FitReport& report,
                    const InitialGuessOptions& grid, const InitialGuess& guess, double left) {
  constexpr double kHeld = 0.1;  // of the variance of the prior
  if (LeastRigidityOfFlat(problem, report) > 0.0) return Bound::kAtLeast;
  const auto [least, most] = std::minmax_element(grid.bend.begin(), grid.bend.end());
  if (left < kHeld) return Bound::kNone;
  if (problem.is_pooled) {
    constexpr double kEdge = 0.1;  // of the logarithm
    const MaterialField start = ListStartTables(problem).at(guess.table);
    const double log_length = std::log(BendingLength(MeanBend(start.bend.front()), start.density));
    const NumberRange& range = NumberRanges()[kLogBendingLength];
    return log_length > range.high - kEdge  ? Bound::kAtLeast
           : log_length < range.low + kEdge ? Bound::kAtMost
                                            : Bound::kNone;
  }
  if (*least == *most) return Bound::kNone;
  return guess.bend >= *most    ? Bound::kAtLeast
         : guess.bend <= *least ? Bound::kAtMost
                                : Bound::kNone;
}

// A beam of length L that bends under its weight is shorter, seen from above, by (L/c)⁶·L/112, c
// its bending length. A disc is shorter by less, since its hem resists too: 2.6 times less at c =
// 4 cm and L = 6 cm. 4 leaves room.
double LeastRigidityOfFlat(const FitProblem& problem, const FitReport& report) {
  double least = 0.0;
  for (std::size_t i = 0; i < report.drapes.size(); ++i) {
    if (report.drapes[i].image_radius.size() == 0) return 0.0;
    const DrapeDiscs& discs = problem.observations[i].discs;
    const Sag sag = FindSag(problem.observations[i], report.drapes[i]);
    if (sag.mean >= sag.error) return 0.0;
    const double overhang = discs.specimen - discs.support,
                 length =
                     overhang * std::pow(overhang / (4 * 112 * (sag.mean + sag.error)), 1 / 6.);
    least = std::max(least, std::pow(length, 3) / BendOverWeight(1.0, report.material.density));
  }
  return least;
}

ordered_json VerdictJson(const FitVerdict& verdict) {
  const auto lamp = [](const Lamp& each) {
    return ordered_json{{"grade", ToString(each.grade)}, {"reasons", each.reasons}};
  };
  return {{"grade", ToString(verdict.grade)},
          {"reasons", verdict.reasons},
          {"lamps",
           {{"measurement", lamp(verdict.measurement)},
            {"shape", lamp(verdict.shape)},
            {"bending", lamp(verdict.bending)}}}};
}

std::string VerdictText(const FitProblem& problem, const FitReport& report) {
  const FitVerdict& verdict = report.verdict;
  std::string coefficient, shape;
  if (FindExperiment(problem) != nullptr) {
    if (verdict.shape.reasons.empty())
      shape = "All measurements within their errors, at rest and stable";
  } else if (!report.drapes.empty()) {
    const Eigen::Array2d mean = ListCoefficients(report).colwise().mean();
    coefficient = Format("The drape coefficient is %.1f %%, of the fitted drape %.1f %%",
                         100 * mean[0], 100 * mean[1]);
    if (verdict.shape.reasons.empty())
      shape =
          Format("Outline error %.1f mm rms, folds and area as in the image, at rest and stable",
                 MeanOutlineError(problem, report));
  }
  return std::string("verdict: measurement ") + ToString(verdict.measurement.grade) + ", shape " +
         ToString(verdict.shape.grade) + ", bending " + ToString(verdict.bending.grade) + "\n" +
         LampText("measurement", verdict.measurement, coefficient) +
         LampText("shape", verdict.shape, shape) +
         LampText("bending", verdict.bending, report.fabric_sheet ? BendingText(report) : "");
}

}  // namespace drape
