// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_job.h"

#include <filesystem>
#include <optional>
#include <sstream>
#include <utility>

#include "physics/util/atomic_file.h"
#include "solver/fit/protocol/fit_checkpoint.h"
#include "solver/fit/protocol/nested_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/job/fit_drapes.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// What is continued from a checkpoint, and what is not.
std::string ResumeNote(FitModel model, const FitProblem& problem,
                       const std::optional<StagedFitState>& state) {
  if (!state) return "resume: no checkpoint, from the beginning";
  std::ostringstream note;
  note << "resume: ";
  if (CountParts(problem) > 1)
    note << "part " << state->parts_done + 1 << " of " << CountParts(problem) << ", ";
  if (state->grid_done) {
    note << "round " << state->round + 1 << ", " << DoneCandidates(*state) << " of "
         << state->candidates.size() << " candidates done";
  } else {
    note << state->tried.size() << " scales of the initial guesses done";
  }
  if (model == FitModel::kHeterogeneous) note << "; the fields start again";
  if (HasPosterior(model)) note << "; the posterior starts again";
  return note.str();
}

// A file that cannot be replaced is found before any is.
void CheckTargets(const FitSpec& spec, const FitProblem& problem, const FitFiles& files) {
  const std::string folder = files.target.empty() ? files.out : files.target;
  for (const std::string& name : ListResultFiles(spec, problem))
    CheckReplaceable(folder + "/" + name);
  CheckReplaceable(files.checkpoint);
}

// Appends a line. A fit is valid even if its log cannot be written, for example on a full disk.
void LogLine(AppendFile& log, const std::string& line) { (void)log.TryAppend(line + "\n"); }

// What a log begins with; the data and the device also go to `control`.
void LogInput(const FitData& data, const FitInput& input, const std::string& resumed,
              const RunControl& control, AppendFile& log) {
  const auto log_both = [&](const std::string& line) {
    LogLine(log, line);
    control.Log(line);
  };
  for (const Observation& observation : input.problem.observations)
    log_both(observation.name + ": " + CameraText(observation.camera, observation.quality));
  if (!resumed.empty()) log_both(resumed);
  if (!input.device.empty()) log_both("running on " + input.device);
  for (const std::string& line : data.log_lines) LogLine(log, line);
  for (const std::string& note : input.notes) LogLine(log, note);
}

}  // namespace

FitJobResult RunFitJob(const FitSpec& spec, const FitData& data, const FitFiles& files,
                       const RunControl& control) {
  AppendFile::Check(files.log);
  FitInput input = ReadFitInput(spec, data);
  CheckTargets(spec, input.problem, files);
  const std::string key = CheckpointKey(spec, data, input);
  std::optional<AppendFile> log;
  FitStore store;
  store.begin = [&](const FitInput& in, const StagedFitOptions&, bool ready) {
    std::optional<StagedFitState> saved;
    if (files.resume && ready) saved = ReadCheckpoint(files.checkpoint, key);
    using Content = AppendFile::Content;
    log.emplace(files.log, files.resume ? Content::kKeep : Content::kDrop);
    LogInput(data, in,
             files.resume && ready ? ResumeNote(spec.model, in.problem, saved) : std::string(),
             control, *log);
    return std::move(saved).value_or(StagedFitState());
  };
  store.save = [&](const StagedFitState& state) { WriteCheckpoint(files.checkpoint, key, state); };
  store.log = [&](const std::string& line) { LogLine(*log, line); };
  StoredFit fit = FitFromInput(spec, input, store, control);
  FitReport& report = fit.report;
  WriteFitReport(spec, data, files, input.problem, fit.state, report);
  const FitProblem problem = PartProblem(input.problem, fit.state.parts_done);
  FitJobResult result;
  result.cancelled = report.cancelled;
  result.fitted = report.fitted();
  result.has_posterior = report.posterior.has_value();
  if (result.fitted) {
    result.table = FitText(problem, report);
    result.results = MainFiles(problem, report);
  }
  if (!result.cancelled && !files.keep_checkpoint) fs::remove(files.checkpoint);
  return result;
}

FitJobResult ContinueFitJob(const FitSpec& spec, const FitData& data, FitFiles files,
                            const RunControl& control) {
  files.resume = fs::exists(files.checkpoint);
  if (files.resume) try {
      return RunFitJob(spec, data, files, control);
    } catch (const InputError&) {
      files.resume = false;  // a checkpoint of another fit, or a damaged one
    }
  return RunFitJob(spec, data, files, control);
}

}  // namespace drape
