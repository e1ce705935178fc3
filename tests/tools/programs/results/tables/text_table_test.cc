// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/tables/text_table.h"

#include <gtest/gtest.h>

namespace drape::test {
namespace {

TextTable Example() {
  TextTable table({"step", "error", "ω² [1/s²]"});
  table.Add({"1e-03", "2.5e-07", "12.5 → 3"});
  table.Add({"1", "–"});
  return table;
}

TEST(TextTable, AlignsCharactersNotBytes) {
  EXPECT_EQ(Example().Aligned(),
            "step     error  ω² [1/s²]\n"
            "-------------------------\n"
            "1e-03  2.5e-07   12.5 → 3\n"
            "1            –\n");
}

TEST(TextTable, WritesMarkdown) {
  EXPECT_EQ(Example().Markdown(),
            "| step | error | ω² [1/s²] |\n"
            "|---|---|---|\n"
            "| 1e-03 | 2.5e-07 | 12.5 → 3 |\n"
            "| 1 | – | |\n");
}

}  // namespace
}  // namespace drape::test
