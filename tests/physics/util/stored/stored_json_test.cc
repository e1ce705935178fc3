// SPDX-License-Identifier: Apache-2.0
#include "physics/util/stored/stored_json.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/physics/file_fixture.h"
#include "tests/physics/util/stored/tampering.h"

namespace drape {
namespace {

constexpr StoredFormat kFormat = {"drapefit-test", 3};

class StoredJsonTest : public FileFixture {
 protected:
  const nlohmann::json members_ = {{"numbers", {1.0 / 3, -0.0, 1e-320, 5}},
                                   {"text", "\"ä\n"},
                                   {"none", std::numeric_limits<double>::infinity()}};
  const std::string path_ = Path("a.json");
};

TEST_F(StoredJsonTest, ReadsBackBitForBit) {
  WriteStoredJson(path_, kFormat, members_);
  const nlohmann::json read = ReadStoredJson(path_, kFormat);
  EXPECT_EQ(read.dump(), members_.dump());
  EXPECT_TRUE(std::signbit(read["numbers"][1].get<double>()));
  EXPECT_EQ(read["numbers"][2].get<double>(), 1e-320);
}

TEST_F(StoredJsonTest, OtherFilesAreRefused) {
  WriteStoredJson(path_, kFormat, members_);
  EXPECT_INPUT_ERROR(ReadStoredJson(path_, {"drapefit-other", 3}),
                     "a.json: key 'format': found \"drapefit-test\", expected \"drapefit-other\"");
  EXPECT_INPUT_ERROR(ReadStoredJson(path_, {"drapefit-test", 4}),
                     "a.json: is of another version of the program");
  Write("a.json", R"({"format": "drapefit-test", "numbers": []})");  // before there were versions
  EXPECT_INPUT_ERROR(ReadStoredJson(path_, kFormat), "is of another version of the program");
  Write("a.json", "[]");
  EXPECT_INPUT_ERROR(ReadStoredJson(path_, kFormat), "a.json: found an array of 0");
  EXPECT_INPUT_ERROR(ReadStoredJson(Path("absent.json"), kFormat), "absent.json");
}

TEST_F(StoredJsonTest, AnyChangedContentIsRefused) {
  const std::string whole = StoredJsonText(kFormat, members_);
  std::mt19937_64 random(1);
  int same = 0;
  for (int i = 0; i < test::NumMutants(2000); ++i) {
    test::WriteQuickly(path_, test::Mutant(whole, random));
    try {
      EXPECT_EQ(ReadStoredJson(path_, kFormat).dump(), members_.dump()) << Read(path_);
      ++same;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("a.json"));
    }
  }
  EXPECT_LT(same, test::NumMutants(2000) / 10);  // a space more or less
}

}  // namespace
}  // namespace drape
