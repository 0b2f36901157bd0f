#include "server/store/durability.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>
#include <vector>

#include "server/store/store.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::durability_test {
namespace {

/// A disk that keeps what it is asked to keep only when the test lets it.
class SlowDisk {
 public:
  int force() {
    std::unique_lock lock(mutex_);
    ++begun_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return allowed_ >= begun_; });
    return failure_;
  }
  void waitUntilBegun(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return begun_ >= count; });
  }
  void allow(int count, int failure = 0) {
    const std::lock_guard lock(mutex_);
    allowed_ = count;
    failure_ = failure;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int begun_ = 0;
  int allowed_ = 0;
  int failure_ = 0;
};

TEST(GroupCommit, AllThatCommitWhileTheDiskIsBusyShareTheNextRequest) {
  SlowDisk disk;
  GroupCommit group([&disk] { return disk.force(); });
  std::atomic<int> safeCount{0};
  std::vector<std::thread> threads;
  const auto commit = [&] {
    const std::uint64_t number = group.committed();
    threads.emplace_back([&, number] {
      EXPECT_EQ(group.waitFor(number), 0);
      ++safeCount;
    });
  };
  commit();
  disk.waitUntilBegun(1);
  // the first request does not hold these: they may be written after it began
  for (int i = 0; i < 5; ++i) {
    commit();
  }
  EXPECT_EQ(safeCount, 0);
  disk.allow(1);
  disk.waitUntilBegun(2);
  EXPECT_LE(safeCount, 1);
  disk.allow(2);
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(safeCount, 6);
  EXPECT_EQ(group.requestCount(), 2U);
}

TEST(GroupCommit, ADiskThatFailedOnceIsNotBelievedAgain) {
  int calls = 0;
  GroupCommit group([&calls] { return ++calls == 2 ? EIO : 0; });
  EXPECT_EQ(group.waitFor(group.committed()), 0);
  EXPECT_EQ(group.waitFor(group.committed()), EIO);
  EXPECT_EQ(group.waitFor(group.committed()), EIO);
  EXPECT_EQ(calls, 2);
}

TEST(Durability, HasItsNames) {
  EXPECT_EQ(nameOf(Durability::Process), "process");
  EXPECT_EQ(nameOf(Durability::Power), "power");
  EXPECT_EQ(durabilityOf("power"), Durability::Power);
  EXPECT_EQ(durabilityOf("process"), Durability::Process);
  EXPECT_EQ(durabilityOf("perhaps"), std::nullopt);
}

TEST(Durability, OnlyPowerAsksTheDiskWithEachChange) {
  for (const Durability durability : {Durability::Process, Durability::Power}) {
    const TemporaryFolder folder;
    Store store(folder.path(), 0, durability);
    ASSERT_EQ(store.open(), std::nullopt);
    const std::uint64_t factor = durability == Durability::Power ? 1 : 0;
    ASSERT_EQ(store.save({"sim-1", "one", 0}, "first"), std::nullopt);
    EXPECT_EQ(store.syncCount(), 1 * factor);
    ASSERT_EQ(store.saveState("sim-1", 1, "second"), std::nullopt);
    ASSERT_EQ(store.saveModel("model-1", "text"), std::nullopt);
    ASSERT_EQ(store.saveCheckpoint("sim-1", "young", 1, "second"), std::nullopt);
    EXPECT_EQ(store.syncCount(), 4 * factor);
    // the parts of a big state are safe with its last part
    ASSERT_EQ(store.saveState("sim-1", 2, std::string(20'000'000, 'x')), std::nullopt);
    ASSERT_EQ(store.remove("sim-1"), std::nullopt);
    EXPECT_EQ(store.syncCount(), 6 * factor);
  }
}

/// Puts something that cannot be forced to a disk in the place of the store's own descriptor of the log.
void breakDisk(const std::string& folder) {
  int last = -1;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code ignored;
    if (std::filesystem::read_symlink(entry, ignored) == folder + "/espalier.sqlite-wal") {
      last = std::max(last, std::stoi(entry.path().filename().string()));
    }
  }
  ASSERT_GE(last, 0);
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  ASSERT_EQ(::dup2(pipe[0], last), last);
  ::close(pipe[0]);
  ::close(pipe[1]);
}

TEST(Durability, ADiskThatFailsIsToldAndTheStateIsStillWhole) {
  const TemporaryFolder folder;
  {
    Store store(folder.path(), 0, Durability::Power);
    ASSERT_EQ(store.open(), std::nullopt);
    ASSERT_EQ(store.save({"sim-1", "one", 0}, "first"), std::nullopt);
    breakDisk(folder.path());
    const std::string problem = store.saveState("sim-1", 1, "second").value_or("");
    EXPECT_NE(problem.find("cannot be written safely: "), std::string::npos) << problem;
    EXPECT_EQ(store.readState("sim-1").bytes, "second");
    EXPECT_NE(store.saveState("sim-1", 2, "third"), std::nullopt);
  }
  Store again(folder.path());
  ASSERT_EQ(again.open(), std::nullopt);
  EXPECT_EQ(again.readState("sim-1").problem, "");
  EXPECT_EQ(again.readState("sim-1").bytes, "third");
}

TEST(Durability, TheServerSaysWhichOneItHas) {
  for (const Durability durability : {Durability::Process, Durability::Power}) {
    const TemporaryFolder folder;
    ServerOptions options;
    options.dataFolder = folder.path();
    options.durability = durability;
    const RunningServer server(options);
    const auto client = connectTo(server);
    EXPECT_EQ(member(resultOf(client->request("server.status", "{}")), "durability"), nameOf(durability));
  }
}

mode_t modeOf(const std::string& file) {
  struct stat state {};
  return ::stat(file.c_str(), &state) == 0 ? state.st_mode & 0777 : 0;
}

TEST(Store, ItsFilesAreForItsUserAlone) {
  const TemporaryFolder folder;
  const std::string data = folder.path() + "/data";
  const mode_t before = ::umask(0);
  {
    Store store(data);
    EXPECT_EQ(store.open(), std::nullopt);
    EXPECT_EQ(store.save({"sim-1", "one", 0}, "first"), std::nullopt);
    for (const char* name : {"/espalier.sqlite", "/espalier.sqlite-wal", "/espalier.sqlite-shm", "/lock"}) {
      EXPECT_EQ(modeOf(data + name), 0600U) << name;
    }
    EXPECT_EQ(modeOf(data), 0700U);
  }
  // a database of an older version loses the rights of others
  ::chmod((data + "/espalier.sqlite").c_str(), 0644);
  Store again(data);
  EXPECT_EQ(again.open(), std::nullopt);
  EXPECT_EQ(modeOf(data + "/espalier.sqlite"), 0600U);
  ::umask(before);
}

}  // namespace
}  // namespace espalier::server::durability_test
