// SPDX-License-Identifier: Apache-2.0
#include "physics/material/laws/laws_reference.h"

#include <vector>

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

}  // namespace drape
