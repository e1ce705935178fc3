// SPDX-License-Identifier: Apache-2.0
// Tampering with what programs store for themselves, with the checksum made right again.
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "physics/util/stored/stored_json.h"
#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/resumable.h"
#include "tests/physics/util/stored/tampering.h"

namespace drape::attack {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kFewStored = 30;   // of a short campaign
constexpr std::size_t kMostRules = 220;  // of a file
constexpr int kMutants = 40;             // of a checkpoint
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
  const ResumableRun* run;
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
  const Outcome whole = RunProgramIn(base, MakeRequest(campaign, run.command));
  if (whole.exit_code != 0) throw std::runtime_error(run.name + " failed: " + whole.err);
  StoredFolder stored{&run, base + "/out", ReadResults(base + "/out")};
  if (run.stored.front() == "checkpoint.json") {
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
  Request request = MakeRequest(campaign, ResumeCommand(*stored.run));
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

}  // namespace

void AttackStored(Campaign* campaign) {
  std::vector<Attack> attacks;
  for (const ResumableRun& run : ResumableRuns()) {
    const StoredFolder stored = MakeStored(*campaign, run);
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
