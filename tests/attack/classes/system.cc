// SPDX-License-Identifier: Apache-2.0
// What the system does to a program: no Python, no temporary folder, full or closed streams,
// limits, a full disk, another locale; links and other runs in the output folder; hostile names.
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/resumable.h"
#include "tests/attack/inputs/valid_inputs.h"

namespace drape::attack {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewSystem = 20;  // of a short campaign
constexpr double kSystemSeconds = 30.0;
constexpr char kVictim[] = "in/victim.txt";

Request MakeSystemRequest(const Campaign& campaign, const std::string& program,
                          const std::vector<std::string>& more = {}) {
  Request request = MakeRequest(campaign, QuickCommand(program, more));
  request.environment.erase("PYTHONPATH");
  request.limits.seconds = kSystemSeconds;
  return request;
}

// One change of the surroundings of a run.
struct Surrounding {
  std::string name;
  std::function<void(Request*)> change;
  Expectation expectation = {};
};

std::vector<Surrounding> Environments() {
  const auto set = [](const std::string& key, const std::string& value) {
    return [=](Request* request) { request->environment[key] = value; };
  };
  const auto unset = [](const std::string& key) {
    return [=](Request* request) { request->environment[key] = std::nullopt; };
  };
  const Expectation taken{.verdict = Verdict::kTaken};
  std::vector<Surrounding> all = {
      {"no programs", set("PATH", "/no/such/folder"), taken},
      {"a Python that fails", set("PYTHONHOME", "/no/such/folder"), taken},
      {"no temporary folder", set("TMPDIR", "/no/such/folder"), taken},
      {"a file as temporary folder", set("TMPDIR", "/dev/null"), taken},
      {"no home", unset("HOME"), taken},
      {"no TMPDIR", unset("TMPDIR"), taken},
      {"a zone that is none", set("TZ", ":/dev/zero"), taken},
      {"columns of a terminal", set("COLUMNS", "-1"), taken},
      {"1000 threads by OMP_NUM_THREADS", set("OMP_NUM_THREADS", "1000"), taken},
      {"negative OMP_NUM_THREADS", set("OMP_NUM_THREADS", "-7"), taken}};
  for (const char* locale : {"de_DE.UTF-8", "tr_TR.UTF-8", "no_such", "C", "\x1b[31m"})
    all.push_back({std::string("locale ") + locale, set("LC_ALL", locale), taken});
  return all;
}

// Results are complete before what a program prints is lost.
std::vector<Surrounding> Streams() {
  const Expectation lost{.keeps_results = false};
  const Expectation broken{.keeps_results = false, .may_be_killed = true};  // by SIGPIPE
  const auto out = [](Stream stream) { return [=](Request* r) { r->out = stream; }; };
  const auto err = [](Stream stream) { return [=](Request* r) { r->err = stream; }; };
  return {{"stdin closed", [](Request* r) { r->input = false; }, {.verdict = Verdict::kTaken}},
          {"stdout closed", out(Stream::kClosed), lost},
          {"stdout full", out(Stream::kFull), lost},
          {"stdout broken", out(Stream::kBroken), broken},
          {"stderr closed", err(Stream::kClosed), {.verdict = Verdict::kTaken}},
          {"stderr full", err(Stream::kFull), {.verdict = Verdict::kTaken}},
          {"stderr broken", err(Stream::kBroken), broken},
          {"all closed",
           [](Request* r) {
             r->input = false;
             r->out = r->err = Stream::kClosed;
           },
           lost}};
}

std::vector<Surrounding> SmallLimits() {
  std::vector<Surrounding> all;
  for (const double gigabytes : {0.06, 0.08, 0.1, 0.13, 0.16, 0.2, 0.3})
    all.push_back({"memory of " + std::to_string(gigabytes) + " GB",
                   [=](Request* r) { r->limits.memory_gb = gigabytes; },
                   // The loader ends a program that does not fit. Memory may end in mid-work.
                   {.keeps_results = false, .may_be_killed = true}});
  for (const int files : {6, 8, 10, 16})
    all.push_back({std::to_string(files) + " files",
                   [=](Request* r) { r->limits.files = files; },
                   {.keeps_results = false}});
  for (const long bytes : {1000L, 5000L, 20000L, 100000L})
    all.push_back({"files of " + std::to_string(bytes) + " bytes",
                   [=](Request* r) { r->limits.file_bytes = bytes; },
                   {.keeps_results = false}});
  return all;
}

void TrySurrounding(const Campaign& campaign, const std::string& program,
                    const Surrounding& surrounding, Sandbox& sandbox) {
  AddEarlierResults(&sandbox);
  Request request = MakeSystemRequest(campaign, program);
  surrounding.change(&request);
  const Outcome outcome = sandbox.Run(request, surrounding.expectation);
  const bool lost = request.out == Stream::kFull && outcome.exit_code == 0;
  const bool only_prints = program == "drape_check" || program == "drape_metrics";
  if (lost && only_prints) sandbox.Fail("said nothing of the output that it could not print");
}

void AddSurroundings(Campaign* campaign, std::vector<Attack>* attacks) {
  for (const auto& surroundings : {Environments(), Streams(), SmallLimits()})
    for (const Surrounding& surrounding : surroundings)
      for (const std::string& program : ProgramNames())
        attacks->push_back({program + ", " + surrounding.name, [=](Sandbox& sandbox) {
                              TrySurrounding(*campaign, program, surrounding, sandbox);
                            }});
}

// A disk of 64 kB in a mount of the run's own; needs rights that not every machine gives.
bool CanMount() { return std::system("unshare -m true >/dev/null 2>&1") == 0; }

void TryFullDisk(const Campaign& campaign, const std::string& program, Sandbox& sandbox) {
  AddEarlierResults(&sandbox);
  sandbox.Write("in/full.sh",
                "mount -t tmpfs -o size=64k none out || exit 0\n"
                "echo earlier >out/summary.json\n"
                "head -c 45000 /dev/zero >out/notes.txt\n\"$@\"\nresult=$?\n"
                "[ $result = 0 ] || [ \"$(cat out/summary.json)\" = earlier ] || exit 99\n"
                "exit $result\n");
  Request request = MakeSystemRequest(campaign, program);
  std::vector<std::string> command = {"/usr/bin/unshare", "-m", "bash", "in/full.sh"};
  command.insert(command.end(), request.command.begin(), request.command.end());
  request.command = command;
  sandbox.Run(request);
}

// What lies in the output folder before a run.
struct Prepared {
  std::string name;
  std::function<void(const std::string& out)> prepare;
  bool refused = false;
};

std::vector<Prepared> PreparedFolders() {
  const auto link = [](const std::string& name, const std::string& target) {
    return [=](const std::string& out) { fs::create_symlink(target, out + "/" + name); };
  };
  const auto folder = [](const std::string& name) {
    return [=](const std::string& out) { fs::create_directories(out + "/" + name + "/below"); };
  };
  std::vector<Prepared> all;
  for (const char* name :
       {"summary.json", "fit.log", "drape.obj", "silhouette.png", "material.json", "runs.csv",
        "stability.json", "checkpoint.json", "metrics.json", "settings.json", "bench.json"}) {
    all.push_back({std::string("link ") + name, link(name, "../in/victim.txt")});
    all.push_back({std::string("link to nothing ") + name, link(name, "../in/PLANTED")});
    all.push_back({std::string("folder ") + name, folder(name)});
  }
  all.push_back({"a link to itself", link("summary.json", "summary.json")});
  all.push_back({"stale staging", [](const std::string& out) {
                   for (int pid = 1; pid < 40; ++pid) {
                     const std::string staging = out + "/.drapefit_" + std::to_string(pid);
                     fs::create_directories(staging);
                   }
                 }});
  return all;
}

void TryPrepared(const Campaign& campaign, const std::string& program, const Prepared& prepared,
                 Sandbox& sandbox) {
  sandbox.Write(kVictim, "of somebody else");
  sandbox.Write("out/notes.txt", "earlier");
  prepared.prepare(sandbox.folder() + "/out");
  sandbox.Run(MakeSystemRequest(campaign, program));
}

void TryTwoAtOnce(const Campaign& campaign, const ResumableRun& run, Sandbox& sandbox) {
  const Request request = MakeRequest(campaign, run.command);
  Outcome outcomes[2];
  std::thread other([&] { outcomes[0] = RunProgramIn(sandbox.folder(), request); });
  outcomes[1] = RunProgramIn(sandbox.folder(), request);
  other.join();
  const FolderState after = ReadFolder(sandbox.folder());
  for (const Outcome& outcome : outcomes)
    for (const std::string& reason : JudgeRun(request, outcome, {.keeps_results = false},
                                              {{"tmp", "folder"}, {"home", "folder"}}, after))
      sandbox.Fail(reason);
  for (const auto& [path, content] : after)
    if (fs::path(path).extension() == ".json" &&
        nlohmann::json::parse(content.substr(5), nullptr, false).is_discarded())
      sandbox.Fail("left half of " + path);
}

}  // namespace

void AttackSystem(Campaign* campaign) {
  std::vector<Attack> attacks;
  AddSurroundings(campaign, &attacks);
  AddHostileNames(campaign, &attacks);
  for (const std::string& program : ProgramNames()) {
    if (CanMount())
      attacks.push_back({program + ", full disk",
                         [=](Sandbox& sandbox) { TryFullDisk(*campaign, program, sandbox); }});
    for (const Prepared& prepared : PreparedFolders())
      attacks.push_back({program + ", " + prepared.name, [=](Sandbox& sandbox) {
                           TryPrepared(*campaign, program, prepared, sandbox);
                         }});
  }
  for (const ResumableRun& run : ResumableRuns())
    attacks.push_back({run.name + " twice at once",
                       [=](Sandbox& sandbox) { TryTwoAtOnce(*campaign, run, sandbox); }});
  campaign->Run("system", std::move(attacks), kFewSystem);
}

}  // namespace drape::attack
