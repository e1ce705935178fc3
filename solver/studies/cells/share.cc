// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/cells/share.h"

#include <charconv>

#include "physics/util/errors.h"

namespace drape {
namespace {

std::optional<std::size_t> ParseCount(const char* begin, const char* end) {
  constexpr std::size_t kMost = 1'000'000;
  std::size_t count = 0;
  const auto [parsed, error] = std::from_chars(begin, end, count);
  if (error != std::errc() || parsed != end || count > kMost) return std::nullopt;
  return count;
}

}  // namespace

std::optional<Share> CellChoice::ParseShare() const {
  if (share.empty()) return std::nullopt;
  const char* const begin = share.data();
  const char* const end = begin + share.size();
  const std::size_t slash = share.find('/');
  if (slash != std::string::npos) {
    const auto index = ParseCount(begin, begin + slash);
    const auto count = ParseCount(begin + slash + 1, end);
    if (index && count && *index < *count) return Share{*index, *count};
  }
  throw InputError("option 'share'",
                   "found '" + share + "', expected i/n with whole numbers 0 ≤ i < n, such as 0/8");
}

std::string ListText(const std::vector<std::string>& cells, const std::optional<Share>& share) {
  std::string text;
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (!share || share->Has(k)) text += cells[k] + "\n";
  return text;
}

std::string ShareText(const std::string& share, std::size_t done, std::size_t cells) {
  return "share " + share + ": " + std::to_string(done) + " of " + std::to_string(cells) +
         " cells are complete; the same command without --share gathers all shares\n";
}

}  // namespace drape
