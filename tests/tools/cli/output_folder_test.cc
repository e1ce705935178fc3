// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/output_folder.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <set>

#include "physics/util/atomic_file.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"

namespace drape {
namespace {

class OutputFolders : public FileFixture {
 protected:
  std::set<std::string> Names() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(Path("")))
      names.insert(std::filesystem::relative(entry.path(), Path("")).string());
    return names;
  }
};

using Set = std::set<std::string>;

TEST_F(OutputFolders, PublishesWhatWasWrittenAndLeavesTheRest) {
  Write("earlier.json", "earlier");
  Write("summary.json", "old");
  {
    const OutputFolder out(Path(""));
    WriteFileAtomically(out.Staged("summary.json"), "new");
    WriteFileAtomically(out.Staged("a.json"), "a");
    EXPECT_EQ(Read(Path("summary.json")), "old");
    out.Publish();
  }
  EXPECT_EQ(Read(Path("summary.json")), "new");
  EXPECT_EQ(Names(), Set({"a.json", "earlier.json", "summary.json"}));
}

TEST_F(OutputFolders, SharedOnesStandBesideOneAnotherOnly) {
  using Use = OutputFolder::Use;
  {
    const OutputFolder one(Path("a"), {}, Use::kShared), other(Path("a"), {}, Use::kShared);
    Write("a/.drapefit_0123456789abcdef.tmp", "of the other");
    EXPECT_INPUT_ERROR(OutputFolder(Path("a")), "another program is writing to this folder");
    EXPECT_TRUE(std::filesystem::exists(Path("a/.drapefit_0123456789abcdef.tmp")));
  }
  const OutputFolder alone(Path("a"));
  EXPECT_FALSE(std::filesystem::exists(Path("a/.drapefit_0123456789abcdef.tmp")));
  EXPECT_INPUT_ERROR(OutputFolder(Path("a"), {}, Use::kShared), "another program is writing");
}

TEST_F(OutputFolders, DropWhatIsNotPublished) {
  {
    const OutputFolder out(Path("new/one"));
    WriteFileAtomically(out.Staged("a.json"), "a");
  }
  EXPECT_FALSE(std::filesystem::exists(Path("new/one")));
}

TEST_F(OutputFolders, ClearWhatDeadProgramsHaveLeft) {
  const std::string stale = TemporaryName();
  std::filesystem::create_directory(Path(stale));
  Write(stale + "/gradient.json", "stale");
  Write(".drapefit_0123456789abcdef.tmp", "half");
  Write("kept.json", "kept");
  {
    const OutputFolder out(Path(""));
    WriteFileAtomically(out.Staged("a.json"), "a");
    out.Publish();
  }
  EXPECT_EQ(Names(), Set({"a.json", "kept.json"}));
}

TEST_F(OutputFolders, TouchNothingThatALinkLeadsTo) {
  std::filesystem::create_directory(Path("victim"));
  Write("victim/theirs.json", "theirs");
  std::filesystem::create_directory(Path("out"));
  std::filesystem::create_directory_symlink(Path("victim"),
                                            Path("out/.drapefit_0123456789abcdef.tmp"));
  std::filesystem::create_symlink(Path("victim/theirs.json"), Path("out/a.json"));
  const OutputFolder out(Path("out"));
  WriteFileAtomically(out.Staged("a.json"), "a");
  out.Publish();
  EXPECT_EQ(Read(Path("victim/theirs.json")), "theirs");
  EXPECT_EQ(Read(Path("out/a.json")), "a");
  EXPECT_FALSE(std::filesystem::is_symlink(Path("out/a.json")));
}

TEST_F(OutputFolders, AreOfOneProgramAtATime) {
  Write("a.json", "earlier");
  const auto first = std::make_unique<OutputFolder>(Path(""));
  WriteFileAtomically(first->Staged("a.json"), "first");
  EXPECT_INPUT_ERROR(OutputFolder(Path("")), "another program is writing to this folder");
  EXPECT_EQ(Read(Path("a.json")), "earlier");
  first->Publish();
  EXPECT_EQ(Read(Path("a.json")), "first");
}

// A program that is killed releases its lock and leaves its folder, which the next one removes.
TEST_F(OutputFolders, AreFreeAfterAKill) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const OutputFolder out(Path(""));
    WriteFileAtomically(out.Staged("a.json"), "never seen");
    kill(getpid(), SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  EXPECT_EQ(Names().size(), 2u);  // its folder with one file
  const OutputFolder out(Path(""));
  EXPECT_EQ(Names().size(), 1u);
  out.Publish();
  EXPECT_FALSE(std::filesystem::exists(Path("a.json")));
}

TEST_F(OutputFolders, FindAFolderInPlaceOfAFileBeforeTheyReplaceAny) {
  Write("a.json", "earlier");
  std::filesystem::create_directory(Path("z.png"));
  const OutputFolder out(Path(""));
  for (const char* name : {"a.json", "z.png"}) WriteFileAtomically(out.Staged(name), "new");
  EXPECT_IO_ERROR(out.Publish(), "z.png: cannot replace the file");
  EXPECT_EQ(Read(Path("a.json")), "earlier");
}

TEST_F(OutputFolders, FindAFolderInPlaceOfANamedFileAtOnce) {
  std::filesystem::create_directories(Path("z.png"));
  EXPECT_IO_ERROR(OutputFolder(Path(""), {"a.json", "z.png"}), "z.png: is a folder");
  EXPECT_EQ(Names(), Set({"z.png"}));
  const OutputFolder out(Path(""), {"a.json"});  // it is free
}

TEST_F(OutputFolders, AbandonedOnesLeaveNothing) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const OutputFolder out(Path("")), fresh(Path("fresh"));
    WriteFileAtomically(out.Staged("a.json"), "a");
    OutputFolder::Abandon();
    _exit(0);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  EXPECT_EQ(Names(), Set());
}

}  // namespace
}  // namespace drape
