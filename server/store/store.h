#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "server/store/durability.h"

namespace espalier::server {

/// The folder given by --data: one SQLite database (`espalier.sqlite` with its write-ahead log) that holds simulations,
/// their checkpoints and loaded models. Every change is a transaction. A killed server loses nothing that was answered.
/// A power failure loses nothing either with Durability::Power, else at most the last moments. Neither damages the
/// rest.
///
/// A state is compressed and written in parts, each in a transaction of its own. The last part makes it the state of
/// the simulation. So other simulations wait for a part at most. Errors are sentences that say what to do. Thread-safe;
/// the owner of a simulation saves its states one after the other.
class Store {
 public:
  /// Empty name: nothing is kept. `maximumBytes`: of the database. 0: no bound but the disk.
  explicit Store(std::string folder, std::uint64_t maximumBytes = 0, Durability durability = Durability::Process);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  [[nodiscard]] bool isKept() const { return !folder_.empty(); }
  /// Makes the folder and the database, and takes the lock of the folder for the life of this object. Two servers on
  /// one folder would overwrite each other's simulations.
  [[nodiscard]] std::optional<std::string> open();
  /// Another bound from now on. The database keeps what it has. An error sentence, or nothing.
  [[nodiscard]] std::optional<std::string> setMaximumBytes(std::uint64_t maximumBytes);

  /// A simulation without its state.
  struct Entry {
    std::string id;
    std::string record;  // toText() of its SimulationRecord
    std::uint64_t step = 0;
    std::string owner{};  // the account that it counts for
  };
  /// By identifier, or why they cannot be read.
  [[nodiscard]] tl::expected<std::vector<Entry>, std::string> simulations() const;
  /// One of them, or why it cannot be read.
  [[nodiscard]] tl::expected<Entry, std::string> simulation(const std::string& id) const;
  /// Saves a new simulation, or another record and state of an old one.
  [[nodiscard]] std::optional<std::string> save(const Entry& entry, std::string_view state);
  [[nodiscard]] std::optional<std::string> saveState(const std::string& simulation, std::uint64_t step,
                                                     std::string_view state);
  /// The state, or why it cannot be read.
  struct State {
    std::string bytes;
    std::string problem;  // empty: none
  };
  [[nodiscard]] State readState(const std::string& simulation) const;
  /// Removes a simulation and its checkpoints. No error when there is none.
  [[nodiscard]] std::optional<std::string> remove(const std::string& simulation);

  /// A state kept under a name.
  struct Checkpoint {
    std::string name;
    std::uint64_t step = 0;
    std::uint64_t bytes = 0;  // of the state
  };
  [[nodiscard]] std::optional<std::string> saveCheckpoint(const std::string& simulation, const std::string& name,
                                                          std::uint64_t step, std::string_view state);
  [[nodiscard]] std::vector<Checkpoint> checkpoints(const std::string& simulation) const;
  [[nodiscard]] State readCheckpoint(const std::string& simulation, const std::string& name) const;

  /// Models of model.load: their text in the caller's form, by identifier.
  [[nodiscard]] std::optional<std::string> saveModel(const std::string& model, std::string_view text);
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> models() const;

  /// Bytes of the database and its log on disk; 0: nothing is kept.
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] Durability durability() const { return durability_; }
  /// How often the disk was asked to keep what was written; 0 with Durability::Process.
  [[nodiscard]] std::uint64_t syncCount() const;

 private:
  class Implementation;

  std::string folder_;
  std::uint64_t maximumBytes_;
  Durability durability_;
  std::unique_ptr<Implementation> implementation_;  // null: nothing is kept, or not opened
};

}  // namespace espalier::server
