// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace drape {

// The independent runs of a study are its cells, numbered from 0 in a fixed order. Processes on one
// machine or on many divide them: share i of n are the cells k with k mod n = i. Each cell has
// files of its own in the output folder of the study, which are written atomically, so that
// disjoint shares need no locks. A process without a share takes the finished cells over, runs
// those that are missing, and writes the tables.
struct Share {
  std::size_t index = 0, count = 1;

  bool Has(std::size_t cell) const { return cell % count == index; }
};

// What a user of a study asks for: its cells' names, a share of them, or all and the tables.
struct CellChoice {
  bool list = false;
  std::string share;  // "i/n", 0 ≤ i < n; empty: all

  // None where all cells are asked for. Throws InputError.
  std::optional<Share> ParseShare() const;
};

// One name a line, of the cells of the share or of all.
std::string ListText(const std::vector<std::string>& cells, const std::optional<Share>& share);

// "share 1/3: 4 of 5 cells are complete; …": what a process that runs a share has to say.
std::string ShareText(const std::string& share, std::size_t done, std::size_t cells);

}  // namespace drape
