// SPDX-License-Identifier: Apache-2.0
// SIGINT and SIGTERM at random times in every program, with earlier results in its folder. It ends
// within two seconds with exit code 130, and leaves the earlier results or a valid partial result.
#include <signal.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "physics/util/text_format.h"
#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/valid_inputs.h"

namespace drape::attack {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewInterrupts = 3;  // of a short campaign
constexpr int kTrials = 5;                 // of a program and signal
constexpr double kLongest = 4.0;           // until the signal [s]
constexpr double kPromised = 2.0;          // from the signal to the end [s]
constexpr double kMargin = 0.2;            // of the attack's own polls [s]
constexpr double kPatience = 20.0;         // then the program is killed [s]

// Surroundings of the run.
enum class Around {
  kNothing,
  kEarlyThread,  // a library has started a thread before main, as OpenBLAS does
  kStuckOut,     // nobody reads the output
  kStuckErr      // nobody reads the messages
};

struct Victim {
  std::vector<std::string> earlier;  // what made its folder; empty: nothing
  std::vector<std::string> command;  // takes many seconds
};

// A quick command of each program with what makes it long; options that are given twice are
// errors, so that a changed one replaces the quick one.
std::vector<std::string> Longer(const std::string& program, const std::vector<std::string>& more) {
  std::vector<std::string> command = QuickCommand(program);
  for (const std::string& option : more) {
    command = WithoutOption(command, option.substr(0, option.find('=')));
    command.push_back(option);
  }
  return command;
}

std::vector<Victim> Victims(const Campaign& campaign) {
  const std::string material = std::string("--fabric=") + kValid + "wool.json";
  const std::string picture = std::string(kValid) + "drape.png";
  const std::vector<std::string> quick_fit = Longer("drape_fit", {"--out=fit"});
  std::vector<Victim> victims;
  const auto add = [&](const std::string& program, const std::vector<std::string>& more) {
    victims.push_back({QuickCommand(program), Longer(program, more)});
  };
  add("drape_simulate", {"--mesh=disc:3000", "--steps=20000", "--time_step=0.01"});
  add("drape_fit", {"--model=bayes", "--mesh=disc:600", "--coarse_mesh=disc:300",
                    "--candidates_per_round=6,3", "--iterations=20,20", "--threads=2"});
  add("drape_metrics", {});
  add("drape_equilibria", {"--mesh=disc:600", "--samples=1000", "--threads=2"});
  add("drape_predict", {"--mesh=disc:600", "--draws=1000", "--threads=2"});
  add("drape_check", {"--mesh=disc:3000", "--steps=50"});
  add("drape_compare", {"--models=homogeneous,isotropic", "--mesh=disc:300", "--iterations=20,20",
                        "--candidates_per_round=6,3", "--draws=64"});
  add("drape_bench", {"--mesh=disc:600,disc:900", "--repeats=9"});
  add("drape_speed", {"--mesh=disc:3000", "--steps=1000"});
  add("drape_stability", {"--mesh=disc:600", "--duration=50", "--threads=2"});
  add("drape_gradients", {"--mesh=disc:600", "--horizons=1,100,400"});
  add("drape_space", {});
  add("drape_garment", {"--edge=0.04", "--seconds=2"});
  add("drape_compare_optimisers", {"--methods=lm,cmaes,bo", "--budget=400", "--mesh=disc:300"});
  victims.push_back({quick_fit, {"drape_report", "fit", "--out=out/report.html"}});
  victims.push_back({{}, {"drape_export", material, "--to=all", "--out=out"}});
  victims.push_back({{}, {"drapefit", picture, "--mass=150", "--threads=2", "--out=out"}});
  if (fs::exists(campaign.Program("drape_photo")))
    victims.push_back({{},
                       {"drape_photo", std::string(kValid) + "photograph.png", "--marker=none",
                        "--px_per_m=2400", "--out=out"}});
  return victims;
}

bool MayChange(const std::string& path, const std::string& err) {
  if (err.find("earlier files are unchanged") == std::string::npos) return true;
  for (const char* part : {"checkpoint", "cells", "fabric_", "pool", "steps.json", ".log", "trace"})
    if (path.find(part) != std::string::npos) return true;
  return false;
}

void JudgeAnswer(const Outcome& outcome, Sandbox* sandbox) {
  if (outcome.hung) return sandbox->Fail(Format("did not end within %g s", kPatience));
  // A busy machine gives a program a share of its processors.
  const double allowed =
      kPromised * test::kSlowdown * std::max(1.0, outcome.waiting_per_core) + kMargin;
  if (outcome.answer_seconds > allowed)
    sandbox->Fail(
        Format("ended %.2f s after the signal, allowed %.2f s", outcome.answer_seconds, allowed));
  if (outcome.signal != 0 && outcome.was_caught)
    sandbox->Fail(std::string("was ended by ") + strsignal(outcome.signal));
  if (outcome.signal == 0 && outcome.exit_code != 0 && outcome.exit_code != 130)
    sandbox->Fail("ended with exit code " + std::to_string(outcome.exit_code) + ": " + outcome.err);
}

void JudgeResults(const FolderState& before, const Outcome& outcome, Sandbox* sandbox) {
  const FolderState after = ReadFolder(sandbox->folder());
  for (const auto& [path, content] : before)
    if (!after.contains(path))
      sandbox->Fail("lost " + path);
    else if (after.at(path) != content && !MayChange(path, outcome.err))
      sandbox->Fail("changed " + path + ", and says that it did not");
  for (const auto& [path, content] : after)
    if (path.ends_with(".json") && content.starts_with("file ") &&
        nlohmann::json::parse(content.substr(5), nullptr, false, true).is_discarded())
      sandbox->Fail("left a half " + path);
}

void Interrupt(const Campaign& campaign, const Victim& victim, Around around, int signal,
               double after, Sandbox& sandbox) {
  fs::create_directories(sandbox.folder() + "/out");
  if (!victim.earlier.empty())
    sandbox.Run(MakeRequest(campaign, victim.earlier), {.results = {"."}});
  Request request = MakeRequest(campaign, victim.command);
  request.signal = {signal, after, kPatience};
  request.limits.seconds = 10 * kPatience;
  if (around == Around::kEarlyThread) request.environment["LD_PRELOAD"] = EARLY_THREAD;
  if (around == Around::kStuckOut) request.out = Stream::kStuck;
  if (around == Around::kStuckErr) request.err = Stream::kStuck;
  const FolderState before = ReadFolder(sandbox.folder());
  const Outcome outcome = sandbox.Run(request, {.results = {"."}, .may_be_killed = true});
  JudgeAnswer(outcome, &sandbox);
  JudgeResults(before, outcome, &sandbox);
  if (!sandbox.reasons().empty()) sandbox.Write("threads.txt", outcome.threads);
}

}  // namespace

void AttackInterrupts(Campaign* campaign) {
  std::mt19937_64 random(campaign->options().seed);
  std::vector<Attack> attacks;
  for (const Victim& victim : Victims(*campaign))
    for (const int signal : {SIGINT, SIGTERM})
      for (int i = 0; i < kTrials + 3; ++i) {
        const Around around = i < kTrials ? Around::kNothing : Around(i - kTrials + 1);
        if (around == Around::kEarlyThread && !test::kCanLimitMemory) continue;  // of a sanitizer
        // Half of them come in the first second: that has most stages.
        const double part = static_cast<double>(random() % 1000) / 1000;
        const double after = kLongest * part * part * test::kSlowdown;
        static const char* const kAround[] = {"", ", a thread before main", ", nobody reads stdout",
                                              ", nobody reads stderr"};
        attacks.push_back(
            {Format("%s, %s after %.3f s%s", victim.command[0].c_str(),
                    signal == SIGINT ? "SIGINT" : "SIGTERM", after, kAround[int(around)]),
             [=](Sandbox& sandbox) {
               Interrupt(*campaign, victim, around, signal, after, sandbox);
             }});
      }
  campaign->Run("interrupts", std::move(attacks), kFewInterrupts);
}

}  // namespace drape::attack
