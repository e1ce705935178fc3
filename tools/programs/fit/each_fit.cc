// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/fit/each_fit.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cuda/make_backend.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"
#include "solver/job/fit_job.h"
#include "solver/studies/runner/study.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/programs/results/tables/sample_report.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Fits that share a GPU at once, and host threads beside it: more would spin while it computes.
constexpr int kFitsOnGpu = 128, kThreadsBesideGpu = 4;

struct Single {
  std::string name;
  FitData data;
};

std::vector<Single> SplitData(const FitData& data) {
  FitData one = data;
  one.images.clear();
  one.captures.clear();
  one.specimens.clear();
  std::vector<Single> list;
  for (const std::string& image : data.images) {
    list.push_back({fs::path(image).stem().string(), one});
    list.back().data.images = {image};
  }
  for (const Capture& capture : data.captures) {
    list.push_back(
        {Format("fabric_%d_sample_%d_capture_%d", capture.fabric, capture.sample, capture.capture),
         one});
    list.back().data.captures = {capture};
  }
  return list;
}

void CheckData(const FitToolOptions& options, const FitData& data,
               const std::vector<Single>& singles) {
  const auto refuse = [](const char* key) {
    throw InputError(std::string("option '") + key + "'",
                     "found one beside 'each', expected images alone: it is of one fabric");
  };
  if (!data.lab_measurements.empty()) refuse("lab_tests");
  if (!data.experiment.empty()) refuse("experiment");
  if (!options.data.specimens.empty()) refuse("specimens");
  if (options.resume)
    throw InputError("option 'resume'", "found one beside 'each', whose command itself continues");
  if (singles.empty()) throw InputError("option 'images'", "found nothing, expected at least one");
  for (const Single& single : singles)
    if (single.name == "cells")
      throw InputError(single.data.images.front(),
                       "found the name of the folder of finished fits, expected another");
}

// What the tables show of a fit; each number of a material has the ends of its 90 % interval, empty
// where there is none, and its source.
constexpr const char* kColumns[] = {"grade",
                                    "error_px",
                                    "dc_percent",
                                    "nodes",
                                    "bending_length_overall_cm",
                                    "bending_length_overall_cm_low",
                                    "bending_length_overall_cm_high",
                                    "bending_length_overall_cm_source",
                                    "bending_overall_un_m",
                                    "bending_overall_un_m_low",
                                    "bending_overall_un_m_high",
                                    "bending_overall_un_m_source",
                                    "failure"};

json MakeRow(const json& summary) {
  json row = {{"grade", summary.at("verdict").at("grade")}};
  if (const json& images = summary.at("images"); !images.empty())
    row["error_px"] = images[0].at("metrics").at("profile_rms_px");
  const auto take = [&row](const std::string& key, const json& value) {
    if (std::ranges::count(kColumns, key) > 0 && !value.is_null()) row[key] = value;
  };
  for (const auto& [name, sheet] : summary.at("laboratory").items()) {
    if (!name.starts_with("drape_") && name != "material") continue;
    for (const json& each : sheet.at("rows")) {
      const std::string key = each.at("key");
      take(key, each.at("value"));
      for (const std::string part : {"low", "high", "source"})
        take(key + "_" + part, each.at(part));
    }
  }
  return row;
}

std::optional<json> FitSingle(const FitSpec& spec, const FitData& data, const std::string& folder,
                              const RunControl& control) {
  const FolderFit fit = FitIntoFolder(spec, data, folder, MakePartProvenance, control);
  if (fit.cancelled || control.cancelled()) return {};
  if (!fit.failure.empty()) return json{{"failure", fit.failure}};
  return MakeRow(ParseJson(ReadOwnFile(folder + "/summary.json"), folder));
}

// The files that a fit reads, up to the one that it refuses.
StudyCell MakeCell(const FitSpec& spec, const Single& single, SharedBackends::Member* shared) {
  return CheckedCell(single.name, {{"image", single.name}}, [&] {
    try {
      FitData data = single.data;
      data.shared = shared;
      ReadFitInput(spec, data);
    } catch (const InputError&) {
    }
  });
}

// The rows with all columns.
std::string MakeCsv(const nlohmann::ordered_json& fits) {
  nlohmann::ordered_json lines;
  for (const auto& fit : fits) {
    nlohmann::ordered_json line = {{"image", fit.at("image")}};
    for (const char* key : kColumns) line[key] = fit.value(key, nlohmann::ordered_json());
    lines.push_back(std::move(line));
  }
  return CsvOfObjects(lines);
}

// "1.448 (1.18 … 1.78)"; of a number without an interval its source.
std::string Shown(const json& row, const std::string& key) {
  const auto number = [&](const std::string& name) {
    return row.contains(name) ? Format("%.4g", row.at(name).get<double>()) : "";
  };
  if (!row.contains(key + "_low") && !row.contains(key + "_high"))
    return row.value(key + "_source", "");
  return number(key) + " (" + number(key + "_low") + " … " + number(key + "_high") + ")";
}

std::string MakeTable(const Study& study, const StudyResult& result) {
  std::string text = Format("%-28s %7s %6s %-24s %-24s %10s  %s\n", "image", "DC [%]", "nodes",
                            "bending length c [cm]", "rigidity B [uN m]", "error [px]", "verdict");
  std::string failed;
  for (std::size_t k = 0; k < study.cells.size(); ++k) {
    const json& row = *result.results[k];
    const std::string& name = study.cells[k].name;
    if (row.contains("failure")) {
      failed += "no result: " + name + ": " +
                MakePrintableLine(row.at("failure").get<std::string>()) + "\n";
      continue;
    }
    text += Format("%-28.28s %7.1f %6.0f %-24s %-24s %10.2f  %s\n", name.c_str(),
                   row.value("dc_percent", 0.0), row.value("nodes", 0.0),
                   Shown(row, "bending_length_overall_cm").c_str(),
                   Shown(row, "bending_overall_un_m").c_str(), row.value("error_px", 0.0),
                   row.value("grade", "").c_str());
  }
  return text + failed;
}

}  // namespace

ToolOutcome FitEach(const FitToolOptions& options, FitSpec spec, const FitData& data,
                    const RunControl& control) {
  const std::vector<Single> singles = SplitData(data);
  CheckData(options, data, singles);
  const bool on_gpu = spec.backend == "cuda" || (spec.backend == "auto" && !UsableGpu().empty());
  const StudyOptions run{.out = options.out, .threads = on_gpu ? kFitsOnGpu : spec.threads};
  spec.threads = on_gpu ? std::min(spec.threads, kThreadsBesideGpu)
                        : std::max(1, spec.threads / int(singles.size()));
  SharedBackends shared;
  using Member = std::optional<SharedBackends::Member>;
  const auto join = [&](Member& member) { return on_gpu ? &member.emplace(shared) : nullptr; };
  FitToolOptions copy = options;
  Study study{.name = "each",
              .settings = OptionSettings(FitTable(copy), {"threads", "each", "data_fabric",
                                                          "samples", "captures", "face"})};
  study.cells.resize(singles.size());
  RunInThreads(int(singles.size()), run.threads, control.cancel, [&](int k) {
    Member member;
    study.cells[k] = MakeCell(spec, singles[k], join(member));
  });
  if (control.cancelled()) return {.cancelled = true};
  const auto folder = [&](std::size_t k) { return options.out + "/" + singles[k].name; };
  study.run = [&](std::size_t k, const RunControl& part) {
    Member member;
    FitData one = singles[k].data;
    one.shared = join(member);
    return FitSingle(spec, one, folder(k), part);
  };
  study.is_whole = [&](std::size_t k, const json& result) {
    return result.contains("failure") || fs::exists(folder(k) + "/summary.json");
  };
  const OutputFolder out(options.out, {"each.json", "each.csv"});
  const StudyResult result = RunStudy(study, run, control);
  if (result.cancelled) return {.cancelled = true};
  nlohmann::ordered_json summary = {{"fits", nlohmann::ordered_json::array()}};
  bool any_fitted = false;
  for (std::size_t k = 0; k < study.cells.size(); ++k) {
    any_fitted |= !result.results[k]->contains("failure");
    nlohmann::ordered_json fit = {{"image", study.cells[k].name}};
    fit.update(nlohmann::ordered_json(*result.results[k]));
    summary["fits"].push_back(std::move(fit));
  }
  WriteFileAtomically(out.Staged("each.csv"), MakeCsv(summary["fits"]));
  WriteWithProvenance(out.Staged("each.json"), std::move(summary));
  out.Publish();
  return {.text = MakeTable(study, result),
          .failure = any_fitted ? "" : "nothing could be fitted, see each.csv"};
}

}  // namespace drape
