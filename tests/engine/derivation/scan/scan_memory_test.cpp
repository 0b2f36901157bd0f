// The memory that a step reserves for the string it makes.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>

#include "engine/core/work_meter.h"
#include "tests/support/derived_model.h"
#include "tests/support/sanitized.h"

namespace espalier::scan_memory_test {
namespace {

using test::DerivedModel;

// a string that its first step unfolds to 2^n modules
std::string unfolding(int n) {
  return test::modelText("", "A(1)",
                         "A(x) --> T(" + std::to_string(n) +
                             ")\nI(x) --> I(x+1)\ndecomposition\nmaximum depth: 40\n"
                             "T(n) : n>0 --> T(n-1)T(n-1)\nT(n) : n<=0 --> I(1)\n");
}

/// Counts the memory that a thread has.
class CountingMeter final : public core::WorkMeter {
 public:
  [[nodiscard]] bool take(std::int64_t bytes) noexcept override {
    taken_ += bytes;
    most = std::max(most, taken_);
    return true;
  }
  [[nodiscard]] bool isStopped() const noexcept override { return false; }

  std::int64_t most = 0;

 private:
  std::int64_t taken_ = 0;
};

TEST(ScanMemory, AnEstimateBeyondTheAddressSpaceIsNoFailure) {
  // after the first step eight times its 42 MB are expected, and the second takes as much as the first
  const auto deriveInLittleSpace = [] {
    if (!kIsSanitized) {
      std::uint64_t pages = 0;
      std::ifstream("/proc/self/statm") >> pages;
      const rlim_t most = pages * 4096 + 250'000'000;
      const rlimit bound{most, most};
      setrlimit(RLIMIT_AS, &bound);
    }
    DerivedModel derived(unfolding(22));
    derived.steps(3);
    std::exit(derived.state().string.parameters()[131071] == 3.0 ? 0 : 1);
  };
  EXPECT_EXIT(deriveInLittleSpace(), testing::ExitedWithCode(0), "");
}

TEST(ScanMemory, AStringThatUnfoldsAtOnceReservesLittleForItsNextStep) {
  // a forest has many such strings: 256 modules of 10 bytes
  DerivedModel derived(unfolding(8));
  CountingMeter meter;
  const core::WorkMeter::Scope scope(&meter);
  derived.steps(3);
  EXPECT_LT(meter.most, 100'000);
}

}  // namespace
}  // namespace espalier::scan_memory_test
