// SPDX-License-Identifier: Apache-2.0
#include "tools/check_report.h"

#include <algorithm>
#include <cstdio>

namespace drape {

void PrintCheckTable(const std::vector<CheckRow>& rows) {
  std::printf("%-10s %-58s %9s %9s\n", "group", "check (relative errors)", "value", "bound");
  for (const CheckRow& row : rows) {
    std::printf("%-10s %-58s %9.1e ", row.group.c_str(), row.name.c_str(), row.value);
    if (row.has_bound()) {
      std::printf("%9.0e  %s\n", row.bound, row.ok() ? "ok" : "FAIL");
    } else {
      std::printf("%9s\n", "-");
    }
  }
  const auto bounded =
      std::count_if(rows.begin(), rows.end(), [](auto& row) { return row.has_bound(); });
  const auto failed = std::count_if(rows.begin(), rows.end(), [](auto& row) { return !row.ok(); });
  std::printf("%td of %td checks failed\n", failed, bounded);
}

}  // namespace drape
