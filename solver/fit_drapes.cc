// SPDX-License-Identifier: Apache-2.0
#include "solver/fit_drapes.h"

#include <algorithm>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/math/statistics.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/guided_settle.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/fit/rollout_residuals.h"
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

FitResiduals::FitResiduals(const FitSpec& spec, const FitData& data, const RunControl& control)
    : input_(std::make_unique<FitInput>(ReadFitInput(spec, data))) {
  FitProblem& problem = input_->problem;
  if (data.experiment.empty())
    throw InputError("residuals", "found no experiment, expected the residuals of one");
  problem.strips = input_->strips.get();
  SettleOptions settle = MakeSettleOptions(spec.stages);
  settle.steps.cancel = settle.equilibrium.cancel = control.cancel;
  std::vector<RolloutBlock> blocks;
  for (const Observation& observation : problem.observations) {
    const State start = MakeStart(*observation.experiment, problem.fine->model(), 0);
    SettledDrape drape = SettleGuided(*problem.fine, problem.material, start, observation, settle);
    if (!drape.IsUsable(SolveMode::kStatic))
      throw InputError(data.experiment, "experiment '" + observation.name + "' is " +
                                            ToString(drape.rest.status) +
                                            " with the start tables, expected a cloth that comes "
                                            "to rest");
    blocks = MakeBlocks(problem.fine, {observation}, AtRest({std::move(drape.rest.x)}),
                        spec.stages.residuals);
  }
  for (RolloutBlock& block : FurtherBlocks(problem, nullptr)) blocks.push_back(std::move(block));
  parametrisation_ = std::make_unique<DynamicsParametrisation>(
      TableParametrisation(problem.material, spec.stages.parameters), problem.fitted);
  residuals_ = std::make_unique<RolloutResiduals>(parametrisation_.get(), std::move(blocks),
                                                  spec.stages.residuals);
}

FitResiduals::~FitResiduals() = default;

int FitResiduals::num_parameters() const { return residuals_->num_parameters(); }

bool FitResiduals::Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                            Eigen::MatrixXd* jacobian) {
  if (theta.size() != num_parameters())
    throw InputError("theta", "found " + std::to_string(theta.size()) + " numbers, expected " +
                                  std::to_string(num_parameters()));
  Eigen::Map<Eigen::VectorXd>(residuals_->theta(), theta.size()) = theta;
  residuals_->PrepareForEvaluation(jacobian != nullptr, true);
  if (!residuals_->all_valid()) return false;
  if (jacobian != nullptr) {
    *residual = residuals_->accepted().residual;
    *jacobian = residuals_->accepted().jacobian;
    return true;
  }
  residual->resize(residuals_->num_residuals());
  for (int i = 0; i < residuals_->num_blocks(); ++i) {
    auto rows = residual->segment(residuals_->first_row(i), residuals_->residual(i).size());
    rows = residuals_->residual(i);
    residuals_->Weigh(i, rows, nullptr);
  }
  return true;
}

void FitResiduals::StartFromLast() { residuals_->RestartFromLastShapes(); }

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
