// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/fabric_fits.h"

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/job/fit_captures.h"
#include "solver/job/fit_job.h"
#include "solver/posterior/posterior_io.h"
#include "solver/studies/cells/study_settings.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

bool HasPosterior(const std::string& folder) {
  try {
    const nlohmann::json summary = ReadJsonFile(folder + "/summary.json");
    if (!summary.contains("posterior") || summary.value("status", "") != "done") return false;
    ReadPosterior(folder);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

// Empty: none.
std::string ReadFailure(const std::string& folder) {
  const std::string path = folder + "/failure.json";
  if (!fs::exists(path)) return "";
  try {
    const nlohmann::json file = ReadJsonFile(path);
    return JsonInput(file, path).At("reason").String();
  } catch (const InputError& error) {
    return error.what();
  }
}

void WriteFailure(const std::string& folder, const std::string& reason) {
  WriteFileAtomically(folder + "/failure.json",
                      nlohmann::json({{"reason", reason}}).dump(1) + "\n");
}

// From its checkpoint, where there is a valid one.
void RunOne(const FitCellJob& job, const FitCell& cell, const RunControl& control) {
  const std::string folder = job.out + "/" + cell.name;
  fs::create_directories(folder);
  RemoveTemporaries(folder);
  FitData data;
  data.material = job.material;
  FitSpec spec = job.fit;
  spec.threads = 1;
  FitFiles files{.out = folder,
                 .checkpoint = folder + "/checkpoint.json",
                 .log = folder + "/fit.log",
                 .provenance = job.provenance};
  try {
    UseCaptures(cell.captures, &data);
    files.resume = fs::exists(files.checkpoint);
    FitJobResult result;
    try {
      result = RunFitJob(spec, data, files, control);
    } catch (const InputError&) {
      if (!files.resume) throw;
      files.resume = false;  // a damaged checkpoint
      result = RunFitJob(spec, data, files, control);
    }
    if (result.cancelled || control.cancelled()) return;
    if (!result.fitted) return WriteFailure(folder, "nothing could be fitted");
    if (!HasPosterior(folder)) WriteFailure(folder, "the posterior could not be fitted");
  } catch (const InputError& error) {
    WriteFailure(folder, error.what());
  }
}

template <class SameCell>
std::vector<FitCell> MakeCells(const std::vector<Capture>& captures, const SameCell& same,
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

std::vector<FitCell> CellsOfShare(const std::vector<FitCell>& cells, const Share& share) {
  std::vector<FitCell> own;
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (share.Has(k)) own.push_back(cells[k]);
  return own;
}

FitCellRun FindFits(const FitCellJob& job, const std::vector<FitCell>& cells) {
  FitCellRun run;
  for (const FitCell& cell : cells) {
    const std::string folder = job.out + "/" + cell.name, failure = ReadFailure(folder);
    if (!failure.empty()) {
      run.failures.push_back({cell.name, failure});
    } else if (HasPosterior(folder)) {
      run.done.push_back(cell.name);
    } else {
      run.missing.push_back(cell.name);
    }
  }
  return run;
}

FitCellRun RunFitCells(const FitCellJob& job, const std::vector<FitCell>& cells,
                       const RunControl& control) {
  const std::string settings = job.out + "/fits.json";
  CheckStudySettings(settings, job.settings, "fits");
  fs::create_directories(job.out);
  AddStudySettings(settings, job.settings);
  std::vector<const FitCell*> todo;
  for (const FitCell& cell : cells) {
    const std::string folder = job.out + "/" + cell.name;
    if (ReadFailure(folder).empty() && !HasPosterior(folder)) todo.push_back(&cell);
  }
  std::mutex mutex;
  int done = static_cast<int>(cells.size() - todo.size());
  RunInThreads(static_cast<int>(todo.size()), job.threads, control.cancel, [&](int i) {
    RunOne(job, *todo[i], {.cancel = control.cancel});
    const std::scoped_lock lock(mutex);
    ++done;
    control.Report(double(done) / double(cells.size()),
                   "fit " + std::to_string(done) + " of " + std::to_string(cells.size()));
  });
  FitCellRun run = FindFits(job, cells);
  run.cancelled = control.cancelled();
  return run;
}

}  // namespace drape
