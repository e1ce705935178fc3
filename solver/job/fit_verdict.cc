// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_verdict.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "physics/material/material_scaling.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/math/statistics.h"
#include "physics/util/text_format.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/forward/settle.h"
#include "solver/job/fit_report.h"
#include "solver/prediction/exchange/exchange_record.h"
#include "solver/prediction/prediction.h"

namespace drape {
namespace {

// The stiffness of a strip along weft or warp that is free to contract [N/m].
double StripStiffness(const LinearFabric& f, bool warp) {
  return warp ? f.c22 - f.c12 * f.c12 / f.c11 : f.c11 - f.c12 * f.c12 / f.c22;
}

double Rigidity(const LinearFabric& f, bool warp) { return warp ? f.bend_warp : f.bend_weft; }
double OverallRigidity(const LinearFabric& f) { return OverallStiffness(f.bend_warp, f.bend_weft); }

double Formability(const LinearFabric& f, bool warp) {
  const double strip = StripStiffness(f, warp);
  return FormabilityMm2(Rigidity(f, warp), ExtensionPercent(kFastForces[0], strip),
                        ExtensionPercent(kFastForces[1], strip));
}

using Quantity = std::function<double(const LinearFabric&)>;

// Writes the rows of one fabric.
class SheetWriter {
 public:
  SheetWriter(const FabricSheetInput& input, const Judgement& judge)
      : input_(input),
        judge_(judge),
        fabric_(Linearise(input.tables)),
        warp_first_(input.directions.warp != "softer") {
    const std::optional<KnownTo> ratio = judge(log_ratio_, Resistance::kBending);
    ratio_varies_ = ratio.has_value();
    ratio_determined_ = ratio && ratio->determined;
  }

  LaboratorySheet Write() {
    AddMass();
    AddBending();
    AddShear();
    for (const bool warp : {warp_first_, !warp_first_}) AddExtensions(warp);
    return {"Material, as laboratories report it", std::move(rows_)};
  }

 private:
  static constexpr double kMicro = 1e6, kCentimetres = 1e2, kGrams = 1e3;  // in an SI unit
  static constexpr const char *kMeasured = "measured", *kPrior = "from the prior",
                              *kAssumedMass = "measured, if the assumed mass is right";

  LinearFabric Linearise(const MaterialField& tables) const {
    return LineariseInDrape(tables, input_.law, input_.weights);
  }

  const std::string& Name(bool warp) const {
    return warp ? input_.directions.warp : input_.directions.weft;
  }

  void AddMass() {
    rows_.push_back({.key = "mass_g_per_m2",
                     .name = "mass per area W",
                     .value = kGrams * fabric_.density,
                     .unit = "g/m²",
                     .source = input_.density_is_given ? "given" : "assumed: of the start tables",
                     .standard = ""});
  }

  // The test that measures a row.
  struct Basis {
    Resistance resistance = Resistance::kBending;
    bool one_direction = false;
    bool of_mass = true;  // in proportion to it
    std::optional<double> reads_up_to = {};
  };

  void Add(const char* key, const std::string& name, const char* unit, const char* standard,
           const LogQuantity& log_quantity, const Basis& basis) {
    LaboratoryRow row{.key = key,
                      .name = name,
                      .value = std::exp(log_quantity(input_.tables)),
                      .unit = unit,
                      .source = kPrior,
                      .standard = standard,
                      .reads_up_to = basis.reads_up_to};
    const std::optional<KnownTo> known = judge_(log_quantity, basis.resistance);
    const bool tied = basis.one_direction && !ratio_varies_;
    if (known && !tied) row.interval = {row.value * known->low, row.value * known->high};
    if (known && known->determined && (!basis.one_direction || ratio_determined_))
      row.source = basis.of_mass && !input_.density_is_given ? kAssumedMass : kMeasured;
    rows_.push_back(std::move(row));
  }
  void Add(const char* key, const std::string& name, const char* unit, const char* standard,
           const Quantity& quantity, const Basis& basis) {
    Add(key, name, unit, standard, LogQuantity([this, quantity](const MaterialField& tables) {
          return std::log(quantity(Linearise(tables)));
        }),
        basis);
  }

  void AddBending() {
    const char* iso = "ISO 9073-7";
    const auto in_drape = [this](const MaterialField& tables) {
      return std::log(kMicro * EffectiveBend(tables, input_.weights));
    };
    Add("bending_in_drape_un_m", "bending rigidity B, as it drapes", "µN·m", "mean over directions",
        LogQuantity(in_drape), {});
    const auto rows = [&](const std::string& direction, const std::string& key,
                          const Quantity& rigidity, bool one_direction) {
      Add(("bending_" + key + "_un_m").c_str(), "bending rigidity B, " + direction, "µN·m", iso,
          Quantity([=](const LinearFabric& f) { return kMicro * rigidity(f); }),
          {.one_direction = one_direction});
      Add(("bending_length_" + key + "_cm").c_str(), "bending length c, " + direction, "cm", iso,
          Quantity([=](const LinearFabric& f) {
            return kCentimetres * BendingLength(rigidity(f), f.density);
          }),
          {.one_direction = one_direction, .of_mass = false});
      Add(("kes_b_" + key + "_gf_cm2_per_cm").c_str(), "B, " + direction, "gf·cm²/cm", "KES-FB2",
          Quantity([=](const LinearFabric& f) { return KesBending(rigidity(f)); }),
          {.one_direction = one_direction});
    };
    for (const bool warp : {warp_first_, !warp_first_})
      rows(
          Name(warp), Name(warp), [warp](const LinearFabric& f) { return Rigidity(f, warp); },
          true);
    if (Name(warp_first_) == "stiffer")
      Add("bending_ratio", "ratio of B, stiffer over softer", "", iso, log_ratio_,
          {.one_direction = true, .of_mass = false});
    rows("overall", "overall", OverallRigidity, false);
  }

  void AddShear() {
    const auto add = [&](const char* key, const char* name, const char* unit, const char* standard,
                         const Quantity& quantity, std::optional<double> reads_up_to = {}) {
      Add(key, name, unit, standard, quantity,
          {.resistance = Resistance::kStretching, .of_mass = false, .reads_up_to = reads_up_to});
    };
    add("shear_n_per_m", "shear rigidity G", "N/m", "c33/2",
        [](const LinearFabric& f) { return f.shear; });
    add(
        "fast_eb5_percent", "bias extension EB5", "%", "FAST-3: G = 123/EB5",
        [](const LinearFabric& f) { return FastBiasExtensionPercent(f.shear); },
        kFastMostExtension);
    add("kes_g_gf_per_cm_deg", "G", "gf/(cm·°)", "KES-FB1",
        [](const LinearFabric& f) { return KesShear(f.shear); });
  }

  void AddExtensions(bool warp) {
    const std::string direction = ", " + Name(warp), end = "_" + Name(warp);
    const auto extension = [&](const std::string& key, const std::string& name,
                               const char* standard, double force, double reads_up_to) {
      Add((key + end + "_percent").c_str(), name + direction, "%", standard,
          Quantity([=](const LinearFabric& f) {
            return ExtensionPercent(force, StripStiffness(f, warp));
          }),
          {.resistance = Resistance::kStretching, .of_mass = false, .reads_up_to = reads_up_to});
    };
    const char *fast = "FAST-3, linear", *kes = "KES-FB1, linear";
    extension("fast_e5", "extension E5", fast, kFastForces[0], kFastMostExtension);
    extension("fast_e20", "extension E20", fast, kFastForces[1], kFastMostExtension);
    extension("fast_e100", "extension E100", fast, kFastForces[2], kFastMostExtension);
    extension("kes_emt", "extension EMT", kes, kKesForce, kKesMostExtension);
    // The formability at which E20 is the largest extension that the instrument reads.
    const double most =
        FormabilityMm2(Rigidity(fabric_, warp),
                       kFastMostExtension * kFastForces[0] / kFastForces[1], kFastMostExtension);
    Add(("fast_formability" + end + "_mm2").c_str(), "formability F" + direction, "mm²", "FAST",
        Quantity([=](const LinearFabric& f) { return Formability(f, warp); }),
        {.resistance = Resistance::kStretching, .reads_up_to = most});
  }

  const FabricSheetInput& input_;
  const Judgement& judge_;
  const LinearFabric fabric_;
  const bool warp_first_;  // in the order of rows, and over the other in the ratio
  const LogQuantity log_ratio_ = [this](const MaterialField& tables) {
    const LinearFabric fabric = Linearise(tables);
    return std::log(Rigidity(fabric, warp_first_) / Rigidity(fabric, !warp_first_));
  };
  bool ratio_varies_ = false, ratio_determined_ = false;
  std::vector<LaboratoryRow> rows_;
};

double Variance(const std::vector<double>& values) {
  const Eigen::Map<const Eigen::ArrayXd> all(values.data(), Eigen::Index(values.size()));
  return (all - all.mean()).square().mean();
}

// The power of the rigidities in a quantity: 1 of a rigidity, 1/3 of a bending length.
double BendDegree(const LogQuantity& log_quantity, const MaterialField& tables) {
  return (log_quantity(Scaled(tables, 1.0, 2.0)) - log_quantity(tables)) / std::log(2.0);
}

std::vector<double> EvaluateAll(const LogQuantity& log_quantity, const FabricSamples& samples) {
  std::vector<double> values;
  for (const MaterialField& tables : samples.tables) values.push_back(log_quantity(tables));
  return values;
}

using nlohmann::ordered_json;

// A log factor counts as determined when the data leave less than this share of its prior
// deviation.
constexpr double kDetermined = 0.7;
// Standard deviation of the log bending stiffness that silhouettes of twins leave: shear
// stiffness, nonlinear tables and other branches make up for it [METHODS, P57].
constexpr double kModelDeviation = 0.3;
constexpr double kQuantile90 = 1.645;  // of a normal distribution, two-sided

// A quantity that is good up to one limit and usable up to another [METHODS, P57].
struct Limits {
  double good, usable;
};
constexpr Limits kOutlineError = {3.0, 5.0};        // root mean square [mm]
constexpr Limits kCoefficientError = {0.02, 0.05};  // of the drape coefficient
constexpr Limits kFoldError = {0, 1};
constexpr Limits kForceResidual = {kAtRestResidual, 1e-3};  // by the weight
constexpr Limits kDrift = {1e3 * kAtRestDrift, 5.0};        // of a vertex of a nudged drape [mm]
constexpr Limits kMisfit = {2.0, 3.0};                      // of a laboratory reading [sigma]
constexpr double kReliableK = 0.7;                          // of importance weights [Vehtari 2024]
constexpr double kNearSingular = 0.95;  // c12²/(c11·c22); kLargestCoupling² is 0.98

FitGrade ChooseGrade(double value, const Limits& limits) {
  if (value <= limits.good) return FitGrade::kGood;
  return value <= limits.usable ? FitGrade::kUsable : FitGrade::kDoNotUse;  // NaN too
}

class Judge {
 public:
  void Add(FitGrade grade, const std::string& reason) {
    if (grade != FitGrade::kGood) found_.push_back({grade, reason});
  }
  FitVerdict Verdict() {
    std::stable_sort(found_.begin(), found_.end(),
                     [](const Found& a, const Found& b) { return a.grade > b.grade; });
    FitVerdict verdict;
    if (!found_.empty()) verdict.grade = found_.front().grade;
    for (const Found& found : found_) verdict.reasons.push_back(found.reason);
    return verdict;
  }

 private:
  struct Found {
    FitGrade grade;
    std::string reason;
  };
  std::vector<Found> found_;
};

double Millimetres(double pixels, const Observation& observation) {
  return 1e3 * pixels / observation.camera.pixels_per_metre();
}

// The root mean square over the images of the outline's error [mm].
double OutlineError(const FitProblem& problem, const FitReport& report) {
  double sum = 0.0;
  for (std::size_t i = 0; i < report.drapes.size(); ++i)
    sum += std::pow(
        Millimetres(report.drapes[i].fitted.metrics.profile_rms, problem.observations[i]), 2);
  return std::sqrt(sum / static_cast<double>(report.drapes.size()));
}

void JudgeDrape(const Observation& observation, const DrapeReport& drape, const std::string& which,
                Judge& judge) {
  if (drape.fitted.x.size() == 0)
    return judge.Add(FitGrade::kDoNotUse, "the fitted drape has no outline" + which);
  const SilhouetteMetrics& m = drape.fitted.metrics;
  const double error = Millimetres(m.profile_rms, observation);
  judge.Add(ChooseGrade(error, kOutlineError),
            Format("an outline error of %.1f mm (%.1f px), expected at most %.0f mm", error,
                   m.profile_rms, kOutlineError.good) +
                which);
  judge.Add(ChooseGrade(std::abs(m.image.folds - m.fitted.folds), kFoldError),
            Format("%d folds, the image has %d", m.fitted.folds, m.image.folds) + which);
  judge.Add(ChooseGrade(std::abs(m.image.drape_coefficient - m.fitted.drape_coefficient),
                        kCoefficientError),
            Format("drape coefficient %.1f %%, the image has %.1f %%",
                   100 * m.fitted.drape_coefficient, 100 * m.image.drape_coefficient) +
                which);
  judge.Add(
      ChooseGrade(drape.force_residual, kForceResidual),
      Format("not at rest: forces of %.1g of the weight remain", drape.force_residual) + which);
  if (!IsStable(drape.lowest_eigenvalues))
    judge.Add(FitGrade::kDoNotUse, "the fitted drape is not stable" + which);
  if (drape.self_intersections > 0)
    judge.Add(FitGrade::kDoNotUse, Format("the fitted drape passes through itself, in %d pairs of "
                                          "faces, which --contact=self prevents",
                                          drape.self_intersections) +
                                       which);
  if (drape.status == EquilibriumStatus::kStable) {
    judge.Add(ChooseGrade(1e3 * drape.drift, kDrift),
              Format("nudged, it comes to rest %.1f mm away", 1e3 * drape.drift) + which);
  } else {
    judge.Add(FitGrade::kDoNotUse, "nudged, it does not come to rest" + which);
  }
}

void JudgeImage(const Observation& observation, const std::string& which, Judge& judge) {
  if (observation.quality.doubtful)
    judge.Add(FitGrade::kUsable,
              "scale, centre or outline of the image may be off, see its notes" + which);
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

void JudgePosterior(const PosteriorFit& fit, Judge& judge) {
  if (!(fit.pareto_k < kReliableK))
    judge.Add(FitGrade::kUsable,
              std::isnan(fit.pareto_k)
                  ? "nothing confirms the posterior: do not use its intervals"
                  : Format("Pareto k %.2f: do not use the posterior's intervals", fit.pareto_k));
}

bool IsNearlySingular(const MaterialField& material) {
  return std::any_of(
      material.stretch.begin(), material.stretch.end(),
      [](const StretchTable& table) { return LargestSquaredCoupling(table) > kNearSingular; });
}

// The standard deviation of gradientᵀ·θ under the prior and rows of weight w, shape [K, P].
double LaplaceDeviation(const Eigen::VectorXd& gradient, const Eigen::MatrixXd& weighted_rows,
                        double prior_sigma) {
  Eigen::MatrixXd precision = weighted_rows.transpose() * weighted_rows;
  precision.diagonal().array() += 1 / (prior_sigma * prior_sigma);
  return std::sqrt(gradient.dot(precision.llt().solve(gradient)));
}

// How well the logarithm of a quantity is known at a fitted table, of which `shares` is its
// gradient by the log entries, shape [39].
class LaplaceApproximation {
 public:
  LaplaceApproximation(const Eigen::MatrixXd& tie, const WeightedRows& rows, double prior_sigma)
      : tie_(tie),
        has_outlines_(rows.outline_rows > 0),
        all_(rows.jacobian.size() > 0 ? rows.jacobian : Eigen::MatrixXd(0, tie.cols())),
        prior_sigma_(prior_sigma) {
    all_.topRows(rows.outline_rows) *= std::sqrt(rows.outline_weight);
    strips_ = all_.bottomRows(all_.rows() - rows.outline_rows);
  }

  // Whether a free number changes it at all.
  bool Varies(const Eigen::VectorXd& shares) const {
    constexpr double kRounding = 1e-6;
    return (tie_.transpose() * shares).norm() > kRounding;
  }

  // degree: of the quantity in a stiffness, whose logarithm has the model's error.
  StiffnessEstimate Estimate(double value, const Eigen::VectorXd& shares, bool outlines_tell,
                             double degree = 1.0) const {
    const Eigen::VectorXd gradient = tie_.transpose() * shares;
    const double limit = kDetermined * prior_sigma_ * gradient.norm();
    const bool by_strips = LaplaceDeviation(gradient, strips_, prior_sigma_) < limit;
    const double deviation = LaplaceDeviation(gradient, all_, prior_sigma_);
    const double model = by_strips || !has_outlines_ ? 0.0 : degree * kModelDeviation;
    return StiffnessEstimate{.value = value,
                             .log_deviation = std::hypot(deviation, model),
                             .model_deviation = model,
                             .determined = by_strips || (outlines_tell && deviation < limit)};
  }

 private:
  Eigen::MatrixXd tie_;
  bool has_outlines_;
  Eigen::MatrixXd all_, strips_;
  double prior_sigma_;
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

// "to a factor of 1.3 (data) and 3 % (mesh)"; power: of the stiffness that is spoken of.
std::string ErrorText(const FitReport& report, const StiffnessEstimate& estimate,
                      double MeshError::*log_error, double power) {
  std::string text = Format("to a factor of %.2g", std::pow(estimate.factor(), power));
  if (report.mesh_error)
    text += Format(" (data) and %.2g %% (mesh)",
                   100.0 * std::expm1(power * std::abs((*report.mesh_error).*log_error)));
  return text;
}

std::string StretchingText(const FitReport& report) {
  const StiffnessEstimate& stretch = report.stiffness->stretch;
  if (!stretch.determined) return "not stretching";
  return Format("stretching of %.3g N/m ", stretch.value) +
         ErrorText(report, stretch, &MeshError::log_stretch, 1.0);
}

// Without a density of the cloth, what does not depend on it: the cube root of the rigidity.
std::string BendingText(const FitReport& report) {
  const StiffnessEstimate& bend = report.stiffness->bend;
  if (!bend.determined) return "not bending";
  if (report.density_is_given)
    return Format("bending of %.3g uN m ", 1e6 * bend.value) +
           ErrorText(report, bend, &MeshError::log_bend, 1.0);
  const double density = report.material.density;
  return Format("a bending length of %.3g mm ", 1e3 * BendingLength(bend.value, density)) +
         ErrorText(report, bend, &MeshError::log_bend, 1.0 / 3.0) +
         Format(" (bending of %.3g uN m if the cloth weighs %.3g g/m2, as the start tables say)",
                1e6 * bend.value, 1e3 * density);
}

ordered_json EstimateJson(const StiffnessEstimate& estimate) {
  return {{"value", estimate.value},
          {"factor_90", estimate.factor()},
          {"log_sd", estimate.log_deviation},
          {"determined", estimate.determined}};
}

}  // namespace

Judgement JudgeByPosterior(const StoredPosterior& posterior, bool stretch_measured,
                           double bend_deviation) {
  constexpr int kSamples = 1000;
  constexpr double kLeastVariance = 1e-20;  // rounding
  constexpr double kLeastShare = 0.5;
  struct Samples {
    MaterialField median;
    FabricSamples after, before;
  };
  const auto samples = std::make_shared<const Samples>(
      Samples{MedianTables(posterior), SampleFabric(posterior, kSamples, 1),
              SamplePrior(posterior, kSamples, 1)});
  return [=](const LogQuantity& log_quantity, Resistance resistance) -> std::optional<KnownTo> {
    std::vector<double> after = EvaluateAll(log_quantity, samples->after);
    std::sort(after.begin(), after.end());
    const double prior = Variance(EvaluateAll(log_quantity, samples->before));
    if (!(prior > kLeastVariance)) return std::nullopt;
    const double left = Variance(after), median = log_quantity(samples->median);
    const bool narrowed = 1.0 - left / prior >= kLeastShare;
    const bool bends = resistance == Resistance::kBending;
    const double degree = BendDegree(log_quantity, samples->median);
    const double model = bends ? kQuantile90 * std::abs(degree) * bend_deviation : 0.0;
    return KnownTo{.low = std::exp(-std::hypot(median - Quantile(after, 0.05), model)),
                   .high = std::exp(std::hypot(Quantile(after, 0.95) - median, model)),
                   .determined = narrowed && (bends || stretch_measured)};
  };
}

LaboratorySheet MakeFabricSheet(const FabricSheetInput& input, const Judgement& judge) {
  return SheetWriter(input, judge).Write();
}

double StiffnessEstimate::factor() const { return std::exp(kQuantile90 * log_deviation); }

StiffnessEstimates EstimateStiffness(const MaterialField& table, const Eigen::VectorXd& weights,
                                     const Eigen::MatrixXd& tie, const WeightedRows& rows,
                                     double prior_sigma) {
  const LaplaceApproximation laplace(tie, rows, prior_sigma);
  return {
      laplace.Estimate(EffectiveStretch(table, weights), SharesInStretch(table, weights), false),
      laplace.Estimate(EffectiveBend(table, weights), SharesInBend(table, weights), true)};
}

Judgement JudgeByLaplace(const MaterialField& table, const Eigen::MatrixXd& tie,
                         const WeightedRows& rows, double prior_sigma) {
  const LaplaceApproximation laplace(tie, rows, prior_sigma);
  return [=](const LogQuantity& quantity, Resistance resistance) -> std::optional<KnownTo> {
    const Eigen::VectorXd shares = GradientByLogEntries(quantity, table);
    if (!laplace.Varies(shares)) return std::nullopt;
    const double degree = std::max(std::abs(shares.head(kStretchEntries).sum()),
                                   std::abs(shares.tail(kBendEntries).sum()));
    const StiffnessEstimate estimate =
        laplace.Estimate(1.0, shares, resistance == Resistance::kBending, degree);
    return KnownTo{
        .low = 1 / estimate.factor(), .high = estimate.factor(), .determined = estimate.determined};
  };
}

FitVerdict JudgeFit(const FitProblem& problem, const FitReport& report) {
  Judge judge;
  if (!report.fitted()) {
    judge.Add(FitGrade::kDoNotUse, "nothing could be fitted");
    return judge.Verdict();
  }
  if (report.cancelled) {  // its drapes have not been examined
    judge.Add(FitGrade::kDoNotUse, "the fit was cancelled");
    return judge.Verdict();
  }
  const bool several = report.drapes.size() > 1;
  for (std::size_t i = 0; i < report.drapes.size(); ++i) {
    const Observation& observation = problem.observations[i];
    const std::string which = several ? " (" + observation.name + ")" : "";
    JudgeDrape(observation, report.drapes[i], which, judge);
    JudgeImage(observation, which, judge);
  }
  JudgeStrips(report.strips, judge);
  if (report.posterior) JudgePosterior(*report.posterior, judge);
  if (IsNearlySingular(report.material))
    judge.Add(FitGrade::kUsable, "the stretch table is at the limit of what resists all strains");
  if (report.spectrum.determined == 0) judge.Add(FitGrade::kDoNotUse, "the data determine nothing");
  return judge.Verdict();
}

ordered_json VerdictJson(const FitReport& report) {
  ordered_json json = {{"grade", ToString(report.verdict.grade)},
                       {"reasons", report.verdict.reasons}};
  if (report.stiffness)
    json.update({{"bend_n_m", EstimateJson(report.stiffness->bend)},
                 {"stretch_n_per_m", EstimateJson(report.stiffness->stretch)}});
  return json;
}

std::string VerdictLine(const FitProblem& problem, const FitReport& report) {
  const FitVerdict& verdict = report.verdict;
  constexpr std::size_t kMostReasons = 3;
  std::string line = std::string("verdict: ") + ToString(verdict.grade);
  if (verdict.reasons.empty() && !report.drapes.empty())
    line +=
        Format(": outline error %.1f mm rms, folds and area as in the image, at rest and stable",
               OutlineError(problem, report));
  for (std::size_t i = 0; i < std::min(kMostReasons, verdict.reasons.size()); ++i)
    line += (i == 0 ? ": " : "; ") + verdict.reasons[i];
  if (verdict.reasons.size() > kMostReasons)
    line += Format("; and %zu more", verdict.reasons.size() - kMostReasons);
  if (report.stiffness && verdict.grade != FitGrade::kDoNotUse)
    line += ". Trust " + BendingText(report) + ", " + StretchingText(report) +
            ", and no single entry of the tables";
  return line + "\n";
}

}  // namespace drape
