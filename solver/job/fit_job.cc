// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_job.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "solver/fit/protocol/nested_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/job/fit_run.h"

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

// Members of a file by the names of the members of the struct.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(InitialGuess, table, stretch, bend, lifts, profile_rms)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PartResult, part, began_carried, cost, profile_rms, stretch,
                                   bend)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RolloutCounts, rollouts, tangents, failed, jumps, capped)

namespace {

using nlohmann::json;

json ToJson(const Eigen::VectorXd& v) { return std::vector<double>(v.begin(), v.end()); }

Eigen::VectorXd ToVector(const json& numbers) {
  const auto list = numbers.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(list.data(), static_cast<Eigen::Index>(list.size()));
}

// The density and the 39 entries; an empty list before the guess is settled.
json ToJson(const MaterialField& tables) {
  if (tables.stretch.empty()) return json::array();
  std::vector<double> numbers = {tables.density};
  numbers.insert(numbers.end(), tables.stretch[0].entries(),
                 tables.stretch[0].entries() + kStretchEntries);
  numbers.insert(numbers.end(), tables.bend[0].entries(), tables.bend[0].entries() + kBendEntries);
  return numbers;
}

MaterialField ToTables(const json& numbers) {
  if (numbers.empty()) return {};
  MaterialField tables{numbers.at(0), {StretchTable()}, {BendTable()}};
  for (int i = 0; i < kStretchEntries; ++i) tables.stretch[0].entries()[i] = numbers.at(1 + i);
  for (int i = 0; i < kBendEntries; ++i)
    tables.bend[0].entries()[i] = numbers.at(1 + kStretchEntries + i);
  return tables;
}

json ToJson(const FitCandidate& candidate) {
  json shapes = json::array();
  for (const Eigen::VectorXd& x : candidate.shapes) shapes.push_back(ToJson(x));
  return {{"guess", candidate.guess},
          {"base", ToJson(candidate.base)},
          {"is_carried", candidate.is_carried},
          {"guess_rms", candidate.guess_rms},
          {"theta", ToJson(candidate.theta)},
          {"shapes", shapes},
          {"cost", candidate.cost},
          {"profile_rms", candidate.profile_rms},
          {"termination", candidate.termination},
          {"iterations", candidate.iterations},
          {"done", candidate.done}};
}

FitCandidate ToCandidate(const json& stored) {
  FitCandidate candidate{.guess = stored.at("guess"),
                         .base = ToTables(stored.at("base")),
                         .is_carried = stored.at("is_carried"),
                         .guess_rms = stored.at("guess_rms"),
                         .theta = ToVector(stored.at("theta")),
                         .shapes = {},
                         .cost = stored.at("cost"),
                         .profile_rms = stored.at("profile_rms"),
                         .termination = stored.at("termination"),
                         .iterations = stored.at("iterations"),
                         .done = stored.at("done")};
  for (const json& x : stored.at("shapes")) candidate.shapes.push_back(ToVector(x));
  return candidate;
}

StagedFitState ToState(const json& stored) {
  StagedFitState state{.parts_done = stored.at("parts_done"),
                       .part_results = stored.at("part_results"),
                       .carried = {},
                       .tried = stored.at("tried"),
                       .grid_done = stored.at("grid_done"),
                       .candidates = {},
                       .round = stored.at("round"),
                       .iterations = stored.at("iterations"),
                       .counts = stored.at("counts"),
                       .grid_seconds = stored.at("grid_seconds"),
                       .fit_seconds = stored.at("fit_seconds")};
  if (!stored.at("carried").is_null()) state.carried = ToCandidate(stored["carried"]);
  for (const json& candidate : stored.at("candidates"))
    state.candidates.push_back(ToCandidate(candidate));
  return state;
}

// The first name in which two keys differ; empty when they are the same.
std::string FirstDifference(const std::string& saved, const std::string& present) {
  if (saved == present) return "";
  const json a = json::parse(saved, nullptr, false), b = json::parse(present, nullptr, false);
  if (a.is_object() && b.is_object()) {
    for (const auto& [key, value] : b.items())
      if (!a.contains(key) || a[key] != value) return key;
    for (const auto& [key, value] : a.items())
      if (!b.contains(key)) return key;
  }
  return "job";
}

}  // namespace

void WriteCheckpoint(const std::string& path, const std::string& key, const StagedFitState& state) {
  json candidates = json::array();
  for (const FitCandidate& candidate : state.candidates) candidates.push_back(ToJson(candidate));
  WriteStoredJson(path, kCheckpointFormat,
                  {{"job", key},
                   {"parts_done", state.parts_done},
                   {"part_results", state.part_results},
                   {"carried", state.carried ? ToJson(*state.carried) : json()},
                   {"tried", state.tried},
                   {"grid_done", state.grid_done},
                   {"round", state.round},
                   {"iterations", state.iterations},
                   {"counts", state.counts},
                   {"grid_seconds", state.grid_seconds},
                   {"fit_seconds", state.fit_seconds},
                   {"candidates", candidates}});
}

std::optional<StagedFitState> ReadCheckpoint(const std::string& path, const std::string& key) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const json stored = ReadStoredJson(path, kCheckpointFormat);
  if (const std::string name = FirstDifference(stored.value("job", ""), key); !name.empty())
    throw InputError(path, "found another '" + name +
                               "', expected the present one: run without --resume, or undo the "
                               "change");
  try {
    return ToState(stored);
  } catch (const json::exception& error) {
    throw InputError(path, std::string("is damaged or was altered: ") + error.what());
  }
}

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
