// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_checkpoint.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "physics/util/errors.h"
#include "physics/util/options/names_file.h"

namespace drape {

// Members of a file by the names of the members of the struct.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(InitialGuess, table, stretch, bend, lifts, profile_rms)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PartResult, part, began_carried, cost, profile_rms, stretch,
                                   bend)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RolloutCounts, rollouts, tangents, failed, jumps, capped)

namespace {

using nlohmann::json;

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
  return {{"guess", candidate.guess},
          {"base", ToJson(candidate.base)},
          {"is_carried", candidate.is_carried},
          {"mirrored", candidate.mirrored},
          {"guess_rms", candidate.guess_rms},
          {"theta", candidate.theta},
          {"shapes", candidate.shapes},
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
                         .mirrored = stored.at("mirrored"),
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
                       .first_fits = {},
                       .round = stored.at("round"),
                       .iterations = stored.at("iterations"),
                       .counts = stored.at("counts"),
                       .grid_seconds = stored.at("grid_seconds"),
                       .fit_seconds = stored.at("fit_seconds")};
  if (!stored.at("carried").is_null()) state.carried = ToCandidate(stored["carried"]);
  for (const json& candidate : stored.at("candidates"))
    state.candidates.push_back(ToCandidate(candidate));
  for (const json& tables : stored.at("first_fits")) state.first_fits.push_back(ToTables(tables));
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
  json candidates = json::array(), first_fits = json::array();
  for (const FitCandidate& candidate : state.candidates) candidates.push_back(ToJson(candidate));
  for (const MaterialField& tables : state.first_fits) first_fits.push_back(ToJson(tables));
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
                   {"candidates", std::move(candidates)},
                   {"first_fits", std::move(first_fits)}});
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

std::string CheckpointKey(const FitSpec& spec, const FitData& data, const FitInput& input) {
  nlohmann::json key;
  const auto add = [&key]<class T>(const T& value, const Field& field) {
    if (!field.in_key || NamesFile(value, field)) return;
    if constexpr (NamedEnum<T>) {
      key[field.key] = ToString(value);
    } else {
      key[field.key] = value;
    }
  };
  VisitFields(spec, add);
  VisitFields(spec.observation, add);
  VisitFields(spec.stages, add);
  // spec.fields and spec.posterior are not part of it: what they set follows the fit of one table.
  // The content of the files of `data`, as read, is part of it.
  const auto& [images, captures, source, specimens, lab_measurements, experiment, material, density,
               ground_truth, notes, log_lines, shared] = data;
  const FitProblem& problem = input.problem;
  if (experiment.empty() && (FindExperiment(problem) != nullptr || !problem.further.empty()))
    throw InputError("checkpoint",
                     "found experiments in memory, expected some of a file, whose content is the "
                     "key of what is stored");
  for (const ReadRecord::File& file : input.files) key["read_files"].push_back(file.sha256);
  key["discs"] = {input.discs.specimen, input.discs.support};
  key["density"] = problem.material.density;
  key["stretch_table"] = problem.material.stretch[0].c;
  key["bend_table"] = problem.material.bend[0].b;
  for (const MaterialField& other : problem.other_materials)
    key["other_materials"].push_back({other.stretch[0].c, other.bend[0].b});
  for (const Observation& observation : problem.observations)
    key["images"].push_back(observation.radius);
  for (const Capture& c : captures)
    key["data"].push_back({c.fabric, c.sample, c.capture, ToString(source)});
  if (!input.strips) return key.dump();
  for (const LabMeasurement& measurement : input.strips->measurements()) {
    nlohmann::json points;
    for (const LabPoint& point : measurement.points) points.push_back({point.set, point.reading});
    key["lab_measurements"].push_back({ToString(measurement.kind), measurement.direction,
                                       measurement.length, measurement.width, measurement.sigma,
                                       points});
  }
  return key.dump();
}

}  // namespace drape
