// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace drape {

// A piece of a workspace that is in use in the levels first … last.
struct UpdateBlock {
  std::int64_t size;
  int first, last;
};

struct UpdateSpace {
  std::vector<std::int64_t> offset;  // of each block
  std::int64_t size = 0;
};

// First fit: each block, by first level and then large ones first, where it fits below the others
// that are in use.
UpdateSpace PackUpdates(const std::vector<UpdateBlock>& blocks);

}  // namespace drape
