// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/study_program.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "tools/cli/option_text.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

std::string LastLine(const std::string& text) {
  const std::size_t end = text.find_last_not_of('\n');
  if (end == std::string::npos) return "without a message";
  const std::size_t begin = text.rfind('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
}

}  // namespace

std::vector<std::string> StudyScriptCommand(const std::string& name) {
  return ScriptCommand("studies/" + name + ".py", "tools/programs/studies/scripts/" + name + ".py");
}

std::vector<Option> StudyOptionList(StudyOptions& options) {
  return Concatenate(
      std::vector<Option>{OutOption(options.out)},
      OfOneRun({
          PlainOption("list", &options.list,
                      "print the names of the independent runs (cells) in their order, and end"),
          PlainOption(
              "share", &options.share,
              "i/n: run only the cells k with k mod n = i and write no tables, beside "
              "processes with other shares of the same --out; without it, finished cells are "
              "kept and the missing ones run"),
      }));
}

std::vector<Option> FitOptionsOfCells(FitToolOptions& fit, const std::set<std::string>& except) {
  const std::set<std::string> of_each_fit = {
      "images",       "each",     "lab_tests", "experiment", "fabric",      "density",
      "ground_truth", "model",    "out",       "resume",     "data",        "data_fabric",
      "samples",      "captures", "face",      "camera",     "data_source", "specimens",
      "accuracy",     "solve",    "support",   "specimen",   "table_form",  "accuracy_table"};
  std::vector<Option> options = FitTable(fit).options;
  std::erase_if(options, [&](const Option& option) {
    return of_each_fit.contains(option.key) || except.contains(option.key);
  });
  return options;
}

ordered_json SummariseCells(const Study& study, const StudyResult& result) {
  ordered_json json = {{"study", study.name},
                       {"outcome", result.cancelled ? "cancelled" : "done"},
                       {"settings", study.settings}};
  json["cells"] = ordered_json::array();
  for (std::size_t k = 0; k < study.cells.size(); ++k) {
    ordered_json cell = {{"name", study.cells[k].name}, {"input", study.cells[k].input}};
    cell["input"].update(study.cells[k].names);
    cell["result"] = result.results[k] ? ordered_json(*result.results[k]) : ordered_json();
    json["cells"].push_back(std::move(cell));
  }
  return json;
}

ToolOutcome RunStudyProgram(const Study& study, const StudyOptions& options,
                            const RunControl& control, const SummariseStudy& summarise) {
  CheckShare(options);
  if (options.list) return {.text = RunStudy(study, options, control).text};
  const bool is_share = !options.share.empty();
  const std::string file = study.name + ".json";
  const OutputFolder out(options.out, {file, "report.md", "runs.csv"},
                         is_share ? OutputFolder::Use::kShared : OutputFolder::Use::kAlone);
  constexpr int kLevels = 4;  // of the folders of cells and their fits
  if (!is_share) RemoveTemporaries(options.out, kLevels);
  const StudyResult result = RunStudy(study, options, control);
  if (is_share) return {.text = result.text, .cancelled = result.cancelled};
  WriteWithProvenance(out.Staged(file),
                      summarise ? summarise(result) : SummariseCells(study, result));
  ToolOutcome outcome{.cancelled = result.cancelled};
  if (!result.cancelled) outcome.text = RunStudyScript(study.name, out.Staged(""));
  out.Publish();
  return outcome;
}

std::string RunStudyScript(const std::string& name, const std::string& folder) {
  const std::string missing = "no tables and pictures: ";
  std::vector<std::string> command = StudyScriptCommand(name);
  if (command.back().empty()) return missing + name + ".py is not installed\n";
  command.push_back(folder);
  try {
    const ProgramResult run = RunProgram(command);
    return run.output + (run.status == 0 ? "" : missing + LastLine(run.errors) + "\n");
  } catch (const InputError& error) {
    return missing + error.what() + "\n";
  }
}

}  // namespace drape
