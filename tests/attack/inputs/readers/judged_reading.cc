// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/readers/judged_reading.h"

#include <exception>
#include <filesystem>

#include "physics/util/errors.h"
#include "tests/attack/run/judge.h"

namespace drape::attack {

std::vector<std::string> ReadDamaged(const Reader& reader, const std::string& path, bool* refused) {
  try {
    const std::string wrong = reader.read(path);
    return wrong.empty() ? std::vector<std::string>() : std::vector<std::string>{wrong};
  } catch (const InputError& error) {
    if (refused != nullptr) *refused = true;
    const std::string name = std::filesystem::path(path).filename();
    return JudgeMessage(Visible(error.what()), {name, "option 'accuracy'"});
  } catch (const std::exception& error) {
    return {std::string("threw another error than InputError: ") + error.what()};
  }
}

}  // namespace drape::attack
