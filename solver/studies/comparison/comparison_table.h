// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/metrics/distribution_metrics.h"
#include "solver/studies/comparison/experiment.h"
#include "solver/studies/comparison/model_choice.h"

namespace drape {

// The experiments of a comparison, summed up.

// The trivial predictors, beside the models.
inline constexpr char kOtherSamples[] = "other samples", kNormal[] = "normal", kCircle[] = "circle";

// An experiment, or what a trivial predictor gives on the same split.
struct ComparedExperiment {
  int fabric = 0;
  std::string model;
  int seed = 0;
  ExperimentResult result;
};

struct SeedSpread {
  Spread spread;  // over the seeds
  int seeds = 0;  // that have the number, for all fabrics of the table
};

// A line of a table, by key of kComparedNumbers.
struct ComparisonRow {
  std::string model;
  int experiments = 0, failed = 0;
  std::map<std::string, SeedSpread> numbers;
};

struct ComparisonTable {
  int fabric = 0;  // 0: all; there a seed's number is the mean over the fabrics
  std::vector<ComparisonRow> rows;
  // Among the models all of whose experiments have a score. A capture that is held out under
  // several seeds counts once, with its mean score.
  ModelChoice choice;
};

// As [Gong 2024, table 3]: average stiffness of a fabric and its standard deviation by a posterior,
// means over the seeds.
struct PosteriorStiffnessRow {
  int fabric = 0;
  std::string model;
  ExperimentStiffness belief;
};

struct Comparison {
  std::vector<ComparisonTable> tables;  // of each fabric, then of all where there are several
  std::vector<PosteriorStiffnessRow> beliefs;
  std::vector<std::string> failures;  // "fabric 1, heter, seed 2: …"
};

// models: from the simplest on; others: trivial predictors, which have lines but are not chosen.
Comparison SumUp(const std::vector<ComparedExperiment>& experiments,
                 const std::vector<std::string>& models, const std::vector<std::string>& others);

// Writes comparison.csv (a line for each table, model and number), comparison.json and
// comparison.md to `folder`, each atomically. `provenance`: where the results are from, for the
// JSON. Throws InputError.
void WriteComparison(const std::string& folder, const Comparison& comparison,
                     const nlohmann::ordered_json& provenance);

// What a scene needs: one line per model with its errors on held-out and on own drapes and the
// rollouts of its fit, which are the same on each machine; the chosen model in red; bars are
// standard errors of the difference from the best; a ring for a model that is not compared, as an
// experiment of it has no score. Writes path.png and path.svg by gnuplot; nothing where no model
// has a score. Throws InputError without gnuplot.
void RenderModelChart(const std::string& path, const ComparisonTable& table);

// Held-out error against the free numbers of each model and against the time of its fit, with the
// error of the training samples' own drapes and that of a circle as lines. Files, and what is
// thrown, as RenderModelChart.
void RenderHeldOutChart(const std::string& path, const ComparisonTable& table);

// The tables for a person, in Markdown.
std::string ComparisonText(const Comparison& comparison);

}  // namespace drape
