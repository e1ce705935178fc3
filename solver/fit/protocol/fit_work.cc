// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/fit_work.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace drape {
namespace {

// Measured from 300 to 1,200 vertices on one core.
constexpr double kGrowth = 1.3;             // cost of a step ~ vertices^kGrowth
constexpr double kNewtonSteps = 40.0;       // of an equilibrium after the settle steps
constexpr double kEvaluationSteps = 10.0;   // of an iteration without its derivatives
constexpr double kStepsPerParameter = 0.8;  // of its derivatives
constexpr double kSettledPerStart = 1.5;    // guesses settled for a candidate of the first round
constexpr int kSurelyTaken = 8;             // iterations; of more, fits usually take half

double ExpectIterations(int most) {
  return most <= kSurelyTaken ? most : 0.5 * (most + kSurelyTaken);
}

// The time of `count` equal tasks.
double Elapsed(int count, int threads, double each) {
  return each * std::ceil(double(count) / std::max(1, threads));
}

}  // namespace

double FitWork::total() const {
  return std::accumulate(rounds.begin(), rounds.end(), initial_guesses);
}

FitWork ExpectFitWork(const FitProblem& problem, const StagedFitOptions& options) {
  const auto count = [](const auto& list) { return static_cast<int>(list.size()); };
  const int images = count(problem.observations), threads = problem.fine->threads();
  const InitialGuessOptions grid = Refined(options.grid, options.candidates_per_round.front());
  const double coarse_step = ExpectStepTime(problem.coarse->model().mesh.num_vertices(),
                                            problem.fine->model().mesh.num_vertices());
  FitWork work;
  work.initial_guesses =
      Elapsed(count(grid.stretch) * count(grid.bend) * count(grid.lifts) * images, threads,
              coarse_step * grid.steps);
  const double settle = options.residuals.rollout.steps + kNewtonSteps;
  const double iteration =
      kEvaluationSteps + kStepsPerParameter * std::stoi(ToString(options.parameters));
  for (int round = 0; round < count(options.candidates_per_round); ++round) {
    const double starts = round == 0 ? kSettledPerStart : round == 1 ? count(grid.lifts) : 0.0;
    work.rounds.push_back(
        Elapsed(options.candidates_per_round[round] * images, threads,
                starts * settle + ExpectIterations(options.iterations[round]) * iteration));
  }
  return work;
}

double ExpectStepTime(int vertices, int of_vertices) {
  return std::pow(double(vertices) / of_vertices, kGrowth);
}

double IterationShare(int iterations, double usual) {
  return 1.0 - std::exp(-2.0 * iterations / usual);
}

}  // namespace drape
