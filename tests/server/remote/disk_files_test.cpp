#include "server/remote/disk_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "tests/server/server_fixture.h"

namespace espalier::server::disk_files_test {
namespace {

TEST(DiskFiles, ReadsBackWhatWasWrittenAndLeavesNoTemporaryFile) {
  const TemporaryFolder folder;
  const std::string name = folder.path() + "/a.bin";
  const std::string content("one\0two\n", 8);
  EXPECT_EQ(writeFileAtomically(name, content), std::nullopt);
  EXPECT_EQ(writeFileAtomically(name, content + content), std::nullopt);
  EXPECT_EQ(DiskFileProvider().read(name), content + content);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), std::filesystem::directory_iterator()),
            1);
}

TEST(DiskFiles, LinksStayAndTheirFilesAreWritten) {
  const TemporaryFolder folder;
  const std::filesystem::path at = folder.path();
  std::filesystem::create_directory(at / "runs");
  ASSERT_EQ(writeFileAtomically(at / "runs/one", "old"), std::nullopt);
  std::filesystem::create_symlink("runs/one", at / "latest");
  std::filesystem::create_symlink(at / "latest", at / "runs/newest");
  std::filesystem::create_symlink("runs/two", at / "next");
  EXPECT_EQ(writeFileAtomically(at / "runs/newest", "new"), std::nullopt);
  EXPECT_EQ(writeFileAtomically(at / "next", "two"), std::nullopt);
  EXPECT_TRUE(std::filesystem::is_symlink(at / "latest"));
  EXPECT_TRUE(std::filesystem::is_symlink(at / "runs/newest"));
  EXPECT_TRUE(std::filesystem::is_symlink(at / "next"));
  EXPECT_FALSE(std::filesystem::is_symlink(at / "runs/one"));
  EXPECT_EQ(DiskFileProvider().read(at / "runs/one"), "new");
  EXPECT_EQ(DiskFileProvider().read(at / "runs/two"), "two");
  // a link to nowhere: the folder of its file does not exist
  std::filesystem::create_symlink("none/three", at / "broken");
  const auto problem = writeFileAtomically(at / "broken", "three");
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->find("cannot write '" + (at / "broken").string() + "': No such file or directory."), 0U)
      << *problem;
  // links in a circle
  std::filesystem::create_symlink("left", at / "right");
  std::filesystem::create_symlink("right", at / "left");
  EXPECT_NE(writeFileAtomically(at / "left", "four"), std::nullopt);
  EXPECT_TRUE(std::filesystem::is_symlink(at / "left"));
}

TEST(DiskFiles, AFileThatIsWrittenAnewKeepsItsPermissions) {
  const TemporaryFolder folder;
  const std::filesystem::path name = std::filesystem::path(folder.path()) / "a";
  using std::filesystem::perms;
  ASSERT_EQ(writeFileAtomically(name, "old"), std::nullopt);
  const perms shared = perms::owner_read | perms::owner_write | perms::group_read | perms::group_write;
  std::filesystem::permissions(name, shared);
  EXPECT_EQ(writeFileAtomically(name, "new"), std::nullopt);
  EXPECT_EQ(std::filesystem::status(name).permissions(), shared);
  if (::geteuid() != 0) {
    std::filesystem::permissions(name, perms::owner_read);
    EXPECT_NE(writeFileAtomically(name, "newer"), std::nullopt);
    EXPECT_EQ(DiskFileProvider().read(name), "new");
  }
}

TEST(DiskFiles, WhatCannotBeReadIsNothing) {
  const TemporaryFolder folder;
  EXPECT_EQ(DiskFileProvider().read(folder.path() + "/missing"), std::nullopt);
  EXPECT_EQ(DiskFileProvider().read(folder.path()), std::nullopt);
  EXPECT_EQ(writeFileAtomically(folder.path() + "/big", "12345"), std::nullopt);
  EXPECT_EQ(DiskFileProvider(4).read(folder.path() + "/big"), std::nullopt);
}

TEST(DiskFiles, AModelReadsOnlyWhatReallyLiesInItsFolder) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() + "/model/data");
  ASSERT_EQ(writeFileAtomically(folder.path() + "/outside", "secret"), std::nullopt);
  ASSERT_EQ(writeFileAtomically(folder.path() + "/model/data/in", "1"), std::nullopt);
  std::filesystem::create_symlink("../outside", folder.path() + "/model/link");
  std::filesystem::create_symlink("data/in", folder.path() + "/model/inner");
  const std::string model = folder.path() + "/model/";
  EXPECT_EQ(DiskFileProvider().readInside(model, model + "data/in"), "1");
  EXPECT_EQ(DiskFileProvider().readInside(model, model + "inner"), "1");
  EXPECT_EQ(DiskFileProvider().readInside(model, model + "link"), std::nullopt);
  EXPECT_EQ(DiskFileProvider().readInside(model, model + "../outside"), std::nullopt);
  EXPECT_EQ(DiskFileProvider().readInside(folder.path() + "/none/", model + "inner"), std::nullopt);
}

TEST(DiskFiles, AnUnwritableNameIsASentenceThatSaysWhatToDo) {
  const TemporaryFolder folder;
  const std::string name = folder.path() + "/missing/a";
  EXPECT_EQ(writeFileAtomically(name, "x"),
            "cannot write '" + name +
                "': No such file or directory. Check that the folder exists, is writable and "
                "has room.");
}

}  // namespace
}  // namespace espalier::server::disk_files_test
