// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/classes/classes.h"

#include <utility>

namespace drape::attack {

const std::vector<AttackClass>& AttackClasses() {
  static const std::vector<AttackClass> kClasses = {
      {"options", AttackOptions},      {"files", AttackFiles},     {"images", AttackImages},
      {"mutants", AttackMutants},      {"refused", AttackRefused}, {"stored", AttackStored},
      {"inputs", AttackInputs},        {"system", AttackSystem},   {"signals", AttackSignals},
      {"interrupts", AttackInterrupts}};
  return kClasses;
}

void AddEarlierResults(Sandbox* sandbox) {
  for (const char* name : {"out/summary.json", "out/drape.obj", "out/notes.txt"})
    sandbox->Write(name, "earlier");
}

Request MakeRequest(const Campaign& campaign, std::vector<std::string> command) {
  command.front() = campaign.Program(command.front());
  Request request{.command = std::move(command)};
  if (!campaign.options().thorough)
    request.environment["PYTHONPATH"] = campaign.options().sources + "/tests/tools/without_charts";
  return request;
}

}  // namespace drape::attack
