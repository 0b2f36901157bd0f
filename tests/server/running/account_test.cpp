#include "server/running/account.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

#include "engine/core/buffer.h"
#include "server/remote/control_group.h"
#include "server/remote/freed_memory.h"
#include "server/remote/limits.h"
#include "server/running/turn_meter.h"

namespace espalier::server::account_test {
namespace {

ServerLimits limitsOf(std::uint64_t server, std::uint64_t account) {
  ServerLimits limits;
  limits.memoryBytes = server;
  limits.accountMemoryBytes = account;
  return limits;
}

TEST(Account, CountsForItsOwnerAndTheServer) {
  Accounts accounts(limitsOf(1'000, 700));
  Account& ada = accounts.of("ada");
  Account& ben = accounts.of("ben");
  EXPECT_EQ(&accounts.of("ada"), &ada);
  EXPECT_TRUE(ada.take(MemoryKind::Strings, 600));
  EXPECT_FALSE(ada.take(MemoryKind::Frames, 101));
  EXPECT_TRUE(ada.take(MemoryKind::Frames, 100));
  EXPECT_EQ(
      ada.memoryError().message,
      "the account 'ada' has 700 of 700 bytes (limit accountMemoryBytes), and this needs more. Delete simulations, "
      "close streams, or start the server with a higher --limit accountMemoryBytes=N.");
  // the server is full before ben is
  EXPECT_FALSE(ben.take(MemoryKind::Strings, 301));
  EXPECT_TRUE(ben.take(MemoryKind::Strings, 300));
  EXPECT_EQ(ben.memoryBytes(), 300U);
  EXPECT_EQ(ben.memoryError().message,
            "all simulations, streams and messages of this server together have 1000 of 1000 bytes (limit "
            "memoryBytes), and this needs more. Delete simulations, close streams, or start the server with a higher "
            "--limit memoryBytes=N.");
  EXPECT_EQ(ben.memoryError().data, R"({"limit":"memoryBytes","value":1000,"bound":1000})");
  EXPECT_EQ(accounts.server().bytes(MemoryKind::Strings), 900U);
  EXPECT_EQ(accounts.server().bytes(MemoryKind::Frames), 100U);
  ada.add(MemoryKind::Strings, -600);
  EXPECT_EQ(accounts.server().memoryBytes(), 400U);
  EXPECT_TRUE(ben.take(MemoryKind::Strings, 301));
  EXPECT_EQ(accounts.all().size(), 2U);
}

TEST(Account, ComputesNoMoreBeyondItsSeconds) {
  ServerLimits limits;
  limits.accountCpuSeconds = 2;
  Accounts accounts(limits);
  Account& ada = accounts.of("ada");
  ada.spend(2'000'000'000);
  EXPECT_EQ(ada.cpuProblem(), std::nullopt);
  ada.spend(1'000'000);
  ASSERT_TRUE(ada.cpuProblem().has_value());
  EXPECT_EQ(ada.cpuProblem()->data, R"({"limit":"accountCpuSeconds","value":3,"bound":2})");
  EXPECT_NE(ada.cpuProblem()->message.find("The account 'ada' computes no more"), std::string::npos);
  EXPECT_EQ(accounts.of("ben").cpuProblem(), std::nullopt);
  EXPECT_DOUBLE_EQ(accounts.server().cpuSeconds(), 2.001);
}

TEST(Account, AHoldingGivesBackWhatItHolds) {
  Accounts accounts(limitsOf(100, 0));
  Account& ada = accounts.of("ada");
  {
    Holding holding(ada, MemoryKind::Environments);
    holding.set(70);
    holding.set(30);
    EXPECT_EQ(ada.bytes(MemoryKind::Environments), 30U);
    EXPECT_EQ(accounts.server().memoryBytes(), 30U);
  }
  EXPECT_EQ(accounts.server().memoryBytes(), 0U);
}

TEST(Account, WithoutABoundTheServerHasMostOfTheMachine) {
  const Accounts accounts{ServerLimits()};
  EXPECT_EQ(accounts.server().bounds().memoryBytes, usableMemoryBytes());
  EXPECT_GT(usableMemoryBytes(), 100'000'000U);
}

/// A block of memory that is used, so that no compiler leaves it out.
std::vector<char> blockOf(std::size_t bytes) {
  std::vector<char> block(bytes);
  const char* volatile seen = block.data();
  (void)seen;
  return block;
}

TEST(TurnMeter, ReservesWhileTheTurnRunsAndRefusesBigBlocks) {
  ASSERT_TRUE(isHeapMetered());
  Accounts accounts(limitsOf(40'000'000, 0));
  Account& ada = accounts.of("ada");
  {
    TurnMeter meter(ada, MemoryKind::Compiling);
    const core::WorkMeter::Scope scope(&meter);
    // by `new`, and by a buffer of the engine
    auto first = std::make_unique<std::vector<char>>(10'000'000);
    EXPECT_GE(ada.bytes(MemoryKind::Compiling), 10'000'000U);
    core::Buffer<double> second;
    second.resize(2'000'000);
    EXPECT_GE(ada.bytes(MemoryKind::Compiling), 26'000'000U);
    EXPECT_FALSE(meter.isStopped());
    EXPECT_THROW(blockOf(20'000'000), std::bad_alloc);
    EXPECT_TRUE(meter.isRefused());
    EXPECT_THROW(core::pollWork(), core::WorkStopped);
    // a message about it can still be made
    EXPECT_EQ(std::string(1'000, 'x').size(), 1'000U);
    first.reset();
    EXPECT_TRUE(meter.tryAgain());
    const std::vector<char> third = blockOf(8'000'000);
    EXPECT_FALSE(meter.isRefused());
  }
  EXPECT_EQ(accounts.server().memoryBytes(), 0U);
  EXPECT_GT(ada.cpuSeconds(), 0.0);
}

TEST(TurnMeter, ManySmallBlocksEndTheTurnToo) {
  Accounts accounts(limitsOf(10'000'000, 0));
  TurnMeter meter(accounts.of("ada"), MemoryKind::Compiling);
  const core::WorkMeter::Scope scope(&meter);
  std::vector<std::unique_ptr<std::array<char, 1'000>>> blocks;
  blocks.reserve(200'000);
  EXPECT_THROW(
      for (int i = 0; i < 200'000; ++i) { blocks.push_back(std::make_unique<std::array<char, 1'000>>()); },
      std::bad_alloc);
  EXPECT_TRUE(meter.isStopped());
  EXPECT_LT(blocks.size(), 100'000U);
}

TEST(TurnMeter, TheHeapIsTrimmedAlsoAfterTheLastOfManyLargeTurns) {
  Accounts accounts(limitsOf(200'000'000, 0));
  const auto makeLargeTurn = [&] {
    TurnMeter meter(accounts.of("ada"), MemoryKind::Compiling);
    const core::WorkMeter::Scope scope(&meter);
    const std::vector<char> block = blockOf(50'000'000);
  };
  // A turn that ends within a second of the last trim leaves one to be made. One that ends later trims the heap itself:
  // of two turns in a row that may be the second one, so both are made again until a trim is left.
  for (int attempt = 0; attempt < 20 && !isHeapTrimDue(); ++attempt) {
    makeLargeTurn();
    makeLargeTurn();
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(1500);
    while (!isHeapTrimDue() && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  EXPECT_TRUE(isHeapTrimDue());
  trimHeap();
  EXPECT_FALSE(isHeapTrimDue());
}

TEST(TurnMeter, DestructorsGetMemoryWhileAnExceptionEndsTheTurn) {
  Accounts accounts(limitsOf(10'000'000, 0));
  TurnMeter meter(accounts.of("ada"), MemoryKind::Compiling);
  const core::WorkMeter::Scope scope(&meter);
  struct Mover {
    ~Mover() { const std::vector<char> moved = blockOf(5'000'000); }
  };
  EXPECT_THROW(
      {
        const Mover mover;
        const std::vector<char> tooMuch = blockOf(20'000'000);
      },
      std::bad_alloc);
  EXPECT_THROW(blockOf(20'000'000), std::bad_alloc);
}

TEST(TurnMeter, WorkThatDoesNotAskGetsNoMemoryWhenItIsStopped) {
  Accounts accounts(limitsOf(10'000'000, 0));
  TurnMeter meter(accounts.of("ada"), MemoryKind::Decoding, TurnMeter::WhenStopped::GetsNoMemory);
  const core::WorkMeter::Scope scope(&meter);
  EXPECT_TRUE(meter.take(8));
  meter.stop();
  EXPECT_FALSE(meter.take(8));
  EXPECT_TRUE(meter.take(-8));
  EXPECT_FALSE(meter.isRefused());
}

TEST(TurnMeter, CountsPartsByThemselves) {
  Accounts accounts(limitsOf(100'000'000, 0));
  TurnMeter meter(accounts.of("ada"), MemoryKind::Strings);
  const core::WorkMeter::Scope scope(&meter);
  std::vector<char> kept;
  PartMeter part;
  {
    const core::WorkMeter::Scope inner(&part);
    kept.resize(5'000'000);
    const std::vector<char> given = blockOf(3'000'000);
  }
  EXPECT_GE(part.net(), 5'000'000);
  EXPECT_LT(part.net(), 5'100'000);
  meter.stop();
  EXPECT_TRUE(part.isStopped());
}

}  // namespace
}  // namespace espalier::server::account_test
