// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"
#include "solver/studies/comparison/compared_model.h"
#include "solver/studies/comparison/comparison_table.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

std::string FabricName(int fabric) { return fabric == 0 ? "all" : std::to_string(fabric); }

ordered_json RowJson(const ComparisonRow& row) {
  ordered_json numbers = ordered_json::object();
  for (const ComparedNumber& number : kComparedNumbers) {
    const auto found = row.numbers.find(number.key);
    if (found == row.numbers.end()) continue;
    const auto& [spread, seeds] = found->second;
    numbers[number.key] = {{"mean", spread.mean}, {"sd", spread.sd}, {"seeds", seeds}};
  }
  return {{"model", row.model},
          {"runs", row.experiments},
          {"failed", row.failed},
          {"numbers", numbers}};
}

ordered_json ChoiceJson(const ModelChoice& choice) {
  ordered_json differences = ordered_json::array();
  for (const ScoreDifference& difference : choice.differences)
    differences.push_back({{"model", difference.model},
                           {"mean_score", difference.mean_score},
                           {"difference_from_best", difference.mean},
                           {"standard_error", difference.standard_error},
                           {"within_one_standard_error", difference.within()}});
  return {{"score", "feature_energy"},
          {"captures", choice.captures},
          {"best", choice.best},
          {"chosen", choice.chosen},
          {"models", differences}};
}

ordered_json ComparisonJson(const Comparison& comparison, const ordered_json& provenance) {
  ordered_json json = {{"format", "drapefit-comparison"}, {"version", 1}};
  json["tables"] = json["posteriors"] = ordered_json::array();
  for (const ComparisonTable& table : comparison.tables) {
    ordered_json rows = ordered_json::array();
    for (const ComparisonRow& row : table.rows) rows.push_back(RowJson(row));
    json["tables"].push_back({{"fabric", FabricName(table.fabric)},
                              {"rows", rows},
                              {"choice", ChoiceJson(table.choice)}});
  }
  for (const PosteriorStiffnessRow& row : comparison.beliefs)
    json["posteriors"].push_back(
        {{"fabric", row.fabric},
         {"model", row.model},
         {"stretch_n_per_m", {row.belief.stretch, row.belief.stretch_deviation}},
         {"bend_n_m", {row.belief.bend, row.belief.bend_deviation}}});
  json["failures"] = comparison.failures;
  json["provenance"] = provenance;
  return json;
}

std::string ComparisonCsv(const Comparison& comparison) {
  std::string csv = "fabric,model,number,mean,sd,seeds,runs,failed\n";
  for (const ComparisonTable& table : comparison.tables)
    for (const ComparisonRow& row : table.rows)
      for (const ComparedNumber& number : kComparedNumbers) {
        const auto found = row.numbers.find(number.key);
        if (found == row.numbers.end()) continue;
        const auto& [spread, seeds] = found->second;
        csv += FabricName(table.fabric) + "," + row.model + "," + number.key +
               Format(",%.9g,%.9g,%d,%d,%d\n", spread.mean, spread.sd, seeds, row.experiments,
                      row.failed);
      }
  return csv;
}

// "0.0123 ± 0.0004"; without the spread where there is one seed.
std::string Entry(const ComparisonRow& row, const ComparedNumber& number) {
  const auto found = row.numbers.find(number.key);
  if (found == row.numbers.end()) return "–";
  const auto& [spread, seeds] = found->second;
  const std::string mean = Format("%.4g", spread.mean / number.unit);
  return seeds < 2 ? mean : mean + Format(" ± %.2g", spread.sd / number.unit);
}

std::string TableText(const ComparisonTable& table) {
  std::string head = "| |", rule = "|---|";
  for (const ComparisonRow& row : table.rows) {
    head += Format(" %s", row.model.c_str());
    if (row.failed > 0) head += Format(" (%d of %d failed)", row.failed, row.experiments);
    head += " |";
    rule += "---|";
  }
  std::string text = head + "\n" + rule + "\n";
  for (const ComparedNumber& number : kComparedNumbers) {
    std::string line = std::string("| ") + number.label + " |";
    for (const ComparisonRow& row : table.rows)
      line.append(" ").append(Entry(row, number)).append(" |");
    text += line + "\n";
  }
  return text;
}

std::string ChoiceText(const ModelChoice& choice) {
  if (choice.chosen.empty()) return "No model has a score in all of its runs.\n";
  std::string text =
      "**" + choice.chosen + "** is the simplest model within one standard error of the best, " +
      choice.best + Format(" (energy score of features, %d captures held out):", choice.captures);
  for (const ScoreDifference& d : choice.differences)
    text += Format(" %s %.3f", d.model.c_str(), d.mean_score) +
            (d.model == choice.best
                 ? ";"
                 : Format(" (+%.3f, standard error %.3f);", d.mean, d.standard_error));
  text.back() = '.';
  return text + "\n";
}

std::string BeliefsText(const std::vector<PosteriorStiffnessRow>& beliefs) {
  if (beliefs.empty()) return "";
  std::string text =
      "\n## Stiffness by the posteriors\n\n"
      "| fabric | model | stretching [N/m] | sd | bending [N m] | sd |\n"
      "|---|---|---|---|---|---|\n";
  for (const PosteriorStiffnessRow& row : beliefs)
    text += Format("| %d | %s | %.4g | %.2g | %.3g | %.2g |\n", row.fabric, row.model.c_str(),
                   row.belief.stretch, row.belief.stretch_deviation, row.belief.bend,
                   row.belief.bend_deviation);
  return text;
}

// The models of a comparison and what they say of a cloth.
std::string ModelsText(const Comparison& comparison) {
  std::string text = "Models from the simplest on:";
  for (const ComparedModel& model : ComparedModels())
    for (const ComparisonRow& row : comparison.tables[0].rows)
      if (row.model == model.name) text += " " + model.name + " (" + model.meaning + "),";
  text.back() = '.';
  return text + "\n";
}

}  // namespace

std::string ComparisonText(const Comparison& comparison) {
  std::string text =
      "# Comparison of models\n\n"
      "Mean ± standard deviation over the seeds; a seed draws the split and the drapes. Of all "
      "fabrics: of the mean over them.\n" +
      ModelsText(comparison) +
      "The "
      "standard error is that of the mean difference from the best model over held-out\ncaptures, "
      "taken as independent: those of one sample repeat each other, so it is a lower bound.\nThere "
      "a capture that is "
      "held out under several seeds counts once, and only models are judged all of whose "
      "experiments "
      "have "
      "a score.\n";
  for (const ComparisonTable& table : comparison.tables)
    text += "\n## " + (table.fabric == 0 ? "All fabrics" : "Fabric " + FabricName(table.fabric)) +
            "\n\n" + TableText(table) + "\n" + ChoiceText(table.choice);
  text += BeliefsText(comparison.beliefs);
  for (const std::string& failure : comparison.failures)
    text += "\nWithout a score: " + failure + "\n";
  return text;
}

void WriteComparison(const std::string& folder, const Comparison& comparison,
                     const ordered_json& provenance) {
  WriteFileAtomically(folder + "/comparison.csv", ComparisonCsv(comparison));
  WriteFileAtomically(folder + "/comparison.md", ComparisonText(comparison));
  WriteFileAtomically(folder + "/comparison.json",
                      ComparisonJson(comparison, provenance).dump(1) + "\n");
}

}  // namespace drape
