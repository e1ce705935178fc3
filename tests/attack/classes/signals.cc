// SPDX-License-Identifier: Apache-2.0
// SIGKILL, SIGINT and SIGTERM at random times; continued to the end, a run gives the same bytes as
// one that was not interrupted.
#include <signal.h>

#include <algorithm>
#include <random>
#include <stdexcept>

#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/resumable.h"
#include "tests/attack/inputs/valid_inputs.h"

namespace drape::attack {
namespace {

constexpr std::size_t kFewSignals = 6;  // of a short campaign
constexpr int kRepeats = 7;             // of a program and signal
constexpr int kMostStops = 3;           // of a run

struct WholeRun {
  const ResumableRun* run;
  FolderState results;
  double seconds = 0.0;
};

WholeRun RunWhole(const Campaign& campaign, const ResumableRun& run) {
  Sandbox sandbox(campaign.options().work + "/signals_good/" + run.name);
  const Outcome outcome = sandbox.Run(MakeRequest(campaign, run.command));
  if (outcome.exit_code != 0) throw std::runtime_error(run.name + " failed: " + outcome.err);
  return {&run, ReadFolder(sandbox.folder() + "/out"), outcome.seconds};
}

void CompareWith(const FolderState& expected, Sandbox* sandbox) {
  const FolderState found = ReadFolder(sandbox->folder() + "/out");
  for (const auto& [file, content] : expected) {
    if (!IsReproducible(file)) continue;
    const auto other = found.find(file);
    if (other == found.end())
      sandbox->Fail("did not write " + file);
    else if (WithoutTimes(file,
                          other->second.substr(std::min<std::size_t>(5, other->second.size()))) !=
             WithoutTimes(file, content.substr(std::min<std::size_t>(5, content.size()))))
      sandbox->Fail("wrote another " + file + " than the run that was not interrupted");
  }
  for (const auto& [file, content] : found)
    if (!expected.contains(file)) sandbox->Fail("left " + file);
}

void StopAndContinue(const Campaign& campaign, const WholeRun& whole, int signal, uint64_t seed,
                     Sandbox& sandbox) {
  std::mt19937_64 random(seed);
  const int stops = 1 + static_cast<int>(random() % kMostStops);
  Outcome outcome;
  for (int i = 0; i <= stops; ++i) {
    Request request =
        MakeRequest(campaign, i == 0 ? whole.run->command : ResumeCommand(*whole.run));
    request.limits.seconds = std::max(60.0, 20 * whole.seconds);
    if (i < stops) {
      const double part = static_cast<double>(random() % 1000) / 1000;
      request.signal = {signal, 1.1 * part * whole.seconds};
    }
    // Before it handles them, the other signals end it, too; it has then done nothing.
    outcome = sandbox.Run(request, {.may_be_killed = i < stops});
    if (i < stops && outcome.exit_code == 0) break;  // it was quicker
  }
  if (outcome.exit_code != 0) return sandbox.Fail("did not come to its end");
  CompareWith(whole.results, &sandbox);
}

}  // namespace

void AttackSignals(Campaign* campaign) {
  std::vector<WholeRun> wholes;
  for (const ResumableRun& run : ResumableRuns()) wholes.push_back(RunWhole(*campaign, run));
  std::vector<Attack> attacks;
  for (const WholeRun& whole : wholes)
    for (const int signal : {SIGKILL, SIGINT, SIGTERM})
      for (int i = 0; i < kRepeats; ++i) {
        const uint64_t seed = campaign->options().seed * 1000 + static_cast<uint64_t>(i);
        attacks.push_back(
            {whole.run->name + " signal " + std::to_string(signal) + ", " + std::to_string(i),
             [=](Sandbox& sandbox) { StopAndContinue(*campaign, whole, signal, seed, sandbox); }});
      }
  campaign->Run("signals", std::move(attacks), kFewSignals);
}

}  // namespace drape::attack
