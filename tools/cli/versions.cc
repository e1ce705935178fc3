// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/versions.h"

#include <cholmod.h>

#include <Eigen/Core>

#include "physics/util/stored/build.h"

namespace drape {
namespace {

std::string Dotted(int major, int minor, int patch) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

}  // namespace

std::vector<std::pair<std::string, std::string>> Versions() {
  return {{"drapefit", BuildVersion()},
          {"commit", BuildCommit()},
          {"compiler", __VERSION__},
          {"eigen", Dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"cholmod", Dotted(CHOLMOD_MAIN_VERSION, CHOLMOD_SUB_VERSION, CHOLMOD_SUBSUB_VERSION)}};
}

}  // namespace drape
