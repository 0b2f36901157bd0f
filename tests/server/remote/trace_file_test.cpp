#include "server/remote/trace_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/server/server_fixture.h"

namespace espalier::server {
namespace {

std::unique_ptr<TraceFile> make(const std::string& name) {
  auto made = TraceFile::create(name);
  EXPECT_TRUE(made.has_value());
  return std::move(made.value());
}

TEST(TraceFile, WhatWasWrittenIsReadCompressedOrNot) {
  const TemporaryFolder folder;
  const std::string much(3'000'000, 'x');
  for (const char* name : {"/t.trace", "/t.trace.zst"}) {
    const auto file = make(folder.path() + name);
    file->write("head");
    file->write(much);
    EXPECT_EQ(file->close(), std::nullopt);
    std::string bytes;
    EXPECT_EQ(readTraceFile(folder.path() + name, bytes), std::nullopt);
    EXPECT_EQ(bytes, "head" + much);
  }
  EXPECT_LT(std::filesystem::file_size(folder.path() + "/t.trace.zst"), 100'000U);
}

TEST(TraceFile, WhatWasFlushedIsReadableThoughTheFileWasNeverClosed) {
  const TemporaryFolder folder;
  const auto file = make(folder.path() + "/t.zst");
  file->write("first");
  file->flush();
  file->write("second, which is lost");
  std::string bytes;
  EXPECT_EQ(readTraceFile(folder.path() + "/t.zst", bytes), std::nullopt);
  EXPECT_EQ(bytes, "first");
}

TEST(TraceFile, AFewBytesDoNotFillTheMemory) {
  const TemporaryFolder folder;
  const auto file = make(folder.path() + "/t.zst");
  file->write(std::string(50'000'000, 'x'));
  EXPECT_EQ(file->close(), std::nullopt);
  ASSERT_LT(std::filesystem::file_size(folder.path() + "/t.zst"), 100'000U);
  std::string bytes;
  EXPECT_EQ(readTraceFile(folder.path() + "/t.zst", bytes, 50'000'000), std::nullopt);
  const auto problem = readTraceFile(folder.path() + "/t.zst", bytes, 49'999'999);
  ASSERT_TRUE(problem.has_value());
  EXPECT_NE(problem->find("has more than 49999999 bytes when it is decompressed. Decompress it with zstd"),
            std::string::npos)
      << *problem;
}

TEST(TraceFile, FailuresAreSentences) {
  const TemporaryFolder folder;
  const auto made = TraceFile::create(folder.path() + "/none/t");
  EXPECT_NE(made.error().find("No such file or directory; give a file in a folder that exists."), std::string::npos);
  std::string bytes;
  EXPECT_NE(readTraceFile(folder.path() + "/t", bytes)->find("cannot read the trace"), std::string::npos);
  // a full disk does not end the run, and is told at its end
  const auto full = make("/dev/full");
  full->write(std::string(1'000'000, 'x'));
  EXPECT_NE(full->close()->find("the trace '/dev/full' is not complete: No space left on device."), std::string::npos);
}

}  // namespace
}  // namespace espalier::server
