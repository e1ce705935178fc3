// SPDX-License-Identifier: Apache-2.0
// Files that programs write for themselves: a checkpoint with fitted branches, and cells of a
// study. The cloth is one without physics, so that thousands are read quickly.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "physics/util/errors.h"
#include "physics/util/stored/stored_json.h"
#include "solver/job/fit_checkpoint.h"
#include "solver/studies/runner/study.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/readers/readers.h"
#include "tests/solver/fake_fit.h"

namespace drape::attack {
namespace {

using nlohmann::json;

constexpr char kJob[] = "job";

// In its second round, with one branch fitted.
StagedFitState MakeHalfwayState(const test::FakeFit& small) {
  std::vector<StagedFitState> saved;
  StagedFitControl control;
  control.save = [&](const StagedFitState& state) { saved.push_back(state); };
  RunStagedFit(small.problem, small.options, {}, control);
  const auto found = std::find_if(saved.begin(), saved.end(), [](const StagedFitState& state) {
    return state.round == 1 && DoneCandidates(state) == 1;
  });
  if (found == saved.end()) throw std::runtime_error("the fit has no second round");
  return *found;
}

// What is read must be a state from which the fit continues to its end.
std::string ReadAndContinue(const test::FakeFit& small, const std::string& path) {
  const auto state = ReadCheckpoint(path, kJob);
  if (!state) return "found no checkpoint";
  const int rounds = static_cast<int>(small.options.candidates_per_round.size());
  const StagedFitState end = RunStagedFit(small.problem, small.options, *state, {});
  // Where no initial guess comes to rest there is nothing to fit.
  return end.round == rounds || end.candidates.empty() ? ""
                                                       : "continued to another round than the last";
}

std::vector<Reader> MakeCheckpointReaders(const std::string& scratch) {
  const auto small = std::make_shared<test::FakeFit>();
  const std::string path = scratch + "checkpoint.json";
  WriteCheckpoint(path, kJob, MakeHalfwayState(*small));
  const auto read = [small](const std::string& from) { return ReadAndContinue(*small, from); };
  return {{.name = "checkpoint",
           .file = "checkpoint.json",
           .content = ReadText(path),
           .read = read,
           .is_json = false}};
}

// The file of a finished cell, which a study takes over.
std::vector<Reader> MakeCellReaders(const std::string& scratch) {
  constexpr StoredFormat kCellFormat = {"drapefit-cell", 3};
  const auto study = std::make_shared<Study>();
  study->name = "race";
  study->settings = {{"budget", 20}};
  study->outcomes = {"end"};
  study->cells = {{.name = "wool_2.lm", .input = {{"method", "lm"}, {"seed", 1}}}};
  study->run = [](std::size_t, const RunControl&) -> std::optional<json> {
    return json::parse(R"({"trace": [[1.0, 0.1, 5.5]], "theta": [0.5, -0.25], "cpu_s": 0.5,
                           "evaluations": 7, "rms_px": [1.5, 0.5], "outcome": "end"})");
  };
  const auto file = [study](const std::string& out) {
    return out + "/cells/" + CellId(*study, 0) + ".json";
  };
  const auto run = [study](const std::string& out) {
    StudyOptions options;
    options.out = out;
    return RunStudy(*study, options, {}).complete;
  };
  run(scratch + "study");
  const std::string path = file(scratch + "study");
  const auto read = [file, run](const std::string& from) {
    const std::string out = from + ".study";
    std::filesystem::create_directories(out + "/cells");
    std::filesystem::remove(file(out));
    std::filesystem::create_symlink(from, file(out));
    return run(out) ? std::string() : "the study is not complete";
  };
  return {{.name = "cell",
           .file = "cell.json",
           .content = ReadText(path),
           .read = read,
           .is_json = false},
          {.name = "cell with its checksum",
           .file = "cell.json",
           .content = ReadStoredJson(path, kCellFormat).dump(),
           .read = read,
           .seal =
               [](const json& members) {
                 return StoredJsonText({"drapefit-cell", 3}, members);
               },
           .impossible = {{"/result", "[]"},
                          {"/result", "null"},
                          {"/result/cpu_s", "-1"},
                          {"/result/evaluations", "-3"},
                          {"/result/rms_px/1", "-0.5"},
                          {"/result/outcome", "\"wonderful\""},
                          {"/result/outcome", "3"},
                          {"/key/study", "\"another\""}}}};
}

}  // namespace

std::vector<Reader> MakeRecordReaders(const std::string& scratch) {
  std::vector<Reader> readers = MakeCheckpointReaders(scratch);
  for (Reader& reader : MakeCellReaders(scratch)) readers.push_back(std::move(reader));
  return readers;
}

}  // namespace drape::attack
