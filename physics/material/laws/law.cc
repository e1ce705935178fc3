// SPDX-License-Identifier: Apache-2.0
#include "physics/material/laws/law.h"

#include "physics/util/errors.h"

namespace drape {

Law MakeLaw(const std::string& name) {
  if (name == "smooth") return {SmoothStretch(), SmoothBend()};
  if (name == "reference") return {ReferenceStretch(), ReferenceBend()};
  throw InputError("law", "unknown name '" + name + "', expected reference or smooth");
}

MaterialPolicy ReadingPolicy(const Law& law, double min_relative_stiffness) {
  return {law.rejects_negative_entries() ? NegativeEntries::kReject : NegativeEntries::kWarn,
          min_relative_stiffness};
}

}  // namespace drape
