// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/optimiser.h"

#include <ceres/ceres.h>
#include <fcntl.h>
#include <glog/logging.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <ctime>
#include <functional>
#include <nlopt.hpp>
#include <sstream>
#include <system_error>

#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/fit/fit.h"

namespace drape {
namespace {

// Methods that need a box search |θ_i| ≤ kBound.
constexpr double kBound = 3.0;

double ThreadSeconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// ½‖r‖² for methods without derivatives. A function that starts from the last point with
// derivatives (DrapeFunction) loses its way when that point stays behind: once the cost is lower by
// a tenth, derivatives are requested and counted.
class MeteredCost {
 public:
  // The function outlives the object.
  explicit MeteredCost(BudgetedFunction& function) : function_(function) {}

  // Nothing where the function cannot be evaluated or the budget is spent.
  std::optional<double> Evaluate(const Eigen::VectorXd& theta) {
    constexpr double kGain = 0.9;
    Eigen::VectorXd residual;
    if (!function_.Evaluate(theta, &residual, nullptr)) return std::nullopt;
    const double cost = 0.5 * residual.squaredNorm();
    if (!(cost < kGain * followed_)) return cost;
    followed_ = cost;
    RowMatrix jacobian;
    function_.Evaluate(theta, &residual, &jacobian);
    return cost;
  }

 private:
  BudgetedFunction& function_;
  double followed_ = std::numeric_limits<double>::infinity();
};

Eigen::VectorXd CopyVector(const double* values, int size) {
  return Eigen::Map<const Eigen::VectorXd>(values, size);
}

class BudgetedCost final : public ceres::CostFunction {
 public:
  explicit BudgetedCost(BudgetedFunction& function) : function_(function) {
    set_num_residuals(function.num_residuals());
    mutable_parameter_block_sizes()->push_back(function.size());
  }
  bool Evaluate(double const* const* theta, double* residuals, double** jacobians) const override {
    const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    Eigen::VectorXd residual;
    RowMatrix jacobian;
    if (!function_.Evaluate(CopyVector(theta[0], function_.size()), &residual,
                            with_jacobian ? &jacobian : nullptr))
      return false;
    std::copy_n(residual.data(), residual.size(), residuals);
    if (with_jacobian) std::copy_n(jacobian.data(), jacobian.size(), jacobians[0]);
    return true;
  }

 private:
  BudgetedFunction& function_;
};

class BudgetedGradient final : public ceres::FirstOrderFunction {
 public:
  explicit BudgetedGradient(BudgetedFunction& function) : function_(function) {}
  int NumParameters() const override { return function_.size(); }
  bool Evaluate(const double* theta, double* cost, double* gradient) const override {
    Eigen::VectorXd residual;
    RowMatrix jacobian;
    if (!function_.Evaluate(CopyVector(theta, function_.size()), &residual,
                            gradient != nullptr ? &jacobian : nullptr))
      return false;
    *cost = 0.5 * residual.squaredNorm();
    if (gradient != nullptr)
      Eigen::Map<Eigen::VectorXd>(gradient, function_.size()) = jacobian.transpose() * residual;
    return true;
  }

 private:
  BudgetedFunction& function_;
};

class StopWhenSpent final : public ceres::IterationCallback {
 public:
  explicit StopWhenSpent(const BudgetedFunction& function) : function_(function) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return function_.exhausted() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const BudgetedFunction& function_;
};

constexpr int kMostIterations = 1000000;

// The options of the last round of a fit.
ceres::Solver::Options MakeCeresOptions(const BudgetedFunction& function) {
  TrustRegionOptions options;
  options.max_iterations = kMostIterations;
  options.cost_tolerance = kLastCostTolerance;
  return CeresOptions(function.size(), options);
}

std::string Solve(BudgetedFunction& function, ceres::Solver::Options options,
                  Eigen::VectorXd theta) {
  StopWhenSpent stop(function);
  options.callbacks.push_back(&stop);
  ceres::Problem problem;
  problem.AddResidualBlock(new BudgetedCost(function), nullptr, theta.data());
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.message;
}

// Each method below runs until it converges or the meter refuses, and says in a sentence why it
// ended.

// invalid_steps: trials in a row that cannot be evaluated before it stops.
std::string RunLevenbergMarquardt(BudgetedFunction& function, int invalid_steps) {
  ceres::Solver::Options options = MakeCeresOptions(function);
  options.max_num_consecutive_invalid_steps = invalid_steps;
  return Solve(function, options, Eigen::VectorXd::Zero(function.size()));
}

// Runs at most kRefiningRounds of the same method from the best point so far.
std::string RefineByLevenbergMarquardt(BudgetedFunction& function) {
  const Eigen::VectorXd best = function.run().theta;
  if (best.size() == 0) return "the start cannot be evaluated";
  function.RefineFromBest();
  ceres::Solver::Options options = MakeCeresOptions(function);
  options.max_num_iterations = kRefiningRounds;
  return Solve(function, options, best);
}

// subspace: in the plane of gradient and Gauss–Newton step instead of along the dogleg.
std::string RunDogleg(BudgetedFunction& function, bool subspace) {
  Eigen::VectorXd residual;
  if (!function.Evaluate(Eigen::VectorXd::Zero(function.size()), &residual, nullptr))
    return "the start cannot be evaluated";
  ceres::Solver::Options options = MakeCeresOptions(function);
  options.trust_region_strategy_type = ceres::DOGLEG;
  options.dogleg_type = subspace ? ceres::SUBSPACE_DOGLEG : ceres::TRADITIONAL_DOGLEG;
  // The radius is in units of the columns' norms: it has the size of the predicted change of r.
  options.initial_trust_region_radius = residual.norm();
  return Solve(function, options, Eigen::VectorXd::Zero(function.size()));
}

std::string RunLbfgs(BudgetedFunction& function) {
  StopWhenSpent stop(function);
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::LBFGS;
  options.max_num_iterations = kMostIterations;
  options.function_tolerance = kLastCostTolerance;
  options.gradient_tolerance = options.parameter_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  options.callbacks.push_back(&stop);
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(function.size());
  ceres::GradientProblem problem(new BudgetedGradient(function));
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, problem, theta.data(), &summary);
  return summary.message;
}

constexpr std::pair<const char*, nlopt::algorithm> kNLopt[] = {{"bobyqa", nlopt::LN_BOBYQA},
                                                               {"sbplx", nlopt::LN_SBPLX},
                                                               {"crs", nlopt::GN_CRS2_LM},
                                                               {"direct", nlopt::GN_DIRECT_L}};

std::string RunNLopt(BudgetedFunction& function, nlopt::algorithm algorithm, int seed) {
  constexpr double kFirstStep = 0.5;  // in log units
  constexpr double kFailed = 10.0;    // cost of a failure by that of the start
  using Theta = std::vector<double>;
  using Cost = std::function<double(const Theta&)>;
  MeteredCost metered(function);
  // A finite number wherever the start has one.
  Cost cost = [&](const Theta& theta) {
    if (function.exhausted()) throw nlopt::forced_stop();
    const std::optional<double> found =
        metered.Evaluate(CopyVector(theta.data(), static_cast<int>(theta.size())));
    if (found) return *found;
    const std::vector<TracePoint>& trace = function.run().trace;
    return trace.empty() ? HUGE_VAL : kFailed * trace.front().cost;
  };
  const unsigned size = static_cast<unsigned>(function.size());
  Theta theta(size, 0.0);
  nlopt::srand(static_cast<unsigned long>(seed));
  nlopt::opt optimiser(algorithm, size);
  optimiser.set_min_objective(
      [](const Theta& at, Theta&, void* of) { return (*static_cast<Cost*>(of))(at); }, &cost);
  optimiser.set_lower_bounds(-kBound);
  optimiser.set_upper_bounds(kBound);
  optimiser.set_initial_step(kFirstStep);
  optimiser.set_xtol_abs(1e-6);
  double least = 0.0;
  try {
    cost(theta);  // not all of them begin with the start
    optimiser.optimize(theta, least);
  } catch (const nlopt::forced_stop&) {
    return "budget spent";
  } catch (const std::runtime_error& error) {  // also of nlopt::roundoff_limited
    return error.what();
  }
  return "converged";
}

// A process whose standard input and output are one socket: writing to a dead one gives an error
// instead of a signal.
class SearchProcess {
 public:
  explicit SearchProcess(const std::vector<std::string>& command) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      throw InputError(command.front(), "cannot start: " + std::system_category().message(errno));
    socket_ = ends[0];
    const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    pid_ = StartProgram(command, ends[1], ends[1], null);
    close(null);
    close(ends[1]);
  }
  ~SearchProcess() {
    kill(pid_, SIGKILL);
    close(socket_);
    if (!ended_) waitpid(pid_, nullptr, 0);
  }
  SearchProcess(const SearchProcess&) = delete;
  SearchProcess& operator=(const SearchProcess&) = delete;

  // Without its end; empty at the end of the output.
  std::string ReadLine() {
    std::string line;
    for (char c = 0; recv(socket_, &c, 1, 0) == 1 && c != '\n';) line += c;
    return line;
  }
  void Write(const std::string& line) const {
    [[maybe_unused]] const auto sent = send(socket_, line.data(), line.size(), MSG_NOSIGNAL);
  }
  // Waits for its end. False unless it ended with 0.
  bool Succeeds() {
    int status = 0;
    ended_ = waitpid(pid_, &status, 0) == pid_;
    return ended_ && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

 private:
  pid_t pid_ = 0;
  int socket_ = -1;
  bool ended_ = false;
};

[[noreturn]] void FailSearch(const std::string& name, const OptimiserOptions& options) {
  throw InputError("methods", "'" + name + "' ended early, expected numpy and scipy in " +
                                  options.search_command.front());
}

bool IsOfNLopt(const std::string& name) {
  return std::ranges::any_of(kNLopt, [&](const auto& known) { return name == known.first; });
}

// Runs the script in a process of its own, which proposes points and receives their costs.
std::string RunSearch(BudgetedFunction& function, const std::string& name,
                      const OptimiserOptions& options) {
  if (function.exhausted()) return "budget spent";
  MeteredCost cost(function);
  std::vector<std::string> command = options.search_command;
  command.insert(command.end(), {name, std::to_string(function.size()), Format("%.17g", kBound),
                                 std::to_string(options.seed)});
  SearchProcess search(command);
  Eigen::VectorXd theta(function.size());
  while (!function.exhausted()) {
    std::istringstream line(search.ReadLine());
    double seconds = 0.0;
    line >> seconds;
    for (double& value : theta) line >> value;
    if (!line) {
      if (search.Succeeds()) return "converged";
      FailSearch(name, options);
    }
    function.AddSeconds(seconds);
    const std::optional<double> found = cost.Evaluate(theta);
    search.Write(found ? Format("%.17g\n", *found) : "none\n");
  }
  return "budget spent";
}

std::vector<OptimiserMethod> AllMethods() {
  std::vector<OptimiserMethod> methods;
  for (const char* name : {"lm", "lm_patient", "dogleg", "subspace_dogleg", "lbfgs",
                           "adam_published", "adam_0.03", "adam_0.1"})
    methods.push_back({name, true});
  const std::size_t first = methods.size();
  for (const auto& [name, algorithm] : kNLopt)
    methods.push_back({name, false, algorithm == nlopt::GN_CRS2_LM});
  for (const char* name : {"cmaes", "bo", "rembo_2", "rembo_4", "rembo_8", "rembo_ucb_4", "hesbo_2",
                           "hesbo_4", "hesbo_8"})
    methods.push_back({name, false, true, false});
  const std::size_t end = methods.size();
  for (std::size_t i = first; i < end; ++i)
    methods.push_back({methods[i].name + "_lm", false, methods[i].random, false, methods[i].name});
  return methods;
}

std::string RunWithoutDerivatives(const std::string& name, BudgetedFunction& function,
                                  const OptimiserOptions& options) {
  for (const auto& [known, algorithm] : kNLopt)
    if (name == known) return RunNLopt(function, algorithm, options.seed);
  return RunSearch(function, name, options);
}

// [Kingma 2015], with its β. rates: [P]. Adam has no rule for a point that cannot be evaluated: it
// goes back to the best one, with half the rates and its moments forgotten.
std::string RunAdam(BudgetedFunction& function, Eigen::VectorXd rates) {
  constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-8;
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(function.size()), residual, mean, square;
  RowMatrix jacobian;
  for (int step = 0; !function.exhausted();) {
    if (!function.Evaluate(theta, &residual, &jacobian)) {
      if (function.run().theta.size() == 0) return "the start cannot be evaluated";
      const bool best_has_none = theta == function.run().theta;  // no derivatives at the best point
      if (best_has_none) return "no derivatives at the best point";
      theta = function.run().theta;
      rates *= 0.5;
      step = 0;
      continue;
    }
    if (step == 0) mean = square = Eigen::VectorXd::Zero(function.size());
    ++step;
    const Eigen::VectorXd gradient = jacobian.transpose() * residual;
    mean = kBeta1 * mean + (1.0 - kBeta1) * gradient;
    square = kBeta2 * square + (1.0 - kBeta2) * gradient.cwiseAbs2();
    const Eigen::ArrayXd unbiased = mean.array() / (1.0 - std::pow(kBeta1, step));
    const Eigen::ArrayXd size = (square.array() / (1.0 - std::pow(kBeta2, step))).sqrt();
    theta.array() -= rates.array() * unbiased / (size + kEpsilon);
  }
  return "budget spent";
}

std::string Run(const OptimiserMethod& method, BudgetedFunction& function,
                const OptimiserOptions& options) {
  const std::string& name = method.name;
  if (!method.search.empty()) {
    const double kept = (kRefiningRounds + 1) * (1.0 + options.jacobian_cost_units);
    function.LimitTo(std::max(1.0, options.budget - kept));
    RunWithoutDerivatives(method.search, function, options);
    function.LimitTo(options.budget);
    return RefineByLevenbergMarquardt(function);
  }
  if (!method.derivatives) return RunWithoutDerivatives(name, function, options);
  constexpr int kInvalidSteps = 5, kPatientInvalidSteps = 50;
  const auto rates = [&](double rate) { return Eigen::VectorXd::Constant(function.size(), rate); };
  if (name == "lm") return RunLevenbergMarquardt(function, kInvalidSteps);
  if (name == "lm_patient") return RunLevenbergMarquardt(function, kPatientInvalidSteps);
  if (name == "dogleg") return RunDogleg(function, false);
  if (name == "subspace_dogleg") return RunDogleg(function, true);
  if (name == "lbfgs") return RunLbfgs(function);
  if (name == "adam_0.03") return RunAdam(function, rates(0.03));
  if (name == "adam_0.1") return RunAdam(function, rates(0.1));
  CHECK_EQ(name, "adam_published");
  CHECK_EQ(options.published_rates.size(), function.size());
  return RunAdam(function, options.published_rates);
}

}  // namespace

BudgetedFunction::BudgetedFunction(ResidualFunction& function, const OptimiserOptions& options)
    : function_(function), options_(options), start_(ThreadSeconds()), limit_(options.budget) {
  CHECK_GT(options.budget, 0.0);
  CHECK_GE(options.jacobian_cost_units, 0.0);
}

bool BudgetedFunction::exhausted() const {
  constexpr double kMostCalls = 10.0;
  return run_.spent >= std::min(limit_, options_.budget) ||
         run_.evaluations >= kMostCalls * options_.budget ||
         (options_.cancel != nullptr && options_.cancel->load());
}

bool BudgetedFunction::Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                                RowMatrix* jacobian) {
  const bool here = theta_.size() == theta.size() && theta_ == theta;
  if (!here && !EvaluateResidual(theta)) return false;
  if (!valid_) return false;
  if (jacobian != nullptr && jacobian_.size() == 0 && !EvaluateJacobian()) return false;
  *residual = residual_;
  if (jacobian != nullptr) *jacobian = jacobian_;
  return true;
}

void BudgetedFunction::RefineFromBest() {
  theta_.resize(0);
  function_.RefineFromBest();
}

bool BudgetedFunction::Call(RowMatrix* jacobian) {
  const double begin = ThreadSeconds();
  const bool found = function_.Evaluate(theta_, &residual_, jacobian);
  const double end = ThreadSeconds();
  run_.function_seconds += end - begin;
  if (jacobian != nullptr) run_.jacobian_seconds += end - begin;
  run_.seconds = end - start_;
  return found;
}

bool BudgetedFunction::EvaluateResidual(const Eigen::VectorXd& theta) {
  if (exhausted()) return false;
  theta_ = theta;
  jacobian_.resize(0, 0);
  valid_ = Call(nullptr);
  run_.spent += function_.cost_units();
  ++run_.evaluations;
  if (valid_) {
    Record(0.5 * residual_.squaredNorm());
  } else {
    ++run_.failed;
  }
  return valid_;
}

bool BudgetedFunction::EvaluateJacobian() {
  if (exhausted()) return false;
  const bool found = Call(&jacobian_);
  if (!found) {
    jacobian_.resize(0, 0);
    ++run_.failed;
  }
  run_.spent += options_.jacobian_cost_units;
  ++run_.jacobians;
  return found;
}

void BudgetedFunction::Record(double cost) {
  if (!(cost < run_.cost)) return;
  run_.cost = cost;
  run_.theta = theta_;
  run_.trace.push_back({run_.spent, run_.seconds, cost});
}

const std::vector<OptimiserMethod>& OptimiserMethods() {
  static const std::vector<OptimiserMethod> methods = AllMethods();
  return methods;
}

const OptimiserMethod& FindOptimiser(const std::string& name) {
  std::string names;
  for (const OptimiserMethod& method : OptimiserMethods()) {
    if (method.name == name) return method;
    names += (names.empty() ? "" : ", ") + method.name;
  }
  throw InputError("methods", "unknown name '" + name + "', expected some of " + names);
}

void CheckSearchScript(const std::vector<std::string>& names, const OptimiserOptions& options) {
  for (const std::string& name : names) {
    const OptimiserMethod& method = FindOptimiser(name);
    const std::string searched = method.search.empty() ? name : method.search;
    if (method.derivatives || IsOfNLopt(searched)) continue;
    std::vector<std::string> command = options.search_command;
    command.insert(command.end(), {searched, "2", "1", "1"});
    if (RunProgram(command).status != 0) FailSearch(name, options);  // its first proposal, alone
    return;
  }
}

OptimiserRun RunOptimiser(const std::string& name, ResidualFunction& function,
                          const OptimiserOptions& options) {
  const OptimiserMethod& method = FindOptimiser(name);
  BudgetedFunction metered(function, options);
  const std::string end = Run(method, metered, options);
  OptimiserRun run = metered.run();
  run.end = metered.exhausted() ? "budget spent" : end;
  run.cancelled = options.cancel != nullptr && options.cancel->load();
  return run;
}

}  // namespace drape
