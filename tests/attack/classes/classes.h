// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/attack/inputs/readers/readers.h"
#include "tests/attack/run/campaign.h"

namespace drape::attack {

// Each runs the attacks of one class.
void AttackOptions(Campaign* campaign);     // each option of each program
void AttackFiles(Campaign* campaign);       // bad files of each kind
void AttackImages(Campaign* campaign);      // damaged and misleading pictures
void AttackMutants(Campaign* campaign);     // each reader in process, with random damage
void AttackRefused(Campaign* campaign);     // each reader and program, with what it must refuse
void AttackStored(Campaign* campaign);      // tampering with stored files
void AttackInputs(Campaign* campaign);      // changed inputs of what is stored, and full disks
void AttackSystem(Campaign* campaign);      // surroundings, links, names
void AttackSignals(Campaign* campaign);     // stopped at random times and continued
void AttackInterrupts(Campaign* campaign);  // SIGINT and SIGTERM in every program

// The readers that are called in this process.
std::vector<Reader> MakeAllReaders(const CampaignOptions& options);

// Hostile names of inputs and output folders, of the class "system".
void AddHostileNames(Campaign* campaign, std::vector<Attack>* attacks);

struct AttackClass {
  std::string name;
  void (*run)(Campaign*);
};
const std::vector<AttackClass>& AttackClasses();

// One file by the reader of a mutant, in this process; what is wrong. Throws InputError when there
// is no such reader.
std::vector<std::string> ReadOnce(const CampaignOptions& options, const std::string& reader,
                                  const std::string& path);

// Puts earlier results into "out", which no refused run may touch.
void AddEarlierResults(Sandbox* sandbox);

// The request for a command whose program is without folder.
Request MakeRequest(const Campaign& campaign, std::vector<std::string> command);

}  // namespace drape::attack
