#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/messages.h"

namespace espalier::server {

/// What is needed beside a snapshot to make a simulation again.
struct SimulationRecord {
  std::string id;
  std::uint64_t seed = 0;
  bool hasSeed = false;           // given by the caller: replaces the model's
  protocol::CreateParams create;  // as asked for; its model is in the snapshot
};

/// The folder given by --data: `simulations/ID.json` (how it was created) and `simulations/ID.snapshot` (its state
/// after the last completed step), each replaced as a whole. A killed server loses nothing but the step it was in; the
/// disk's own cache is not forced, so a power failure may cost more. Empty name: nothing is kept. Thread-safe for
/// different simulations.
class DataFolder {
 public:
  explicit DataFolder(std::string folder) : folder_(std::move(folder)) {}

  [[nodiscard]] bool isKept() const { return !folder_.empty(); }
  /// Makes the folder and takes its lock, which is held as long as a copy of this object lives: two servers on one
  /// folder would overwrite each other's simulations. An error sentence, or nothing.
  [[nodiscard]] std::optional<std::string> prepare();
  [[nodiscard]] std::optional<std::string> saveRecord(const SimulationRecord& record) const;
  [[nodiscard]] std::optional<std::string> saveSnapshot(const std::string& id, std::string_view snapshot) const;
  void remove(const std::string& id) const;

  struct Loaded {
    SimulationRecord record;
    std::string snapshot;
  };
  /// Everything saved, by identifier; what cannot be read is described in `problems` and left where it is.
  [[nodiscard]] std::vector<Loaded> loadAll(std::vector<std::string>& problems) const;

 private:
  [[nodiscard]] std::string fileOf(const std::string& id, std::string_view suffix) const;

  std::string folder_;
  std::shared_ptr<const int> lock_;  // descriptor of `folder_`/lock, locked; closed with the last copy
};

}  // namespace espalier::server
