// A process that runs out of memory in the middle of a step is as before the step: each allocation of a step fails
// once.

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>
#include <random>

#include "tests/environment/candidates.h"
#include "tests/environment/query_builder.h"

namespace {

// allocations of this thread until one fails; negative: none fails
thread_local long allocationsLeft = -1;

void* allocate(std::size_t size) {
  if (allocationsLeft >= 0 && allocationsLeft-- == 0) {
    throw std::bad_alloc();
  }
  if (void* memory = std::malloc(size == 0 ? 1 : size)) {
    return memory;
  }
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size);
}
void* operator new[](std::size_t size) {
  return allocate(size);
}
// std::stable_sort asks in this way and does without the memory when there is none
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return std::malloc(size == 0 ? 1 : size);
}
// inlined, they look to g++ like a free() of what new gave (-Wmismatched-new-delete)
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace espalier::environment::allocation_failure_test {
namespace {

class AllocationFailure : public testing::TestWithParam<Candidate> {};

TEST_P(AllocationFailure, LeavesTheStateAsItWas) {
  std::mt19937_64 random(5);
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  const auto undisturbed = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process && undisturbed);
  for (std::uint64_t step = 0; step < 2; ++step) {
    const turtle::QueryBatch queries = queriesOf(GetParam(), step, random);
    const std::string before = process->save();
    turtle::ReplyBatch replies;
    bool hasFailed = true;
    // each of the first 200 allocations, then fewer and fewer
    for (long failing = 0; hasFailed; failing += 1 + failing / 200) {
      replies.prepare(queries);
      hasFailed = false;
      try {
        allocationsLeft = failing;
        const auto error = process->step(queries, replies);
        allocationsLeft = -1;
        // a process of processes says it in words
        hasFailed = error.has_value();
        ASSERT_TRUE(!error || error->message.find("not enough memory") != std::string::npos) << error->message;
        ASSERT_TRUE(process->save() == before || !error) << "allocation " << failing << " of step " << step;
      } catch (const std::bad_alloc&) {
        allocationsLeft = -1;
        hasFailed = true;
        ASSERT_TRUE(process->save() == before) << "allocation " << failing << " of step " << step;
      }
    }
    turtle::ReplyBatch expected;
    expected.prepare(queries);
    ASSERT_FALSE(undisturbed->step(queries, expected).has_value());
    EXPECT_EQ(replies.values, expected.values);
    EXPECT_EQ(replies.isSet, expected.isSet);
    EXPECT_TRUE(process->save() == undisturbed->save());
  }
}

INSTANTIATE_TEST_SUITE_P(Processes, AllocationFailure, testing::ValuesIn(candidates()), nameOf);

}  // namespace
}  // namespace espalier::environment::allocation_failure_test
