#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace espalier::server {

/// The folder given by --data: one SQLite database (`espalier.sqlite` with its write-ahead log) that holds simulations,
/// their checkpoints and loaded models. Every change is a transaction: a killed server loses nothing that was answered,
/// a power failure at most the last moments, and neither damages the rest.
///
/// A state is compressed and written in parts, each a transaction of its own, and becomes the simulation's with the
/// last one: saving a big simulation makes nobody wait for more than a part. Errors are sentences that say what to do.
/// Thread-safe; the states of one simulation are saved one after the other by its owner.
class Store {
 public:
  /// Empty name: nothing is kept. `maximumBytes`: of the database; 0: as much as the disk has.
  explicit Store(std::string folder, std::uint64_t maximumBytes = 0);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  [[nodiscard]] bool isKept() const { return !folder_.empty(); }
  /// Makes the folder and the database, and takes the folder's lock, which is held as long as this object lives: two
  /// servers on one folder would overwrite each other's simulations.
  [[nodiscard]] std::optional<std::string> open();

  /// A simulation without its state.
  struct Entry {
    std::string id;
    std::string record;  // text; how it is made again
    std::uint64_t step = 0;
  };
  /// By identifier, or why they cannot be read.
  [[nodiscard]] std::variant<std::vector<Entry>, std::string> simulations() const;
  /// A new simulation, or another record and state for one that is there.
  [[nodiscard]] std::optional<std::string> save(const Entry& entry, std::string_view state);
  [[nodiscard]] std::optional<std::string> saveState(const std::string& simulation, std::uint64_t step,
                                                     std::string_view state);
  /// The state, or why it cannot be read.
  struct State {
    std::string bytes;
    std::string problem;  // empty: none
  };
  [[nodiscard]] State readState(const std::string& simulation) const;
  /// With its checkpoints. One that is not there is no error.
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

  /// Models that model.load kept: their text in the caller's form, by identifier.
  [[nodiscard]] std::optional<std::string> saveModel(const std::string& model, std::string_view text);
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> models() const;

  /// Of the database and its log on disk; 0: nothing is kept.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  class Implementation;

  std::string folder_;
  std::uint64_t maximumBytes_;
  std::unique_ptr<Implementation> implementation_;  // null: nothing is kept, or not opened
};

}  // namespace espalier::server
