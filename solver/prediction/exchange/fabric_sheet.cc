// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/fabric_sheet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "physics/material/material_scaling.h"
#include "physics/util/math/statistics.h"
#include "solver/fit/strips.h"
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

// What cantilevers have read of the logarithm of a bending length.
struct CantileverReading {
  double log_length = 0.0, deviation = 0.0;
};

// The mean over all points of the tests of strips in a direction, by their precision; points that
// contradict one another make it less certain.
std::optional<CantileverReading> ReadCantilevers(const std::vector<LabMeasurement>& tests,
                                                 double direction) {
  constexpr double kStep = 1e-3;  // [°]
  double weight = 0.0, sum = 0.0, squares = 0.0;
  int count = 0;
  for (const LabMeasurement& test : tests) {
    if (test.kind != LabMeasurementKind::kCantilever || test.direction != direction) continue;
    for (const LabPoint& point : test.points) {
      const auto log_length = [&](double angle) {
        return std::log(EstimateBending(point.set, angle, 1.0).length);
      };
      const double length = log_length(point.reading),
                   slope = (log_length(point.reading + kStep) - length) / kStep,
                   precision = 1.0 / std::pow(slope * test.sigma, 2);
      if (!std::isfinite(length) || !std::isfinite(precision)) continue;
      weight += precision;
      sum += precision * length;
      squares += precision * length * length;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  const double mean = sum / weight, misfit = squares - mean * sum;
  const double scatter = count > 1 ? std::max(1.0, misfit / (count - 1)) : 1.0;
  return CantileverReading{mean, std::sqrt(scatter / weight)};
}

std::optional<CantileverReading> Overall(const std::optional<CantileverReading>& warp,
                                         const std::optional<CantileverReading>& weft) {
  if (!warp || !weft) return std::nullopt;
  return CantileverReading{0.5 * (warp->log_length + weft->log_length),
                           0.5 * std::hypot(warp->deviation, weft->deviation)};
}

// Writes the rows of one fabric.
class SheetWriter {
 public:
  SheetWriter(const FabricSheetInput& input, const Judgement& judge)
      : input_(input),
        judge_(judge),
        fabric_(Linearise(input.tables)),
        warp_first_(input.directions.warp != "softer") {
    const std::optional<KnownTo> ratio = judge(log_ratio_, Resistance::kBending);
    ratio_determined_ = ratio && ratio->determined;
  }

  LaboratorySheet WriteLinear() {
    for (const LinearNumber& number : LinearNumbers()) {
      const bool bends = std::string(number.key).starts_with("bend");
      const std::string key = NumberKey(number, input_.directions);
      Add(key, key, number.unit, "",
          Quantity([&](const LinearFabric& f) { return f.*number.value; }),
          {.resistance = bends ? Resistance::kBending : Resistance::kStretching,
           .one_direction = bends,
           .of_mass = bends,
           .of_tables = true});
    }
    return {"Material, linear in its drapes", std::move(rows_)};
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
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static constexpr char kIso[] = "ISO 9073-7";

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
                     .source = input_.density_is_given ? kGiven : "assumed: of the start tables",
                     .standard = ""});
  }

  // The test that measures a row.
  struct Basis {
    Resistance resistance = Resistance::kBending;
    bool one_direction = false;
    bool of_mass = true;     // in proportion to it
    bool of_tables = false;  // its value, whatever other branches say
    std::optional<double> reads_up_to = {};
  };

  void Add(const std::string& key, const std::string& name, const char* unit, const char* standard,
           const LogQuantity& log_quantity, const Basis& basis) {
    const double value = log_quantity(input_.tables);
    std::optional<KnownTo> known;
    if (std::isfinite(value)) known = judge_(log_quantity, basis.resistance);
    if (!known || !known->determined || (basis.one_direction && !ratio_determined_)) known.reset();
    if (known && basis.of_tables) known->middle = 1.0;
    AddRow({.key = key,
            .name = name,
            .value = std::exp(value),
            .unit = unit,
            .source = kFromThePrior,
            .standard = standard,
            .reads_up_to = basis.reads_up_to},
           known, basis.of_mass);
  }
  // known: of a measured quantity.
  void AddRow(LaboratoryRow row, const std::optional<KnownTo>& known, bool of_mass) {
    if (known) {
      row.interval = {known->low > 0.0 ? row.value * known->low : -kInfinity,
                      row.value * known->high};
      row.value *= known->middle;
      if (row.is_bound())
        row.value = std::isinf(row.interval->high) ? row.interval->low : row.interval->high;
      row.source = of_mass && !input_.density_is_given ? kMeasuredIfMass : kMeasured;
    }
    rows_.push_back(std::move(row));
  }
  void Add(const std::string& key, const std::string& name, const char* unit, const char* standard,
           const Quantity& quantity, const Basis& basis) {
    Add(key, name, unit, standard, LogQuantity([this, quantity](const MaterialField& tables) {
          return std::log(quantity(Linearise(tables)));
        }),
        basis);
  }

  void AddBending() {
    const auto in_drape = [this](const MaterialField& tables) {
      return std::log(kMicro * EffectiveBend(tables, input_.weights));
    };
    Add("bending_in_drape_un_m", "bending rigidity B, as it drapes", "µN·m", "mean over directions",
        LogQuantity(in_drape), {});
    Add("stretch_in_drape_n_per_m", "tensile stiffness, as it drapes", "N/m",
        "mean over directions", LogQuantity([this](const MaterialField& tables) {
          return std::log(EffectiveStretch(tables, input_.weights));
        }),
        {.resistance = Resistance::kStretching, .of_mass = false});
    const auto warp = ReadCantilevers(input_.tests, 90.0), weft = ReadCantilevers(input_.tests, 0);
    for (const bool along_warp : {warp_first_, !warp_first_})
      AddDirection(
          Name(along_warp), along_warp ? warp : weft,
          [=](const LinearFabric& f) { return Rigidity(f, along_warp); }, true);
    if (Name(warp_first_) == "stiffer")
      Add("bending_ratio", "ratio of B, stiffer over softer", "", kIso, log_ratio_,
          {.one_direction = true, .of_mass = false});
    AddDirection("overall", Overall(warp, weft), OverallRigidity, false);
  }

  // Rigidity and bending length of a direction: as cantilevers have read them, or of the tables.
  void AddDirection(const std::string& direction, const std::optional<CantileverReading>& reading,
                    const Quantity& rigidity, bool one_direction) {
    // degree: of the rigidity in the quantity.
    const auto add = [&](const std::string& of, const std::string& name, const char* unit,
                         const char* standard, double degree, const auto& quantity) {
      const bool of_mass = degree == 1.0;
      const double density = fabric_.density;
      if (!reading)
        return Add(of, name + direction, unit, standard, Quantity([=](const LinearFabric& f) {
                     return quantity(rigidity(f), f.density);
                   }),
                   {.one_direction = one_direction, .of_mass = of_mass});
      const double length = std::exp(reading->log_length),
                   factor = std::exp(3.0 * degree * kQuantile90 * reading->deviation);
      AddRow({.key = of,
              .name = name + direction,
              .value = quantity(std::pow(length, 3) / BendOverWeight(1.0, density), density),
              .unit = unit,
              .source = {},
              .standard = standard},
             KnownTo{.low = 1.0 / factor, .high = factor}, of_mass);
    };
    add("bending_" + direction + "_un_m", "bending rigidity B, ", "µN·m", kIso, 1.0,
        [](double b, double) { return kMicro * b; });
    add("bending_length_" + direction + "_cm", "bending length c, ", "cm", kIso, 1.0 / 3.0,
        [](double b, double density) { return kCentimetres * BendingLength(b, density); });
    add("kes_b_" + direction + "_gf_cm2_per_cm", "B, ", "gf·cm²/cm", "KES-FB2", 1.0,
        [](double b, double) { return KesBending(b); });
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
      Add(key + end + "_percent", name + direction, "%", standard,
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
    Add("fast_formability" + end + "_mm2", "formability F" + direction, "mm²", "FAST",
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
  bool ratio_determined_ = false;
  std::vector<LaboratoryRow> rows_;
};

double Variance(const std::vector<double>& values) {
  const Eigen::Map<const Eigen::ArrayXd> all(values.data(), Eigen::Index(values.size()));
  return (all - all.mean()).square().mean();
}

std::vector<double> EvaluateAll(const LogQuantity& log_quantity, const FabricSamples& samples) {
  std::vector<double> values;
  for (const MaterialField& tables : samples.tables) values.push_back(log_quantity(tables));
  return values;
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
  if (posterior.branch_deviation > 0.0) bend_deviation = 0.0;
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
                   .determined = narrowed && (bends || stretch_measured),
                   .by_outlines = bend_deviation > 0.0,
                   .left = left / prior};
  };
}

Judgement JudgeOverBranches(const Judgement& judge, const MaterialField& tables,
                            const std::vector<BranchTables>& branches) {
  if (branches.empty()) return judge;
  return [=](const LogQuantity& quantity, Resistance resistance) -> std::optional<KnownTo> {
    std::optional<KnownTo> known = judge(quantity, resistance);
    if (!known || !known->by_outlines || resistance != Resistance::kBending) return known;
    const double own = quantity(tables), wide = 0.5 * std::log(known->high / known->low);
    std::vector<std::pair<double, double>> at;  // the logarithm of a branch over `own`, its weight
    double all = 0.0;
    for (const BranchTables& branch : branches)
      if (const double log = quantity(branch.tables) - own; std::isfinite(log)) {
        at.emplace_back(log, branch.weight);
        all += branch.weight;
      }
    if (at.empty() || !(wide > 0.0)) return known;
    const auto quantile = [&](double p) {
      double low = std::ranges::min(at).first - 3 * wide,
             high = std::ranges::max(at).first + 3 * wide;
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = 0.5 * (low + high);
        double below = 0.0;
        for (const auto& [log, weight] : at)
          below += 0.5 * weight * std::erfc((log - middle) * kQuantile90 / (wide * M_SQRT2));
        (below < p * all ? low : high) = middle;
      }
      return std::exp(0.5 * (low + high));
    };
    known->low = quantile(0.05);
    known->high = quantile(0.95);
    known->middle = quantile(0.5);
    return known;
  };
}

double BendDegree(const LogQuantity& log_quantity, const MaterialField& tables) {
  return (log_quantity(Scaled(tables, 1.0, 2.0)) - log_quantity(tables)) / std::log(2.0);
}

Judgement JudgeByBound(const Judgement& judge, Bound bound, const MaterialField& tables,
                       double least) {
  if (bound == Bound::kNone) return judge;
  MaterialField least_stiff = tables;
  for (auto& row : least_stiff.bend[0].b)
    for (double& entry : row) entry = kBendPerRigidity * least;
  return [=](const LogQuantity& quantity, Resistance resistance) -> std::optional<KnownTo> {
    constexpr double kRatio = 1e-3;  // of a degree: rounding
    std::optional<KnownTo> known = judge(quantity, resistance);
    if (!known || !known->by_outlines || resistance != Resistance::kBending) return known;
    const double degree = BendDegree(quantity, tables);
    known->determined = degree > kRatio;
    if (bound == Bound::kAtLeast) {
      known->high = std::numeric_limits<double>::infinity();
      if (least > 0.0) known->low = std::exp(quantity(least_stiff) - quantity(tables));
    } else {
      known->low = 0.0;
    }
    return known;
  };
}

LaboratorySheet MakeFabricSheet(const FabricSheetInput& input, const Judgement& judge) {
  return SheetWriter(input, judge).Write();
}

LaboratorySheet MakeLinearSheet(const FabricSheetInput& input, const Judgement& judge) {
  return SheetWriter(input, judge).WriteLinear();
}

}  // namespace drape
