// SPDX-License-Identifier: Apache-2.0
#include "physics/util/atomic_file.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <thread>

#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"

namespace drape {
namespace {

using AtomicFile = FileFixture;

TEST_F(AtomicFile, ReplacesTheWholeContentAndLeavesNothingElse) {
  const std::string path = Write("a.txt", "an old text that is longer");
  WriteFileAtomically(path, "new");
  EXPECT_EQ(ReadWholeFile(path), "new");
  EXPECT_EQ(NumFiles(), 1);
}

TEST_F(AtomicFile, KeepsTheOldFileWhenTheDiskIsFull) {
  const std::string path = Write("a.txt", "old");
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);  // then write() fails with EFBIG
  rlimit limit = {};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small = {100, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_IO_ERROR(WriteFileAtomically(path, std::string(1000, 'a')),
                  "a.txt: cannot write the whole file, only 100 bytes: File too large");
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(Read(path), "old");
  EXPECT_EQ(NumFiles(), 1);
}

TEST_F(AtomicFile, RejectsATargetThatCannotBeAFile) {
  std::filesystem::create_directory(Path("folder"));
  EXPECT_IO_ERROR(WriteFileAtomically(Path("folder"), "x"), "folder: cannot replace the file");
  EXPECT_IO_ERROR(WriteFileAtomically(Path("absent/a.txt"), "x"),
                  "a.txt: cannot create a file in this folder: No such file or directory");
  EXPECT_EQ(NumFiles(), 1);
}

TEST_F(AtomicFile, ReplacesALinkAndLeavesWhereItLeads) {
  const std::string victim = Write("victim", "theirs");
  std::filesystem::create_symlink(victim, Path("a.txt"));
  WriteFileAtomically(Path("a.txt"), "mine");
  EXPECT_EQ(Read(victim), "theirs");
  EXPECT_EQ(Read(Path("a.txt")), "mine");
  EXPECT_FALSE(std::filesystem::is_symlink(Path("a.txt")));
}

TEST_F(AtomicFile, FindsATargetThatCannotBeAFileBeforehand) {
  std::filesystem::create_directory(Path("folder"));
  EXPECT_IO_ERROR(CheckReplaceable(Path("folder")), "folder: is a folder");
  EXPECT_IO_ERROR(CheckReplaceable(Path("absent/a.txt")), "No such file or directory");
  EXPECT_INPUT_ERROR(CheckReplaceable(Path(std::string(256, 'a'))),
                     "256 bytes for a file, expected at most");
  EXPECT_IO_ERROR(CheckReplaceable("/proc/a.txt"), "cannot create a file in this folder");
  CheckReplaceable(Write("a.txt", ""));
  CheckReplaceable(Path("new.txt"));
  EXPECT_EQ(NumFiles(), 2);
}

TEST_F(AtomicFile, LeavesOfAKillAreRemoved) {
  const std::string folder = "a/" + TemporaryName(), deep = "a/b/c/" + TemporaryName(),
                    shallow = "a/b/" + TemporaryName();
  for (const std::string& name : {folder, std::string("a/b/c")})
    std::filesystem::create_directories(Path(name));
  Write(folder + "/c.json", "half");
  Write(shallow, "half");
  Write(deep, "half");
  Write("a/c.json", "whole");
  RemoveTemporaries(Path("a"), 2);
  RemoveTemporaries(Path("absent"), 2);
  EXPECT_TRUE(std::filesystem::exists(Path("a/c.json")));
  EXPECT_TRUE(std::filesystem::exists(Path(deep)));
  EXPECT_FALSE(std::filesystem::exists(Path(folder)));
  EXPECT_FALSE(std::filesystem::exists(Path(shallow)));
}

// Files of a user whose names are like ours, and what a link leads to.
TEST_F(AtomicFile, FilesOfOthersAreNotRemoved) {
  const std::string ours = TemporaryName();
  for (const char* name : {"a/.drapefit_notes", "a/.drapefit_0123456789abcdex.tmp", "else"})
    std::filesystem::create_directories(Path(name));
  Write("a/.drapefit_notes/b.txt", "theirs");
  Write("a/.drapefit_0123.tmp", "theirs");
  Write("else/" + ours, "theirs");
  std::filesystem::create_directory_symlink(Path("else"), Path("a/link"));
  std::filesystem::create_directory_symlink(Path("else"), Path("a/" + ours));
  RemoveTemporaries(Path("a"), 9);
  for (const std::string& name :
       {std::string("a/.drapefit_notes/b.txt"), std::string("a/.drapefit_0123.tmp"),
        std::string("a/.drapefit_0123456789abcdex.tmp"), "else/" + ours})
    EXPECT_TRUE(std::filesystem::exists(Path(name))) << name;
}

TEST_F(AtomicFile, PipesAndSocketsAreNotRead) {
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  std::filesystem::create_symlink(Path("pipe"), Path("link"));
  EXPECT_INPUT_ERROR(ReadWholeFile(Path("pipe")), "pipe: is a pipe, expected a file");
  EXPECT_INPUT_ERROR(ReadWholeFile(Path("link")), "link: is a pipe, expected a file");
}

TEST_F(AtomicFile, AnEndInTheMiddleOfAWriteLeavesNoPart) {
  Write("a.txt", "old");
  const std::string content(40'000'000, 'x');
  for (const int milliseconds : {2, 5, 10, 20}) {
    EXPECT_EXIT(
        {
          std::thread([&] {
            for (;;) WriteFileAtomically(Path("a.txt"), content);
          }).detach();
          std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
          AbandonTemporaries();
          std::this_thread::sleep_for(std::chrono::milliseconds(50));  // for a further write
          _exit(0);
        },
        testing::ExitedWithCode(0), "");
    EXPECT_EQ(NumFiles(), 1);
  }
}

TEST_F(AtomicFile, GrowsAndIsNoLink) {
  const std::string path = Write("a.log", "old\n"), victim = Write("victim", "theirs");
  EXPECT_TRUE(AppendFile(path, AppendFile::Content::kKeep).TryAppend("new\n"));
  EXPECT_EQ(Read(path), "old\nnew\n");
  EXPECT_TRUE(AppendFile(path, AppendFile::Content::kDrop).TryAppend("first\n"));
  EXPECT_EQ(Read(path), "first\n");
  std::filesystem::create_symlink(victim, Path("link"));
  std::filesystem::create_directory(Path("folder"));
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  for (const auto content : {AppendFile::Content::kKeep, AppendFile::Content::kDrop}) {
    EXPECT_IO_ERROR(AppendFile(Path("link"), content), "link: is a link");
    EXPECT_IO_ERROR(AppendFile(Path("folder"), content), "folder: is a folder");
    EXPECT_IO_ERROR(AppendFile(Path("pipe"), content), "pipe: ");
  }
  EXPECT_IO_ERROR(AppendFile::Check(Path("link")), "is a link");
  EXPECT_IO_ERROR(AppendFile::Check(Path("absent/a.log")), "absent/a.log");
  AppendFile::Check(Path("new"));
  EXPECT_EQ(Read(victim), "theirs");
  EXPECT_FALSE(std::filesystem::exists(Path("new")));
}

TEST_F(AtomicFile, ReadsEmptyAndBinaryFilesWhole) {
  EXPECT_EQ(ReadWholeFile(Write("empty", "")), "");
  const std::string bytes("a\0\r\n\xff", 5);
  EXPECT_EQ(ReadWholeFile(Write("bytes", bytes)), bytes);
  EXPECT_INPUT_ERROR(ReadWholeFile(Path("absent")), "absent: no such file");
  EXPECT_INPUT_ERROR(ReadWholeFile("/dev/zero"), "/dev/zero: is a device, expected a file");
  EXPECT_INPUT_ERROR(ReadWholeFile(Path("")), "is a folder, expected a file");
}

// Two roles of two files differ, and so do two parts of one file.
TEST_F(AtomicFile, RecordsEachReadInItsOrder) {
  const std::string a = Write("a", "1"), b = Write("b", "2");
  const auto sums = [](const std::vector<std::array<std::string, 2>>& reads) {
    const ReadRecord record;
    for (const auto& [path, part] : reads) ReadWholeFile(path, part);
    std::vector<std::string> sums;
    for (const ReadRecord::File& file : record.files()) sums.push_back(file.sha256);
    return sums;
  };
  EXPECT_NE(sums({{a}, {a}, {b}}), sums({{a}, {b}, {b}}));
  EXPECT_EQ(sums({{a}, {Write("copy", "1")}}), sums({{a}, {a}}));
  EXPECT_NE(sums({{a, "#felt"}}), sums({{a, "#silk"}}));
}

TEST(AppendNumber, ReadsBackBitForBit) {
  for (const double value : {.1, 1. / 3, -1e-300, 5e-324, 1.7976931348623157e308, 0., 1e22, 3.}) {
    std::string text = "x=";
    AppendNumber(text, value);
    EXPECT_EQ(std::strtod(text.c_str() + 2, nullptr), value) << text;
    EXPECT_LE(text.size(), 2u + 24u);
  }
}

TEST(AppendNumber, RefusesNumbersThatAreNotFinite) {
  std::string text;
  EXPECT_THROW(AppendNumber(text, std::numeric_limits<double>::quiet_NaN()), std::domain_error);
}

}  // namespace
}  // namespace drape
