// Saves of many simulations at a time into the data folder, with each durability. With `power` each save waits until
// the disk has it; saves that come while the disk is busy share its next request (group commit).
#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "server/store/store.h"

namespace espalier::benchmarking {
namespace {

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

/// A folder on a disk, beside the program: the system's folder for temporary files may be in memory.
class Folder {
 public:
  Folder() : path_(fs::read_symlink("/proc/self/exe").parent_path() / ("store-benchmark-" + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

double medianOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Milliseconds until the disk has so many more bytes of a file: the median of many.
double forcingMilliseconds(const fs::path& folder, std::size_t bytes) {
  const int file = ::open((folder / "forced").c_str(), O_CREAT | O_WRONLY | O_APPEND, 0600);
  const std::string block(bytes, 'x');
  std::vector<double> times;
  for (int i = 0; i < 100; ++i) {
    const auto start = Clock::now();
    if (::write(file, block.data(), block.size()) < 0 || ::fdatasync(file) != 0) {
      break;
    }
    times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  }
  ::close(file);
  return times.empty() ? 0.0 : medianOf(times);
}

void save(benchmark::State& state, server::Durability durability, int simulations) {
  constexpr int kSaves = 200;             // of each simulation
  constexpr std::size_t kBytes = 20'000;  // of a state
  const Folder folder;
  const double forcing = forcingMilliseconds(folder.path(), kBytes);
  server::Store store((folder.path() / "data").string(), 0, durability);
  if (const auto problem = store.open()) {
    state.SkipWithError(problem->c_str());
    return;
  }
  std::vector<std::vector<double>> waits(static_cast<std::size_t>(simulations));
  for (auto _ : state) {
    const std::uint64_t before = store.syncCount();
    std::vector<std::thread> threads;
    const auto start = Clock::now();
    for (int i = 0; i < simulations; ++i) {
      threads.emplace_back([&, i] {
        const std::string name = "simulation-" + std::to_string(i);
        std::string bytes(kBytes, 'x');
        (void)store.save({name, "record", 0}, bytes);
        for (int step = 1; step <= kSaves; ++step) {
          bytes[static_cast<std::size_t>(step)] = static_cast<char>(step);
          const auto begin = Clock::now();
          (void)store.saveState(name, static_cast<std::uint64_t>(step), bytes);
          waits[static_cast<std::size_t>(i)].push_back(
              std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
        }
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const double saves = static_cast<double>(simulations) * (kSaves + 1);
    std::vector<double> all;
    for (const std::vector<double>& some : waits) {
      all.insert(all.end(), some.begin(), some.end());
    }
    state.SetIterationTime(seconds);
    state.counters["saves/s"] = saves / seconds;
    state.counters["saves/request"] =
        store.syncCount() == before ? 0.0 : saves / static_cast<double>(store.syncCount() - before);
    state.counters["median ms"] = medianOf(all);
    state.counters["forcing ms"] = forcing;
  }
}

const bool kIsRegistered = [] {
  for (const server::Durability durability : {server::Durability::Process, server::Durability::Power}) {
    for (const int simulations : {1, 4, 16, 64}) {
      const std::string name = "store/" + std::string(server::nameOf(durability)) + "/" + std::to_string(simulations);
      benchmark::RegisterBenchmark(
          name.c_str(), [durability, simulations](benchmark::State& state) { save(state, durability, simulations); })
          ->Unit(benchmark::kMillisecond)
          ->UseManualTime()
          ->Iterations(1);
    }
  }
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking
