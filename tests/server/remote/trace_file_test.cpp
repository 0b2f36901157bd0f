#include "server/remote/trace_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "engine/simulation/trace.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::trace_file_test {
namespace {

std::unique_ptr<TraceFile> make(const std::string& name) {
  auto made = TraceFile::create(name);
  EXPECT_TRUE(made.has_value());
  return std::move(made.value());
}

/// All bytes of a trace, taken in pieces of odd sizes.
std::string contentOf(const std::string& name) {
  const auto source = TraceFileSource::open(name);
  EXPECT_TRUE(source.has_value());
  std::string bytes;
  for (std::size_t size = 0; source;) {
    EXPECT_EQ((*source)->read(777'777, bytes), std::nullopt);
    if (bytes.size() - size < 777'777) {
      break;
    }
    size = bytes.size();
  }
  return bytes;
}

/// A zstd frame of `blocks` blocks of 128 KB of one byte, which have four bytes each, after the given bytes.
std::string zstdBomb(const std::string& head, std::size_t blocks) {
  // no content size, a window of 128 KB
  std::string frame("\x28\xB5\x2F\xFD\x00\x38", 6);
  const auto block = [&frame](std::size_t size, unsigned kind, bool isLast) {
    const std::size_t header = size << 3U | kind << 1U | (isLast ? 1U : 0U);
    for (const unsigned shift : {0U, 8U, 16U}) {
      frame += static_cast<char>(header >> shift & 0xFFU);
    }
  };
  block(head.size(), 0, false);
  frame += head;
  for (std::size_t i = 0; i < blocks; ++i) {
    block(std::size_t{1} << 17U, 1, i + 1 == blocks);
    frame += '\0';
  }
  return frame;
}

/// The message of the replay of a trace of these bytes when an event has at most 10 MB.
std::string replayOf(const std::string& bytes) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() + "/t.zst", std::ios::binary) << bytes;
  const auto source = TraceFileSource::open(folder.path() + "/t.zst");
  const auto outcome = simulation::replayTrace(**source, 10'000'000, 1);
  return outcome ? "(none)" : outcome.error();
}

TEST(TraceFile, WhatWasWrittenIsReadCompressedOrNot) {
  const TemporaryFolder folder;
  const std::string much(3'000'000, 'x');
  for (const char* name : {"/t.trace", "/t.trace.zst"}) {
    const auto file = make(folder.path() + name);
    file->write("head");
    file->write(much);
    EXPECT_EQ(file->close(), std::nullopt);
    EXPECT_EQ(contentOf(folder.path() + name), "head" + much);
  }
  EXPECT_LT(std::filesystem::file_size(folder.path() + "/t.trace.zst"), 100'000U);
}

TEST(TraceFile, WhatWasFlushedIsReadableThoughTheFileWasNeverClosed) {
  const TemporaryFolder folder;
  const auto file = make(folder.path() + "/t.zst");
  file->write("first");
  file->flush();
  file->write("second, which is lost");
  EXPECT_EQ(contentOf(folder.path() + "/t.zst"), "first");
}

TEST(TraceFile, AFewBytesThatStandForGigabytesAreRefusedAtTheFirstEvent) {
  // 6 GB of zeros in 183 kB
  EXPECT_EQ(replayOf(zstdBomb("", 45'777)),
            "this is not a trace: it does not begin with ESPTRACE. --trace FILE records one.");
  // an event of zeros that is longer than the bound, one that is longer than the memory, and one within the bound
  const std::string head("ESPTRACE\x01\0\0\0", 12);
  EXPECT_EQ(
      replayOf(zstdBomb(head + std::string("\0\0\0\x40\x01\0\0\0", 8), 45'777)),
      "the event at byte 12 has 5368709120 bytes, of which at most 10000000 are read: the trace is damaged, or needs "
      "more memory.");
  EXPECT_EQ(
      replayOf(zstdBomb(head + std::string(8, '\xFF'), 45'777)),
      "the event at byte 12 has 18446744073709551615 bytes, of which at most 10000000 are read: the trace is damaged, "
      "or needs more memory.");
  EXPECT_EQ(replayOf(zstdBomb(head + std::string("\0\x80\x96\0\0\0\0\0", 8), 45'777)),
            "the event at byte 12 cannot be read: the trace is damaged.");
}

TEST(TraceFile, FailuresAreSentences) {
  const TemporaryFolder folder;
  const auto made = TraceFile::create(folder.path() + "/none/t");
  EXPECT_NE(made.error().find("No such file or directory; give a file in a folder that exists."), std::string::npos);
  EXPECT_NE(TraceFileSource::open(folder.path() + "/t").error().find("Check the name and the working folder."),
            std::string::npos);
  EXPECT_NE(TraceFileSource::open(folder.path()).error().find("Is a directory"), std::string::npos);
  // a full disk does not end the run, and is told at its end
  const auto full = make("/dev/full");
  full->write(std::string(1'000'000, 'x'));
  EXPECT_NE(full->close()->find("the trace '/dev/full' is not complete: No space left on device."), std::string::npos);
}

}  // namespace
}  // namespace espalier::server::trace_file_test
