// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape::attack {

// Holes that are known and still open. A failure of one is counted and printed as open and does not
// fail the campaign. An entry goes when its hole is closed.
struct OpenHole {
  std::string attack;  // a part of the attack's "class: name"
  std::string reason;  // a part of the reason why it failed
  std::string hole;    // what is open
};

const std::vector<OpenHole>& OpenHoles();

// The hole that explains all reasons of a failure; nullptr: there is none.
const OpenHole* FindOpenHole(const std::string& attack, const std::vector<std::string>& reasons);

}  // namespace drape::attack
