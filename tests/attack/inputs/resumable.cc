// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/resumable.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/attack/inputs/valid_inputs.h"

namespace drape::attack {
namespace {

using nlohmann::json;

bool IsOfTime(const std::string& key) {
  static const std::set<std::string> kKeys = {"spent", "checksum", "started",    "written",
                                              "trace", "fronts",   "provenance", "sha256"};
  for (const char* part : {"second", "cpu", "wall", "peak", "memory", "time_left", "elapsed",
                           "exponent", "jacobian_cost", "cost_units", "_s_spread"})
    if (key.find(part) != std::string::npos) return true;
  return kKeys.contains(key);
}

json Strip(const json& value) {
  if (value.is_object()) {
    json kept = json::object();
    for (const auto& [key, member] : value.items())
      if (!IsOfTime(key)) kept[key] = Strip(member);
    return kept;
  }
  if (!value.is_array()) return value;
  json kept = json::array();
  for (const json& item : value) kept.push_back(Strip(item));
  return kept;
}

std::vector<std::string> Fields(const std::string& row) {
  std::vector<std::string> fields;
  std::istringstream text(row);
  for (std::string field; std::getline(text, field, ',');) fields.push_back(field);
  return fields;
}

std::string StripCsv(const std::string& text) {
  std::istringstream lines(text);
  std::vector<bool> kept;
  std::string result;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("#", 0) == 0) continue;
    const std::vector<std::string> fields = Fields(line);
    if (kept.empty())
      for (const std::string& name : fields) kept.push_back(!IsOfTime(name));
    for (std::size_t i = 0; i < fields.size() && i < kept.size(); ++i)
      if (kept[i]) result += fields[i] + ";";
    result += "\n";
  }
  return result;
}

}  // namespace

const std::vector<ResumableRun>& ResumableRuns() {
  static const std::vector<ResumableRun> kRuns = {
      {"drape_fit",
       QuickCommand("drape_fit",
                    {"--initial_bend=0.5,1,2", "--candidates_per_round=2,1", "--iterations=3,6"}),
       "--resume",
       {"checkpoint.json"}},
      {"drape_compare",
       QuickCommand("drape_compare", {"--models=homogeneous,isotropic"}),
       "",
       {"fabric_3/one_table_1.json", "fabric_3/homogeneous/seed_1/summary.json"}},
      {"drape_compare_optimisers",
       QuickCommand("drape_compare_optimisers", {"--methods=lm,adam_0.1", "--budget=8"}),
       "",
       {"cells/"}},
      {"drape_stability",
       QuickCommand("drape_stability", {"--maps=step time_step=0.1/0.2/0.5 bend=1/2/4"}),
       "",
       {"cells/"}},
      {"drape_bench",
       QuickCommand("drape_bench", {"--mesh=disc:100,disc:120", "--solve=hybrid,static"}),
       "",
       {"cells/"}}};
  return kRuns;
}

std::vector<ResumableRun> AllResumableRuns() {
  std::vector<ResumableRun> runs = ResumableRuns();
  const std::string mesh = std::string("--mesh=") + kValid + "disc.obj";
  std::vector<std::string> fits = QuickCommand(
      "drape_fit", {std::string("--data=") + kValid + "set", "--samples=1,2", "--captures=1",
                    "--posterior_iterations=1", "--simpler_models=false", "--share=0/1"});
  fits.front() = "drape_space";
  fits = WithoutOption(fits, "--images");
  const auto with_mesh = [&](const std::string& program) {
    std::vector<std::string> command = WithoutOption(QuickCommand(program), "--mesh");
    command.push_back(mesh);
    return command;
  };
  runs.push_back({"drape_speed", with_mesh("drape_speed"), "", {"cells/"}});
  runs.push_back({"drape_gradients", with_mesh("drape_gradients"), "", {"cells/"}});
  runs.push_back({"drape_garment", QuickCommand("drape_garment"), "--resume", {"checkpoint.json"}});
  runs.push_back({"drape_space", fits, "", {"fabrics/cells/"}});
  return runs;
}

std::vector<std::string> ResumeCommand(const ResumableRun& run) {
  std::vector<std::string> command = run.command;
  if (!run.resume.empty()) command.push_back(run.resume);
  return command;
}

std::string WithoutTimes(const std::string& file, const std::string& text) {
  const std::string kind = std::filesystem::path(file).extension();
  if (kind == ".json") {
    const json parsed = json::parse(text, nullptr, false, true);
    return parsed.is_discarded() ? text : Strip(parsed).dump();
  }
  return kind == ".csv" ? StripCsv(text) : text;
}

bool IsReproducible(const std::string& file) {
  const std::filesystem::path path(file);
  const std::string name = path.filename(), kind = path.extension();
  if (kind == ".log" || kind == ".svg" || kind == ".md" || kind == ".html") return false;
  return name != "checkpoint.json" && name != "traces.csv" && name != "comparison.csv" &&
         name != "accuracy.json" &&
         (kind != ".png" || name.rfind("fit_", 0) == 0 || name.rfind("drape_", 0) == 0);
}

}  // namespace drape::attack
