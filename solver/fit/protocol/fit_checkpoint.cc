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

json ToJson(const FitCandidate& branch) {
  json shapes = json::array();
  for (const Eigen::VectorXd& x : branch.shapes) shapes.push_back(ToJson(x));
  return {{"stretch", branch.seed.stretch},
          {"bend", branch.seed.bend},
          {"lifts", branch.seed.lifts},
          {"coarse_rms", branch.seed.profile_rms},
          {"seed_rms", branch.seed_rms},
          {"theta", ToJson(branch.theta)},
          {"shapes", shapes},
          {"cost", branch.cost},
          {"profile_rms", branch.profile_rms},
          {"termination", static_cast<int>(branch.termination)},
          {"iterations", branch.iterations},
          {"done", branch.done}};
}

FitCandidate ReadCandidate(const JsonInput& input) {
  FitCandidate branch;
  branch.seed = {input.At("stretch").Number(), input.At("bend").Number(),
                 Numbers(input.At("lifts")), input.At("coarse_rms").Number()};
  branch.seed_rms = input.At("seed_rms").Number();
  branch.theta = Vector(input.At("theta"));
  const JsonInput shapes = input.At("shapes");
  for (int i = 0; i < shapes.ExpectArray().Size(); ++i)
    branch.shapes.push_back(Vector(shapes.At(i)));
  branch.cost = input.At("cost").Number();
  branch.profile_rms = input.At("profile_rms").Number();
  branch.termination = static_cast<FitTermination>(
      IntegerUpTo(input.At("termination"), static_cast<int>(FitTermination::kFailed)));
  branch.iterations = input.At("iterations").Integer();
  branch.done = Boolean(input.At("done"));
  return branch;
}

// The first key in which two jobs differ; empty when they are the same.
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

void WriteCheckpoint(const std::string& path, const std::string& job, const StagedFitState& state) {
  json branches = json::array();
  for (const FitCandidate& branch : state.branches) branches.push_back(ToJson(branch));
  const json document = {{"format", "drapefit-checkpoint"},
                         {"job", job},
                         {"grid_done", state.grid_done},
                         {"round", state.round},
                         {"iterations", state.iterations},
                         {"counts",
                          {state.counts.rollouts, state.counts.tangents, state.counts.failed,
                           state.counts.jumps, state.counts.capped}},
                         {"seconds", {state.grid_seconds, state.fit_seconds}},
                         {"branches", branches}};
  WriteFileAtomically(path, document.dump() + "\n");
}

std::optional<StagedFitState> ReadCheckpoint(const std::string& path, const std::string& job) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const json document = ReadJsonFile(path);
  const JsonInput input(document, path);
  if (const std::string key = FirstDifference(input.At("job").String(), job); !key.empty())
    throw InputError(path, "found another '" + key +
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
  const JsonInput branches = input.At("branches");
  for (int i = 0; i < branches.ExpectArray().Size(); ++i)
    state.branches.push_back(ReadCandidate(branches.At(i)));
  return state;
}

}  // namespace drape
