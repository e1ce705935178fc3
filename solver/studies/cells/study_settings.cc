// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/cells/study_settings.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"

namespace drape {

void CheckStudySettings(const std::string& path, const std::map<std::string, std::string>& settings,
                        const std::string& runs) {
  if (!std::filesystem::exists(path)) return;
  const nlohmann::json stored = ParseJson(ReadOwnFile(path), path);
  const JsonInput input(stored, path);
  input.ExpectObject();
  for (const auto& [key, value] : settings) {
    if (!input.Has(key)) continue;
    const std::string before = input.At(key).String();
    if (before != value)
      throw InputError(path, "the " + runs + " there have " + key + " '" + before + "', found '" +
                                 value +
                                 "', expected the same: take another --out, or undo the change");
  }
}

void AddStudySettings(const std::string& path, const std::map<std::string, std::string>& settings) {
  nlohmann::json all =
      std::filesystem::exists(path) ? ParseJson(ReadOwnFile(path), path) : nlohmann::json::object();
  all.update(nlohmann::json(settings));
  WriteFileAtomically(path, all.dump(1) + "\n");
}

}  // namespace drape
