// SPDX-License-Identifier: Apache-2.0
#include "physics/util/text_format.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

namespace drape {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Format, IsThatOfPrintf) {
  EXPECT_EQ(Format("%5.2f|%-6.3g|%+e|%g", 1.005, 2.5, -3.0, 1e9),
            " 1.00|2.5   |-3.000000e+00|1e+09");
  EXPECT_EQ(Format("%d %+3d %u %x %c %%", -1, 2, 3u, 255u, 'z'), "-1  +2 3 ff z %");
  EXPECT_EQ(Format("%zu %td %ld %lld %08lx", std::size_t{1} << 40, std::ptrdiff_t{-5}, -1L,
                   1LL << 50, 0xabcul),
            "1099511627776 -5 -1 1125899906842624 00000abc");
  EXPECT_EQ(Format("%-8s|%.2s|%*d|%-*.*f|", "µ", "abc", 4, 7, 7, 1, 2.25),
            "µ      |ab|   7|2.2    |");
  EXPECT_EQ(Format("%s", std::string(1000, 'a').c_str()), std::string(1000, 'a'));
}

TEST(Format, ShowsNoNumberThatIsNotFinite) {
  EXPECT_EQ(Format("%g %e %f", kNan, kInfinity, -kInfinity), "none none none");
  EXPECT_EQ(Format("%8.3f|%-8.3g|%+08.1e|", kNan, -kNan, kInfinity), "    none|none    |    none|");
}

TEST(Utf8, IsToldFromOtherBytes) {
  EXPECT_TRUE(IsUtf8("a µ → 𝜃"));
  for (const char* wrong :
       {"\xff", "a\xc2", "\xe2\x82", "\xc0\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80"})
    EXPECT_FALSE(IsUtf8(wrong)) << wrong;
}

TEST(MakePrintable, LetsNothingThroughThatATerminalActsOn) {
  EXPECT_EQ(MakePrintable("µ → 'a`b'\n\tc"), "µ → 'a`b'\n\tc");
  EXPECT_EQ(MakePrintable("a\x1b[31mb\r\x07\x7f"), "a\\x1b[31mb\\x0d\\x07\\x7f");
  EXPECT_EQ(MakePrintable(std::string("\0", 1)), "\\x00");
  EXPECT_EQ(MakePrintable("\xff\xc2\x9b"), "\\xff\\xc2\\x9b");
  EXPECT_EQ(MakePrintable("a\u202eb\u2066c\u2030"), "a\\xe2\\x80\\xaeb\\xe2\\x81\\xa6c\u2030");
}

TEST(MakePrintable, ShortensLongWords) {
  const std::string word(5000, 'w');
  const std::string shown = MakePrintable("begin " + word + "end\nnext");
  EXPECT_LT(shown.size(), 250u);
  EXPECT_EQ(shown.substr(0, 8), "begin ww");
  EXPECT_EQ(shown.substr(shown.size() - 11), "wwwend\nnext");
  EXPECT_TRUE(IsUtf8(MakePrintable(std::string(1, 'a') + [] {
    std::string all;
    for (int i = 0; i < 1000; ++i) all += "µ";
    return all;
  }())));
  EXPECT_EQ(MakePrintable(std::string(200, 'w')), std::string(200, 'w'));
}

TEST(MakePrintableLine, IsOneShortLine) {
  EXPECT_EQ(MakePrintableLine("a\nb"), "a b");
  std::string many;
  for (int i = 0; i < 10000; ++i) many += "word ";
  EXPECT_LE(MakePrintableLine(many).size(), 390u);
}

TEST(FormatBeyond, TellsAValueFromItsLimit) {
  EXPECT_EQ(FormatBeyond(3.2, 3, 1), "3.2");
  EXPECT_EQ(FormatBeyond(3.04, 3, 1), "3.04");
  EXPECT_EQ(FormatBeyond(9.9999, 10, 0), "9.9999");
  EXPECT_EQ(FormatBeyond(3, 3, 0), "3.000000000000");
}

// Returns the words that a shell makes of a line.
TEST(ShellLine, IsReadAsItsWords) {
  EXPECT_EQ(ShellLine({"drape_fit", "--images=a.png"}), "drape_fit --images=a.png");
  for (const std::string& word :
       {std::string("it's"), std::string("$(touch x)"), std::string("`a`;b&|<>"),
        std::string("a\nb\t\x7f\xff\\"), std::string(""), std::string("\u202e"),
        std::string("#~*?[x]{a,b}!$'\""), std::string(300, 'L') + " "}) {
    const std::string line = ShellLine({"printf", "%s", word});
    const std::string command = "bash -c " + ShellLine({line});
    FILE* pipe = popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::string read(1000, ' ');
    read.resize(fread(read.data(), 1, read.size(), pipe));
    EXPECT_EQ(pclose(pipe), 0);
    EXPECT_EQ(read, word) << line;
  }
}

}  // namespace
}  // namespace drape
