// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/fit_cells.h"

#include <filesystem>
#include <optional>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "solver/job/fit_input.h"
#include "solver/job/fit_job.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

FitData MakeData(const FitCellJob& job, const FitCell& cell) {
  FitData data;
  data.material = job.material;
  UseCaptures(cell.captures, &data);
  return data;
}

json Failure(const std::string& reason) { return {{"failure", reason}}; }

std::optional<json> FitOne(const FitCellJob& job, const FitCell& cell, const RunControl& control) {
  const std::string folder = job.out + "/" + cell.name;
  fs::create_directories(folder);
  RemoveTemporaries(folder);
  FitSpec spec = job.fit;
  spec.threads = 1;
  const FitFiles files{.out = folder,
                       .checkpoint = folder + "/checkpoint.json",
                       .log = folder + "/fit.log",
                       .provenance = job.provenance};
  try {
    const FitJobResult result = ContinueFitJob(spec, MakeData(job, cell), files, control);
    if (result.cancelled || control.cancelled()) return {};
    if (!result.fitted) return Failure("nothing could be fitted");
    if (!result.has_posterior) return Failure("the posterior could not be fitted");
  } catch (const InputError& error) {
    return Failure(error.what());
  }
  return json{{"folder", cell.name}};
}

template <class Same>
std::vector<FitCell> MakeCells(const std::vector<Capture>& captures, const Same& same,
                               bool by_sample) {
  std::vector<FitCell> cells;
  for (const Capture& capture : captures) {
    if (cells.empty() || !same(cells.back().captures.front(), capture)) {
      std::string name = "fabric_" + std::to_string(capture.fabric);
      if (by_sample) name += "/sample_" + std::to_string(capture.sample);
      cells.push_back({std::move(name), {}});
    }
    cells.back().captures.push_back(capture);
  }
  return cells;
}

// With the files that the fit reads, up to the one that it refuses.
StudyCell MakeStudyCell(const FitCellJob& job, const FitCell& cell) {
  return CheckedCell(cell.name, {}, [&] {
    try {
      ReadFitInput(job.fit, MakeData(job, cell));
    } catch (const InputError&) {
    }
  });
}

}  // namespace

std::vector<FitCell> CellsByFabric(const std::vector<Capture>& captures) {
  return MakeCells(
      captures, [](const Capture& a, const Capture& b) { return a.fabric == b.fabric; }, false);
}

std::vector<FitCell> CellsBySample(const std::vector<Capture>& captures) {
  return MakeCells(
      captures,
      [](const Capture& a, const Capture& b) {
        return a.fabric == b.fabric && a.sample == b.sample;
      },
      true);
}

FitCellRun RunFitCells(const FitCellJob& job, const std::vector<FitCell>& cells,
                       const RunControl& control) {
  Study study;
  study.name = "posteriors";
  study.settings = job.settings;
  for (const FitCell& cell : cells)
    study.cells.push_back(job.study.list ? StudyCell{.name = cell.name} : MakeStudyCell(job, cell));
  study.run = [&](std::size_t k, const RunControl& part) { return FitOne(job, cells[k], part); };
  FitCellRun run;
  run.study = RunStudy(study, job.study, control);
  for (std::size_t k = 0; k < run.study.results.size(); ++k) {
    const auto& result = run.study.results[k];
    if (!result) continue;
    if (result->contains("failure"))
      run.failures.push_back({cells[k].name, result->at("failure")});
    else
      run.done.push_back(cells[k].name);
  }
  return run;
}

}  // namespace drape
