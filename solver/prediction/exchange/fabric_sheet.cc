// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/fabric_sheet.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "physics/material/material_scaling.h"
#include "physics/util/math/statistics.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/prediction/exchange/linear_fabric.h"
#include "solver/prediction/fabric_source.h"

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
      : input_(input), judge_(judge), fabric_(Linearise(input.tables)) {
    const std::optional<KnownTo> ratio = judge(
        [this](const MaterialField& tables) {
          const LinearFabric fabric = Linearise(tables);
          return std::log(fabric.bend_warp / fabric.bend_weft);
        },
        Resistance::kBending);
    ratio_varies_ = ratio.has_value();
    ratio_determined_ = ratio && ratio->determined;
  }

  LaboratorySheet Write() {
    AddMass();
    AddBending();
    AddShear();
    for (const bool warp : {true, false}) AddExtensions(warp);
    return {"Material, as laboratories report it", std::move(rows_)};
  }

 private:
  static constexpr double kMicro = 1e6, kCentimetres = 1e2, kGrams = 1e3;  // in an SI unit
  static constexpr const char *kMeasured = "measured", *kPrior = "from the prior",
                              *kAssumedMass = "measured, if the assumed mass is right";

  LinearFabric Linearise(const MaterialField& tables) const {
    return LineariseInDrape(tables, input_.law, input_.weights);
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
    rows(
        "warp", "warp", [](const LinearFabric& f) { return Rigidity(f, true); }, true);
    rows(
        "weft", "weft", [](const LinearFabric& f) { return Rigidity(f, false); }, true);
    rows("overall", "overall", OverallRigidity, false);
  }

  void AddShear() {
    const auto add = [&](const char* key, const char* name, const char* unit, const char* standard,
                         const Quantity& quantity, std::optional<double> reads_up_to = {}) {
      Add(key, name, unit, standard, quantity,
          {.resistance = Resistance::kStretching, .reads_up_to = reads_up_to});
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
    const std::string direction = warp ? ", warp" : ", weft", end = warp ? "_warp" : "_weft";
    const auto extension = [&](const std::string& key, const std::string& name,
                               const char* standard, double force, double reads_up_to) {
      Add((key + end + "_percent").c_str(), name + direction, "%", standard,
          Quantity([=](const LinearFabric& f) {
            return ExtensionPercent(force, StripStiffness(f, warp));
          }),
          {.resistance = Resistance::kStretching, .reads_up_to = reads_up_to});
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

}  // namespace

Judgement JudgeByPosterior(const StoredPosterior& posterior, bool stretch_measured,
                           double bend_deviation) {
  constexpr int kSamples = 1000;
  constexpr double kLeastVariance = 1e-20;  // rounding
  constexpr double kLeastShare = 0.5;
  constexpr double kQuantile = 1.645;  // of a normal distribution, 90 % two-sided
  struct Samples {
    MaterialField median;
    FabricSamples after, before;
  };
  const auto samples = std::make_shared<const Samples>(
      Samples{MedianTables(posterior), SamplePosterior(posterior, kSamples, 1),
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
    const double model = bends ? kQuantile * std::abs(degree) * bend_deviation : 0.0;
    return KnownTo{.low = std::exp(-std::hypot(median - Quantile(after, 0.05), model)),
                   .high = std::exp(std::hypot(Quantile(after, 0.95) - median, model)),
                   .determined = narrowed && (bends || stretch_measured)};
  };
}

LaboratorySheet MakeFabricSheet(const FabricSheetInput& input, const Judgement& judge) {
  return SheetWriter(input, judge).Write();
}

}  // namespace drape
