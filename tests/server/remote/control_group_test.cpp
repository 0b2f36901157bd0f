#include "server/remote/control_group.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/server/server_fixture.h"

namespace espalier::server::control_group_test {
namespace {

void write(const std::string& file, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(file).parent_path());
  std::ofstream(file) << text;
}

unsigned allProcessors() {
  const TemporaryFolder empty;
  return processorCount(empty.path());
}

TEST(ControlGroup, WithoutOneTheMachineCounts) {
  const TemporaryFolder folder;
  EXPECT_EQ(controlGroupMemoryBytes(folder.path()), std::nullopt);
  EXPECT_GE(allProcessors(), 1U);
  EXPECT_LE(allProcessors(), std::max(std::thread::hardware_concurrency(), 1U));
}

TEST(ControlGroup, OfVersionTwoGivesItsQuotaRoundedUp) {
  const TemporaryFolder folder;
  write(folder.path() + "/cpu.max", "max 100000\n");
  write(folder.path() + "/memory.max", "max\n");
  EXPECT_EQ(processorCount(folder.path()), allProcessors());
  EXPECT_EQ(controlGroupMemoryBytes(folder.path()), std::nullopt);
  write(folder.path() + "/cpu.max", "20000 100000\n");
  write(folder.path() + "/memory.max", "268435456\n");
  EXPECT_EQ(processorCount(folder.path()), 1U);
  EXPECT_EQ(controlGroupMemoryBytes(folder.path()), 268'435'456U);
  write(folder.path() + "/cpu.max", "110000 100000\n");
  EXPECT_EQ(processorCount(folder.path()), std::min(2U, allProcessors()));
  write(folder.path() + "/cpu.max", "9900000 100000\n");
  EXPECT_EQ(processorCount(folder.path()), std::min(99U, allProcessors()));
}

TEST(ControlGroup, OfVersionOneIsReadToo) {
  const TemporaryFolder folder;
  write(folder.path() + "/cpu/cpu.cfs_quota_us", "-1\n");
  write(folder.path() + "/cpu/cpu.cfs_period_us", "100000\n");
  write(folder.path() + "/memory/memory.limit_in_bytes", "1000000\n");
  EXPECT_EQ(processorCount(folder.path()), allProcessors());
  EXPECT_EQ(controlGroupMemoryBytes(folder.path()), 1'000'000U);
  write(folder.path() + "/cpu/cpu.cfs_quota_us", "50000\n");
  EXPECT_EQ(processorCount(folder.path()), 1U);
}

TEST(ControlGroup, TheLeastOfItsBoundsCounts) {
  const TemporaryFolder folder;
  write(folder.path() + "/memory.max", "2000000\n");
  write(folder.path() + "/memory.high", "max\n");
  EXPECT_EQ(controlGroupMemoryBytes(folder.path()), 2'000'000U);
  write(folder.path() + "/memory.high", "1000000\n");
  EXPECT_EQ(controlGroupMemoryBytes(folder.path()), 1'000'000U);
}

TEST(UsableMemory, LimitsOfTheProcessCount) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take more address space than any limit";
#endif
  const std::uint64_t before = usableMemoryBytes();
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    ::rlimit limit{};
    ASSERT_EQ(::getrlimit(resource, &limit), 0);
    const ::rlimit own = limit;
    // little, but more than this process has: nothing fails meanwhile
    limit.rlim_cur = before / 2;
    ASSERT_EQ(::setrlimit(resource, &limit), 0);
    const std::uint64_t bounded = usableMemoryBytes();
    EXPECT_EQ(processMemoryBytes(), before / 2);
    ASSERT_EQ(::setrlimit(resource, &own), 0);
    EXPECT_EQ(bounded, before / 2 / 5 * 4);
    EXPECT_EQ(usableMemoryBytes(), before);
  }
}

TEST(ControlGroup, NonsenseIsNoBound) {
  const TemporaryFolder folder;
  write(folder.path() + "/cpu.max", "0 0\n");
  write(folder.path() + "/memory.max", "-5 lots\n");
  EXPECT_EQ(processorCount(folder.path()), allProcessors());
  EXPECT_EQ(controlGroupMemoryBytes(folder.path()), std::nullopt);
}

}  // namespace
}  // namespace espalier::server::control_group_test
