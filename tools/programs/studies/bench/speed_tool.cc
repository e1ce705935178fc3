// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/bench/speed_tool.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/backend_option.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

std::vector<Option> ClothAndSteps(SpeedToolOptions& options) {
  SpeedJob& job = options.job;
  return {
      MeshOption("mesh", &job.meshes,
                 "cloths: OBJ files, such as the published discs, or disc:N; none: built-in discs "
                 "of the published numbers of vertices"),
      FabricOption(&job.material),
      LawOption(job.law),
      TimeStepOption(job.h),
      {.key = "steps",
       .value = &job.steps,
       .doc = "number of time steps of a rollout",
       .least = 1,
       .most = 1000000},
  };
}

std::vector<Option> MeasurementOptions(SpeedToolOptions& options) {
  SpeedJob& job = options.job;
  Option threads = ThreadsOption(job.threads);
  threads.doc = "number of threads; 0: one for each core. One rollout runs on one";
  return {
      BackendOption(job.backend),
      threads,
      {.key = "batch",
       .value = &job.batches,
       .doc = "numbers of equal rollouts computed together; times are for one of them",
       .least = 1,
       .most = 65536},
      {.key = "repeats",
       .value = &job.repeats,
       .doc = "number of repeats of each rollout",
       .least = 1,
       .most = 1000},
      {.key = "run_seconds",
       .value = &job.seconds,
       .doc = "time after which a rollout is not repeated again",
       .unit = "s",
       .least = 0},
      {.key = "published",
       .value = &options.published,
       .doc = "table of figures of others, with their sources, to print beside",
       .is_path = true},
      OutOption(options.out),
  };
}

// The job with what follows from the options.
SpeedJob MakeJob(const SpeedToolOptions& options, const PublishedSpeeds& published) {
  SpeedJob job = options.job;
  job.threads = CountThreads(job.threads);
  if (job.batches.empty()) throw InputError("option 'batch'", "is empty, expected some");
  if (!job.meshes.empty()) return job;
  for (const int vertices : published.vertices)
    job.meshes.push_back("disc:" + std::to_string(vertices));
  if (job.meshes.empty())
    throw InputError("option 'mesh'", "is empty, expected meshes, or published figures of some");
  return job;
}

std::string MachineName(const SpeedTable& table, const MeasuredSpeed& row) {
  const bool on_cpu = row.device.find("CPU thread") != std::string::npos;
  std::string name = row.device;
  if (on_cpu && !table.cpu.empty()) name += " of " + table.cpu;
  if (row.batch > 1) name += ", of " + std::to_string(row.batch) + " at once";
  return name;
}

// The rows of one batch, one for each mesh.
struct OwnRow {
  std::string machine;
  std::vector<const MeasuredSpeed*> cells;
};

std::vector<OwnRow> OwnRows(const SpeedJob& job, const SpeedTable& table) {
  std::vector<OwnRow> rows;
  for (const int batch : job.batches) {
    OwnRow own;
    for (const MeasuredSpeed& row : table.rows)
      if (row.batch == batch) own.cells.push_back(&row);
    if (!own.cells.empty()) own.machine = MachineName(table, *own.cells.front());
    rows.push_back(std::move(own));
  }
  return rows;
}

std::string Cell(const std::vector<double>& speeds, std::size_t mesh) {
  return mesh < speeds.size() ? Format("%.3g", speeds[mesh]) : "–";
}

std::string Line(const std::string& name, const std::string& machine,
                 const std::vector<std::string>& cells) {
  std::string line = "| " + name + " | " + machine + " |";
  for (const std::string& cell : cells) line += " " + cell + " |";
  return line + "\n";
}

// The column of each mesh in the published table: that of its number of vertices; none: past it.
std::vector<std::size_t> PublishedColumns(const PublishedSpeeds& published,
                                          const std::vector<OwnRow>& own) {
  std::vector<std::size_t> columns;
  for (const MeasuredSpeed* cell : own.front().cells)
    columns.push_back(static_cast<std::size_t>(
        std::find(published.vertices.begin(), published.vertices.end(), cell->vertices) -
        published.vertices.begin()));
  return columns;
}

// One of the two parts of a step, ours and that of others.
std::string PartText(const std::string& title, const PublishedSpeeds& published,
                     std::vector<double> PublishedSpeed::*speeds, const std::vector<OwnRow>& own,
                     double (*measured)(const MeasuredSpeed&)) {
  std::vector<std::string> heads, rule;
  for (const MeasuredSpeed* cell : own.front().cells) {
    heads.push_back(std::to_string(cell->vertices));
    rule.emplace_back("---");
  }
  std::string text = Line(title, "machine", heads) + Line("---", "---", rule);
  const std::vector<std::size_t> columns = PublishedColumns(published, own);
  for (const PublishedSpeed& row : published.rows) {
    if ((row.*speeds).empty()) continue;
    std::vector<std::string> cells;
    for (const std::size_t column : columns) cells.push_back(Cell(row.*speeds, column));
    text += Line(row.name, row.machine, cells);
  }
  for (const OwnRow& row : own) {
    std::vector<std::string> cells;
    for (const MeasuredSpeed* cell : row.cells) cells.push_back(Format("%.3g", measured(*cell)));
    text += Line("drapefit", row.machine, cells);
  }
  return text + "\n";
}

std::string MemoryText(const std::vector<OwnRow>& own) {
  std::string text;
  for (const OwnRow& row : own) {
    std::string forward, gradient;
    for (const MeasuredSpeed* cell : row.cells) {
      forward += Format(" %.0f", cell->forward_mb);
      gradient += Format(" %.0f", cell->gradient_mb);
    }
    text += "peak memory of the host [MB], " + row.machine + ": forward" + forward +
            ", with the gradient" + gradient + "\n";
  }
  return text;
}

std::string SpeedText(const SpeedToolOptions& options, const SpeedJob& job,
                      const PublishedSpeeds& published, const SpeedTable& table) {
  const std::vector<OwnRow> own = OwnRows(job, table);
  std::string text =
      PartText("forward [s a step], vertices:", published, &PublishedSpeed::forward, own,
               [](const MeasuredSpeed& cell) { return cell.forward; }) +
      PartText("backward [s a step], vertices:", published, &PublishedSpeed::backward, own,
               [](const MeasuredSpeed& cell) { return cell.backward(); }) +
      MemoryText(own);
  text += Format(
      "drapefit: law %s, %d steps of %g s, median of at most %d; the gradient is of one "
      "scalar by the 39 numbers of a table, backward is gradient less forward\n",
      job.law.c_str(), job.steps, job.h, job.repeats);
  if (options.job.meshes.empty())
    text +=
        "meshes: built-in discs of about the published numbers of vertices, not the published "
        "meshes (--mesh)\n";
  for (const PublishedSpeed& row : published.rows)
    text += row.name + ", " + row.machine + ": " + row.source + "\n";
  return text;
}

Json SpeedJson(const SpeedJob& job, const SpeedTable& table) {
  Json json = {
      {"law", job.law}, {"time_step_s", job.h}, {"steps", job.steps}, {"material", job.material}};
  json["rows"] = Json::array();
  for (const MeasuredSpeed& row : table.rows)
    json["rows"].push_back({{"mesh", row.mesh},
                            {"vertices", row.vertices},
                            {"device", row.device},
                            {"batch", row.batch},
                            {"repeats", row.repeats},
                            {"forward_seconds", row.forward},
                            {"forward_seconds_spread", row.forward_spread},
                            {"gradient_seconds", row.gradient},
                            {"gradient_seconds_spread", row.gradient_spread},
                            {"backward_seconds", row.backward()},
                            {"forward_peak_mb", row.forward_mb},
                            {"gradient_peak_mb", row.gradient_mb}});
  return json;
}

}  // namespace

OptionTable SpeedOptionTable(SpeedToolOptions& options) {
  return {.tool = "drape_speed",
          .summary =
              "times a step of a drape, forward and backward, beside published figures of others",
          .example = "drape_speed --config=configs/studies/speed.json --out=out/speed",
          .notes =
              "files: speed.md (the table that is printed), speed.json\n"
              "Rollouts start from the flat cloth at rest. Each measurement is a process of "
              "its own, so that its peak memory is its own.\n"
              "Ctrl-C ends the run without files.\n",
          .options = Concatenate(Grouped("cloth and steps", ClothAndSteps(options)),
                                 Grouped("measurement and results", MeasurementOptions(options)))};
}

SpeedToolResult RunSpeedTool(const SpeedToolOptions& options, const RunControl& control) {
  const PublishedSpeeds published =
      options.published.empty() ? PublishedSpeeds{} : ReadPublishedSpeeds(options.published);
  const SpeedJob job = MakeJob(options, published);
  const OutputFolder out(options.out, {"speed.md", "speed.json"});
  SpeedToolResult result{MeasureSpeeds(job, control), ""};
  if (result.table.cancelled) return result;
  result.text = SpeedText(options, job, published, result.table);
  WriteFileAtomically(out.Staged("speed.md"), result.text);
  WriteWithProvenance(out.Staged("speed.json"), SpeedJson(job, result.table));
  out.Publish();
  return result;
}

namespace {

ToolOutcome Run(const SpeedToolOptions& options, const RunControl& control) {
  SpeedToolResult result = RunSpeedTool(options, control);
  return {.text = std::move(result.text), .cancelled = result.table.cancelled};
}

}  // namespace

int SpeedMain(int argc, char** argv) { return ToolMain(argc, argv, SpeedOptionTable, Run); }

}  // namespace drape
