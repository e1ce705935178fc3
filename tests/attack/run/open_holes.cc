// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/run/open_holes.h"

#include <algorithm>

namespace drape::attack {

const std::vector<OpenHole>& OpenHoles() {
  static const std::vector<OpenHole> kHoles = {};
  return kHoles;
}

const OpenHole* FindOpenHole(const std::string& attack, const std::vector<std::string>& reasons) {
  const OpenHole* found = nullptr;
  for (const std::string& reason : reasons) {
    const auto hole =
        std::find_if(OpenHoles().begin(), OpenHoles().end(), [&](const OpenHole& open) {
          return attack.find(open.attack) != std::string::npos &&
                 reason.find(open.reason) != std::string::npos;
        });
    if (hole == OpenHoles().end()) return nullptr;
    found = &*hole;
  }
  return found;
}

}  // namespace drape::attack
