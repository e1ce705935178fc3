// SPDX-License-Identifier: Apache-2.0
#include "physics/material/laws/law.h"

#include <vector>

#include "physics/material/material_io.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

std::vector<StretchNode> MakeNodes() {
  std::vector<StretchNode> nodes;
  nodes.reserve(kStrainNodes * kStrainNodes * kStrainNodes);
  for (int i = 0; i < kStrainNodes; ++i)
    for (int j = 0; j < kStrainNodes; ++j)
      for (int k = 0; k < kStrainNodes; ++k) nodes.push_back(MakeStretchNode(i, j, k));
  return nodes;
}

}  // namespace

ReferenceStretch::ReferenceStretch() {
  static const std::vector<StretchNode> nodes = MakeNodes();
  nodes_ = nodes.data();
}

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
