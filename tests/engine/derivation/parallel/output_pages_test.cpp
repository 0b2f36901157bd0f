#include "engine/derivation/parallel/output_pages.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>

#include "engine/core/buffer.h"
#include "engine/core/worker_team.h"

namespace espalier {
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

TEST(OutputPages, NothingIsPreparedForNothing) {
  derivation::OutputPages pages;
  pages.cover(nullptr, 0);
  pages.prepare(0, 0);
}

}  // namespace
}  // namespace espalier
