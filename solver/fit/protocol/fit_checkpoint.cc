// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/fit_checkpoint.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

using nlohmann::json;

json ToJson(const Eigen::VectorXd& v) { return std::vector<double>(v.begin(), v.end()); }

std::vector<double> Numbers(const JsonInput& input) {
  std::vector<double> values;
  input.ExpectArray();
  for (int i = 0; i < input.Size(); ++i) values.push_back(input.At(i).Number());
  return values;
}
Eigen::VectorXd Vector(const JsonInput& input) {
  const std::vector<double> values = Numbers(input);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

bool Boolean(const JsonInput& input) {
  if (!input.value().is_boolean()) input.Fail("true or false");
  return input.value().get<bool>();
}

int IntegerUpTo(const JsonInput& input, int last) {
  const int value = input.Integer();
  if (value < 0 || value > last) input.Fail("a number from 0 to " + std::to_string(last));
  return value;
}

json ToJson(const FitCandidate& candidate) {
  json shapes = json::array();
  for (const Eigen::VectorXd& x : candidate.shapes) shapes.push_back(ToJson(x));
  return {{"stretch", candidate.guess.stretch},
          {"bend", candidate.guess.bend},
          {"lifts", candidate.guess.lifts},
          {"coarse_rms", candidate.guess.profile_rms},
          {"guess_rms", candidate.guess_rms},
          {"theta", ToJson(candidate.theta)},
          {"shapes", shapes},
          {"cost", candidate.cost},
          {"profile_rms", candidate.profile_rms},
          {"termination", static_cast<int>(candidate.termination)},
          {"iterations", candidate.iterations},
          {"done", candidate.done}};
}

FitCandidate ReadCandidate(const JsonInput& input) {
  FitCandidate candidate;
  candidate.guess = {input.At("stretch").Number(), input.At("bend").Number(),
                     Numbers(input.At("lifts")), input.At("coarse_rms").Number()};
  candidate.guess_rms = input.At("guess_rms").Number();
  candidate.theta = Vector(input.At("theta"));
  const JsonInput shapes = input.At("shapes");
  for (int i = 0; i < shapes.ExpectArray().Size(); ++i)
    candidate.shapes.push_back(Vector(shapes.At(i)));
  candidate.cost = input.At("cost").Number();
  candidate.profile_rms = input.At("profile_rms").Number();
  candidate.termination = static_cast<FitTermination>(
      IntegerUpTo(input.At("termination"), static_cast<int>(FitTermination::kFailed)));
  candidate.iterations = input.At("iterations").Integer();
  candidate.done = Boolean(input.At("done"));
  return candidate;
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
  const json document = {{"format", "drapefit-checkpoint"},
                         {"job", key},
                         {"grid_done", state.grid_done},
                         {"round", state.round},
                         {"iterations", state.iterations},
                         {"counts",
                          {state.counts.rollouts, state.counts.tangents, state.counts.failed,
                           state.counts.jumps, state.counts.capped}},
                         {"seconds", {state.grid_seconds, state.fit_seconds}},
                         {"candidates", candidates}};
  WriteFileAtomically(path, document.dump() + "\n");
}

std::optional<StagedFitState> ReadCheckpoint(const std::string& path, const std::string& key) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const json document = ReadJsonFile(path);
  const JsonInput input(document, path);
  if (const std::string name = FirstDifference(input.At("job").String(), key); !name.empty())
    throw InputError(path, "found another '" + name +
                               "', expected the present one: run without --resume, or undo the "
                               "change");
  StagedFitState state;
  state.grid_done = Boolean(input.At("grid_done"));
  state.round = IntegerUpTo(input.At("round"), std::numeric_limits<int>::max());
  state.iterations = input.At("iterations").Integer();
  const JsonInput counts = input.At("counts");
  state.counts = {counts.At(0).Integer(), counts.At(1).Integer(), counts.At(2).Integer(),
                  counts.At(3).Integer(), counts.At(4).Integer()};
  state.grid_seconds = input.At("seconds").At(0).Number();
  state.fit_seconds = input.At("seconds").At(1).Number();
  const JsonInput candidates = input.At("candidates");
  for (int i = 0; i < candidates.ExpectArray().Size(); ++i)
    state.candidates.push_back(ReadCandidate(candidates.At(i)));
  return state;
}

}  // namespace drape
