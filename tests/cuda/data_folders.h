// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

// Where a test or benchmark finds its files, also when it runs from a bundle (tools/bundle
// --tests).
namespace drape::test {

// The folder that the environment names; otherwise ../<name> beside the folder of this program, if
// it exists; otherwise that of the build.
inline std::string FindDataFolder(const char* variable, const std::string& name,
                                  const std::string& of_build) {
  if (const char* named = std::getenv(variable)) return named;
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto beside = program.parent_path().parent_path() / name;
  return !error && std::filesystem::is_directory(beside, error) ? beside.string() : of_build;
}

// The folder with fabrics/ and starts/; $DRAPE_CONFIGS overrides it.
inline std::string ConfigsFolder() {
  return FindDataFolder("DRAPE_CONFIGS", "configs", DRAPE_SOURCE_DIR "/configs");
}

#ifdef DRAPE_SHARED_DIR
// The folder with golden/ and cusick/, the public test data; $DRAPE_SHARED overrides it.
inline std::string SharedFolder() {
  return FindDataFolder("DRAPE_SHARED", "shared", DRAPE_SHARED_DIR);
}
#endif

}  // namespace drape::test
