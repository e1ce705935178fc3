// SPDX-License-Identifier: Apache-2.0
#include "losses/image/picture_parts.h"

#include <numeric>

#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr size_t kMaxRuns = size_t{1} << 21;

// The representative of run i: each run refers to an earlier one of its part, or to itself.
int Root(std::vector<PixelRun>& runs, int i) {
  while (runs[i].part != i) i = runs[i].part = runs[runs[i].part].part;
  return i;
}

void Unite(std::vector<PixelRun>& runs, int i, int j) {
  const int a = Root(runs, i), b = Root(runs, j);
  if (a < b) runs[b].part = a;
  if (b < a) runs[a].part = b;
}

void AddRuns(const PictureMask& mask, int row, uint8_t value, std::vector<PixelRun>* runs) {
  for (int col = 0; col < mask.width;) {
    if (mask.at(col, row) != value) {
      ++col;
      continue;
    }
    const int first = col;
    while (col < mask.width && mask.at(col, row) == value) ++col;
    runs->push_back({row, first, col, static_cast<int>(runs->size())});
  }
}

// Unites the runs [first, end) of a row with those of the row before it, [before, first).
void UniteWithRowBefore(int before, int first, int end, int reach, std::vector<PixelRun>* runs) {
  int above = before;
  for (int i = first; i < end; ++i) {
    while (above < first && (*runs)[above].end + reach <= (*runs)[i].first) ++above;
    for (int j = above; j < first && (*runs)[j].first < (*runs)[i].end + reach; ++j)
      Unite(*runs, i, j);
  }
}

// Numbers the parts in the order of their first runs and measures them.
std::vector<PicturePart> Measure(const PictureMask& mask, std::vector<PixelRun>* runs) {
  std::vector<PicturePart> parts;
  std::vector<int> number(runs->size());
  for (size_t i = 0; i < runs->size(); ++i) {
    const int root = Root(*runs, static_cast<int>(i));
    if (root == static_cast<int>(i)) {
      number[i] = static_cast<int>(parts.size());
      parts.emplace_back();
    }
    number[i] = number[root];
    const PixelRun& run = (*runs)[i];
    PicturePart& part = parts[number[i]];
    const int64_t pixels = run.end - run.first;
    part.pixels += pixels;
    part.column += 0.5 * (run.first + run.end - 1) * pixels;
    part.row += double(run.row) * pixels;
    part.touches_border |=
        run.row == 0 || run.row == mask.height - 1 || run.first == 0 || run.end == mask.width;
  }
  for (size_t i = 0; i < runs->size(); ++i) (*runs)[i].part = number[i];
  for (PicturePart& part : parts) {
    part.column /= part.pixels;
    part.row /= part.pixels;
  }
  return parts;
}

}  // namespace

int64_t CountPixels(const std::vector<PicturePart>& parts) {
  return std::accumulate(parts.begin(), parts.end(), int64_t{0},
                         [](int64_t sum, const PicturePart& part) { return sum + part.pixels; });
}

PictureParts FindParts(const PictureMask& mask, uint8_t value, Neighbours neighbours,
                       const std::string& where) {
  const int reach = neighbours == Neighbours::kEight ? 1 : 0;
  PictureParts found;
  int before = 0;
  for (int row = 0; row < mask.height; ++row) {
    const int first = static_cast<int>(found.runs.size());
    AddRuns(mask, row, value, &found.runs);
    if (found.runs.size() > kMaxRuns)
      throw InputError(where,
                       "is noise: more than 2 million changes between dark and light, "
                       "expected one piece of cloth");
    UniteWithRowBefore(before, first, static_cast<int>(found.runs.size()), reach, &found.runs);
    before = first;
  }
  found.parts = Measure(mask, &found.runs);
  return found;
}

}  // namespace drape
