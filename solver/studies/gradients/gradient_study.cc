// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/gradients/gradient_study.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "losses/outline/outline.h"
#include "physics/cloth/assembly/step_solver.h"
#include "physics/cloth/state.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/util/math/random.h"
#include "physics/util/text_format.h"
#include "solver/forward/random_drapes.h"

namespace drape {
namespace {

double LargestMove(const Eigen::VectorXd& dx) {
  return dx.reshaped(3, dx.size() / 3).colwise().norm().maxCoeff();
}

// NaN where it is not found.
double LowestStiffness(StepSolver& solver, const MaterialField& material,
                       const Eigen::VectorXd& x) {
  const Eigen::VectorXd lowest = LowestEigenvalues(solver, material, x, 1);
  return lowest.size() == 0 ? std::nan("") : lowest[0];
}

// Zero of 1/speed² on the line through two points.
std::optional<double> FoldEstimate(const std::vector<ContinuationPoint>& points) {
  if (points.size() < 2) return {};
  const ContinuationPoint &before = points[points.size() - 2], &last = points.back();
  const double first = std::pow(before.speed, -2), second = std::pow(last.speed, -2);
  if (!(first > second)) return {};
  return last.s + (last.s - before.s) * second / (first - second);
}

class BranchFollower {
 public:
  BranchFollower(StepSolver& solver, const MaterialParametrisation& parametrisation,
                 const Eigen::VectorXd& direction, const ContinuationOptions& options)
      : solver_(solver),
        parametrisation_(parametrisation),
        direction_(direction),
        options_(options),
        step_(options.first_step) {}

  ContinuationResult Run(const Eigen::VectorXd& x) {
    if (!Start(x)) return std::move(result_);
    while (result_.points.back().s != options_.end) {
      if (!FindTangent()) return Lost();
      while (!Advance()) {
        if (result_.status == ContinuationStatus::kCancelled) return std::move(result_);
        step_ *= 0.5;
        if (step_ < options_.min_step) return Lost();
      }
    }
    FindTangent();
    result_.status = ContinuationStatus::kReachedEnd;
    return std::move(result_);
  }

 private:
  MaterialField MaterialAt(double s) const { return parametrisation_.Material(s * direction_); }

  bool Start(const Eigen::VectorXd& x) {
    result_.lost_at = options_.end;
    const EquilibriumResult rest =
        SolveEquilibrium(solver_, MaterialAt(0.0), x, options_.corrector);
    if (rest.status == EquilibriumStatus::kCancelled)
      result_.status = ContinuationStatus::kCancelled;
    if (rest.status != EquilibriumStatus::kStable) return false;
    Accept(0.0, rest, 0.0);
    return true;
  }

  void Accept(double s, const EquilibriumResult& rest, double error) {
    result_.points.push_back({.s = s,
                              .x = rest.x,
                              .stiffness = LowestStiffness(solver_, MaterialAt(s), rest.x),
                              .prediction_error = error});
  }

  // ∂x/∂s at the last point.
  bool FindTangent() {
    ContinuationPoint& point = result_.points.back();
    const MaterialField material = MaterialAt(point.s);
    const MaterialField change = parametrisation_.Jvp(material, direction_);
    if (!EquilibriumJvpColumn(solver_, material, change, point.x, &tangent_)) return false;
    point.speed = VertexRms(tangent_);
    return true;
  }

  // One step of length step_ or to the end. False when it is rejected.
  bool Advance() {
    const ContinuationPoint& from = result_.points.back();
    const double rest = options_.end - from.s;
    const double s = std::abs(rest) <= step_ ? options_.end : from.s + std::copysign(step_, rest);
    const Eigen::VectorXd predicted = from.x + (s - from.s) * tangent_;
    const EquilibriumResult drape =
        SolveEquilibrium(solver_, MaterialAt(s), ReachSafely(solver_.model(), from.x, predicted),
                         options_.corrector);
    const double error = LargestMove(drape.x - predicted);
    if (drape.status == EquilibriumStatus::kStable && error <= options_.max_error) {
      Accept(s, drape, error);
      LengthenStep(error);
      return true;
    }
    if (drape.status == EquilibriumStatus::kCancelled)
      result_.status = ContinuationStatus::kCancelled;
    ++result_.refused;
    result_.lost_at = s;
    return false;
  }

  // The prediction's error is of second order in the step: aims at a quarter of what is allowed.
  void LengthenStep(double error) {
    const double factor = std::sqrt(0.25 * options_.max_error / std::max(error, 1e-12));
    step_ = std::min(options_.max_step, step_ * std::clamp(factor, 0.5, 2.0));
    step_ = std::max(step_, options_.min_step);
  }

  ContinuationResult Lost() {
    result_.status = ContinuationStatus::kFold;
    result_.fold_estimate = FoldEstimate(result_.points);
    return std::move(result_);
  }

  StepSolver& solver_;
  const MaterialParametrisation& parametrisation_;
  const Eigen::VectorXd direction_;
  const ContinuationOptions& options_;
  double step_;
  Eigen::VectorXd tangent_;
  ContinuationResult result_;
};

using nlohmann::json;

// The shape after the steps of `rollout` or, static, at rest near the start; empty where it fails.
Eigen::VectorXd Shape(Backend& backend, const MaterialField& material, const State& start,
                      SolveMode mode, const RolloutOptions& rollout) {
  const RolloutInput input{&material, &start};
  if (mode == SolveMode::kDynamic) {
    RolloutResult end = backend.Rollouts({&input, 1}, rollout, nullptr).front();
    return end.status == RolloutStatus::kOk ? end.end.x : Eigen::VectorXd();
  }
  EquilibriumResult rest = backend.Equilibria({&input, 1}, {}).front();
  return rest.status == EquilibriumStatus::kStable ? rest.x : Eigen::VectorXd();
}

// Its derivatives by the table entries; empty where it fails.
RowMatrix Tangents(Backend& backend, const MaterialField& material, State start, SolveMode mode,
                   const RolloutOptions& rollout) {
  const MaterialField* weight = &material;
  if (mode == SolveMode::kStatic) start.x = Shape(backend, material, start, mode, rollout);
  if (start.x.size() == 0) return {};
  const RolloutInput input{&material, &start};
  return mode == SolveMode::kStatic
             ? backend.EquilibriumTangents({&input, 1}, {&weight, 1}).front()
             : backend.Tangents({&input, 1}, {&weight, 1}, rollout).front().dx;
}

constexpr double kSteps[] = {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1};
constexpr double kHorizonStep[] = {1e-6};
constexpr double kHemRms = 5e-3;    // of the start shape at the hem [m]
constexpr double kSweepH = 0.1;     // [s]
constexpr int kSweepHorizon = 50;   // steps
constexpr double kFoldEnd = -3.0;   // of the log factor on all bend entries
constexpr double kShortest = 1e-7;  // of a step towards the fold

// A line along a random unit vector of the 39 log entries.
TableParametrisation MakeLine(const StudiedCloth& cloth) {
  std::mt19937_64 random(1);
  Eigen::MatrixXd direction(kMaterialEntries, 1);
  for (double& entry : direction.reshaped()) entry = SampleNormal(random);
  direction /= direction.norm();
  return {cloth.material, direction};
}

State Relaxed(Backend& backend, const MaterialField& material, const State& start) {
  const RolloutInput input{&material, &start};
  return backend.Rollouts({&input, 1}, {.h = kSweepH}, nullptr).front().end;
}

json ToJson(const std::vector<GradientError>& errors) {
  json list = json::array();
  for (const GradientError& error : errors)
    list.push_back({{"step", error.step}, {"size_m", error.size}, {"error", error.error}});
  return list;
}

json SweepSteps(const StudiedCloth& cloth, const State& start) {
  const std::unique_ptr<Backend> backend = MakeCpuBackend(cloth.model, 1);
  const TableParametrisation line = MakeLine(cloth);
  const RolloutOptions rollout = {.h = kSweepH, .steps = kSweepHorizon};
  const State relaxed = Relaxed(*backend, cloth.material, start);
  const auto compare = [&](const State& from, SolveMode mode) {
    return ToJson(CompareDifferences(*backend, line, from, mode, rollout, kSteps));
  };
  const json moving = {{"of", cloth.law + ", " + std::to_string(kSweepHorizon) + " steps"},
                       {"errors", compare(start, SolveMode::kDynamic)}};
  const json resting = {{"of", cloth.law + ", at rest"},
                        {"errors", compare(relaxed, SolveMode::kStatic)}};
  return json::array({moving, resting});
}

std::optional<json> CompareHorizons(const StudiedCloth& cloth, const State& start, double h,
                                    const std::vector<int>& horizons, const RunControl& control) {
  const std::unique_ptr<Backend> backend = MakeCpuBackend(cloth.model, 1);
  json series = {
      {"law", cloth.law}, {"h_s", h}, {"steps", json::array()}, {"errors", json::array()}};
  for (const int horizon : horizons) {
    if (control.cancelled()) return std::nullopt;
    const std::vector<GradientError> errors =
        CompareDifferences(*backend, MakeLine(cloth), start, SolveMode::kDynamic,
                           {.h = h, .steps = horizon}, kHorizonStep);
    if (errors.empty()) continue;
    series["steps"].push_back(horizon);
    series["errors"].push_back(ToJson(errors).front());
  }
  return series;
}

json ToJson(const ContinuationResult& path) {
  json branch = {{"status", ToString(path.status)}, {"points", json::array()}};
  for (const ContinuationPoint& point : path.points)
    branch["points"].push_back(
        {{"s", point.s}, {"speed_m", point.speed}, {"lowest_eigenvalue", point.stiffness}});
  if (path.status == ContinuationStatus::kFold && path.fold_estimate)
    branch["fold_estimate"] = *path.fold_estimate;
  return branch;
}

std::optional<json> FollowToItsEnd(const StudiedCloth& cloth, int seed, const RunControl& control) {
  const std::unique_ptr<Backend> backend = MakeCpuBackend(cloth.model, 1);
  const State relaxed = Relaxed(*backend, cloth.material, RandomStart(*cloth.model, seed, kHemRms));
  StepSolver solver(cloth.model);
  ContinuationOptions options;
  options.end = kFoldEnd;
  options.min_step = kShortest;
  options.corrector.cancel = control.cancel;
  const ContinuationResult path =
      FollowBranch(solver, TableParametrisation(cloth.material, ParameterTying::kScales),
                   Eigen::Vector2d(0.0, 1.0), relaxed.x, options);
  if (control.cancelled()) return std::nullopt;
  return ToJson(path);
}

}  // namespace

void ContinuationOptions::Check() const {
  CHECK(std::isfinite(end) && end != 0.0) << end;
  CHECK(min_step > 0.0 && min_step <= first_step && first_step <= max_step);
  CHECK_GT(max_error, 0.0);
}

ContinuationResult FollowBranch(StepSolver& solver, const MaterialParametrisation& parametrisation,
                                const Eigen::VectorXd& direction, const Eigen::VectorXd& x,
                                const ContinuationOptions& options) {
  options.Check();
  CHECK_EQ(direction.size(), parametrisation.size());
  return BranchFollower(solver, parametrisation, direction, options).Run(x);
}

std::vector<GradientError> CompareDifferences(Backend& backend, const MaterialParametrisation& line,
                                              const State& start, SolveMode integrator,
                                              const RolloutOptions& rollout,
                                              std::span<const double> steps) {
  CHECK_EQ(line.size(), 1);
  const auto at = [&](double s) { return line.Material(Eigen::VectorXd::Constant(1, s)); };
  const RowMatrix by_entries = Tangents(backend, at(0.0), start, integrator, rollout);
  std::vector<GradientError> errors;
  if (by_entries.size() == 0) return errors;
  const Eigen::VectorXd tangent = by_entries * line.LogEntriesByTheta(Eigen::VectorXd::Zero(1));
  for (const double step : steps) {
    const Eigen::VectorXd above = Shape(backend, at(step), start, integrator, rollout),
                          below = Shape(backend, at(-step), start, integrator, rollout);
    GradientError error{step, VertexRms(tangent), std::nan("")};
    if (above.size() > 0 && below.size() > 0)
      error.error = ((above - below) / (2.0 * step) - tangent).norm() / tangent.norm();
    errors.push_back(error);
  }
  return errors;
}

Study MakeGradientStudy(std::vector<StudiedCloth> cloths, const GradientStudyOptions& options) {
  using Run = std::function<std::optional<json>(const RunControl&)>;
  Study study;
  study.name = "gradients";
  study.settings = {{"start_seed", options.start_seed}};
  std::vector<Run> runs;
  const auto add = [&](const std::string& name, json input, Run run) {
    study.cells.push_back({.name = name, .input = std::move(input)});
    runs.push_back(std::move(run));
  };
  const auto all = std::make_shared<const std::vector<StudiedCloth>>(std::move(cloths));
  const auto start = [seed = options.start_seed](const StudiedCloth& cloth) {
    return RandomStart(*cloth.model, seed, kHemRms);
  };
  for (const StudiedCloth& cloth : *all)
    add("difference steps, " + cloth.law, {{"part", "differences"}, {"law", cloth.law}},
        [&cloth, start](const RunControl&) { return SweepSteps(cloth, start(cloth)); });
  for (const StudiedCloth& cloth : *all)
    for (const double h : options.time_steps)
      add("horizons, " + cloth.law + Format(", h = %g s", h),
          {{"part", "horizons"}, {"law", cloth.law}, {"h", h}, {"horizons", options.horizons}},
          [&cloth, start, h, horizons = options.horizons](const RunControl& control) {
            return CompareHorizons(cloth, start(cloth), h, horizons, control);
          });
  for (int seed = options.start_seed; seed < options.start_seed + options.fold_starts; ++seed)
    add("branch of start " + std::to_string(seed), {{"part", "branches"}, {"seed", seed}},
        [all, seed](const RunControl& control) {
          return FollowToItsEnd(all->front(), seed, control);
        });
  study.run = [all, runs](std::size_t cell, const RunControl& control) {
    return runs[cell](control);
  };
  return study;
}

}  // namespace drape
