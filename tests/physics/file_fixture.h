// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "physics/util/errors.h"

// Expects that `statement` throws an InputError whose one-line message contains `text`.
#define EXPECT_INPUT_ERROR(statement, text)                                \
  try {                                                                    \
    statement;                                                             \
    ADD_FAILURE() << "no InputError, expected: " << (text);                \
  } catch (const ::drape::InputError& error) {                             \
    EXPECT_THAT(error.what(), ::testing::HasSubstr(text));                 \
    EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("\n"))); \
  }

namespace drape {

// A new folder for each test, removed at its end.
class FileFixture : public ::testing::Test {
 protected:
  FileFixture() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(::testing::TempDir()) /
              (std::string("drape_") + info->test_suite_name() + "_" + info->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~FileFixture() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  std::string Write(const std::string& name, const std::string& content) const {
    std::ofstream(Path(name), std::ios::binary) << content;
    return Path(name);
  }

  static std::string Read(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  int NumFiles() const {
    using Iterator = std::filesystem::directory_iterator;
    return static_cast<int>(std::distance(Iterator(folder_), Iterator()));
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace drape
