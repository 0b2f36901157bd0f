#include "engine/derivation/parallel/output_pages.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <atomic>
#include <cstdint>

#include "engine/core/buffer.h"
#include "engine/core/worker_team.h"

namespace espalier::output_pages_test {
namespace {

TEST(OutputPages, PreparingKeepsWhatIsWrittenAndEndsOnEveryThread) {
  // the last page is no whole one
  core::Buffer<std::uint32_t> buffer;
  buffer.resize(5'000'000);
  derivation::OutputPages pages;
  pages.cover(buffer.data(), buffer.size() * 4);
  core::WorkerTeam team(3);
  constexpr std::size_t kPiece = 10'000;
  std::atomic<std::size_t> next{0};
  team.onEveryWorker([&](unsigned) {
    for (std::size_t begin = next.fetch_add(kPiece); begin < buffer.size(); begin = next.fetch_add(kPiece)) {
      pages.prepare(begin * 4, (begin + kPiece) * 4);
      for (std::size_t i = begin; i < begin + kPiece; ++i) {
        buffer[i] = static_cast<std::uint32_t>(i * 3);
      }
    }
  });
  for (std::size_t i = 0; i < buffer.size(); ++i) {
    ASSERT_EQ(buffer[i], static_cast<std::uint32_t>(i * 3));
  }
}

/// Whether the page of this address is in memory.
bool isResident(const char* address) {
  unsigned char state = 0;
  const auto page = reinterpret_cast<std::uintptr_t>(address) / 4096 * 4096;
  return mincore(reinterpret_cast<void*>(page), 1, &state) == 0 && (state & 1U) != 0;
}

TEST(OutputPages, ARangeIsPreparedAndNothingBeyondIt) {
#ifdef MADV_POPULATE_WRITE
  constexpr std::size_t kBytes = 5 * core::kHugePageBytes;
  auto* const memory = static_cast<char*>(core::mapPages(kBytes));
  if (madvise(memory, 4096, MADV_POPULATE_WRITE) != 0) {
    core::unmapPages(memory, kBytes);
    GTEST_SKIP() << "the system cannot touch pages ahead";
  }
  derivation::OutputPages pages;
  pages.cover(memory, kBytes);
  // an empty range touches nothing, also at the end
  pages.prepare(2 * core::kHugePageBytes, 2 * core::kHugePageBytes);
  pages.prepare(kBytes, kBytes);
  EXPECT_FALSE(isResident(memory + 2 * core::kHugePageBytes));
  EXPECT_FALSE(isResident(memory + kBytes - 1));
  // the last byte of one page and the first of the next
  pages.prepare(2 * core::kHugePageBytes - 1, 2 * core::kHugePageBytes + 1);
  EXPECT_TRUE(isResident(memory + core::kHugePageBytes));
  EXPECT_TRUE(isResident(memory + 3 * core::kHugePageBytes - 1));
  EXPECT_FALSE(isResident(memory + 3 * core::kHugePageBytes));
  core::unmapPages(memory, kBytes);
#else
  GTEST_SKIP() << "the system cannot touch pages ahead";
#endif
}

}  // namespace
}  // namespace espalier::output_pages_test
