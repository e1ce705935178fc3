// SPDX-License-Identifier: Apache-2.0
// Tampering with what programs store for themselves, with the checksum made right again; changed
// and moved inputs beside it; a disk that was full while they stored it.
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string_view>

#include "physics/util/math/sha256.h"
#include "physics/util/stored/stored_json.h"
#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/resumable.h"
#include "tests/attack/inputs/valid_inputs.h"
#include "tests/physics/util/stored/tampering.h"

namespace drape::attack {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kFewStored = 30, kFewInputs = 4, kFewDisks = 2;  // of a short campaign
constexpr std::size_t kMostRules = 220;                                // of a file
constexpr int kMutants = 40;                                           // of a checkpoint
constexpr double kStoredSeconds = 30.0;

// Results that a run from a file must repeat: what it printed and wrote, but for times.
using Results = std::map<std::string, std::string>;

Results ReadResults(const std::string& out) {
  Results results;
  for (const auto& [file, content] : ReadFolder(out))
    if (content.rfind("file ", 0) == 0 && IsReproducible(file))
      results[file] = WithoutTimes(file, content.substr(5));
  return results;
}

// What a run has stored when it was stopped, or at its end, and the results of the whole.
struct StoredFolder {
  ResumableRun run;
  std::string folder;  // as it was stopped
  Results results;     // of the whole run
};

bool HasDrapes(const std::string& checkpoint) {
  const json stored = json::parse(checkpoint, nullptr, false);
  if (!stored.is_object() || !stored.contains("candidates")) return false;
  return std::any_of(stored["candidates"].begin(), stored["candidates"].end(),
                     [](const json& candidate) { return !candidate["shapes"].empty(); });
}

// A fit keeps its checkpoint only when it is stopped: at later and later times, until there are
// fitted branches in it.
bool StopFit(const Campaign& campaign, const ResumableRun& run, const std::string& folder,
             double seconds) {
  for (double after = 0.3 * seconds; after < 2 * seconds; after += 0.05 * seconds) {
    Sandbox sandbox(folder);
    Request request = MakeRequest(campaign, run.command);
    request.signal = {SIGINT, after};
    RunProgramIn(folder, request);
    if (HasDrapes(sandbox.Read("out/checkpoint.json"))) return true;
  }
  return false;
}

StoredFolder MakeStored(const Campaign& campaign, const ResumableRun& run) {
  const std::string base = campaign.options().work + "/stored_good/" + run.name;
  Sandbox sandbox(base);
  Request request = MakeRequest(campaign, run.command);
  request.limits.seconds = 2 * kStoredSeconds;
  const Outcome whole = RunProgramIn(base, request);
  if (whole.exit_code != 0) throw std::runtime_error(run.name + " failed: " + whole.err);
  StoredFolder stored{run, base + "/out", ReadResults(base + "/out")};
  if (run.stored.front() == "checkpoint.json" && !fs::exists(base + "/out/checkpoint.json")) {
    const std::string stopped = base + "_stopped";
    if (!StopFit(campaign, run, stopped, whole.seconds))
      throw std::runtime_error(run.name + " left no checkpoint with drapes");
    stored.folder = stopped + "/out";
  }
  return stored;
}

// Whether a result is another than without the damage; not of the damaged file itself.
void CompareResults(const Results& expected, const std::string& damaged, Sandbox* sandbox) {
  const Results found = ReadResults(sandbox->folder() + "/out");
  for (const auto& [file, content] : expected) {
    if (file == damaged) continue;
    const auto same = found.find(file);
    if (same == found.end())
      sandbox->Fail("did not write " + file);
    else if (same->second != content)
      sandbox->Fail("silently wrote another " + file);
  }
}

void TryStored(const Campaign& campaign, const StoredFolder& stored, const std::string& file,
               const std::string& content, bool compare, Sandbox& sandbox) {
  fs::copy(stored.folder, sandbox.folder() + "/out", fs::copy_options::recursive);
  sandbox.Write("out/" + file, content);
  Request request = MakeRequest(campaign, ResumeCommand(stored.run));
  request.limits.seconds = kStoredSeconds;
  const Outcome outcome = sandbox.Run(request, {.named = {fs::path(file).filename()}});
  if (compare && outcome.exit_code == 0) CompareResults(stored.results, file, &sandbox);
}

struct Tampered {
  std::string what, content;
};

// Members that may have any value of their type: with its checksum made right, a value that a run
// could have found is a forgery that no reader can tell.
bool IsForgery(const std::string& what) {
  for (const char* member : {"/stiffness = -1", "/settled_rms_px = null", "/run/end = \"x\""})
    if (what.rfind(member, 0) == 0) return true;
  return false;
}

std::vector<Tampered> TamperJson(const std::string& text, uint64_t seed) {
  json members = json::parse(text);
  const bool sealed = members.contains("checksum");
  const std::string format = members.value("format", "");
  const int version = sealed ? members.value("version", 0) : 0;
  if (sealed)
    for (const char* key : {"format", "version", "checksum"}) members.erase(key);
  std::vector<Tampered> all;
  const test::Tampering tampering(members, [&](const std::string& what, const json& tampered) {
    if (sealed && !tampered.is_object()) return;
    all.push_back(
        {what, sealed ? StoredJsonText({format.c_str(), version}, tampered) : tampered.dump()});
  });
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < std::min(kMostRules, all.size()); ++i)
    std::swap(all[i], all[i + random() % (all.size() - i)]);
  all.resize(std::min(kMostRules, all.size()));
  return all;
}

std::vector<Tampered> TamperText(const std::string& text, uint64_t seed) {
  std::vector<Tampered> all;
  std::mt19937_64 random(seed);
  for (int i = 0; i < kMutants; ++i)
    all.push_back({"mutant " + std::to_string(i), test::Mutant(text, random)});
  for (const double part : {0.0, 0.2, 0.5, 0.9})
    all.push_back({"cut", text.substr(0, static_cast<std::size_t>(part * text.size()))});
  return all;
}

// The name of the first file in a folder, in the order of the names.
std::string FirstFile(const std::string& folder) {
  std::string first;
  for (const fs::directory_entry& file : fs::directory_iterator(folder)) {
    const std::string name = file.path().filename().string();
    if (first.empty() || name < first) first = name;
  }
  return first;
}

// The folder that a run has stored, made when it is first needed.
class LazyStored {
 public:
  LazyStored(const Campaign& campaign, const ResumableRun& run) : campaign_(campaign), run_(run) {}

  const ResumableRun& run() const { return run_; }
  const StoredFolder& Get() {
    std::call_once(once_, [&] { stored_ = MakeStored(campaign_, run_); });
    return stored_;
  }

 private:
  const Campaign& campaign_;
  const ResumableRun run_;
  std::once_flag once_;
  StoredFolder stored_;
};

// A good input that a word of a command names: "--fabric=../../valid/wool.json".
struct StoredInput {
  std::size_t word;
  std::string flag, path;  // "--fabric=", "wool.json"
};

std::vector<StoredInput> ListInputs(const std::vector<std::string>& command) {
  std::vector<StoredInput> inputs;
  for (std::size_t i = 1; i < command.size(); ++i) {
    const std::size_t value = command[i].find('=') + 1;
    if (value > 0 && command[i].substr(value).starts_with(kValid))
      inputs.push_back({i, command[i].substr(0, value),
                        command[i].substr(value + std::string_view(kValid).size())});
  }
  return inputs;
}

// Appends a byte that means nothing, of a folder to its first file.
void ChangeContents(const fs::path& input) {
  fs::path file = input;
  if (fs::is_directory(input)) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(input))
      if (entry.is_regular_file()) files.push_back(entry.path());
    file = *std::min_element(files.begin(), files.end());
  }
  std::ofstream(file, std::ios::app) << "\n";
}

// The finished cells of a study; none of another run.
std::set<std::string> ListCells(const std::string& out, const ResumableRun& run) {
  std::set<std::string> cells;
  const std::string& named = run.stored.front();
  const std::string folder = out + "/" + (named.ends_with("/") ? named : "cells");
  if (!fs::is_directory(folder)) return cells;
  for (const fs::directory_entry& cell : fs::directory_iterator(folder))
    cells.insert(cell.path().filename().string());
  return cells;
}

// Checks that each input that a result names has the contents that it states.
void CheckProvenance(Sandbox* sandbox) {
  for (const fs::directory_entry& file : fs::directory_iterator(sandbox->folder() + "/out")) {
    if (file.path().extension() != ".json") continue;
    const json result = json::parse(ReadText(file.path().string()), nullptr, false);
    if (!result.is_object() || !result.contains("provenance")) continue;
    for (const json& input : result["provenance"].value("inputs", json::array()))
      if (input.at("sha256") !=
          Sha256(ReadText(sandbox->folder() + "/" + input.at("path").get<std::string>())))
        sandbox->Fail("names contents of " + input.at("path").dump() + " that it has not");
  }
}

enum class InputChange { kMoved, kChanged };

// A run continues with an input of the same contents in another folder. With other contents it is
// refused, or takes over nothing.
void TryInput(const Campaign& campaign, const StoredFolder& stored, const StoredInput& input,
              InputChange change, Sandbox& sandbox) {
  const std::string out = sandbox.folder() + "/out", moved = "in/deep/other_" + input.path;
  fs::copy(stored.folder, out, fs::copy_options::recursive);
  fs::create_directories(fs::path(sandbox.folder() + "/" + moved).parent_path());
  fs::copy(sandbox.folder() + "/" + kValid + input.path, sandbox.folder() + "/" + moved,
           fs::copy_options::recursive);
  if (change == InputChange::kChanged) ChangeContents(sandbox.folder() + "/" + moved);
  std::vector<std::string> command = ResumeCommand(stored.run);
  command[input.word] = input.flag + moved;
  const std::set<std::string> before = ListCells(out, stored.run);
  Request request = MakeRequest(campaign, command);
  request.limits.seconds = kStoredSeconds;
  const Outcome outcome = sandbox.Run(request);
  const std::set<std::string> after = ListCells(out, stored.run);
  const bool has_cells = !before.empty();
  if (outcome.exit_code == 0) CheckProvenance(&sandbox);
  if (change == InputChange::kMoved) {
    if (outcome.exit_code != 0) sandbox.Fail("refused the same contents under another path");
    if (after != before) sandbox.Fail("took over no result of the same contents");
  } else if (outcome.exit_code == 0) {
    if (!has_cells) sandbox.Fail("continued with other contents");
    if (has_cells && after.size() < 2 * before.size()) sandbox.Fail("mixed results of two inputs");
  }
}

// A run on a disk of `kilobytes`, and again with room: what failed for want of it is computed.
void TryFullDisk(const Campaign& campaign, const StoredFolder& stored, int kilobytes,
                 Sandbox& sandbox) {
  fs::create_directories(sandbox.folder() + "/out");
  sandbox.Write("in/full.sh", "mount -t tmpfs -o size=" + std::to_string(kilobytes) +
                                  "k none out || exit 0\n\"$@\"\necho $? >in/first\n"
                                  "mount -o remount,size=64m out\n\"$@\" " +
                                  stored.run.resume +
                                  "\nresult=$?\ncp -r out kept\nexit $result\n");
  Request request = MakeRequest(campaign, stored.run.command);
  std::vector<std::string> command = {"/usr/bin/unshare", "-m", "bash", "in/full.sh"};
  command.insert(command.end(), request.command.begin(), request.command.end());
  request.command = command;
  request.limits.seconds = kStoredSeconds;
  const Outcome outcome = sandbox.Run(request, {.results = {"out", "kept", "in"}});
  if (!fs::exists(sandbox.folder() + "/kept")) return;  // no right to mount
  if (outcome.exit_code != 0) return sandbox.Fail("did not continue when there was room");
  fs::remove_all(sandbox.folder() + "/out");
  fs::rename(sandbox.folder() + "/kept", sandbox.folder() + "/out");
  CompareResults(stored.results, "", &sandbox);
}

using StoredRuns = std::vector<std::shared_ptr<LazyStored>>;

// The runs of AllResumableRuns; the classes of a campaign share them.
const StoredRuns& AllStored(const Campaign& campaign) {
  static const StoredRuns all = [&] {
    StoredRuns runs;
    for (const ResumableRun& run : AllResumableRuns())
      runs.push_back(std::make_shared<LazyStored>(campaign, run));
    return runs;
  }();
  return all;
}

}  // namespace

void AttackInputs(Campaign* campaign) {
  std::vector<Attack> inputs, disks;
  for (const std::shared_ptr<LazyStored>& stored : AllStored(*campaign)) {
    const ResumableRun& run = stored->run();
    for (const StoredInput& input : ListInputs(run.command))
      for (const auto& [change, name] :
           {std::pair{InputChange::kMoved, "moved"}, {InputChange::kChanged, "changed"}})
        inputs.push_back(
            {run.name + " " + input.flag + " " + name, [=, change = change](Sandbox& sandbox) {
               TryInput(*campaign, stored->Get(), input, change, sandbox);
             }});
    for (const int kilobytes : {8, 16, 24, 40, 64, 100, 160})
      disks.push_back(
          {run.name + ", a disk of " + std::to_string(kilobytes) + " kB, then room",
           [=](Sandbox& sandbox) { TryFullDisk(*campaign, stored->Get(), kilobytes, sandbox); }});
  }
  campaign->Run("inputs", std::move(inputs), kFewInputs);
  campaign->Run("disks", std::move(disks), kFewDisks);
}

void AttackStored(Campaign* campaign) {
  std::vector<Attack> attacks;
  StoredRuns runs = AllStored(*campaign);
  runs.resize(ResumableRuns().size());
  for (const std::shared_ptr<LazyStored>& lazy : runs) {
    const StoredFolder& stored = lazy->Get();
    const ResumableRun& run = stored.run;
    for (const std::string& named : run.stored) {
      const std::string file =
          named.ends_with("/") ? named + FirstFile(stored.folder + "/" + named) : named;
      const std::string text = ReadText(stored.folder + "/" + file);
      const bool is_cell = named.ends_with("/");
      // The result of a cell and a checkpoint have a checksum and are trusted: of a checkpoint only
      // damage is tried, which its checksum shows.
      const auto all = file == "checkpoint.json" ? TamperText(text, campaign->options().seed)
                                                 : TamperJson(text, campaign->options().seed);
      for (const Tampered& one : all)
        attacks.push_back({run.name + " " + file + ": " + one.what, [=](Sandbox& sandbox) {
                             const bool compare =
                                 !is_cell && file != "checkpoint.json" && !IsForgery(one.what);
                             TryStored(*campaign, stored, file, one.content, compare, sandbox);
                           }});
    }
  }
  campaign->Run("stored", std::move(attacks), kFewStored);
}

}  // namespace drape::attack
