// SPDX-License-Identifier: Apache-2.0
#include "solver/fit_drapes.h"

#include <algorithm>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/math/statistics.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/job/fit_job.h"

namespace drape {

namespace {

DrapeFit FitInMemory(const FitSpec& spec, const FitData& data, FitInput input,
                     const RunControl& control, const std::string& folder) {
  FitFiles files;
  files.out = folder;
  if (!folder.empty()) CheckTargets(spec, input.problem, files);
  StoredFit stored = FitFromInput(spec, input, {}, control);
  if (!folder.empty())
    WriteFitReport(spec, data, files, input.problem, stored.state, stored.report);
  const auto report = std::make_shared<const FitReport>(std::move(stored.report));
  DrapeFit fit{.material = report->material,
               .sheet = report->fabric_sheet.value_or(LaboratorySheet()),
               .verdict = report->verdict,
               .notes = report->notes,
               .cloth = FindFittedCloth(input, stored.state).model,
               .cancelled = report->cancelled,
               .report = report};
  if (fit.cloth == nullptr && !input.problem.further.empty())
    fit.cloth = input.problem.further.front().model;
  if (const FitCandidate* best = Best(stored.state)) fit.drapes = FittedShapes(*report, *best);
  return fit;
}

}  // namespace

DrapeFit FitDrapes(const FitSpec& spec, ObservedFabric fabric, const RunControl& control,
                   const std::string& folder) {
  return FitInMemory(spec, {}, MakeFitInput(spec, std::move(fabric)), control, folder);
}

DrapeFit FitDrapes(const FitSpec& spec, ExperimentFile experiments, const RunControl& control,
                   const std::string& folder) {
  return FitInMemory(spec, {}, MakeFitInput(spec, std::move(experiments)), control, folder);
}

DrapeFit FitDrapes(const FitSpec& spec, const FitData& data, const RunControl& control,
                   const std::string& folder) {
  return FitInMemory(spec, data, ReadFitInput(spec, data), control, folder);
}

double PosteriorQuantity::Quantile(double share) const {
  std::vector<double> sorted = samples;
  std::sort(sorted.begin(), sorted.end());
  return drape::Quantile(sorted, share);
}

const PosteriorQuantity& Posterior::of(const std::string& key) const {
  std::string keys;
  for (const PosteriorQuantity& quantity : quantities) {
    if (quantity.key == key) return quantity;
    keys += (keys.empty() ? "" : ", ") + quantity.key;
  }
  throw InputError("posterior", "found no quantity '" + key + "', expected one of " + keys);
}

Posterior SamplePosterior(const DrapeFit& fit, int count, uint64_t seed) {
  const FitReport* report = fit.report.get();
  if (report == nullptr || !report->posterior ||
      report->posterior->kind != PosteriorKind::kHierarchy)
    throw InputError("SamplePosterior",
                     "found a fit without a posterior of its fabric, expected one by model bayes");
  if (count < 1)
    throw InputError("count", "found " + std::to_string(count) + ", expected 1 or more");
  Posterior posterior{.fabrics = {}, .quantities = {}, .pareto_k = report->posterior->pareto_k};
  for (const LaboratoryRow& row : fit.sheet.rows) posterior.quantities.push_back({row, {}});
  const Judgement judge_nothing = [](const LogQuantity&, Resistance) { return std::nullopt; };
  std::vector<LabMeasurement> tests;
  for (const StripReport& strip : report->strips) tests.push_back(strip.measurement);
  const GaussianPosterior& gaussian = report->posterior->distribution.gaussian;
  const Eigen::MatrixXd u = gaussian.Draws(IndependentSamples(gaussian.size(), count, seed));
  for (int i = 0; i < count; ++i) {
    posterior.fabrics.push_back(report->posterior->FabricAt(u.col(i)));
    const LaboratorySheet sheet = MakeFabricSheet({.tables = posterior.fabrics.back(),
                                                   .law = fit.cloth->law,
                                                   .weights = report->stiffness_weights,
                                                   .density_is_given = report->density_is_given,
                                                   .directions = report->directions,
                                                   .tests = tests},
                                                  judge_nothing);
    for (std::size_t k = 0; k < sheet.rows.size(); ++k)
      posterior.quantities[k].samples.push_back(sheet.rows[k].value);
  }
  return posterior;
}

}  // namespace drape
