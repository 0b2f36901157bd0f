#include "engine/core/buffer.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <new>
#include <thread>
#include <utility>
#include <vector>

namespace espalier::core::buffer_test {
namespace {

TEST(Buffer, KeepsElementsWhileGrowingFromHeapToMapping) {
  Buffer<std::uint64_t> buffer;
  for (std::uint64_t i = 0; i < 1'000'000; ++i) {
    buffer.push_back(i * 3);
  }
  ASSERT_EQ(buffer.size(), 1'000'000U);
  for (std::uint64_t i = 0; i < buffer.size(); ++i) {
    ASSERT_EQ(buffer[i], i * 3);
  }
}

TEST(Buffer, ClearKeepsTheMemory) {
  Buffer<double> buffer;
  buffer.resize(1000);
  const double* data = buffer.data();
  buffer.clear();
  buffer.resize(1000);
  EXPECT_EQ(buffer.data(), data);
}

TEST(Buffer, CopiesAreIndependent) {
  Buffer<int> a;
  a.append(std::array<int, 3>{1, 2, 3});
  Buffer<int> b = a;
  b[0] = 9;
  EXPECT_EQ(a[0], 1);
  a = b;
  EXPECT_EQ(a[0], 9);
}

TEST(Buffer, MovesLeaveAUsableBuffer) {
  Buffer<int> a;
  a.push_back(1);
  Buffer<int> b = std::move(a);
  EXPECT_EQ(b.size(), 1U);
  a.push_back(5);  // NOLINT(bugprone-use-after-move): a moved-from buffer is empty and usable
  EXPECT_EQ(a[0], 5);
}

TEST(Buffer, GrowingAMappingKeepsElementsAndPages) {
  Buffer<std::uint64_t> buffer;
  buffer.resize(500'000);
  for (std::uint64_t i = 0; i < buffer.size(); ++i) {
    buffer[i] = i * 5;
  }
  buffer.reserve(5'000'000);
  ASSERT_EQ(buffer.size(), 500'000U);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(buffer.data()) % kHugePageBytes, 0U);
  for (std::uint64_t i = 0; i < buffer.size(); ++i) {
    ASSERT_EQ(buffer[i], i * 5);
  }
  buffer.resize(5'000'000);
  buffer[4'999'999] = 7;
  EXPECT_EQ(buffer[4'999'999], 7U);
}

TEST(Buffer, PopulatingPagesChangesNothing) {
  Buffer<std::uint64_t> buffer;
  buffer.resize(1'000'000);
  buffer[999'999] = 3;
  populatePages(buffer.data(), buffer.capacity() * sizeof(std::uint64_t));
  EXPECT_EQ(buffer[0], 0U);
  EXPECT_EQ(buffer[999'999], 3U);
}

TEST(Buffer, AThreadTouchesPagesFromTheEndAndChangesNothing) {
  std::vector<std::uint64_t> list;
  constexpr std::size_t kCount = 10'000'000;  // 80 MB
  list.reserve(kCount);
  {
    const std::jthread touching = populatePagesFromEnd(list.data(), kCount * sizeof(std::uint64_t));
    EXPECT_TRUE(touching.joinable());
    for (std::size_t i = 0; i < kCount; ++i) {
      list.push_back(i);
    }
  }
  for (std::size_t i = 0; i < kCount; ++i) {
    ASSERT_EQ(list[i], i);
  }
  EXPECT_FALSE(populatePagesFromEnd(list.data(), 1'000'000).joinable()) << "not worth a thread";
}

TEST(Buffer, ImpossibleSizesThrowBadAlloc) {
  Buffer<double> buffer;
  EXPECT_THROW(buffer.reserve(SIZE_MAX / 16), std::bad_alloc);
  // an array that was mapped already stays as it is
  buffer.resize(1'000'000);
  buffer[0] = 4.0;
  EXPECT_THROW(buffer.reserve(SIZE_MAX / 16), std::bad_alloc);
  EXPECT_EQ(buffer[0], 4.0);
  EXPECT_THROW(static_cast<void>(mapPages(SIZE_MAX)), std::bad_alloc);
}

TEST(Buffer, SharingCopiesOnlyWhenOneIsWritten) {
  Buffer<int> a;
  a.append(std::array<int, 3>{1, 2, 3});
  const int* const memory = std::as_const(a).data();
  Buffer<int> b = a.share();
  const Buffer<int> c = std::as_const(b).share();
  EXPECT_EQ(std::as_const(a).data(), memory);
  EXPECT_EQ(std::as_const(b).data(), memory);
  EXPECT_EQ(c.data(), memory);
  a[0] = 9;
  EXPECT_EQ(b.view()[0], 1);
  EXPECT_EQ(c.data(), memory);
  EXPECT_NE(std::as_const(a).data(), memory);
  // every way to write
  const auto leaves = [&c](auto write) {
    Buffer<int> other = c.share();
    write(other);
    return c.view()[0] == 1 && c.view()[2] == 3 && std::as_const(other).data() != c.data();
  };
  EXPECT_TRUE(leaves([](Buffer<int>& other) { other.push_back(4); }));
  EXPECT_TRUE(leaves([](Buffer<int>& other) { other.append(std::array<int, 1>{4}); }));
  EXPECT_TRUE(leaves([](Buffer<int>& other) { other.span()[2] = 4; }));
  EXPECT_TRUE(leaves([](Buffer<int>& other) { other.data()[2] = 4; }));
  EXPECT_TRUE(leaves([](Buffer<int>& other) {
    other.resize(1);
    other.push_back(7);
  }));
  EXPECT_TRUE(leaves([](Buffer<int>& other) {
    other.clear();
    other.push_back(7);
  }));
  EXPECT_TRUE(leaves([](Buffer<int>& other) { other.reserve(1000); }));
  EXPECT_TRUE(leaves([](Buffer<int>& other) { other.release(); }));
}

TEST(Buffer, OfTwoThatShareTheOneThatIsWrittenLeaves) {
  Buffer<int> a;
  a.append(std::array<int, 3>{1, 2, 3});
  const Buffer<int> b = a.share();
  a[0] = 9;
  EXPECT_EQ(b.view()[0], 1);
  EXPECT_NE(std::as_const(a).data(), b.data());
}

TEST(Buffer, TheLastThatSharesKeepsTheMemory) {
  for (const std::size_t count : {std::size_t{100}, std::size_t{500'000}}) {
    Buffer<double> a;
    a.reserve(2 * count);
    a.resize(count);
    const double* const memory = std::as_const(a).data();
    {
      const Buffer<double> b = a.share();
      EXPECT_EQ(a.capacity(), count);
    }
    a[0] = 1.0;
    EXPECT_EQ(std::as_const(a).data(), memory);
    EXPECT_EQ(a.capacity(), 2 * count);
    // the memory lives as long as one of them
    Buffer<double> c = a.share();
    a.release();
    EXPECT_EQ(c.view()[0], 1.0);
    c.clear();
    c.resize(2 * count);
    EXPECT_EQ(std::as_const(c).data(), memory);
  }
  Buffer<int> empty;
  EXPECT_TRUE(empty.share().empty());
}

}  // namespace
}  // namespace espalier::core::buffer_test
