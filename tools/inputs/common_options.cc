// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/common_options.h"

#include "tools/cli/field_options.h"

namespace drape {

Option OutOption(std::string& folder) {
  return {.key = "out",
          .value = &folder,
          .doc = "output folder, created if missing",
          .is_path = true,
          .required = true};
}

Option LawOption(std::string& law) {
  return {.key = "law",
          .value = &law,
          .doc = "constitutive law: how stiffness depends on strain and curvature",
          .choices = {"reference", "smooth"}};
}

Option LawOption(LawKind& law) {
  return EnumOption("law", law, "how stiffness follows from strain and curvature");
}

Option ThreadsOption(int& threads) {
  return {.key = "threads",
          .value = &threads,
          .doc = "number of parallel rollouts; 0: one for each core",
          .least = 0,
          .most = 1024};
}

Option MeshOption(const std::string& key, Option::Value mesh, const std::string& doc) {
  return {.key = key, .value = mesh, .doc = doc, .is_path = true, .words = {"disc:"}};
}

}  // namespace drape
