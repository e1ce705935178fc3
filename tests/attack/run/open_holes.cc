// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/run/open_holes.h"

#include <algorithm>

namespace drape::attack {

const std::vector<OpenHole>& OpenHoles() {
  static const std::vector<OpenHole> kHoles = {
      {"", "echoes control bytes", "names and values are printed raw"},
      {"", "the error has", "long names and values are printed whole"},
      {"", "nan or inf", "nan and inf are printed"},
      {"NUL and text after it", "took a bad input", "text after a NUL byte is ignored"},
      {"", "does not name", "std::bad_alloc names nothing"},
      {"drape_compare_optimisers", "was refused, but changed",
       "folders are made before all is read"},
      {"drape_bench", "was refused, but changed", "runs.csv is made before all is read"}};
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
