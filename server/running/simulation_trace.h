#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "engine/simulation/trace.h"
#include "server/remote/trace_file.h"

namespace espalier::server {

/// A trace in the data folder.
struct StoredTrace {
  std::uint64_t number = 0;  // 1, 2, ... of the simulation
  std::uint64_t bytes = 0;   // compressed
};

/// Where the traces of a server are.
struct TraceFolder {
  std::string path;          // empty: there are none
  DiskRoom* room = nullptr;  // of the owner of the simulation; null: none
};

/// The trace of a simulation of the server: a compressed file in the data folder, readable up to the last completed
/// step whenever the server ends.
class SimulationTrace {
 public:
  /// `FOLDER/ID-N.trace.zst` with the first free N. Makes the folder. An error sentence when that fails.
  [[nodiscard]] static tl::expected<std::unique_ptr<SimulationTrace>, std::string> create(const TraceFolder& folder,
                                                                                          const std::string& id);

  /// The traces of a simulation, by number. `folder` empty: there are none.
  [[nodiscard]] static std::vector<StoredTrace> list(const std::string& folder, const std::string& id);
  /// The bytes of a trace as far as it was written. Nothing when there is none or it is larger than `bound`.
  [[nodiscard]] static std::optional<std::string> read(const std::string& folder, const std::string& id,
                                                       std::uint64_t number, std::uint64_t bound);

  /// Bytes of all traces of a simulation.
  [[nodiscard]] static std::uint64_t bytesOf(const std::string& folder, const std::string& id);
  /// Removes all traces of a simulation. One that is being written is closed before.
  static void removeAll(const TraceFolder& folder, const std::string& id);
  /// Of all traces in a folder.
  [[nodiscard]] static std::uint64_t bytesIn(const std::string& folder);

  /// A trace that never began leaves no file.
  ~SimulationTrace();
  SimulationTrace(const SimulationTrace&) = delete;
  SimulationTrace& operator=(const SimulationTrace&) = delete;

  /// The process with its dialogue recorded; null stays null.
  [[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> record(
      std::unique_ptr<turtle::EnvironmentProcess> process) {
    return simulation::record(std::move(process), recorder_);
  }
  /// After rewind() or restore().
  void begin(simulation::Simulation& simulation) {
    hasBegun_ = true;
    recorder_->begin(simulation);
    file_->flush();
  }
  void complete(const simulation::Simulation& simulation) {
    recorder_->complete(simulation);
    file_->flush();
  }
  /// Adds a note: an environment failed and this was done about it.
  void note(std::uint64_t step, const std::string& message) { recorder_->fail(step, message); }
  [[nodiscard]] std::uint64_t memoryBytes() const { return file_->memoryBytes(); }
  /// Nothing is recorded any more.
  void close() { (void)file_->close(); }
  /// Nobody can ask for it: it leaves no file.
  void discard() { hasBegun_ = false; }
  /// Why the trace has ended: the disk does not take it. A sentence that names no folder; empty: it goes on.
  [[nodiscard]] std::string problem() const;

 private:
  SimulationTrace(std::unique_ptr<TraceFile> file, std::string path, DiskRoom* room)
      : path_(std::move(path)),
        room_(room),
        file_(std::move(file)),
        recorder_(std::make_shared<simulation::TraceRecorder>(*file_)) {}

  std::string path_;
  DiskRoom* room_;
  bool hasBegun_ = false;
  std::unique_ptr<TraceFile> file_;
  std::shared_ptr<simulation::TraceRecorder> recorder_;
};

}  // namespace espalier::server
