// SPDX-License-Identifier: Apache-2.0
#include "physics/util/stored/csv_log.h"

#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"
#include "tests/physics/util/stored/tampering.h"

namespace drape {
namespace {

class CsvLogTest : public FileFixture {
 protected:
  std::vector<CsvRow> ReadRows() const {
    std::vector<CsvRow> rows;
    for (const NumberedCsvRow& row : ReadCsvLog(path_, kShared, columns_))
      rows.push_back(row.fields);
    return rows;
  }
  static constexpr char kShared[] = "mesh=disc:100";
  const CsvRow columns_ = {"name", "x", "y"};
  const std::vector<CsvRow> rows_ = {
      {"plain", "1", ""}, {"a, \"b\"\nc", "2", "3"}, {"\"", "", "\r"}, {"ä", "4", "5"}};
  const std::string path_ = Path("runs.csv");
};

TEST_F(CsvLogTest, IsReadBack) {
  WriteCsvLog(path_, kShared, columns_, {rows_[0]});
  for (int i = 1; i < 4; ++i) AppendCsvRow(path_, rows_[i]);
  EXPECT_EQ(ReadRows(), rows_);
  EXPECT_EQ(ReadCsvLog(path_, kShared, columns_)[2].where, path_ + ":6");  // a row has two lines
  EXPECT_EQ(FormatCsvRow(rows_[1]), "\"a, \"\"b\"\"\nc\",2,3");            // RFC 4180
  for (const CsvRow& row : rows_) EXPECT_EQ(ParseCsvRow(FormatCsvRow(row), "row"), row);
}

TEST_F(CsvLogTest, AnUnfinishedRowIsDropped) {
  WriteCsvLog(path_, kShared, columns_, rows_);
  const std::string whole = Read(path_);
  const std::size_t head = whole.find("plain");
  for (std::size_t size = head; size <= whole.size(); ++size) {
    test::WriteQuickly(path_, whole.substr(0, size));
    const std::vector<CsvRow> rows = ReadRows();
    ASSERT_LE(rows.size(), 4u);
    EXPECT_TRUE(std::equal(rows.begin(), rows.end(), rows_.begin())) << size;
    EXPECT_EQ(rows.size() == 4, size == whole.size());
  }
}

TEST_F(CsvLogTest, DamageIsNamed) {
  WriteCsvLog(path_, "other", columns_, rows_);
  EXPECT_INPUT_ERROR(ReadRows(), "runs.csv:1: found '# other', expected '# mesh=disc:100'");
  WriteCsvLog(path_, kShared, {"name"}, {});
  EXPECT_INPUT_ERROR(ReadRows(), "runs.csv:2: found other columns than those of this program");
  WriteCsvLog(path_, kShared, columns_, {{"a", "b"}});
  EXPECT_INPUT_ERROR(ReadRows(), "runs.csv:3: found 2 fields, expected 3");
  WriteCsvLog(path_, kShared, columns_, {});
  Write("runs.csv", Read(path_) + "a\"b,1,2\n");
  EXPECT_INPUT_ERROR(ReadRows(), "runs.csv:3: found a quotation mark within a field");
  EXPECT_INPUT_ERROR(ParseCsvRow("\"a", "row"), "row: found a field whose quotation mark");
  EXPECT_INPUT_ERROR(ParseCsvNumber("nan", "row"), "row: found 'nan', expected a number");
  EXPECT_IO_ERROR(AppendCsvRow(Path("no/runs.csv"), {"a"}), "no/runs.csv: cannot be written");
}

TEST_F(CsvLogTest, NoMutantIsMoreThanRowsOrAnError) {
  WriteCsvLog(path_, kShared, columns_, rows_);
  const std::string whole = Read(path_);
  std::mt19937_64 random(1);
  for (int i = 0; i < test::NumMutants(2000); ++i) {
    test::WriteQuickly(path_, test::Mutant(whole, random));
    try {
      for (const CsvRow& row : ReadRows()) EXPECT_EQ(row.size(), 3u);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("runs.csv"));
    }
  }
}

}  // namespace
}  // namespace drape
